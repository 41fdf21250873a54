//! The dimensions of the parts of a formula, as far as they are known.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use crate::diagnostic::{Diagnostic, Span};
use crate::expression::{Node, NodeId};
use crate::function::Function;
use crate::parser::Formula;
use crate::unit::Unit;

/// The dimension of a formula or of a part of it.
#[derive(Clone, Debug, Default)]
pub struct Dimension {
    /// A unit with this dimension; `None` if the dimension is not known.
    pub unit: Option<Unit>,
    /// Whether numbers with a unit, or names that are converted, are part of it. Contradictions are then errors.
    pub is_certain: bool,
}

impl Dimension {
    /// An error if a formula at `span` cannot have this unit.
    pub fn misfit(&self, unit: &Unit, span: Span) -> Option<Diagnostic> {
        let own = self.unit.as_ref().filter(|own| self.is_certain && !(own.fits(unit) && own.counts_as(unit)))?;
        let title = format!("expected {}, found {}", unit.quantity(), own.quantity());
        let help = format!("write a value in {}, or in another unit of the same kind", unit.base());
        Some(Diagnostic::error(title, span, own.quantity()).help(help))
    }

    fn times(&self, other: &Self, power: i32) -> Self {
        let unit = self.unit.as_ref().zip(other.unit.as_ref()).map(|(a, b)| a.times(b, power));
        Self { unit, is_certain: self.is_certain || other.is_certain }
    }
}

/// The dimensions of the operations of a formula, and the conversions in it.
#[derive(Debug, Default)]
pub(crate) struct Dimensions {
    of: Vec<Dimension>,
    /// The results of conversions.
    converted: BTreeMap<NodeId, Unit>,
}

impl Dimensions {
    /// The dimension of the whole formula.
    pub(crate) fn whole(&self) -> Dimension {
        self.of.last().cloned().unwrap_or_default()
    }

    /// Notes that the last operation gives a quantity that has been converted from this unit, or that is in it.
    pub(crate) fn note(&mut self, formula: &Formula, unit: Option<Unit>, is_certain: bool) {
        let last = formula.nodes().len() - 1;
        self.of.resize_with(last, Dimension::default);
        if let Some(unit) = unit.clone().filter(|_| is_certain) {
            self.converted.insert(last, unit);
        }
        self.of.push(Dimension { unit, is_certain });
    }

    /// Derives the dimension of the last operation from those of its operands.
    ///
    /// # Errors
    /// Terms of different dimensions, a bare number as a term of a quantity with a unit, and the sine of something other
    /// than an angle.
    pub(crate) fn derive(&mut self, formula: &Formula) -> Result<(), Diagnostic> {
        let of = |id: &NodeId| &self.of[*id];
        let is_plain = |id: &NodeId| is_plain(&formula.nodes()[*id]);
        let dimension = match formula.nodes().last() {
            Some(Node::Negate(a)) => of(a).clone(),
            Some(Node::Add(a, b) | Node::Subtract(a, b)) => self.sum(formula, [*a, *b])?,
            Some(Node::Multiply(a, b)) if is_plain(a) => of(b).clone(),
            Some(Node::Multiply(a, b) | Node::Divide(a, b)) if is_plain(b) => of(a).clone(),
            Some(Node::Multiply(a, b)) => of(a).times(of(b), 1),
            Some(Node::Divide(a, b)) => of(a).times(of(b), -1),
            Some(Node::Power(a, b)) => match &formula.nodes()[*b] {
                Node::Number(number) if number.value == 2.0 => of(a).times(of(a), 1),
                _ => Dimension::default(),
            },
            Some(Node::Call(function, arguments)) => self.call(formula, *function, arguments)?,
            _ => Dimension::default(),
        };
        self.of.push(dimension);
        Ok(())
    }

    fn call(&self, formula: &Formula, function: Function, arguments: &[NodeId]) -> Result<Dimension, Diagnostic> {
        match (function, arguments) {
            (Function::Abs, [a]) => Ok(self.of[*a].clone()),
            (Function::Min | Function::Max | Function::Hypot, [a, b]) => self.sum(formula, [*a, *b]),
            (Function::Sin | Function::Cos | Function::Tan, [a]) => {
                let is_wrong = |unit: &Unit| self.of[*a].is_certain && !unit.is_number();
                match self.of[*a].unit.as_ref().filter(|unit| is_wrong(unit)) {
                    None => Ok(Dimension::default()),
                    Some(unit) => {
                        let error =
                            Diagnostic::error("the argument is not an angle", formula.span(*a), unit.quantity());
                        Err(error.help("write an angle, such as `30 deg`, or a number"))
                    }
                }
            }
            _ => Ok(Dimension::default()),
        }
    }

    /// The dimension of two terms.
    fn sum(&self, formula: &Formula, terms: [NodeId; 2]) -> Result<Dimension, Diagnostic> {
        let [a, b] = terms.map(|id| &self.of[id]);
        let is_certain = a.is_certain || b.is_certain;
        if let (Some(first), Some(second)) = (&a.unit, &b.unit)
            && is_certain
            && !first.fits(second)
        {
            let title = format!("{} and {} cannot be added or compared", first.quantity(), second.quantity());
            let error = Diagnostic::error(title, formula.span(terms[1]), second.quantity());
            return Err(error
                .context(formula.span(terms[0]), first.quantity())
                .help("write all terms in units of the same kind"));
        }
        for ((id, own), other) in terms.into_iter().zip([a, b]).zip([b, a]) {
            let unit = other.unit.as_ref().filter(|unit| other.is_certain && !unit.is_one());
            let number = bare_number(formula, id).filter(|number| *number != 0.0 && own.unit.is_none());
            if let (Some(unit), Some(number)) = (unit, number) {
                let title = format!("{number} has no unit, and {} is expected", unit.quantity());
                let example = if unit.is_number() { "deg".to_owned() } else { unit.base() };
                let help = format!("write `{number} {example}`, or another unit");
                return Err(Diagnostic::error(title, formula.span(id), "in which unit?").help(help));
            }
        }
        Ok(Dimension { unit: a.unit.clone().or_else(|| b.unit.clone()), is_certain })
    }

    /// An error if a name in the product `id` is converted from its unit, and once more by numbers in the formula.
    pub(crate) fn double_conversion(&self, formula: &Formula, id: NodeId) -> Option<Diagnostic> {
        let mut converted = Vec::new();
        let factor = self.bare_factor(formula, id, &mut converted);
        let (name, unit) = converted.into_iter().find(|(_, unit)| {
            // Turns per minute are converted by 2 pi as well.
            is_near(factor, unit.factor()) || (unit.is_frequency() && is_near(factor, TAU * unit.factor()))
        })?;
        let title = format!("`{name}` is converted twice: by its unit, and by a factor in the formula");
        let error = Diagnostic::error(title, formula.span(id), "here, by a factor");
        Some(error.help(format!("take the factor out: a formula takes `{name}` in {}", unit.base())))
    }

    /// An error if a term of the formula is converted to `unit` by numbers in it.
    pub(crate) fn conversion(&self, formula: &Formula, unit: &Unit) -> Option<Diagnostic> {
        let mut open = vec![formula.nodes().len() - 1];
        while let Some(id) = open.pop() {
            match formula.nodes()[id] {
                Node::Add(a, b) | Node::Subtract(a, b) => open.extend([a, b]),
                Node::Negate(a) => open.push(a),
                Node::Multiply(..) | Node::Divide(..)
                    if is_near(self.bare_factor(formula, id, &mut Vec::new()) * unit.factor(), 1.0) =>
                {
                    let title = "the value is converted twice: by its unit, and by a factor in the formula";
                    let error = Diagnostic::error(title, formula.span(id), "with a factor");
                    return Some(error.help(format!("take the factor out: the formula is in {}", unit.base())));
                }
                _ => {}
            }
        }
        None
    }

    /// The product of the bare numbers that are factors of an operation; adds the converted names among the factors.
    fn bare_factor(&self, formula: &Formula, id: NodeId, converted: &mut Vec<(String, Unit)>) -> f64 {
        let nodes = formula.nodes();
        if let Some(unit) = self.converted.get(&id) {
            if let Node::Multiply(name, _) = nodes[id]
                && let Node::Name(name) = &nodes[name]
            {
                converted.push((name.clone(), unit.clone()));
            }
            return 1.0;
        }
        match &nodes[id] {
            Node::Number(number) => number.value,
            Node::Name(name) if name == "pi" => PI,
            Node::Negate(a) => self.bare_factor(formula, *a, converted),
            Node::Multiply(a, b) => self.bare_factor(formula, *a, converted) * self.bare_factor(formula, *b, converted),
            Node::Divide(a, b) => self.bare_factor(formula, *a, converted) / self.bare_factor(formula, *b, converted),
            _ => 1.0,
        }
    }
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-6 * b.abs()
}

/// Whether a factor leaves the dimension of a product as it is: other bare numbers may have a unit.
fn is_plain(node: &Node<String>) -> bool {
    match node {
        Node::Number(number) => number.value == 2.0 || number.value == 0.5,
        Node::Name(name) => name == "pi",
        _ => false,
    }
}

/// The value of a number or of its negative.
fn bare_number(formula: &Formula, id: NodeId) -> Option<f64> {
    match &formula.nodes()[id] {
        Node::Number(number) => Some(number.value),
        Node::Negate(a) => bare_number(formula, *a).map(|number| -number),
        _ => None,
    }
}
