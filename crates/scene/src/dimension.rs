//! The dimensions of the parts of a formula, as far as they are known.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use crate::diagnostic::{Diagnostic, Span};
use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::parser::Formula;
use crate::unit::Unit;

/// How a factor in a formula may differ from that of a unit and still be meant to convert it.
const SAME_FACTOR: f64 = 1e-3;

/// The dimension of a formula or of a part of it.
#[derive(Clone, Debug, Default)]
pub struct Dimension {
    /// A unit with this dimension; `None` if the dimension is not known.
    pub unit: Option<Unit>,
    /// The source of the unit.
    pub source: Source,
    /// Whether it is a formula of numbers without units.
    pub is_bare: bool,
    /// Whether pi is part of it.
    pub has_pi: bool,
    /// An error about a word that may be a unit or a name, where the formula does not have the unit of its place.
    pub ambiguity: Option<Box<Diagnostic>>,
}

/// The source of the unit of a quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// No unit, or that of a coordinate, a point or the time.
    #[default]
    Nature,
    /// The unit of a parameter in SI units. Formulae of such parameters may contain numbers with units of their own,
    /// such as 9.81.
    Declaration,
    /// A number with a unit: all contradictions are errors.
    Number,
    /// A name that is converted: the unit has to be known as well.
    Conversion,
}

impl Dimension {
    /// Whether numbers with a unit, or names that are converted, are part of it.
    pub fn is_certain(&self) -> bool {
        self.source >= Source::Number
    }

    /// An error if a formula at `span` cannot have this unit, or if its unit is not known although names in it are
    /// converted.
    pub fn misfit(&self, unit: &Unit, span: Span) -> Option<Diagnostic> {
        let Some(own) = &self.unit else {
            return (self.source == Source::Conversion).then(|| unknown_dimension(span));
        };
        let is_inverse = own.exponents == unit.exponents.map(|exponent| -exponent) && !own.is_one();
        if !self.is_certain() || (own.fits(unit) && !is_inverse) {
            return None;
        }
        if let Some(ambiguity) = &self.ambiguity {
            return Some((**ambiguity).clone());
        }
        let title = format!("expected {}, found {}", unit.quantity(), own.quantity());
        let help = match is_inverse {
            true => "a quotient such as `1/2 mm` divides by 2 mm: write `0.5 mm`".to_owned(),
            false => format!("write a value in {}, or in another unit of the same kind", unit.base()),
        };
        Some(Diagnostic::error(title, span, own.quantity()).help(help))
    }

    /// The dimension as that of a quantity that is to be converted, which has to be known.
    pub(crate) fn converted(self) -> Self {
        let unit = self.unit.filter(|_| !self.is_bare);
        Self { unit, source: Source::Conversion, ..self }
    }

    pub(crate) fn bare() -> Self {
        Self { unit: Some(Unit::one()), is_bare: true, ..Self::default() }
    }

    /// The dimension of a product with a power of another quantity.
    fn times(&self, other: &Self, power: i32) -> Self {
        let is_certain = self.is_certain() || other.is_certain();
        // Bare numbers may have a unit in SI formulae, such as 9.81.
        let unit = match self.is_bare != other.is_bare && !is_certain {
            true => None,
            false => self.unit.as_ref().zip(other.unit.as_ref()).map(|(a, b)| a.times(b, power)),
        };
        Self::joined(self, other, unit)
    }

    fn joined(a: &Self, b: &Self, unit: Option<Unit>) -> Self {
        let ambiguity = a.ambiguity.clone().or_else(|| b.ambiguity.clone());
        let (is_bare, has_pi) = (a.is_bare && b.is_bare, a.has_pi || b.has_pi);
        Self { unit, source: a.source.max(b.source), is_bare, has_pi, ambiguity }
    }

    fn with_unit(&self, unit: Option<Unit>) -> Self {
        Self { unit, ..self.clone() }
    }
}

/// An error about a formula with parts that are converted, and others without units.
pub(crate) fn unknown_dimension(span: Span) -> Diagnostic {
    let help = "give each parameter in it a unit, `\"-\"` for a pure number";
    Diagnostic::error("the unit of this formula is not known", span, "in which unit?").help(help)
}

/// The dimensions of the operations of a formula, and the conversions in it.
#[derive(Debug, Default)]
pub(crate) struct Dimensions {
    of: Vec<Dimension>,
    /// The product of the bare numbers that are factors of each operation.
    factors: Vec<f64>,
    /// The results of conversions.
    converted: BTreeMap<NodeId, Unit>,
}

impl Dimensions {
    /// The dimension of the whole formula.
    pub(crate) fn whole(&self) -> Dimension {
        self.of.last().cloned().unwrap_or_default()
    }

    /// The dimension of an operation.
    pub(crate) fn of(&self, id: NodeId) -> &Dimension {
        &self.of[id]
    }

    /// Notes that the last operation gives a quantity that is in this unit, or has been converted from it.
    pub(crate) fn note(&mut self, formula: &Formula, dimension: Dimension) {
        let last = formula.nodes().len() - 1;
        self.of.resize_with(last, Dimension::default);
        self.factors.resize(last, 1.0);
        self.factors.push(if dimension.has_pi { PI } else { 1.0 });
        if let Some(unit) = dimension.unit.clone().filter(|_| dimension.is_certain()) {
            self.converted.insert(last, unit);
        }
        self.of.push(dimension);
    }

    /// Derives the dimension of the last operation from those of its operands.
    ///
    /// # Errors
    /// Terms of different dimensions, a term without a unit where others are converted, and a function of a quantity
    /// that is not a number or an angle.
    pub(crate) fn derive(&mut self, formula: &Formula) -> Result<(), Diagnostic> {
        let of = |id: &NodeId| &self.of[*id];
        let dimension = match formula.nodes().last() {
            Some(Node::Number(_)) => Dimension::bare(),
            Some(Node::Negate(a)) => of(a).clone(),
            Some(Node::Add(a, b) | Node::Subtract(a, b)) => self.sum(formula, [*a, *b])?,
            Some(Node::Multiply(a, b)) => of(a).times(of(b), 1),
            Some(Node::Divide(a, b)) => of(a).times(of(b), -1),
            Some(Node::Power(a, b)) => {
                let exponent = match &formula.nodes()[*b] {
                    Node::Number(number) if of(b).is_bare => Some(number.value),
                    _ => None,
                };
                let unit = exponent.and_then(|exponent| of(a).unit.as_ref()?.power(exponent));
                of(a).with_unit(unit)
            }
            Some(Node::Call(function, arguments)) => self.call(formula, *function, arguments)?,
            Some(Node::Spline(_, argument)) => self.number(formula, *argument)?,
            _ => Dimension::default(),
        };
        let factor = |id: &NodeId| self.factors[*id];
        let factor = match formula.nodes().last() {
            Some(Node::Number(number)) => number.value,
            Some(Node::Negate(a)) => factor(a),
            Some(Node::Multiply(a, b)) => factor(a) * factor(b),
            Some(Node::Divide(a, b)) => factor(a) / factor(b),
            _ => 1.0,
        };
        self.factors.push(factor);
        self.of.push(dimension);
        Ok(())
    }

    fn call(&self, formula: &Formula, function: Function, arguments: &[NodeId]) -> Result<Dimension, Diagnostic> {
        let angle = |of: Dimension| {
            let source = if of.is_bare { Source::Number } else { of.source };
            Dimension { unit: Some(Unit::radian()), source, is_bare: false, ..of }
        };
        match (function, arguments) {
            (Function::Abs, [a]) => Ok(self.of[*a].clone()),
            (Function::Sqrt, [a]) => {
                let own = &self.of[*a];
                Ok(own.with_unit(own.unit.as_ref().and_then(|unit| unit.power(0.5))))
            }
            (Function::Min | Function::Max | Function::Hypot, [a, b]) => self.sum(formula, [*a, *b]),
            (Function::Atan2, [a, b]) => self.sum(formula, [*a, *b]).map(angle),
            (Function::Sign, [a]) => {
                let own = &self.of[*a];
                Ok(Dimension { is_bare: own.is_bare, has_pi: own.has_pi, ..Dimension::bare() })
            }
            (Function::Asin | Function::Acos | Function::Atan, [a]) => {
                self.number(formula, *a).map(|_| angle(self.of[*a].clone()))
            }
            (_, [a]) => self.number(formula, *a),
            _ => Ok(Dimension::default()),
        }
    }

    /// The dimension of a function of a number or an angle.
    fn number(&self, formula: &Formula, id: NodeId) -> Result<Dimension, Diagnostic> {
        let own = &self.of[id];
        if let Some(unit) = own.unit.as_ref().filter(|unit| own.is_certain() && !unit.is_number()) {
            let error =
                Diagnostic::error("the argument is not a number or an angle", formula.span(id), unit.quantity());
            return Err(error.help("write a quotient of quantities of the same kind, or an angle such as `30 deg`"));
        }
        Ok(Dimension { is_bare: own.is_bare, has_pi: own.has_pi, ..Dimension::bare() })
    }

    /// The dimension of two terms.
    fn sum(&self, formula: &Formula, terms: [NodeId; 2]) -> Result<Dimension, Diagnostic> {
        let [a, b] = terms.map(|id| &self.of[id]);
        let is_certain = a.is_certain() || b.is_certain();
        for ((id, own), other) in terms.into_iter().zip([a, b]).zip([b, a]) {
            let Some(unit) = other.unit.as_ref().filter(|unit| other.is_certain() && !unit.is_plain()) else {
                continue;
            };
            let is_zero = matches!(&formula.nodes()[id], Node::Number(number) if number.value == 0.0);
            // Angles in radians are written with pi.
            let is_angle = unit.is_number() && own.has_pi;
            if (own.is_bare && !is_zero && !is_angle) || (own.unit.is_none() && is_name(formula, id)) {
                let title = format!("a term has no unit, and {} is expected", unit.quantity());
                let example = if unit.is_number() { "deg".to_owned() } else { unit.base() };
                let help = match &formula.nodes()[id] {
                    Node::Number(number) => format!("write `{} {example}`, or another unit", number.value),
                    _ if own.is_bare => format!("write its numbers with a unit, such as `{example}`"),
                    _ => format!("give the parameter a unit, such as `unit = \"{example}\"`"),
                };
                return Err(Diagnostic::error(title, formula.span(id), "in which unit?").help(help));
            }
        }
        if let (Some(first), Some(second)) = (&a.unit, &b.unit)
            && is_certain
            && !(a.is_bare || b.is_bare)
            && !first.fits(second)
        {
            if let Some(ambiguity) = a.ambiguity.as_ref().or(b.ambiguity.as_ref()) {
                return Err((**ambiguity).clone());
            }
            let title = format!("{} and {} cannot be added or compared", first.quantity(), second.quantity());
            let error = Diagnostic::error(title, formula.span(terms[1]), second.quantity());
            return Err(error
                .context(formula.span(terms[0]), first.quantity())
                .help("write all terms in units of the same kind"));
        }
        let known = |own: &Dimension| own.unit.clone().filter(|_| !own.is_bare);
        let bare = || (a.is_bare && b.is_bare).then(Unit::one);
        // A term of an unknown unit takes that of the other one, where that is sure.
        let unit = match (known(a), known(b)) {
            (Some(unit), Some(_)) => Some(unit),
            (Some(unit), None) | (None, Some(unit)) if is_certain || a.is_bare || b.is_bare => Some(unit),
            _ => bare(),
        };
        Ok(Dimension::joined(a, b, unit))
    }

    /// An error if a name in the product `id` is converted from its unit, and once more by numbers in the formula.
    pub(crate) fn double_conversion(&self, formula: &Formula, id: NodeId) -> Option<Diagnostic> {
        let factor = self.factors[id];
        let is_twice = |unit: &Unit| {
            let is_turns = unit.exponents == [0, 0, -1, 1] && is_near(factor, 1.0 / 60.0);
            is_near(factor, unit.factor()) || is_turns
        };
        let (name, unit) = self.converted_factors(formula, id).into_iter().find(|(_, unit)| is_twice(unit))?;
        let title = format!("`{name}` is converted twice: by its unit, and by a factor in the formula");
        let error = Diagnostic::error(title, formula.span(id), "here, by a factor");
        Some(error.help(format!("take the factor out: a formula takes `{name}` in {}", unit.base())))
    }

    /// An error if a product in the formula is converted to `unit` by numbers in it.
    pub(crate) fn conversion(&self, formula: &Formula, unit: &Unit) -> Option<Diagnostic> {
        let is_product = |id: &NodeId| matches!(formula.nodes()[*id], Node::Multiply(..) | Node::Divide(..));
        let is_converting = |id: &NodeId| is_near(self.factors[*id] * unit.factor(), 1.0);
        let own = |id: &NodeId| !self.converted.contains_key(id) && !self.of[*id].is_bare;
        let id = (0..formula.nodes().len()).filter(is_product).filter(own).find(is_converting)?;
        let title = "the value is converted twice: by its unit, and by a factor in the formula";
        let error = Diagnostic::error(title, formula.span(id), "with a factor");
        Some(error.help(format!("take the factor out: the formula is in {}", unit.base())))
    }

    /// The converted names among the factors of an operation, with their units.
    fn converted_factors<'f>(&self, formula: &'f Formula, id: NodeId) -> Vec<(&'f str, &Unit)> {
        let (nodes, mut open, mut found) = (formula.nodes(), vec![id], Vec::new());
        while let Some(id) = open.pop() {
            match (self.converted.get(&id), &nodes[id]) {
                (Some(unit), Node::Multiply(name, _)) => {
                    if let Node::Name(name) = &nodes[*name] {
                        found.push((name.as_str(), unit));
                    }
                }
                (Some(_), _) => {}
                (None, Node::Negate(a)) => open.push(*a),
                (None, Node::Multiply(a, b) | Node::Divide(a, b)) => open.extend([*b, *a]),
                _ => {}
            }
        }
        found
    }
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_FACTOR * b.abs()
}

/// Whether a term is a name or its negative.
fn is_name(formula: &Formula, id: NodeId) -> bool {
    match formula.nodes()[id] {
        Node::Name(_) => true,
        Node::Negate(a) => is_name(formula, a),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::declarations::Declarations;
    use crate::parser::parse_quantity;

    /// Whether a formula is accepted for a quantity in this unit.
    fn is_accepted(text: &str, unit: &str, is_converted: bool) -> bool {
        let mut declarations = Declarations::default();
        let parameters = [("b", "mm"), ("h", "cm"), ("n", "rpm"), ("d", ""), ("mass", "kg"), ("m", "kg")];
        parameters.iter().for_each(|(name, unit)| declarations.declare_parameter(name, unit));
        declarations.declare_coordinate("phi", "rad");
        let unit = Unit::parse(unit).expect("a unit");
        let parsed = parse_quantity(text, 0, &declarations, is_converted.then_some(&unit));
        parsed.is_ok_and(|(_, dimension)| {
            let dimension = if is_converted { dimension.converted() } else { dimension };
            dimension.misfit(&unit, 0..text.len()).is_none()
        })
    }

    #[test]
    fn formulae_of_a_kind_are_accepted() {
        for (text, unit) in [
            ("3*b", "m"),
            ("b/3 + 2 cm", "m"),
            ("sqrt(b^2 + h^2)", "m"),
            ("hypot(b, 3 cm)*sin(30 deg)", "m"),
            ("0.3*sin(30 deg)", "m"),
            ("30 deg + pi/4", "rad"),
            ("30 deg + d*t", "rad"),
            ("n*t", "rad"),
            ("1/n", "s"),
            ("b^3", "m^3"),
            ("atan(h/b)", "rad"),
            ("-3 N/(m/s)*1 m/s", "N"),
            ("2 m", "m"),
            ("9.81*mass", "N"),
            ("100/sqrt(2) * 1 mm", "m"),
            ("d/2*max(-35 deg - phi, 0)^2", "N m"),
            ("20 deg + 3*t + 2*t^2", "rad"),
            ("3*10 kg", "kg"),
            ("max(b, 0)", "m"),
        ] {
            assert!(is_accepted(text, unit, false), "{text}");
        }
        for (text, unit) in [("3*A.x", "mm"), ("phi", "deg"), ("phi_dot", "rpm"), ("sin(phi)", "%"), ("b - A.x", "cm")]
        {
            assert!(is_accepted(text, unit, true), "{text}");
        }
    }

    #[test]
    fn contradictions_and_numbers_without_units_are_refused() {
        for (text, unit) in [
            ("1/2 mm", "m"),
            ("90/2 deg", "rad"),
            ("b + 0.1", "m"),
            ("b + 2*20", "m"),
            ("b + d", "m"),
            ("b + sqrt(400)", "m"),
            ("d*b", "m"),
            ("b", "kg"),
            ("3*b", "kg"),
            ("b/1000", "m"),
            ("n*2*pi/60", "rad/s"),
            ("n/60", "1/s"),
            ("2 m", "kg"),
            ("atan(200 mm/h^2)", "rad"),
            ("sin(3 mm)", "m"),
            ("2 kN + 3 mm", "N"),
            ("30 deg + 0.5", "rad"),
        ] {
            assert!(!is_accepted(text, unit, false), "{text}");
        }
        for (text, unit) in [
            ("A.x - 200", "mm"),
            ("5", "mm"),
            ("max(phi*180/pi, 0)", "deg"),
            ("57.3*phi", "deg"),
            ("abs(1000*A.x)", "mm"),
            ("phi_dot*9.549", "rpm"),
            ("d*phi", "deg"),
            ("A.x", "deg"),
            ("phi", "kN"),
            ("A.x_dot", "mm"),
        ] {
            assert!(!is_accepted(text, unit, true), "{text}");
        }
    }

    /// Recursion over operations would overflow the stack.
    #[test]
    fn long_formulae_are_walked_by_loops() {
        for text in ["1*".repeat(100_000) + "b", "1 deg".to_owned() + &" + pi".repeat(100_000)] {
            let error = parse_quantity(&text, 0, &Declarations::default(), None).expect_err("it is too long");
            assert_eq!(error.title, "a formula is too long");
        }
    }
}
