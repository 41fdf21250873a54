//! Terms as people write them: plain text for documentation, LaTeX for a derivation.

mod names;

use std::collections::{HashMap, HashSet};

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed};

use crate::term::{Named, Symbol, Term};
use names::{latex_function, latex_name};
use qrm_scene::expression::{Number, to_f64};
use qrm_scene::function::Function;
use qrm_scene::scene::Scene;
use qrm_scene::spline::Spline;

/// How formulae are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// As in a scene file, which reads it back: `O4B*cos(phi4)`, `phi4_ddot`.
    Plain,
    /// LaTeX in mathematical mode.
    Latex,
}

/// Writes formulae of one scene.
#[derive(Clone, Debug)]
pub struct Writer<'s> {
    scene: &'s Scene,
    style: Style,
    /// The radicand and the name of each root.
    roots: Vec<(Term, String)>,
    /// Quantities that have symbols of their own.
    names: &'s [Named],
    /// Names of the scene that would look like others as symbols.
    ambiguous: HashSet<&'s str>,
}

/// A product or quotient without its sign.
struct Fraction<'t> {
    is_negative: bool,
    coefficient: BigRational,
    above: Vec<Factor<'t>>,
    below: Vec<Factor<'t>>,
}

/// A power with a positive exponent.
struct Factor<'t> {
    base: &'t Term,
    exponent: BigRational,
}

impl<'s> Writer<'s> {
    /// For the formulae of this scene, in which quantities may have names.
    pub fn new(scene: &'s Scene, style: Style, names: &'s [Named]) -> Self {
        let mut alike: HashMap<String, HashSet<&str>> = HashMap::new();
        for name in scene.names() {
            alike.entry(latex_name("", name)).or_default().insert(name);
        }
        let ambiguous = alike.into_values().filter(|names| names.len() > 1).flatten().collect();
        Self { scene, style, roots: Vec::new(), names, ambiguous }
    }

    /// Gives each root of a sum that occurs in the terms more than once a name, under which it is written from now on.
    #[must_use]
    pub fn naming_roots<'t>(mut self, terms: impl IntoIterator<Item = &'t Term>) -> Self {
        let mut found: Vec<(&Term, usize)> = Vec::new();
        terms.into_iter().for_each(|term| radicands(term, &mut found));
        let radicands: Vec<&Term> = found.into_iter().filter(|(_, times)| *times > 1).map(|(term, _)| term).collect();
        // No name of the scene may look like one of these, with a number or without.
        let is_free = |letter: &&str| !self.scene.names().any(|name| name.starts_with(letter));
        let letter = ["r", "s", "u", "w", "h", "z", "k", "root"].into_iter().find(is_free).unwrap_or("square_root");
        let index = |i: usize| match self.style {
            _ if radicands.len() == 1 => String::new(),
            Style::Plain => format!("{}", i + 1),
            Style::Latex => format!("_{{{}}}", i + 1),
        };
        self.roots = radicands.iter().enumerate().map(|(i, &r)| (r.clone(), format!("{letter}{}", index(i)))).collect();
        self
    }

    /// The names of roots, and what they stand for.
    pub fn roots(&self) -> Vec<(String, String)> {
        let bare = Self { roots: Vec::new(), ..self.clone() };
        let root = |radicand: &Term| Term::Power(Box::new(radicand.clone()), BigRational::new(1.into(), 2.into()));
        self.roots.iter().map(|(radicand, name)| (name.clone(), bare.term(&root(radicand)))).collect()
    }

    /// A term.
    pub fn term(&self, term: &Term) -> String {
        self.summands(term).concat()
    }

    /// The parts of a sum, each with its sign; a single part if it is none.
    pub fn summands(&self, term: &Term) -> Vec<String> {
        let terms = if let Term::Sum(terms) = term { terms.as_slice() } else { std::slice::from_ref(term) };
        let mut fractions: Vec<Fraction> = terms.iter().map(Fraction::new).collect();
        // A sum that begins with a minus is harder to read.
        if let Some(first) = fractions.iter().position(|f| !f.is_negative) {
            fractions[..=first].rotate_right(1);
        }
        let signed = fractions.into_iter().enumerate().map(|(i, fraction)| {
            let sign = match (i, fraction.is_negative) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            format!("{sign}{}", self.fraction(fraction))
        });
        signed.collect()
    }

    /// A symbol.
    pub fn symbol(&self, symbol: Symbol) -> String {
        let coordinate = |i: usize| self.scene.coordinates[i].name.as_str();
        if self.style == Style::Plain {
            return match symbol {
                Symbol::Parameter(i) => self.scene.parameters[i].name.clone(),
                Symbol::Pi => "pi".to_owned(),
                Symbol::Time => "t".to_owned(),
                Symbol::Displacement => "delta".to_owned(),
                Symbol::Coordinate(i) => coordinate(i).to_owned(),
                Symbol::Rate(i) => format!("{}_dot", coordinate(i)),
                Symbol::Acceleration(i) => format!("{}_ddot", coordinate(i)),
                Symbol::Multiplier(i) => format!("lambda_{}", self.scene.constraints[i].name),
                Symbol::NormalForce(i) => format!("abs({})", self.scene.outputs[i].name),
                Symbol::Named(k) | Symbol::NamedSlope(k, _) | Symbol::NamedRate(k) | Symbol::NamedBias(k) => {
                    self.names[k].symbol_name(symbol, self.scene)
                }
                _ => unreachable!("a kernel is not written as formulae"),
            };
        }
        match symbol {
            Symbol::Parameter(i) => self.latex("", &self.scene.parameters[i].name),
            Symbol::Pi => r"\pi".to_owned(),
            Symbol::Time => "t".to_owned(),
            Symbol::Displacement => r"\delta".to_owned(),
            Symbol::Coordinate(i) => self.latex("", coordinate(i)),
            Symbol::Rate(i) => self.latex(r"\dot", coordinate(i)),
            Symbol::Acceleration(i) => self.latex(r"\ddot", coordinate(i)),
            Symbol::Multiplier(i) => {
                format!(r"\lambda_{{\mathrm{{{}}}}}", self.scene.constraints[i].name.replace('_', r"\_"))
            }
            Symbol::NormalForce(i) => format!("|{}|", self.latex("", &self.scene.outputs[i].name)),
            Symbol::Named(k) => latex_name("", &self.names[k].name),
            Symbol::NamedSlope(k, i) => {
                let (above, below) = (latex_name("", &self.names[k].name), self.symbol(Symbol::Coordinate(i)));
                format!(r"\tfrac{{\partial {above}}}{{\partial {below}}}")
            }
            Symbol::NamedRate(k) => latex_name(r"\dot", &self.names[k].name),
            Symbol::NamedBias(k) => latex_name(r"\mathring", &self.names[k].name),
            _ => unreachable!("a kernel is not written as formulae"),
        }
    }

    /// A name as a symbol; as it is if another name would look the same.
    fn latex(&self, accent: &str, name: &str) -> String {
        if self.ambiguous.contains(name) {
            return format!(r"{accent}{{\mathtt{{{}}}}}", name.replace('_', r"\_"));
        }
        latex_name(accent, name)
    }

    fn fraction(&self, fraction: Fraction) -> String {
        let Fraction { coefficient, above, below, is_negative } = fraction;
        let (numerator, denominator) = (coefficient.numer(), coefficient.denom());
        match self.style {
            Style::Plain => {
                let number = decimal(&coefficient);
                let rest = if number.is_some() { BigInt::one() } else { denominator.clone() };
                let above = self.product(number.unwrap_or_else(|| numerator.to_string()), &above, false);
                let many = below.len() + usize::from(!rest.is_one()) > 1;
                let below = self.product(rest.to_string(), &below, false);
                match below.as_str() {
                    "1" => above,
                    _ if many => format!("{above}/({below})"),
                    _ => format!("{above}/{below}"),
                }
            }
            Style::Latex if below.is_empty() => {
                let is_simple = !denominator.is_one() && *denominator <= BigInt::from(12);
                let number = decimal(&coefficient).filter(|_| !is_simple).map(|number| scientific(&number));
                let number = number.unwrap_or_else(|| format!(r"\tfrac{{{numerator}}}{{{denominator}}}"));
                self.product(number, &above, !is_negative)
            }
            Style::Latex => {
                let above = self.product(numerator.to_string(), &above, true);
                format!(r"\frac{{{above}}}{{{}}}", self.product(denominator.to_string(), &below, true))
            }
        }
    }

    /// A number times factors; a number that is one is not written, and a sum that stands alone may do without
    /// parentheses.
    fn product(&self, number: String, factors: &[Factor], may_be_bare: bool) -> String {
        if factors.is_empty() {
            return number;
        }
        let has_number = number != "1";
        let is_alone = factors.len() == 1 && !has_number && may_be_bare;
        let mut text = if has_number { number } else { String::new() };
        for (i, factor) in factors.iter().enumerate() {
            text += match (i, self.style, factor.base) {
                (0, _, _) if !has_number => "",
                (_, Style::Plain, _) => "*",
                // Two numbers side by side would be read as one.
                (0, Style::Latex, Term::Number(_)) => r" \cdot ",
                (_, Style::Latex, _) => r"\,",
            };
            text += &self.factor(factor, is_alone);
        }
        text
    }

    fn factor(&self, factor: &Factor, alone: bool) -> String {
        let Factor { base, exponent } = factor;
        if let Some((_, name)) = self.roots.iter().find(|(radicand, _)| *radicand == **base)
            && !(exponent.is_one() && alone)
        {
            let doubled = exponent * BigInt::from(2);
            return match (self.style, doubled.is_integer(), doubled.is_one()) {
                (_, _, true) => name.clone(),
                (Style::Plain, true, _) => format!("{name}^{doubled}"),
                (Style::Plain, false, _) => format!("{name}^({doubled})"),
                (Style::Latex, ..) => format!("{{{name}}}^{{{doubled}}}"),
            };
        }
        let half = BigRational::new(1.into(), 2.into());
        if *exponent == half {
            let radicand = self.term(base);
            return if self.style == Style::Plain {
                format!("sqrt({radicand})")
            } else {
                format!(r"\sqrt{{{radicand}}}")
            };
        }
        if exponent.is_one() {
            return match base {
                Term::Call(function, argument) => self.call(*function, argument, ""),
                Term::Spline(spline, order, argument) => self.spline(spline, *order, argument, ""),
                Term::Symbol(symbol) => self.symbol(*symbol),
                Term::Sum(_) if alone => self.term(base),
                Term::Number(n) if !n.is_negative() && n.is_integer() => self.term(base),
                _ => self.in_parentheses(&self.term(base)),
            };
        }
        let power = match (self.style, exponent.is_integer()) {
            (Style::Plain, true) => format!("^{exponent}"),
            (Style::Plain, false) => format!("^({exponent})"),
            (Style::Latex, _) => format!("^{{{exponent}}}"),
        };
        match base {
            Term::Call(function, argument) => self.call(*function, argument, &power),
            Term::Spline(spline, order, argument) => self.spline(spline, *order, argument, &power),
            Term::Symbol(symbol) => self.symbol(*symbol) + power.as_str(),
            Term::Number(n) if n.is_integer() && !n.is_negative() => self.term(base) + power.as_str(),
            _ => self.in_parentheses(&self.term(base)) + power.as_str(),
        }
    }

    fn call(&self, function: Function, argument: &Term, power: &str) -> String {
        let inside = self.term(argument);
        if self.style == Style::Plain {
            return format!("{}({inside}){power}", function.name());
        }
        match (function, argument) {
            (Function::Sqrt, _) if power.is_empty() => format!(r"\sqrt{{{inside}}}"),
            (Function::Exp, _) if power.is_empty() => format!(r"\mathrm{{e}}^{{{inside}}}"),
            (Function::Exp | Function::Sqrt, _) => {
                format!(r"\left({}\right){power}", self.call(function, argument, ""))
            }
            (_, Term::Symbol(_)) => format!("{}{power} {inside}", latex_function(function)),
            _ => format!("{}{power}{}", latex_function(function), self.in_parentheses(&inside)),
        }
    }

    /// A spline under its name, with a dash for each derivative.
    fn spline(&self, spline: &Spline, order: usize, argument: &Term, power: &str) -> String {
        let (inside, dashes) = (self.term(argument), "'".repeat(order));
        match self.style {
            Style::Plain => format!("{}{dashes}({inside}){power}", spline.name),
            Style::Latex => {
                let name = format!(r"\operatorname{{{}}}{dashes}", spline.name.replace('_', r"\_"));
                let call = format!("{name}{}", self.in_parentheses(&inside));
                if power.is_empty() { call } else { format!(r"\left({call}\right){power}") }
            }
        }
    }

    fn in_parentheses(&self, text: &str) -> String {
        if self.style == Style::Plain { format!("({text})") } else { format!(r"\left({text}\right)") }
    }
}

impl<'t> Fraction<'t> {
    fn new(term: &'t Term) -> Self {
        let mut fraction =
            Self { is_negative: false, coefficient: BigRational::one(), above: Vec::new(), below: Vec::new() };
        fraction.take(term, false);
        fraction.is_negative = fraction.coefficient.is_negative();
        fraction.coefficient = fraction.coefficient.abs();
        // Constants first, functions last: the next factor is never taken for part of an argument.
        let rank = |factor: &Factor| match factor.base {
            Term::Number(_) => 0,
            Term::Symbol(symbol) if symbol.is_constant() => 1,
            Term::Sum(_) | Term::Product(_) | Term::Power(..) => 3,
            Term::Symbol(_) => 4,
            Term::Call(..) | Term::Spline(..) => 5,
        };
        fraction.above.sort_by_key(rank);
        fraction.below.sort_by_key(rank);
        fraction
    }
}

impl<'t> Fraction<'t> {
    /// Multiplies or divides by a term; products inside products are products.
    fn take(&mut self, term: &'t Term, divides: bool) {
        let (base, exponent) = match term {
            Term::Product(factors) => return factors.iter().for_each(|factor| self.take(factor, divides)),
            Term::Number(number) if divides => return self.coefficient /= number,
            Term::Number(number) => return self.coefficient *= number,
            Term::Power(base, exponent) => (&**base, exponent.clone()),
            base => (base, BigRational::one()),
        };
        if matches!(base, Term::Product(_)) && exponent == -BigRational::one() {
            return self.take(base, !divides);
        }
        let side = if exponent.is_negative() == divides { &mut self.above } else { &mut self.below };
        side.push(Factor { base, exponent: exponent.abs() });
    }
}

/// Collects the sums that stand under a root, and how often.
fn radicands<'t>(term: &'t Term, found: &mut Vec<(&'t Term, usize)>) {
    match term {
        Term::Number(_) | Term::Symbol(_) => {}
        Term::Sum(terms) | Term::Product(terms) => terms.iter().for_each(|term| radicands(term, found)),
        Term::Call(_, inner) | Term::Spline(_, _, inner) => radicands(inner, found),
        Term::Power(base, exponent) => {
            radicands(base, found);
            if !exponent.is_integer() && matches!(**base, Term::Sum(_)) {
                match found.iter_mut().find(|(known, _)| *known == &**base) {
                    Some((_, times)) => *times += 1,
                    None => found.push((base, 1)),
                }
            }
        }
    }
}

/// A number as a decimal, if that is exact.
fn decimal(number: &BigRational) -> Option<String> {
    if number.is_integer() {
        return Some(number.to_string());
    }
    let text = format!("{:?}", to_f64(number));
    (Number::parse(&text)?.exact == *number).then_some(text)
}

/// `1e-5` as LaTeX writes it.
fn scientific(number: &str) -> String {
    match number.split_once('e') {
        Some((mantissa, exponent)) => format!(r"{mantissa} \cdot 10^{{{exponent}}}"),
        None => number.to_owned(),
    }
}
