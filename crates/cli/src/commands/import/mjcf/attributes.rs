//! Attributes of elements, with their defaults and their units.

use std::collections::HashMap;

use super::super::numbers::finite;
use super::super::plane::{Frame, IDENTITY, Matrix, Vector, cross, norm, product, transposed, turn, unit};
use super::xml::{Element, Xml};
use crate::error::Error;

/// The defaults of a model, and the settings of its compiler.
pub(super) struct Attributes<'x> {
    pub(super) xml: &'x Xml<'x>,
    classes: HashMap<String, Class<'x>>,
    is_degree: bool,
    sequence: String,
}

/// The defaults of a class.
#[derive(Clone, Default)]
struct Class<'x> {
    /// The attributes of elements, by the group of their name.
    attributes: HashMap<&'x str, Vec<(&'x str, &'x str)>>,
    /// Actuators, in the order in which they set the parameters of the one default that all kinds share.
    actuators: Vec<&'x Element>,
}

/// The names of actuators, which have common defaults.
const ACTUATORS: [&str; 13] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "orientation",
    "pid",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];

/// The name under which the defaults of an element are kept.
fn group(name: &str) -> &str {
    if ACTUATORS.contains(&name) { "actuator" } else { name }
}

/// The class of elements that do not name one.
pub(super) const MAIN: &str = "main";

impl<'x> Attributes<'x> {
    pub(super) fn read(xml: &'x Xml<'x>) -> Result<Self, Error> {
        let mut own = Self { xml, classes: HashMap::new(), is_degree: true, sequence: "xyz".to_owned() };
        own.classes.insert(MAIN.to_owned(), Class::default());
        for element in xml.children(xml.root()) {
            match element.name.as_str() {
                "compiler" => own.compiler(element)?,
                "default" => own.class(element, MAIN),
                _ => {}
            }
        }
        Ok(own)
    }

    fn compiler(&mut self, element: &Element) -> Result<(), Error> {
        let xml = self.xml;
        match element.get("angle") {
            Some("radian") => self.is_degree = false,
            Some("degree") => self.is_degree = true,
            None => {}
            Some(_) => {
                return Err(xml.error(
                    element,
                    "angle",
                    "this unit of angles is not known",
                    "write `degree` or `radian`",
                ));
            }
        }
        if let Some(sequence) = element.get("eulerseq") {
            if sequence.len() != 3 || !sequence.chars().all(|c| "xyzXYZ".contains(c)) {
                return Err(xml.error(
                    element,
                    "eulerseq",
                    "this is not a sequence of axes",
                    "write three of x, y, z, X, Y, Z",
                ));
            }
            self.sequence = sequence.to_owned();
        }
        if element.get("coordinate") == Some("global") {
            let help = "save the model with local coordinates, by a present version of MuJoCo";
            return Err(xml.error(element, "coordinate", "global coordinates cannot be read", help));
        }
        Ok(())
    }

    /// Reads a class of defaults, and the classes in it, which inherit its attributes.
    fn class(&mut self, element: &'x Element, parent: &str) {
        let name = element.get("class").unwrap_or(parent).to_owned();
        let mut class = self.classes.get(&name).or_else(|| self.classes.get(parent)).cloned().unwrap_or_default();
        for child in self.xml.children(element).filter(|child| child.name != "default") {
            let known = class.attributes.entry(group(&child.name)).or_default();
            for (key, value) in &child.attributes {
                known.retain(|(own, _)| own != key);
                known.push((key, value));
            }
            if ACTUATORS.contains(&child.name.as_str()) {
                class.actuators.push(child);
            }
        }
        self.classes.insert(name.clone(), class);
        for child in self.xml.children(element).filter(|child| child.name == "default") {
            self.class(child, &name);
        }
    }

    /// An attribute of an element, or of its class.
    pub(super) fn get<'a>(&'a self, element: &'a Element, class: &str, name: &str) -> Option<&'a str> {
        element.get(name).or_else(|| {
            let class = element.get("class").unwrap_or(class);
            let known = self.classes.get(class)?.attributes.get(group(&element.name))?;
            known.iter().find(|(own, _)| *own == name).map(|(_, value)| *value)
        })
    }

    /// Whether the model has a class of this name.
    pub(super) fn has_class(&self, name: &str) -> bool {
        self.classes.contains_key(name)
    }

    /// Whether an equality constraint is active. All kinds of them have common defaults.
    pub(super) fn is_active(&self, element: &Element) -> bool {
        let class = self.classes.get(element.get("class").unwrap_or(MAIN));
        let defaults = class.and_then(|class| class.attributes.get("equality"));
        let common = || defaults?.iter().find(|(own, _)| *own == "active").map(|(_, value)| *value);
        element.get("active").or_else(common) != Some("false")
    }

    /// The actuators in the class of an actuator.
    pub(super) fn actuator_defaults(&self, element: &Element) -> impl Iterator<Item = &'x Element> {
        let class = self.classes.get(element.get("class").unwrap_or(MAIN));
        class.into_iter().flat_map(|class| &class.actuators).copied()
    }

    /// The numbers of an attribute of an element, or of its class.
    pub(super) fn numbers(&self, element: &Element, class: &str, name: &str) -> Result<Option<Vec<f64>>, Error> {
        self.get(element, class, name).map(|text| self.parse(element, name, text)).transpose()
    }

    /// The numbers of an attribute of an element, without its class.
    pub(super) fn own_numbers(&self, element: &Element, name: &str) -> Result<Option<Vec<f64>>, Error> {
        element.get(name).map(|text| self.parse(element, name, text)).transpose()
    }

    fn parse(&self, element: &Element, name: &str, text: &str) -> Result<Vec<f64>, Error> {
        let read = |word: &str| finite(word);
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(read).collect();
        match numbers {
            Some(numbers) if numbers.iter().any(|number| number.abs() >= 1e100) => {
                let title = format!("`{name}` has a number that is too large");
                Err(self.xml.error(element, name, &title, "write numbers of less than 1e100"))
            }
            Some(numbers) if !numbers.is_empty() => Ok(numbers),
            _ => {
                let title = format!(
                    "`{name}=\"{}\"` is not a list of finite numbers",
                    text.chars().take(40).collect::<String>()
                );
                Err(self.xml.error(element, name, &title, "write numbers with spaces between them"))
            }
        }
    }

    /// One number.
    pub(super) fn number(&self, element: &Element, class: &str, name: &str) -> Result<Option<f64>, Error> {
        Ok(self.numbers(element, class, name)?.map(|numbers| numbers[0]))
    }

    /// Three numbers.
    pub(super) fn vector(&self, element: &Element, class: &str, name: &str) -> Result<Option<Vector>, Error> {
        match self.numbers(element, class, name)?.as_deref() {
            None => Ok(None),
            Some(&[x, y, z]) => Ok(Some([x, y, z])),
            Some(_) => Err(self.xml.error(element, name, &format!("`{name}` has three numbers"), "write x, y and z")),
        }
    }

    /// An angle in radians.
    pub(super) fn angle(&self, value: f64) -> f64 {
        if self.is_degree { value.to_radians() } else { value }
    }

    /// The frame of an element.
    pub(super) fn frame(&self, element: &Element, class: &str) -> Result<Frame, Error> {
        let place = self.vector(element, class, "pos")?.unwrap_or([0.0; 3]);
        Ok(Frame { place, axes: self.axes(element, class)? })
    }

    fn axes(&self, element: &Element, class: &str) -> Result<Matrix, Error> {
        let wrong = |name: &str| {
            let title = format!("`{name}` gives no orientation");
            Err(self.xml.error(
                element,
                name,
                &title,
                "give it its full count of numbers, its axes not zero and not parallel",
            ))
        };
        if let Some(quat) = self.numbers(element, class, "quat")? {
            let &[w, x, y, z] = &quat[..] else { return wrong("quat") };
            let length = w.hypot(norm([x, y, z]));
            return if length > 1e-12 {
                Ok(from_quaternion(w / length, [x, y, z].map(|part| part / length)))
            } else {
                wrong("quat")
            };
        }
        if let Some(turned) = self.numbers(element, class, "axisangle")? {
            let &[x, y, z, angle] = &turned[..] else { return wrong("axisangle") };
            return if norm([x, y, z]) > 0.0 { Ok(turn([x, y, z], self.angle(angle))) } else { wrong("axisangle") };
        }
        if let Some(angles) = self.vector(element, class, "euler")? {
            let mut axes = IDENTITY;
            for (letter, angle) in self.sequence.chars().zip(angles) {
                let axis = IDENTITY["xyz".find(letter.to_ascii_lowercase()).unwrap_or(0)];
                let own = turn(axis, self.angle(angle));
                // Axes in small letters turn with the body.
                axes = if letter.is_ascii_lowercase() { product(&axes, &own) } else { product(&own, &axes) };
            }
            return Ok(axes);
        }
        if let Some(both) = self.numbers(element, class, "xyaxes")? {
            let &[a, b, c, d, e, f] = &both[..] else { return wrong("xyaxes") };
            let x = unit([a, b, c]);
            let z = unit(cross(x, [d, e, f]));
            let y = cross(z, x);
            return if norm(y) > 0.5 { Ok(transposed(&[x, y, z])) } else { wrong("xyaxes") };
        }
        if let Some(z) = self.vector(element, class, "zaxis")? {
            return if norm(z) > 0.0 { Ok(with_z(z)) } else { wrong("zaxis") };
        }
        Ok(IDENTITY)
    }
}

/// The axes of a frame with this z axis, by the smallest rotation.
pub(super) fn with_z(z: Vector) -> Matrix {
    let z = unit(z);
    let axis = cross([0.0, 0.0, 1.0], z);
    let sine = norm(axis);
    if sine > 1e-12 {
        turn(axis, sine.atan2(z[2]))
    } else if z[2] > 0.0 {
        IDENTITY
    } else {
        turn([1.0, 0.0, 0.0], std::f64::consts::PI)
    }
}

fn from_quaternion(w: f64, [x, y, z]: Vector) -> Matrix {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}
