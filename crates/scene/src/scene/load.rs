//! The kinds of loads.

use super::{Quantity, Value};
use crate::expression::Node;
use crate::function::Function;

/// The kinds of applied loads.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
#[expect(clippy::large_enum_variant, reason = "a scene has few loads")]
pub enum LoadKind {
    /// A force at a place.
    Force {
        /// The components of the force.
        force: [Value; 2],
        /// The position on which it acts.
        at: [Value; 2],
        /// The body on whose centre of mass it acts, if a body was named.
        body: Option<usize>,
    },
    /// A torque that works on an angle.
    Torque {
        /// The value of the torque.
        torque: Value,
        /// The angle.
        angle: Value,
        /// The body with this angle.
        body: usize,
    },
    /// A field of acceleration that acts on every mass.
    Gravity([Value; 2]),
    /// Springs, dampers and other loads along a length or an angle.
    Spring {
        /// The length or angle.
        along: Value,
        /// Stiffness.
        stiffness: Option<Value>,
        /// The length or angle at which the spring is relaxed.
        rest: Option<Value>,
        /// Damping coefficient.
        damping: Option<Value>,
        /// A potential that depends on the length alone.
        potential: Option<Value>,
        /// A force or torque that is positive if it increases the length; it may depend on anything.
        force: Option<Value>,
        /// The friction along the length or angle.
        friction: Option<Friction>,
    },
}

/// A regularized dry friction: `-size*tanh(s_dot/slip)`, or `-size*|normal|*tanh(s_dot/slip)`.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Friction {
    /// The size of the friction force, or the coefficient of friction if there is a normal force.
    pub size: Value,
    /// The speed at which friction reaches three quarters of its full size.
    pub slip: Value,
    /// The output that is the normal force.
    pub normal: Option<usize>,
    /// The joint or load with this friction, in words.
    pub owner: String,
}

impl LoadKind {
    /// All formulae of the load.
    pub fn formulae(&self) -> Vec<&Value> {
        self.forces().into_iter().chain(self.places()).chain(self.laws()).collect()
    }

    /// The points between which it acts, if its length is written as `hypot(x, y)` or `sqrt(x^2 + y^2)`.
    pub fn between(&self) -> Option<[usize; 2]> {
        let Self::Spring { along, .. } = self else { return None };
        let nodes = along.nodes();
        let square = |id: usize| match nodes[id] {
            Node::Power(base, exponent) => {
                matches!(&nodes[exponent], Node::Number(number) if number.value == 2.0).then_some(base)
            }
            _ => None,
        };
        let components = match nodes.last()? {
            Node::Call(Function::Hypot, components) => [*components.first()?, *components.get(1)?],
            Node::Call(Function::Sqrt, sum) => match nodes[*sum.first()?] {
                Node::Add(a, b) => [square(a)?, square(b)?],
                _ => return None,
            },
            _ => return None,
        };
        let difference = |axis: usize| {
            let Node::Subtract(a, b) = nodes[components[axis]] else { return None };
            let point = |id: usize| match nodes[id] {
                Node::Name(Quantity::Point(point, of)) if of == axis => Some(point),
                _ => None,
            };
            Some([point(b)?, point(a)?])
        };
        let ([p, q], [r, s]) = (difference(0)?, difference(1)?);
        ([p, q] == [r, s] || [p, q] == [s, r]).then_some([p, q])
    }

    /// The formulae of forces and torques.
    pub fn forces(&self) -> Vec<&Value> {
        match self {
            Self::Force { force, .. } => force.iter().collect(),
            Self::Torque { torque, .. } => vec![torque],
            Self::Gravity(_) => Vec::new(),
            Self::Spring { force, friction, .. } => force.iter().chain(friction.iter().map(|own| &own.size)).collect(),
        }
    }

    /// The positions, angles and lengths along which it acts; empty if it acts on every mass.
    pub fn places(&self) -> Vec<&Value> {
        match self {
            Self::Force { at, .. } => at.iter().collect(),
            Self::Torque { angle, .. } => vec![angle],
            Self::Gravity(_) => Vec::new(),
            Self::Spring { along, .. } => vec![along],
        }
    }

    /// The output that is the normal force of its friction.
    pub fn normal(&self) -> Option<usize> {
        match self {
            Self::Spring { friction: Some(friction), .. } => friction.normal,
            _ => None,
        }
    }

    /// The formulae other than forces and positions: fields, stiffnesses, potentials.
    fn laws(&self) -> Vec<&Value> {
        match self {
            Self::Force { .. } | Self::Torque { .. } => Vec::new(),
            Self::Gravity(field) => field.iter().collect(),
            Self::Spring { stiffness, rest, damping, potential, friction, .. } => {
                let optional = [stiffness, rest, damping, potential].into_iter().flatten();
                optional.chain(friction.iter().map(|own| &own.slip)).collect()
            }
        }
    }

    /// A description of the load; the arguments print formulae.
    pub fn in_words(&self, formula: &dyn Fn(&Value) -> String, pair: &dyn Fn(&[Value; 2]) -> String) -> String {
        match self {
            Self::Force { force, at, .. } => format!("force `{}` at `{}`", pair(force), pair(at)),
            Self::Torque { torque, angle, .. } => {
                format!("torque `{}` along the angle `{}`", formula(torque), formula(angle))
            }
            Self::Gravity(field) => format!("gravity `{}`", pair(field)),
            Self::Spring { along, stiffness, rest, damping, potential, force, friction } => {
                let mut parts = Vec::new();
                if let Some(stiffness) = stiffness {
                    let rest = rest.as_ref().map_or_else(String::new, |rest| format!(", slack at `{}`", formula(rest)));
                    parts.push(format!("spring `{}`{rest}", formula(stiffness)));
                }
                let said = [("damper", damping), ("potential", potential), ("force", force)];
                let said =
                    said.into_iter().filter_map(|(what, value)| Some(format!("{what} `{}`", formula(value.as_ref()?))));
                parts.extend(said);
                parts.extend(friction.as_ref().map(|Friction { size, slip, normal, .. }| {
                    let what = if normal.is_some() { "friction of coefficient" } else { "friction" };
                    format!("{what} `{}` beyond the speed `{}`", formula(size), formula(slip))
                }));
                let place = formula(along);
                // The names of two points are printed next to each other.
                let between = place
                    .split_once(',')
                    .filter(|_| place.starts_with(|c: char| c.is_alphabetic()) && !place.contains('('));
                match between {
                    Some(_) => format!("{} between `{}`", parts.join(", "), place.replace(['"', '\''], "")),
                    None => format!("{} along `{place}`", parts.join(", ")),
                }
            }
        }
    }
}
