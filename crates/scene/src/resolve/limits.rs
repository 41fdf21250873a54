//! Limits on the formulae of a scene. The symbolic engine expands products; the sizes of the results are counted in
//! advance, without expanding.

use std::collections::BTreeSet;

use crate::diagnostic::Diagnostic;
use crate::document::{Document, Identifier};
use crate::evaluate::known_values;
use crate::expression::Node;
use crate::function::Function;
use crate::parser::OPERATION_LIMIT;
use crate::resolve::motion_values;
use crate::scene::{LoadKind, Quantity, Scene, Value};

/// The largest number of parameters, and of points. The generated code is compiled as a whole: 2000 take a second to
/// generate.
const NAMES: usize = 2000;
/// The largest number of coordinates, constraints, links, and joints: square matrices of this size are factorized.
const EQUATIONS: usize = 1000;
/// The largest number of numbers, names and operations in a formula, with points substituted.
const OPERATIONS: f64 = OPERATION_LIMIT as f64;
/// The largest number of terms of a position, an angle or a constraint and of its derivative, expanded. The mass matrix
/// contains products of two of them: 7 s at this limit.
const TERMS: f64 = 250.0;
/// The largest number of terms of a load or an output and of its derivative, expanded.
const TERMS_OF_LOADS: f64 = 1000.0;
/// The largest nesting depth of functions. Each level may double the number of terms of the mass matrix where squares
/// of sines are replaced. A fraction in a denominator counts twice: each derivative adds another power of it.
const DEPTH: u32 = 8;
/// The largest number of bits of a coefficient. A double has 53; exact numbers are longer and slower.
const DIGITS: f64 = 10_000.0;

/// Reports too many entries of one kind.
pub(super) fn are_too_many(document: &Document, findings: &mut Vec<Diagnostic>) -> bool {
    let before = findings.len();
    let parameters = document.parameters.iter().map(|parameter| &parameter.identifier);
    let points = document.points.iter().chain(document.links.iter().flat_map(|link| &link.points));
    let mut limit = |what: &str, names: Vec<&Identifier>, most: usize, remedy: &str| {
        let Some(first) = names.get(most) else { return };
        let label = format!("number {} of {}", most + 1, names.len());
        let error = Diagnostic::error(format!("too many {what}"), first.span.clone(), label);
        findings.push(error.help(format!("a scene has at most {most} of them; {remedy}")));
    };
    limit("parameters", parameters.collect(), NAMES, "write numbers that nothing changes as numbers");
    limit("points", points.map(|(name, _)| name).collect(), NAMES, "write formulae where they are used once");
    let split = "split the mechanism";
    limit("coordinates", document.coordinates.iter().map(|c| &c.identifier).collect(), EQUATIONS, split);
    limit("constraints", document.constraints.iter().map(|c| &c.identifier).collect(), EQUATIONS, split);
    limit("links", document.links.iter().map(|link| &link.identifier).collect(), EQUATIONS, split);
    limit("joints", document.joints.iter().map(|joint| &joint.identifier).collect(), EQUATIONS, split);
    findings.len() > before
}

/// Reports formulae that are too large for the engine after the substitution of points.
pub(super) fn sizes(scene: &Scene, findings: &mut Vec<Diagnostic>) {
    let coordinates = coordinates_of_points(scene);
    let mut points: Vec<[Size; 2]> = Vec::with_capacity(scene.points.len());
    let mut measured = |value: &Value, points: &[[Size; 2]], length: Size, terms: f64| {
        measure(value, points, length, terms).unwrap_or_else(|finding| {
            findings.push(*finding);
            // Consequential errors are not reported.
            Size::LEAF
        })
    };
    for (place, point) in scene.points.iter().enumerate() {
        let size = [0, 1].map(|axis| measured(&point.position[axis], &points, Size::LEAF, TERMS));
        // Points of several coordinates have names in large trees.
        let is_named = |axis: usize| scene.is_large_tree() && coordinates[place][axis].len() > 1;
        points.push([0, 1].map(|axis| if is_named(axis) { Size::LEAF } else { size[axis] }));
    }
    let laws = scene.loads.iter().filter_map(|load| match &load.kind {
        LoadKind::Spring { along, potential, force, friction, .. } => {
            let laws = potential.iter().chain(force).chain(friction.iter().map(|own| &own.size));
            Some((along, laws.collect::<Vec<_>>()))
        }
        _ => None,
    });
    let laws: Vec<(&Value, Vec<&Value>)> = laws.collect();
    let loads = scene.loads.iter().flat_map(|load| load.kind.formulae());
    let outputs = scene.outputs.iter().flat_map(|output| output.kind.formulae());
    let forces: Vec<&Value> = loads.chain(outputs).collect();
    for value in motion_values(scene) {
        // The laws of a load are formulae of its length.
        let is_law = |(_, laws): &&(&Value, Vec<&Value>)| laws.iter().any(|law| std::ptr::eq(*law, value));
        let along = laws.iter().find(is_law).map(|(along, _)| *along);
        let length = along.and_then(|along| measure(along, &points, Size::LEAF, TERMS_OF_LOADS).ok());
        let is_force = forces.iter().any(|force| std::ptr::eq(*force, value));
        let terms = if is_force { TERMS_OF_LOADS } else { TERMS };
        measured(value, &points, length.unwrap_or(Size::LEAF), terms);
    }
}

/// The coordinates on which abscissa and ordinate of each point depend.
fn coordinates_of_points(scene: &Scene) -> Vec<[BTreeSet<usize>; 2]> {
    let mut points: Vec<[BTreeSet<usize>; 2]> = Vec::with_capacity(scene.points.len());
    for point in &scene.points {
        let coordinates = |value: &Value| {
            let mut found = BTreeSet::new();
            for name in value.names() {
                match *name {
                    Quantity::Coordinate(i) => {
                        found.insert(i);
                    }
                    Quantity::Point(p, axis) => found.extend(points.get(p).into_iter().flat_map(|own| &own[axis])),
                    _ => {}
                }
            }
            found
        };
        let position = point.position.each_ref().map(coordinates);
        points.push(position);
    }
    points
}

/// The size of an expression.
#[derive(Clone, Copy, Debug)]
struct Size {
    /// Operations, with points substituted. All counts are doubles, which do not overflow.
    operations: f64,
    /// Terms after expansion.
    terms: f64,
    /// Terms of the derivative after expansion.
    derivative: f64,
    /// Nesting depth of functions.
    depth: u32,
    /// Binary digits of the coefficients.
    digits: f64,
}

impl Size {
    const LEAF: Self = Self { operations: 1.0, terms: 1.0, derivative: 1.0, depth: 0, digits: 1.0 };

    fn sum(self, other: Self) -> Self {
        Self {
            operations: self.operations + other.operations + 1.0,
            terms: self.terms + other.terms,
            derivative: self.derivative + other.derivative,
            depth: self.depth.max(other.depth),
            digits: if self.is_constant() && other.is_constant() {
                self.digits + other.digits
            } else {
                self.digits.max(other.digits)
            },
        }
    }

    fn product(self, other: Self) -> Self {
        Self {
            operations: self.operations + other.operations + 1.0,
            terms: self.terms * other.terms,
            derivative: self.derivative * other.terms + self.terms * other.derivative,
            depth: self.depth.max(other.depth),
            digits: self.digits + other.digits,
        }
    }

    /// The size of the reciprocal: a denominator is not expanded.
    fn reciprocal(self) -> Self {
        let is_sum = self.terms > 1.0 && !self.is_constant();
        Self { terms: 1.0, depth: self.depth + if is_sum { 2 } else { 0 }, ..self }
    }

    fn power(self, exponent: f64) -> Self {
        if exponent < 0.0 {
            return self.power(-exponent).reciprocal();
        }
        let n = exponent;
        let operations = self.operations + 2.0;
        if n.fract() != 0.0 {
            let digits = self.digits + 64.0;
            return Self { operations, terms: 1.0, derivative: self.derivative, digits, ..self };
        }
        let derivative = self.derivative * if n == 0.0 { 0.0 } else { multinomial(self.terms, n - 1.0) };
        let digits = self.digits * n.max(1.0);
        Self { operations, terms: multinomial(self.terms, n), derivative, digits, ..self }
    }

    fn call(function: Function, arguments: &[Self]) -> Self {
        let all = arguments.iter().copied().reduce(Self::sum).unwrap_or(Self::LEAF);
        let times = match function {
            Function::Abs | Function::Sign | Function::Floor => return all,
            // Sum, difference, and the sign of the difference.
            Function::Min | Function::Max => 2.0,
            _ => 0.0,
        };
        let depth = all.depth + u32::from(times == 0.0 && !all.is_constant());
        let terms = (times * all.terms).max(1.0);
        let derivative = all.derivative * times.max(1.0);
        Self { operations: all.operations * times.max(1.0) + 1.0, terms, derivative, depth, ..all }
    }

    fn is_constant(self) -> bool {
        self.derivative == 0.0
    }

    /// The exceeded limit: a description, the size, and a remedy.
    fn excess(self, most: f64) -> Option<(&'static str, String, String)> {
        let written = |number: f64, what: &str| match number {
            large if large > 1e15 => format!("more than 1e15 {what}"),
            number => format!("{number} {what}"),
        };
        if self.operations > OPERATIONS {
            let help = format!("a formula has at most {OPERATIONS} numbers, names and operations, points written out");
            return Some(("a formula is too long", written(self.operations, "numbers, names and operations"), help));
        }
        if self.digits > DIGITS {
            let help = format!(
                "coefficients are exact, up to {DIGITS} binary digits; write the value of a large power as a number"
            );
            return Some(("a number in a formula is too long", written(self.digits, "binary digits"), help));
        }
        let terms = self.derivative.max(self.terms);
        if terms > most {
            let help = format!(
                "this formula and its derivative have at most {most} terms, multiplied out with points written out; \
                 make a part of it a coordinate that a constraint holds"
            );
            return Some(("a formula is too large to be differentiated", written(terms, "terms"), help));
        }
        (self.depth > DEPTH).then(|| {
            let help = format!(
                "functions are nested at most {DEPTH} deep, and fractions {}, points written out; make a part of it a \
                 coordinate that a constraint holds",
                DEPTH / 2
            );
            ("functions nested too deeply", format!("{} deep", self.depth), help)
        })
    }
}

/// The number of terms in the `n`-th power of a sum with this number of terms.
fn multinomial(terms: f64, n: f64) -> f64 {
    let (many, few) = ((terms - 1.0).max(n), (terms - 1.0).min(n));
    let mut count = 1.0;
    let mut k = 1.0;
    // Above one each factor is at least two, so the loop is short.
    while k <= few && count < 1e300 {
        count *= (many + k) / k;
        k += 1.0;
    }
    count.round()
}

/// The size of a formula, or of its first part that is too large.
fn measure(value: &Value, points: &[[Size; 2]], length: Size, terms: f64) -> Result<Size, Box<Diagnostic>> {
    let exponents = known_values(value, |_| None);
    let mut sizes: Vec<Size> = Vec::with_capacity(value.nodes().len());
    for (id, node) in value.nodes().iter().enumerate() {
        let size = match node {
            Node::Number(number) => {
                let digits = (number.exact.numer().bits() + number.exact.denom().bits()) as f64;
                Size { derivative: 0.0, digits, ..Size::LEAF }
            }
            Node::Name(Quantity::Point(point, axis)) => points[*point][*axis],
            Node::Name(Quantity::PointRate(point, axis)) => {
                let position = points[*point][*axis];
                Size { terms: position.derivative.max(1.0), ..position }
            }
            Node::Name(Quantity::Stretch | Quantity::StretchRate) => length,
            Node::Name(_) => Size::LEAF,
            Node::Negate(a) => sizes[*a],
            Node::Add(a, b) | Node::Subtract(a, b) => sizes[*a].sum(sizes[*b]),
            Node::Multiply(a, b) => sizes[*a].product(sizes[*b]),
            Node::Divide(a, b) => sizes[*a].product(sizes[*b].reciprocal()),
            Node::Power(a, b) => sizes[*a].power(exponents[*b].unwrap_or(1.0)),
            Node::Call(function, arguments) => {
                let arguments: Vec<Size> = arguments.iter().map(|&argument| sizes[argument]).collect();
                Size::call(*function, &arguments)
            }
            Node::Spline(_, argument) => Size::call(Function::Sin, &[sizes[*argument]]),
        };
        if let Some((title, label, help)) = size.excess(terms) {
            return Err(Box::new(Diagnostic::error(title, value.span(id), label).help(help)));
        }
        sizes.push(size);
    }
    Ok(sizes.last().copied().unwrap_or(Size::LEAF))
}
