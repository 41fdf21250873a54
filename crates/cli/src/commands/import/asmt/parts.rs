//! The parts of an assembly, their masses and their markers.

use std::collections::HashMap;

use super::super::linkage::{ImportedLinkage, Link, Mass};
use super::super::names::Names;
use super::super::plane::{BodyFrame, Frame, IDENTITY, Matrix, Plane, Vector, cross, dot, norm};
use super::super::source::Source;
use super::tree::Node;
use crate::error::Error;

/// The parts, and their markers by their path.
pub(super) struct Parts {
    /// The assembly itself, which is the ground, and its parts.
    parts: Vec<Part>,
    markers: HashMap<String, Marker>,
}

struct Part {
    name: String,
    frame: Frame,
    /// The velocity of the place of its frame, and the angular velocity.
    velocity: Vector,
    omega: Vector,
    mass: Option<PrincipalMass>,
    body: Option<BodyFrame>,
}

struct PrincipalMass {
    mass: f64,
    at: Frame,
    inertias: Vector,
}

/// A marker: its part, and its frame there.
#[derive(Clone, Copy)]
pub(super) struct Marker {
    pub(super) part: usize,
    pub(super) frame: Frame,
}

impl Parts {
    pub(super) fn read(source: &Source, assembly: &Node) -> Result<Self, Error> {
        let ground = Part {
            name: String::new(),
            frame: Frame::WORLD,
            velocity: [0.0; 3],
            omega: [0.0; 3],
            mass: None,
            body: None,
        };
        let mut parts = Self { parts: vec![ground], markers: HashMap::new() };
        let root = format!("/{}", assembly.name());
        parts.markers(source, assembly, &root, 0)?;
        for node in assembly.child("Parts").into_iter().flat_map(|parts| parts.children()) {
            let number = parts.parts.len();
            parts.parts.push(part(source, &node)?);
            parts.markers(source, &node, &format!("{root}/{}", node.name()), number)?;
        }
        if parts.parts.len() > 1001 {
            return Err(source.whole("the assembly has more than 1000 parts", "split the assembly"));
        }
        if parts.parts.len() == 1 {
            return Err(source.whole("the assembly has no parts", "export an assembly with parts and joints"));
        }
        Ok(parts)
    }

    /// Reads the markers of a part or of the assembly.
    fn markers(&mut self, source: &Source, node: &Node, path: &str, part: usize) -> Result<(), Error> {
        for point in node.child("RefPoints").into_iter().flat_map(|points| points.children()) {
            let outer = frame(source, &point)?;
            for marker in point.child("Markers").into_iter().flat_map(|markers| markers.children()) {
                let frame = outer.then(&frame(source, &marker)?);
                let path = format!("{path}/{}", marker.name());
                if self.markers.insert(path.clone(), Marker { part, frame }).is_some() {
                    let title = format!("two markers are called `{path}`");
                    return Err(source.error(title, marker.span(), "", "give parts and markers names of their own"));
                }
            }
        }
        Ok(())
    }

    /// Finds a marker of a joint.
    pub(super) fn marker(&self, source: &Source, joint: &Node, key: &str) -> Result<Marker, Error> {
        let place = joint.child(key).and_then(|node| node.first());
        let found = place.and_then(|place| self.markers.get(place.text().trim()));
        found.copied().ok_or_else(|| {
            let title = format!("`{key}` of joint `{}` is not a marker of the assembly", joint.name());
            let span = place.map_or(joint.span(), |place| place.span());
            source.error(title, span, "not known", "name a marker as `/Assembly/Part/Marker`")
        })
    }

    /// The frame of a marker in the assembly, at the positions of the file.
    pub(super) fn world(&self, marker: &Marker) -> Frame {
        self.parts[marker.part].frame.then(&marker.frame)
    }

    /// Finds a marker by its path.
    pub(super) fn find(&self, path: &str) -> Option<Marker> {
        self.markers.get(path).copied()
    }

    /// The frame of a part in the plane.
    pub(super) fn body(&self, plane: &Plane, part: usize) -> BodyFrame {
        self.parts[part].body.unwrap_or_else(|| plane.body(&self.parts[part].frame))
    }

    /// Makes links of the parts.
    pub(super) fn place(&mut self, plane: &Plane, linkage: &mut ImportedLinkage, names: &mut Names) {
        for part in &mut self.parts {
            part.body = Some(plane.body(&part.frame));
        }
        for part in self.parts.iter().skip(1) {
            let body = plane.body(&part.frame);
            let mass = part.mass.as_ref().map(|mass| Mass {
                mass: mass.mass,
                com: body.project(mass.at.place),
                inertia: (0..3).map(|i| mass.inertias[i] * dot(body.normal, mass.at.axis(i)).powi(2)).sum(),
            });
            let name = names.link(&part.name, "part");
            let leaves_plane = |across: f64, vector: Vector| across.abs() > 1e-9 * norm(vector);
            let turns = norm(cross(part.omega, plane.normal));
            if leaves_plane(dot(part.velocity, plane.normal), part.velocity) || leaves_plane(turns, part.omega) {
                linkage.left_out.push(format!("the velocity of part `{name}` out of the plane"));
            }
            linkage.links.push(Link {
                mass,
                velocity: plane.project(part.velocity),
                rate: dot(part.omega, plane.normal),
                ..Link::new(name, plane.project(part.frame.place), body.angle)
            });
        }
        // The ground has the axes of the plane.
        if let Some(ground) = self.parts.first_mut() {
            ground.body = Some(plane.body(&Frame::WORLD));
        }
    }
}

/// Reads a part without its markers.
fn part(source: &Source, node: &Node) -> Result<Part, Error> {
    let row =
        |node: &Node, key: &str| node.child(key).and_then(|own| own.first()).map(|row| row.vector(source)).transpose();
    let [velocity, omega] = [row(node, "Velocity3D")?, row(node, "Omega3D")?].map(|row| row.unwrap_or([0.0; 3]));
    let mut mass = None;
    if let Some(marker) = node.child("PrincipalMassMarker") {
        let value = marker.child("Mass").and_then(|own| own.first()).map(|row| row.number(source)).transpose()?;
        let value = value.unwrap_or(0.0);
        let inertias = row(&marker, "MomentOfInertias")?.unwrap_or([0.0; 3]);
        if value < 0.0 || inertias.iter().any(|inertia| *inertia < 0.0) {
            let title = format!("the mass of part `{}` is negative", node.name());
            return Err(source.error(title, marker.span(), "", "give it a mass and moments of inertia of at least 0"));
        }
        if value > 0.0 || inertias != [0.0; 3] {
            mass = Some(PrincipalMass { mass: value, at: frame(source, &marker)?, inertias });
        }
    }
    Ok(Part { name: node.name().to_owned(), frame: frame(source, node)?, velocity, omega, mass, body: None })
}

/// Reads the frame of a part, a point or a marker: its place and its axes.
pub(super) fn frame(source: &Source, node: &Node) -> Result<Frame, Error> {
    let place = node.child("Position3D").and_then(|own| own.first()).map(|row| row.vector(source)).transpose()?;
    let mut axes: Matrix = IDENTITY;
    if let Some(own) = node.child("RotationMatrix") {
        let rows: Vec<Vector> = own.children().map(|row| row.vector(source)).collect::<Result<_, _>>()?;
        let is_rotation = rows.len() == 3
            // The determinant of a reflection is -1.
            && dot(cross(rows[0], rows[1]), rows[2]) > 0.0
            && (0..3).all(|i| (norm(rows[i]) - 1.0).abs() < 1e-6 && dot(rows[i], rows[(i + 1) % 3]).abs() < 1e-6);
        if !is_rotation {
            let help = "write three rows of length 1 that are perpendicular to each other, with the determinant 1";
            return Err(source.error("this matrix is not a rotation", own.span(), "", help));
        }
        axes = [rows[0], rows[1], rows[2]];
    }
    Ok(Frame { place: place.unwrap_or([0.0; 3]), axes })
}
