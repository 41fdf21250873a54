//! The names of a scene and their meanings.

use std::collections::HashMap;

use super::context::Context;
use crate::diagnostic::{Diagnostic, Span};
use crate::document::{Document, Identifier};
use crate::function::Function;
use crate::names::suggestion;
use crate::scene::Quantity;

/// The declared names, in the order of the file.
#[derive(Debug)]
pub(super) struct Scope {
    names: Vec<(Identifier, Kind)>,
    /// The place of the first declaration of each name.
    places: HashMap<String, usize>,
    /// The names that only conditions may contain.
    results: Vec<(String, Quantity)>,
    /// The index of the first parameter that is not defined yet.
    pub(super) parameter_limit: usize,
}

/// The kind of a declared name.
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

impl Default for Scope {
    fn default() -> Self {
        Self { names: Vec::new(), places: HashMap::new(), results: Vec::new(), parameter_limit: usize::MAX }
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
            findings.push(
                Diagnostic::error(title, span, format!("cannot be {}", kind.describe())).help("choose another name"),
            );
        } else if let Some((first, other)) = self.declared(name) {
            findings.push(
                Diagnostic::error(format!("`{name}` is defined twice"), span, format!("also {}", kind.describe()))
                    .context(first.span.clone(), format!("first defined here, as {}", other.describe()))
                    .help("choose another name for one of them"),
            );
        } else {
            // Coordinates are declared first, so only another coordinate can conflict with the name of this one's rate.
            let coordinates = self.names.iter().filter(|(_, kind)| matches!(kind, Kind::Coordinate(_))).map(|(i, _)| i);
            let is_rate = |rate: &str, of: &str| rate.strip_suffix("_dot") == Some(of);
            for other in coordinates {
                let (rate, coordinate) = if is_rate(name, &other.name) {
                    (identifier, other)
                } else if matches!(kind, Kind::Coordinate(_)) && is_rate(&other.name, name) {
                    (other, identifier)
                } else {
                    continue;
                };
                let title = format!("`{}` already means the rate of `{}`", rate.name, coordinate.name);
                findings.push(
                    Diagnostic::error(title, rate.span.clone(), "a rate is there without being declared")
                        .context(coordinate.span.clone(), "its coordinate")
                        .help("choose another name"),
                );
            }
        }
        self.places.entry(name.clone()).or_insert(self.names.len());
        self.names.push((identifier.clone(), kind));
    }

    /// Declares the results of a motion: accelerations, multipliers, outputs, energies.
    pub(super) fn declare_results<'n>(
        &mut self,
        coordinates: impl Iterator<Item = &'n str>,
        constraints: impl Iterator<Item = &'n str>,
        outputs: impl Iterator<Item = &'n str>,
    ) {
        let outputs = outputs.enumerate().map(|(i, name)| (name.to_owned(), Quantity::Output(i)));
        let accelerations =
            coordinates.enumerate().map(|(i, name)| (format!("{name}_ddot"), Quantity::Acceleration(i)));
        let multipliers = constraints.enumerate().map(|(i, name)| (format!("lambda_{name}"), Quantity::Multiplier(i)));
        let energies = [
            ("kinetic_energy", Quantity::KineticEnergy),
            ("potential_energy", Quantity::PotentialEnergy),
            ("energy", Quantity::Energy),
        ];
        let energies = energies.map(|(name, energy)| (name.to_owned(), energy));
        self.results = outputs.chain(accelerations).chain(multipliers).chain(energies).collect();
    }

    /// Reports a table whose name is already used.
    pub(super) fn declare_table(&self, table: &Identifier, document: &Document, findings: &mut Vec<Diagnostic>) {
        let points = document.points.iter().map(|(identifier, _)| (identifier, "a point"));
        let names = self.names.iter().map(|(identifier, kind)| (identifier, kind.describe())).chain(points);
        if let Some((first, what)) = names.into_iter().find(|(other, _)| other.name == table.name) {
            findings.push(
                Diagnostic::error(format!("`{}` is defined twice", table.name), table.span.clone(), "also a table")
                    .context(first.span.clone(), format!("first defined here, as {what}"))
                    .help("choose another name for one of them"),
            );
        }
    }

    /// The names of the points, in their order.
    pub(super) fn points(&self) -> impl Iterator<Item = &str> {
        self.names
            .iter()
            .filter(|(_, kind)| matches!(kind, Kind::Point(_)))
            .map(|(identifier, _)| identifier.name.as_str())
    }

    /// The quantity denoted by a name in a formula.
    pub(super) fn look_up(&self, name: &str, span: Span, context: Context) -> Result<Quantity, Diagnostic> {
        let own = match name {
            "s" => Some(Quantity::Stretch),
            "s_dot" => Some(Quantity::StretchRate),
            _ => None,
        };
        if let (Some(Quantity::StretchRate), Context::Potential) = (own, context) {
            let error = Diagnostic::error("`s_dot` is a rate", span, "not possible here");
            return Err(error.help("a potential depends on the length `s` alone; write the rest as `force`"));
        }
        if let (Some(own), Context::Law | Context::Potential) = (own, context) {
            return match self.declared("s").or(self.declared("s_dot")) {
                None => Ok(own),
                Some((declared, kind)) => {
                    let has = &declared.name;
                    let title = format!(
                        "`{name}` means the length that a load acts along, or its rate, and the scene has `{has}`"
                    );
                    Err(Diagnostic::error(title, span, "two meanings")
                        .context(declared.span.clone(), kind.describe())
                        .help("give that another name"))
                }
            };
        }
        if (name, context) == ("theta", Context::Profile) {
            return match self.declared(name) {
                Some((declared, kind @ Kind::Parameter(_))) => {
                    let title = "`theta` means the polar angle in the frame of a cam, and the scene has `theta`";
                    Err(Diagnostic::error(title, span, "two meanings")
                        .context(declared.span.clone(), kind.describe())
                        .help("give that another name"))
                }
                _ => Ok(Quantity::Stretch),
            };
        }
        let result = || self.results.iter().find(|(own, _)| own == name).map(|(_, result)| *result);
        let Some(quantity) = self.find(name).or_else(result) else { return Err(self.unknown(name, span, context)) };
        let forbidden = match quantity {
            Quantity::Parameter(i) if i >= self.parameter_limit => return Err(self.too_early(name, i, span)),
            Quantity::Coordinate(_) | Quantity::Point(..) if context < Context::Geometry => "moves with the mechanism",
            Quantity::Rate(_) | Quantity::PointRate(..) if context < Context::Geometry => "moves with the mechanism",
            Quantity::Rate(_) | Quantity::PointRate(..) if context < Context::Load => "is a rate",
            Quantity::Time if context < Context::Geometry => "is time",
            Quantity::Acceleration(_) if context != Context::Condition => "is an acceleration",
            Quantity::Multiplier(_) if context != Context::Condition => "is a multiplier",
            Quantity::Output(_) if context != Context::Condition => "is an output",
            Quantity::KineticEnergy | Quantity::PotentialEnergy | Quantity::Energy if context != Context::Condition => {
                "is an energy"
            }
            _ => return Ok(quantity),
        };
        let allowed = match context {
            Context::Constant => "here only numbers and parameters can stand",
            Context::Potential => {
                "a potential is a formula of the length `s`, parameters and numbers; write the rest as `force`"
            }
            Context::Profile => "a profile is a formula of the angle `theta`, parameters and numbers",
            Context::Geometry | Context::Picture => {
                "here only coordinates, points, parameters, numbers and `t` can stand"
            }
            Context::Load | Context::Law | Context::Condition => "use coordinates and their rates instead",
        };
        Err(Diagnostic::error(format!("`{name}` {forbidden}"), span, "not possible here").help(allowed))
    }

    /// Whether a name is declared, in any context.
    pub(super) fn knows(&self, name: &str) -> bool {
        self.find(name).is_some()
    }

    fn too_early(&self, name: &str, parameter: usize, span: Span) -> Diagnostic {
        let help = "a parameter may depend on those above it";
        if parameter == self.parameter_limit {
            return Diagnostic::error(format!("parameter `{name}` depends on itself"), span, "not yet defined")
                .help(help);
        }
        let error =
            Diagnostic::error(format!("parameter `{name}` is used before it is defined"), span, "not yet defined");
        match self.declared(name) {
            Some((identifier, _)) => error.context(identifier.span.clone(), "defined here").help(help),
            None => error.help(help),
        }
    }

    fn declared(&self, name: &str) -> Option<&(Identifier, Kind)> {
        self.places.get(name).map(|&place| &self.names[place])
    }

    fn find(&self, name: &str) -> Option<Quantity> {
        match name {
            "pi" => return Some(Quantity::Pi),
            "t" => return Some(Quantity::Time),
            _ => {}
        }
        let declared = |name: &str| self.declared(name).map(|(_, kind)| *kind);
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

    fn unknown(&self, name: &str, span: Span, context: Context) -> Diagnostic {
        let (base, component) = name.split_once('.').unwrap_or((name, ""));
        match self.declared(base) {
            Some((_, Kind::Point(_))) if component.is_empty() => {
                return Diagnostic::error(
                    format!("`{name}` is a point, not a number"),
                    span,
                    "its component is missing",
                )
                .help(format!("write `{name}.x` or `{name}.y`"));
            }
            Some((_, Kind::Point(_))) => {
                let components = if context == Context::Condition {
                    format!("write `{base}.x`, `{base}.y`, or their rates `{base}.x_dot`, `{base}.y_dot`")
                } else {
                    format!("write `{base}.x` or `{base}.y`")
                };
                return Diagnostic::error(format!("point `{base}` has no component `{component}`"), span, "not known")
                    .help(components);
            }
            Some((_, kind)) => {
                return Diagnostic::error(
                    format!("`{base}` is {}, not a point", kind.describe()),
                    span,
                    "has no components",
                )
                .help(format!("write `{base}`"));
            }
            None => {}
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
        if context == Context::Condition {
            candidates.extend(self.results.iter().map(|(name, _)| name.clone()));
        }
        let help = suggestion(name, candidates.iter().map(String::as_str), || {
            if context == Context::Condition {
                "names are declared in `coordinates`, [parameters], [points], [constraints] and [outputs]".to_owned()
            } else {
                "names are declared in `coordinates`, [parameters] and [points]".to_owned()
            }
        });
        Diagnostic::error(format!("unknown name `{name}`"), span, "not known").help(help)
    }
}
