//! Masses of bodies: given, or those of their geoms.

use std::f64::consts::PI;

use super::super::plane::{Frame, IDENTITY, Matrix, Vector, add, cross, norm, product, scaled, subtract, transposed};
use super::attributes::{Attributes, with_z};
use super::xml::Element;
use crate::error::Error;

/// A mass in the frame of its body: its centre, and its moments of inertia about it.
pub(super) struct Solid {
    pub(super) mass: f64,
    pub(super) com: Vector,
    pub(super) inertia: Matrix,
}

impl Solid {
    /// The moment of inertia about an axis through the centre of mass.
    pub(super) fn about(&self, axis: Vector) -> f64 {
        let turned = self.inertia.map(|row| row[0] * axis[0] + row[1] * axis[1] + row[2] * axis[2]);
        axis[0] * turned[0] + axis[1] * turned[1] + axis[2] * turned[2]
    }

    fn principal(mass: f64, moments: Vector, frame: &Frame) -> Self {
        let mut diagonal = IDENTITY;
        (0..3).for_each(|i| diagonal[i][i] = moments[i]);
        Self { mass, com: frame.place, inertia: turned(&diagonal, frame) }
    }
}

fn turned(inertia: &Matrix, frame: &Frame) -> Matrix {
    product(&product(&frame.axes, inertia), &transposed(&frame.axes))
}

/// Reads an element `inertial`.
pub(super) fn inertial(attributes: &Attributes, element: &Element) -> Result<Solid, Error> {
    let frame = attributes.frame(element, "")?;
    let mass = attributes.number(element, "", "mass")?.unwrap_or(0.0);
    let full = attributes.numbers(element, "", "fullinertia")?;
    let solid = match (full.as_deref(), attributes.vector(element, "", "diaginertia")?) {
        (Some(&[xx, yy, zz, xy, xz, yz]), _) => {
            let inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            Solid { mass, com: frame.place, inertia: turned(&inertia, &frame) }
        }
        (Some(_), _) => {
            let help = "write xx, yy, zz, xy, xz and yz";
            return Err(attributes.xml.error(element, "fullinertia", "`fullinertia` has six numbers", help));
        }
        (None, moments) => Solid::principal(mass, moments.unwrap_or([0.0; 3]), &frame),
    };
    if mass < 0.0 || (0..3).any(|i| solid.inertia[i][i] < 0.0) {
        return Err(attributes.xml.error(
            element,
            "mass",
            "this mass is negative",
            "write a mass and moments of at least 0",
        ));
    }
    Ok(solid)
}

/// The mass of a geom; `None` where only MuJoCo knows it.
pub(super) fn geom(attributes: &Attributes, element: &Element, class: &str) -> Result<Option<Solid>, Error> {
    let kind = attributes.get(element, class, "type").unwrap_or("sphere");
    let size = attributes.numbers(element, class, "size")?.unwrap_or_default();
    let mut frame = attributes.frame(element, class)?;
    let mut length = None;
    let is_long = matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid");
    if let Some(ends) = attributes.numbers(element, class, "fromto")?.filter(|_| is_long) {
        let &[a, b, c, d, e, f] = &ends[..] else {
            return Err(attributes.xml.error(
                element,
                "fromto",
                "`fromto` has six numbers",
                "write both ends, x y z each",
            ));
        };
        let along = subtract([a, b, c], [d, e, f]);
        if norm(along) == 0.0 {
            return Err(attributes.xml.error(
                element,
                "fromto",
                "this geom has no length",
                "write two ends that differ",
            ));
        }
        frame = Frame { place: scaled(add([a, b, c], [d, e, f]), 0.5), axes: with_z(along) };
        length = Some(norm(along) / 2.0);
    }
    let part = |number: usize| size.get(number).copied().filter(|size| *size > 0.0);
    // With ends, the first size is across.
    let sizes = match (kind, length) {
        ("sphere", _) => part(0).map(|r| [r; 3]),
        ("capsule" | "cylinder", Some(h)) => part(0).map(|r| [r, r, h]),
        ("capsule" | "cylinder", None) => part(0).zip(part(1)).map(|(r, h)| [r, r, h]),
        ("box" | "ellipsoid", Some(h)) => part(0).map(|r| [r, r, h]),
        ("box" | "ellipsoid", None) => part(0).zip(part(1)).zip(part(2)).map(|((a, b), c)| [a, b, c]),
        ("plane", _) => return Ok(Some(Solid::principal(0.0, [0.0; 3], &frame))),
        _ => return Ok(None),
    };
    let Some([a, b, c]) = sizes else {
        let title = format!("this {kind} has no size");
        return Err(attributes.xml.error(element, "size", &title, "give it positive sizes, as many as its type has"));
    };
    let (volume, moments) = moments(kind, [a, b, c]);
    let mass = match attributes.number(element, class, "mass")? {
        Some(mass) => mass,
        None => attributes.number(element, class, "density")?.unwrap_or(1000.0) * volume,
    };
    if mass < 0.0 {
        return Err(attributes.xml.error(element, "mass", "this mass is negative", "write a mass of at least 0"));
    }
    Ok(Some(Solid::principal(mass, moments.map(|moment| moment * mass), &frame)))
}

/// The volume of a solid with these half sizes, and its moments of inertia by its mass.
fn moments(kind: &str, [a, b, c]: Vector) -> (f64, Vector) {
    match kind {
        "capsule" => {
            // Both half spheres, and the cylinder between them.
            let (ball, tube) = (4.0 / 3.0 * a, 2.0 * c);
            let [ball, tube] = [ball, tube].map(|part| part / (ball + tube));
            let across = tube * (3.0 * a * a + 4.0 * c * c) / 12.0 + ball * (0.4 * a * a + c * c + 0.75 * a * c);
            let along = tube * a * a / 2.0 + ball * 0.4 * a * a;
            (PI * a * a * (2.0 * c + 4.0 / 3.0 * a), [across, across, along])
        }
        "cylinder" => {
            let across = (3.0 * a * a + 4.0 * c * c) / 12.0;
            (2.0 * PI * a * a * c, [across, across, a * a / 2.0])
        }
        "box" => (8.0 * a * b * c, [(b * b + c * c) / 3.0, (a * a + c * c) / 3.0, (a * a + b * b) / 3.0]),
        // A sphere is an ellipsoid too.
        _ => (4.0 / 3.0 * PI * a * b * c, [(b * b + c * c) / 5.0, (a * a + c * c) / 5.0, (a * a + b * b) / 5.0]),
    }
}

/// Joins masses: their sum, their centre, and the moment of inertia about an axis through it.
pub(super) fn joined(solids: &[&Solid], axis: Vector) -> (f64, Vector, f64) {
    let mass: f64 = solids.iter().map(|solid| solid.mass).sum();
    if mass == 0.0 {
        return (0.0, [0.0; 3], solids.iter().map(|solid| solid.about(axis)).sum());
    }
    let sum = solids.iter().fold([0.0; 3], |sum, solid| add(sum, scaled(solid.com, solid.mass / mass)));
    let about = |solid: &&Solid| {
        let arm = norm(cross(subtract(solid.com, sum), axis));
        solid.about(axis) + solid.mass * arm * arm
    };
    (mass, sum, solids.iter().map(about).sum())
}

impl Solid {
    /// Converts the mass into the frame that contains this one.
    pub(super) fn seen_from(self, frame: &Frame) -> Self {
        Self { mass: self.mass, com: frame.point(self.com), inertia: turned(&self.inertia, frame) }
    }
}
