//! The names of a scene and what they stand for.

use super::Context;
use crate::diagnostic::{Diagnostic, Span};
use crate::document::Identifier;
use crate::function::Function;
use crate::names::closest;
use crate::scene::Quantity;

/// The declared names, in the order of the file.
#[derive(Debug)]
pub(super) struct Scope {
    names: Vec<(Identifier, Kind)>,
    /// Parameters from this place on are not yet defined.
    pub(super) parameter_limit: usize,
}

/// What a declared name is.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Coordinate(usize),
    Parameter(usize),
    Point(usize),
}

impl Kind {
    fn describe(self) -> &'static str {
        match self {
            Self::Coordinate(_) => "a coordinate",
            Self::Parameter(_) => "a parameter",
            Self::Point(_) => "a point",
        }
    }
}

/// Why a name does not stand for anything here.
pub(super) struct Unresolved {
    title: String,
    label: String,
    help: Option<String>,
}

impl Unresolved {
    fn new(title: String, label: &str, help: Option<String>) -> Self {
        Self { title, label: label.to_owned(), help }
    }

    pub(super) fn at(self, span: Span) -> Diagnostic {
        let error = Diagnostic::error(self.title, span, self.label);
        match self.help {
            Some(help) => error.help(help),
            None => error,
        }
    }
}

impl Default for Scope {
    fn default() -> Self {
        Self { names: Vec::new(), parameter_limit: usize::MAX }
    }
}

impl Scope {
    pub(super) fn declare(&mut self, identifier: &Identifier, kind: Kind, findings: &mut Vec<Diagnostic>) {
        let (name, span) = (&identifier.name, identifier.span.clone());
        let reserved = match name.as_str() {
            "t" => Some("time"),
            "pi" => Some("the number pi"),
            _ if Function::named(name).is_some() => Some("a function"),
            _ => None,
        };
        if let Some(what) = reserved {
            let title = format!("`{name}` already means {what}");
            findings.push(Diagnostic::error(title, span, format!("cannot be {}", kind.describe())).help("choose another name"));
        } else if let Some((first, other)) = self.names.iter().find(|(other, _)| other.name == *name) {
            findings.push(
                Diagnostic::error(format!("`{name}` is defined twice"), span, format!("also {}", kind.describe()))
                    .context(first.span.clone(), format!("first defined here, as {}", other.describe())),
            );
        } else if let Some((first, _)) =
            self.names.iter().find(|(other, k)| matches!(k, Kind::Coordinate(_)) && name.strip_suffix("_dot") == Some(&other.name))
        {
            findings.push(
                Diagnostic::error(format!("`{name}` already means the rate of `{}`", first.name), span, "defined by itself")
                    .context(first.span.clone(), "its coordinate"),
            );
        }
        self.names.push((identifier.clone(), kind));
    }

    /// The names of the points, in their order.
    pub(super) fn points(&self) -> impl Iterator<Item = &str> {
        self.names.iter().filter(|(_, kind)| matches!(kind, Kind::Point(_))).map(|(identifier, _)| identifier.name.as_str())
    }

    /// What a name in a formula stands for.
    pub(super) fn look_up(&self, name: &str, context: Context) -> Result<Quantity, Unresolved> {
        let quantity = self.find(name).ok_or_else(|| self.unknown(name))?;
        let forbidden = match quantity {
            Quantity::Parameter(i) if i >= self.parameter_limit => {
                let help = "a parameter may depend on those above it";
                return Err(Unresolved::new(
                    format!("parameter `{name}` is used before it is defined"),
                    "defined here or further down",
                    Some(help.to_owned()),
                ));
            }
            Quantity::Coordinate(_) | Quantity::Point(..) if context < Context::Geometry => "moves with the mechanism",
            Quantity::Rate(_) | Quantity::PointRate(..) if context < Context::Geometry => "moves with the mechanism",
            Quantity::Rate(_) | Quantity::PointRate(..) if context < Context::Load => "is a rate",
            Quantity::PointRate(..) if context == Context::Condition => "is the rate of a point",
            Quantity::Time if context < Context::Load => "is time",
            _ => return Ok(quantity),
        };
        let allowed = match context {
            Context::Constant => "here only numbers and parameters can stand",
            Context::Geometry => "here only coordinates, points, parameters and numbers can stand",
            Context::Load | Context::Condition => "use coordinates and their rates instead",
        };
        Err(Unresolved::new(format!("`{name}` {forbidden}"), "not possible here", Some(allowed.to_owned())))
    }

    fn find(&self, name: &str) -> Option<Quantity> {
        match name {
            "pi" => return Some(Quantity::Pi),
            "t" => return Some(Quantity::Time),
            _ => {}
        }
        let declared = |name: &str| self.names.iter().find(|(i, _)| i.name == name).map(|(_, kind)| *kind);
        if let Some((point, component)) = name.split_once('.') {
            let Some(Kind::Point(i)) = declared(point) else { return None };
            return match component {
                "x" => Some(Quantity::Point(i, 0)),
                "y" => Some(Quantity::Point(i, 1)),
                "x_dot" => Some(Quantity::PointRate(i, 0)),
                "y_dot" => Some(Quantity::PointRate(i, 1)),
                _ => None,
            };
        }
        match declared(name) {
            Some(Kind::Coordinate(i)) => Some(Quantity::Coordinate(i)),
            Some(Kind::Parameter(i)) => Some(Quantity::Parameter(i)),
            Some(Kind::Point(_)) => None,
            None => match declared(name.strip_suffix("_dot")?) {
                Some(Kind::Coordinate(i)) => Some(Quantity::Rate(i)),
                _ => None,
            },
        }
    }

    fn unknown(&self, name: &str) -> Unresolved {
        let is_point = |name: &str| self.points().any(|p| p == name);
        if is_point(name) {
            let help = format!("write `{name}.x` or `{name}.y`");
            return Unresolved::new(format!("`{name}` is a point, not a number"), "its component is missing", Some(help));
        }
        let mut candidates: Vec<String> = vec!["pi".to_owned()];
        for (identifier, kind) in &self.names {
            let n = &identifier.name;
            match kind {
                Kind::Coordinate(_) => candidates.extend([n.clone(), format!("{n}_dot")]),
                Kind::Parameter(_) => candidates.push(n.clone()),
                Kind::Point(_) => candidates.extend([format!("{n}.x"), format!("{n}.y")]),
            }
        }
        let near = closest(name, candidates.iter().map(String::as_str));
        Unresolved::new(format!("unknown name `{name}`"), "not known", near.map(|near| format!("did you mean `{near}`?")))
    }
}
