//! Units, and their factors to kg, m, s and rad.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Pow};

use crate::diagnostic::{Diagnostic, Span};
use crate::expression::{Expression, Node, NodeId, Number, to_f64};
use crate::names::suggestion;

/// The names of the exponents.
pub const BASE: [&str; 4] = ["kg", "m", "s", "rad"];

/// A unit as a product of powers of kg, m, s and rad, times a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// The exponents of kg, m, s and rad.
    pub exponents: [i32; 4],
    /// The factor without its power of pi.
    rational: BigRational,
    /// The power of pi in the factor.
    pi: i32,
}

/// A unit by name: the exponents of kg, m, s and rad, the numerator and the denominator of its factor, and the power of
/// pi in it.
type Known = (&'static str, [i32; 4], u64, u64, i32);

/// The known units.
const KNOWN: [Known; 52] = [
    ("kg", [1, 0, 0, 0], 1, 1, 0),
    ("g", [1, 0, 0, 0], 1, 1000, 0),
    ("mg", [1, 0, 0, 0], 1, 1_000_000, 0),
    ("t", [1, 0, 0, 0], 1000, 1, 0),
    ("lb", [1, 0, 0, 0], 45_359_237, 100_000_000, 0),
    ("m", [0, 1, 0, 0], 1, 1, 0),
    ("um", [0, 1, 0, 0], 1, 1_000_000, 0),
    ("mm", [0, 1, 0, 0], 1, 1000, 0),
    ("cm", [0, 1, 0, 0], 1, 100, 0),
    ("dm", [0, 1, 0, 0], 1, 10, 0),
    ("km", [0, 1, 0, 0], 1000, 1, 0),
    ("in", [0, 1, 0, 0], 254, 10_000, 0),
    ("ft", [0, 1, 0, 0], 3048, 10_000, 0),
    ("s", [0, 0, 1, 0], 1, 1, 0),
    ("us", [0, 0, 1, 0], 1, 1_000_000, 0),
    ("ms", [0, 0, 1, 0], 1, 1000, 0),
    ("min", [0, 0, 1, 0], 60, 1, 0),
    ("h", [0, 0, 1, 0], 3600, 1, 0),
    ("rad", [0, 0, 0, 1], 1, 1, 0),
    ("mrad", [0, 0, 0, 1], 1, 1000, 0),
    ("deg", [0, 0, 0, 1], 1, 180, 1),
    ("°", [0, 0, 0, 1], 1, 180, 1),
    ("grad", [0, 0, 0, 1], 1, 200, 1),
    ("rev", [0, 0, 0, 1], 2, 1, 1),
    ("turn", [0, 0, 0, 1], 2, 1, 1),
    ("rpm", [0, 0, -1, 1], 1, 30, 1),
    ("N", [1, 1, -2, 0], 1, 1, 0),
    ("mN", [1, 1, -2, 0], 1, 1000, 0),
    ("daN", [1, 1, -2, 0], 10, 1, 0),
    ("kN", [1, 1, -2, 0], 1000, 1, 0),
    ("MN", [1, 1, -2, 0], 1_000_000, 1, 0),
    ("kgf", [1, 1, -2, 0], 980_665, 100_000, 0),
    ("lbf", [1, 1, -2, 0], 44_482_216_152_605, 10_000_000_000_000, 0),
    ("Nm", [1, 2, -2, 0], 1, 1, 0),
    ("Nmm", [1, 2, -2, 0], 1, 1000, 0),
    ("Ncm", [1, 2, -2, 0], 1, 100, 0),
    ("kNm", [1, 2, -2, 0], 1000, 1, 0),
    ("J", [1, 2, -2, 0], 1, 1, 0),
    ("mJ", [1, 2, -2, 0], 1, 1000, 0),
    ("kJ", [1, 2, -2, 0], 1000, 1, 0),
    ("MJ", [1, 2, -2, 0], 1_000_000, 1, 0),
    ("W", [1, 2, -3, 0], 1, 1, 0),
    ("mW", [1, 2, -3, 0], 1, 1000, 0),
    ("kW", [1, 2, -3, 0], 1000, 1, 0),
    ("MW", [1, 2, -3, 0], 1_000_000, 1, 0),
    ("Pa", [1, -1, -2, 0], 1, 1, 0),
    ("kPa", [1, -1, -2, 0], 1000, 1, 0),
    ("MPa", [1, -1, -2, 0], 1_000_000, 1, 0),
    ("GPa", [1, -1, -2, 0], 1_000_000_000, 1, 0),
    ("bar", [1, -1, -2, 0], 100_000, 1, 0),
    ("%", [0, 0, 0, 0], 1, 100, 0),
    ("-", [0, 0, 0, 0], 1, 1, 0),
];

/// The kinds of quantities: the exponents, the name with an article, and the SI unit.
const KINDS: [([i32; 4], &str, &str); 17] = [
    ([0, 0, 0, 0], "a number", "1"),
    ([0, 0, 0, 1], "an angle", "rad"),
    ([0, 1, 0, 0], "a length", "m"),
    ([1, 0, 0, 0], "a mass", "kg"),
    ([0, 0, 1, 0], "a time", "s"),
    ([0, 1, -1, 0], "a velocity", "m/s"),
    ([0, 0, -1, 1], "an angular velocity", "rad/s"),
    ([0, 0, -1, 0], "a frequency", "1/s"),
    ([0, 1, -2, 0], "an acceleration", "m/s^2"),
    ([1, 1, -2, 0], "a force", "N"),
    ([1, 2, -2, 0], "a moment or an energy", "N m"),
    ([1, 2, -3, 0], "a power", "W"),
    ([1, 2, 0, 0], "a moment of inertia", "kg m^2"),
    ([1, 0, -2, 0], "a stiffness", "N/m"),
    ([1, 2, -2, -1], "a rotational stiffness", "N m/rad"),
    ([1, 0, -1, 0], "a damping", "N s/m"),
    ([1, -1, -2, 0], "a pressure", "Pa"),
];

impl Unit {
    /// Reads a unit such as `kg m^2`, `N s/m` or `(m/s)/s`; `None` if a part of it is unknown.
    ///
    /// A slash divides by all factors up to the next slash, or up to the end of its parentheses.
    pub fn parse(text: &str) -> Option<Self> {
        let (above, below) = split(text);
        let mut unit = factors(above)?;
        for part in below {
            unit = unit.times(&factors(part)?, -1);
        }
        Some(unit)
    }

    /// Whether a name is a unit that numbers in formulae may have.
    pub(crate) fn is_known(name: &str) -> bool {
        // `t` is the time.
        known(name).is_some() && !matches!(name, "t" | "-" | "%")
    }

    /// The unit of a pure number.
    pub(crate) fn one() -> Self {
        Self { exponents: [0; 4], rational: BigRational::one(), pi: 0 }
    }

    /// The unit of angles.
    pub(crate) fn radian() -> Self {
        Self { exponents: [0, 0, 0, 1], ..Self::one() }
    }

    /// The SI unit of a power; `None` if its exponents are no integers.
    pub(crate) fn power(&self, exponent: f64) -> Option<Self> {
        let powers = self.exponents.map(|own| f64::from(own) * exponent);
        if powers.iter().any(|power| power.fract() != 0.0 || power.abs() > 99.0) {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "small integers")]
        let exponents = powers.map(|power| power as i32);
        Some(Self { exponents, ..Self::one() })
    }

    /// The product with a power of another unit.
    #[must_use]
    pub fn times(&self, other: &Self, power: i32) -> Self {
        Self {
            exponents: [0, 1, 2, 3].map(|i| self.exponents[i] + power * other.exponents[i]),
            rational: &self.rational * Pow::pow(&other.rational, power),
            pi: self.pi + power * other.pi,
        }
    }

    /// The number of SI units, with angles in radians, in one of this unit.
    pub fn factor(&self) -> f64 {
        to_f64(&self.rational) * std::f64::consts::PI.powi(self.pi)
    }

    /// Whether it is a scaled unit of rates: 1/min may count turns or radians.
    pub(crate) fn is_ambiguous(&self) -> bool {
        self.exponents == [0, 0, -1, 0] && self.is_scaled()
    }

    /// Whether it is the unit of a pure number, or of an angle.
    pub(crate) fn is_number(&self) -> bool {
        self.exponents[..3] == [0; 3]
    }

    /// Whether it is the unit of a pure number, or a power of the radian other than the radian.
    pub(crate) fn is_plain(&self) -> bool {
        self.is_number() && self.exponents[3] != 1
    }

    /// Whether it is the unit of a pure number.
    pub(crate) fn is_one(&self) -> bool {
        self.exponents == [0; 4]
    }

    /// The kind of quantity with an article.
    pub(crate) fn quantity(&self) -> String {
        let kind = KINDS.iter().find(|(exponents, ..)| *exponents == self.exponents);
        kind.map_or_else(|| format!("a quantity in {}", self.base()), |(_, kind, _)| (*kind).to_owned())
    }

    /// The SI unit of the same kind.
    pub(crate) fn base(&self) -> String {
        if let Some((_, _, unit)) = KINDS.iter().find(|(exponents, ..)| *exponents == self.exponents) {
            return (*unit).to_owned();
        }
        let factors = |sign: i32| {
            let named = BASE.iter().zip(self.exponents).filter(|(_, power)| power * sign > 0);
            let text = |(name, power): (&&str, i32)| match power.abs() {
                1 => (*name).to_owned(),
                power => format!("{name}^{power}"),
            };
            named.map(text).collect::<Vec<_>>().join(" ")
        };
        let (above, below) = (factors(1), factors(-1));
        let above = if above.is_empty() { "1".to_owned() } else { above };
        match below.contains(' ') {
            _ if below.is_empty() => above,
            true => format!("{above}/({below})"),
            false => format!("{above}/{below}"),
        }
    }

    /// Whether the factor is not one.
    pub fn is_scaled(&self) -> bool {
        self.pi != 0 || !self.rational.is_one()
    }

    /// Whether quantities of both units can be added; angles are pure numbers.
    pub fn fits(&self, other: &Self) -> bool {
        self.exponents[..3] == other.exponents[..3]
    }

    /// A number in this unit, converted to SI units; `None` if the factor contains pi.
    pub(crate) fn number(&self, written: &Number) -> Option<Number> {
        let exact = &written.exact * &self.rational;
        match self.is_scaled() {
            false => Some(written.clone()),
            true => (self.pi == 0).then(|| rounded(exact)),
        }
    }

    /// Appends the conversion of a value from this unit to SI units.
    pub(crate) fn append(&self, formula: &mut Expression<String>, value: NodeId, span: &Span) -> NodeId {
        self.append_power(formula, value, 1, span)
    }

    /// Appends the conversion of a value from SI units to this unit.
    pub(crate) fn append_inverse(&self, formula: &mut Expression<String>, value: NodeId, span: &Span) -> NodeId {
        self.append_power(formula, value, -1, span)
    }

    /// The factor from SI units to this unit; `None` if it is one.
    pub(crate) fn inverse_factor(&self) -> Option<Expression<String>> {
        let mut formula = Expression::new();
        let factor = self.factor_power(&mut formula, -1, &(0..0))?;
        debug_assert_eq!(factor + 1, formula.nodes().len());
        Some(formula)
    }

    fn append_power(&self, formula: &mut Expression<String>, value: NodeId, power: i32, span: &Span) -> NodeId {
        match self.factor_power(formula, power, span) {
            Some(factor) => formula.push(Node::Multiply(value, factor), span.clone()),
            None => value,
        }
    }

    /// Appends a power of the factor; `None` if it is one.
    fn factor_power(&self, formula: &mut Expression<String>, power: i32, span: &Span) -> Option<NodeId> {
        let rational = Pow::pow(&self.rational, power);
        if self.pi == 0 {
            return self.is_scaled().then(|| formula.push(Node::Number(rounded(rational)), span.clone()));
        }
        let mut product = |whole: &BigInt, pi_power: i32| {
            let whole = (!whole.is_one()).then(|| Node::Number(rounded(BigRational::from(whole.clone()))));
            let factors = whole.into_iter().chain((0..pi_power).map(|_| Node::Name("pi".to_owned())));
            let ids: Vec<NodeId> = factors.map(|node| formula.push(node, span.clone())).collect();
            ids.into_iter().reduce(|a, b| formula.push(Node::Multiply(a, b), span.clone()))
        };
        let pi_power = power * self.pi;
        let above = product(rational.numer(), pi_power.max(0));
        let below = product(rational.denom(), (-pi_power).max(0));
        let Some(below) = below else { return above };
        let above = above.unwrap_or_else(|| formula.push(Node::Number(Number::whole(1)), span.clone()));
        Some(formula.push(Node::Divide(above, below), span.clone()))
    }
}

/// The number that is exactly this rational.
fn rounded(exact: BigRational) -> Number {
    let nearest = to_f64(&exact);
    Number::near(exact, nearest)
}

/// Reports a unit that is not known.
pub(crate) fn unknown_unit(text: &str, span: Span) -> Diagnostic {
    if Unit::parse(text).is_some_and(|unit| unit.is_ambiguous()) {
        let error = Diagnostic::error(format!("`{text}` may count turns or radians"), span, "which of them?");
        return error.help("write `rpm` or `rad/s`; other rates have the unit `1/s`");
    }
    let part = text.split(['/', '*', ' ', '(', ')', '^']).find(|part| !part.is_empty() && Unit::parse(part).is_none());
    let part = part.unwrap_or(text);
    // One letter is similar to any other.
    let names = KNOWN.iter().map(|(name, ..)| *name).filter(|_| part.len() > 1);
    let help = match part {
        "Hz" | "kHz" | "rps" => {
            "write `rpm` or `rev/s` for turns, `rad/s` for angles, `1/s` for other rates".to_owned()
        }
        "gram" | "grams" | "gr" => "did you mean `g`?".to_owned(),
        "inch" => "did you mean `in`?".to_owned(),
        "lbs" => "write `lb` for a mass, `lbf` for a force".to_owned(),
        _ => suggestion(part, names, || "units are such as `mm`, `kN`, `deg`, `rpm` and `kg m^2`".to_owned()),
    };
    Diagnostic::error(format!("unknown unit `{part}`"), span, "not known").help(help)
}

fn known(name: &str) -> Option<&'static Known> {
    KNOWN.iter().find(|(known, ..)| *known == name)
}

/// The text before the first slash outside of parentheses, and the texts between the others.
fn split(text: &str) -> (&str, Vec<&str>) {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, character) in text.char_indices() {
        match character {
            '(' => depth += 1,
            ')' => depth -= 1,
            '/' if depth == 0 => {
                parts.push(&text[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    (parts[0], parts[1..].to_vec())
}

/// Reads a product of powers of units.
fn factors(text: &str) -> Option<Unit> {
    let text = text.trim();
    if let Some(inner) = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')) {
        return Unit::parse(inner);
    }
    let mut unit = Unit::one();
    for factor in text.split([' ', '*', '·']).filter(|factor| !factor.is_empty() && *factor != "1") {
        let (name, power) = match factor.strip_suffix('²') {
            Some(name) => (name, "2"),
            None => factor.split_once('^').unwrap_or((factor, "1")),
        };
        let power = power.parse::<i32>().ok().filter(|power| power.abs() <= 9)?;
        let (_, exponents, numerator, denominator, pi) = *known(name)?;
        let rational = BigRational::new(BigInt::from(numerator), BigInt::from(denominator));
        unit = unit.times(&Unit { exponents, rational, pi }, power);
    }
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_taken_apart() {
        let is = |text: &str, exponents: [i32; 4], factor: f64| {
            let unit = Unit::parse(text).unwrap_or_else(|| panic!("{text}"));
            assert_eq!(unit.exponents, exponents, "{text}");
            assert!((unit.factor() / factor - 1.0).abs() < 1e-15, "{text}: {}", unit.factor());
        };
        is("kg m^2", [1, 2, 0, 0], 1.0);
        is("N s/m", [1, 0, -1, 0], 1.0);
        is("N m", [1, 2, -2, 0], 1.0);
        is("rad/s^2", [0, 0, -2, 1], 1.0);
        is("(m/s)/s^2", [0, 1, -3, 0], 1.0);
        is("N m/rad/s", [1, 2, -3, -1], 1.0);
        is("N/mm", [1, 0, -2, 0], 1e3);
        is("1/s", [0, 0, -1, 0], 1.0);
        is("rpm", [0, 0, -1, 1], std::f64::consts::PI / 30.0);
        is("lbf/in", [1, 0, -2, 0], 175.126_835_246_476_4);
        is("N m/deg", [1, 2, -2, -1], 180.0 / std::f64::consts::PI);
        is("", [0, 0, 0, 0], 1.0);
        assert_eq!(Unit::parse("furlong"), None);
        assert_eq!(Unit::parse("m^x"), None);
    }
}
