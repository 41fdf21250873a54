//! Formats terms for people: as plain text for documentation, or as LaTeX for a derivation.

mod factors;
mod fraction;
mod names;

use std::collections::{HashMap, HashSet};

use num_rational::BigRational;

use crate::term::{Named, Symbol, Term};
use fraction::Fraction;
use names::latex_name;
use qrm_scene::scene::Scene;

/// The notation of formulae.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// The notation of scene files, which can read it: `O4B*cos(phi4)`, `phi4_ddot`.
    Plain,
    /// LaTeX in math mode.
    Latex,
}

/// Writes the formulae of one scene.
#[derive(Clone, Debug)]
pub struct Writer<'s> {
    scene: &'s Scene,
    style: Style,
    /// The radicand and the name of each root.
    roots: Vec<(Term, String)>,
    /// Quantities with their own symbols.
    names: &'s [Named],
    /// Names of the scene whose symbols would be confused with others.
    ambiguous: HashSet<&'s str>,
}

impl<'s> Writer<'s> {
    /// Creates a writer for the formulae of this scene, in which quantities may have names.
    pub fn new(scene: &'s Scene, style: Style, names: &'s [Named]) -> Self {
        let mut alike: HashMap<String, HashSet<&str>> = HashMap::new();
        for name in scene.names() {
            alike.entry(latex_name("", name)).or_default().insert(name);
        }
        let ambiguous = alike.into_values().filter(|names| names.len() > 1).flatten().collect();
        Self { scene, style, roots: Vec::new(), names, ambiguous }
    }

    /// Names each root of a sum that occurs more than once in the terms, and uses the name from now on.
    #[must_use]
    pub fn naming_roots<'t>(mut self, terms: impl IntoIterator<Item = &'t Term>) -> Self {
        let mut found: Vec<(&Term, usize)> = Vec::new();
        terms.into_iter().for_each(|term| radicands(term, &mut found));
        let radicands: Vec<&Term> = found.into_iter().filter(|(_, times)| *times > 1).map(|(term, _)| term).collect();
        // No name of the scene may be confused with a letter, with or without a number.
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

    /// The names and the formulae of named roots.
    pub fn roots(&self) -> Vec<(String, String)> {
        let bare = Self { roots: Vec::new(), ..self.clone() };
        let root = |radicand: &Term| Term::Power(Box::new(radicand.clone()), BigRational::new(1.into(), 2.into()));
        self.roots.iter().map(|(radicand, name)| (name.clone(), bare.term(&root(radicand)))).collect()
    }

    /// A term.
    pub fn term(&self, term: &Term) -> String {
        self.summands(term).concat()
    }

    /// The signed summands of a sum; a single part if the term is not a sum.
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

    /// The text of a symbol.
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
                Symbol::Named(k)
                | Symbol::NamedSlope(k, _)
                | Symbol::NamedRate(k)
                | Symbol::NamedBias(k)
                | Symbol::NamedAcceleration(k) => self.names[k].symbol_name(symbol, self.scene),
                _ => unreachable!("neither kernels nor recursions are written as formulae"),
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
            Symbol::NamedAcceleration(k) => latex_name(r"\ddot", &self.names[k].name),
            _ => unreachable!("neither kernels nor recursions are written as formulae"),
        }
    }

    /// The symbol of a name; the name unchanged if the symbol would be ambiguous.
    fn latex(&self, accent: &str, name: &str) -> String {
        if self.ambiguous.contains(name) {
            return format!(r"{accent}{{\mathtt{{{}}}}}", name.replace('_', r"\_"));
        }
        latex_name(accent, name)
    }
}

/// Collects and counts the sums under roots.
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
