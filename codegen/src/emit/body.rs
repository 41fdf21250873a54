//! Straight-line function bodies: sines and cosines first, then named intermediate values, then the result.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::naming::{power_name, untaken};
use super::piece::{Piece, literal};
use super::plain::method;
use crate::function::Function;
use crate::graph::{Graph, Id, Op, Signed};
use crate::term::Symbol;

/// How many operations of each kind a function takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Operations {
    pub(super) additions: usize,
    pub(super) multiplications: usize,
    pub(super) divisions: usize,
    pub(super) roots: usize,
    pub(super) sines: usize,
    pub(super) others: usize,
}

impl std::fmt::Display for Operations {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let counts = [
            (self.additions, "additions"),
            (self.multiplications, "multiplications"),
            (self.divisions, "divisions"),
            (self.roots, "roots"),
            (self.sines, "sine-cosine pairs"),
            (self.others, "other functions"),
        ];
        let said: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {}", if *count == 1 { &what[..what.len() - 1] } else { what }))
            .collect();
        f.write_str(&if said.is_empty() { "no operations".to_owned() } else { said.join(", ") })
    }
}

/// Writes the statements of one function.
pub(super) struct Body<'g> {
    graph: &'g Graph,
    /// Names of values that stand outside the function: inputs, parameters, precomputed constants.
    outside: &'g HashMap<Id, TokenStream>,
    uses: HashMap<Id, usize>,
    hints: &'g HashMap<Id, String>,
    taken: HashSet<String>,
    names: HashMap<Id, String>,
    statements: Vec<TokenStream>,
    operations: Operations,
    unnamed: usize,
}

impl<'g> Body<'g> {
    /// Prepares the body that computes `roots`. Values that have a name outside are not computed; `named` ones get a
    /// statement of their own even if they serve only once.
    pub(super) fn new(
        graph: &'g Graph,
        outside: &'g HashMap<Id, TokenStream>,
        hints: &'g HashMap<Id, String>,
        named: &HashSet<Id>,
        taken: HashSet<String>,
        roots: &[Signed],
    ) -> Self {
        let mut body = Self {
            graph,
            outside,
            uses: HashMap::new(),
            hints,
            taken,
            names: HashMap::new(),
            statements: Vec::new(),
            operations: Operations::default(),
            unnamed: 0,
        };
        let needed = body.needed(roots);
        for root in roots {
            *body.uses.entry(root.id).or_default() += 1;
        }
        for &id in &needed {
            for operand in graph.op(id).operands() {
                *body.uses.entry(operand).or_default() += 1;
            }
        }
        let angles = body.angles(&needed);
        for (&angle, pair) in angles.iter().filter(|(angle, _)| graph.op(**angle).is_leaf()) {
            body.define_pair(angle, *pair);
        }
        for id in needed {
            if body.names.contains_key(&id) || graph.op(id).is_leaf() {
                continue;
            }
            if let Op::Call(Function::Sin | Function::Cos, angle) = graph.op(id) {
                body.define_pair(*angle, angles[angle]);
            } else if body.uses[&id] > 1 || named.contains(&id) {
                body.define(id);
            }
        }
        body
    }

    /// The values to compute, operands first.
    fn needed(&self, roots: &[Signed]) -> Vec<Id> {
        let mut needed = BTreeSet::new();
        let mut pending: Vec<Id> = roots.iter().map(|r| r.id).collect();
        while let Some(id) = pending.pop() {
            if !self.outside.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
            }
        }
        needed.into_iter().collect()
    }

    /// The angles whose sine (0) or cosine (1) is needed.
    fn angles(&self, needed: &[Id]) -> BTreeMap<Id, [Option<Id>; 2]> {
        let mut angles: BTreeMap<Id, [Option<Id>; 2]> = BTreeMap::new();
        for &id in needed {
            match self.graph.op(id) {
                Op::Call(Function::Sin, angle) => angles.entry(*angle).or_default()[0] = Some(id),
                Op::Call(Function::Cos, angle) => angles.entry(*angle).or_default()[1] = Some(id),
                _ => {}
            }
        }
        angles
    }

    /// Defines sine and cosine of an angle by one call.
    fn define_pair(&mut self, angle: Id, pair: [Option<Id>; 2]) {
        self.operations.sines += 1;
        let value = self.value(angle);
        let hint = self.hint(angle);
        let names = [("sin", pair[0]), ("cos", pair[1])].map(|(what, id)| {
            let name = self.name(id?, hint.as_ref().map(|angle| format!("{what}_{angle}")));
            Some(format_ident!("{name}"))
        });
        let call = |what: &str| value.call(what, &TokenStream::new()).tokens;
        self.statements.push(match names {
            [Some(sine), Some(cosine)] => {
                let call = call("sin_cos");
                quote!(let (#sine, #cosine) = #call;)
            }
            [sine, cosine] => {
                let call = call(if sine.is_some() { "sin" } else { "cos" });
                let name = sine.or(cosine);
                quote!(let #name = #call;)
            }
        });
    }

    fn define(&mut self, id: Id) {
        let value = self.compute(id).tokens;
        let hint = self.hint(id);
        let name = format_ident!("{}", self.name(id, hint));
        self.statements.push(quote!(let #name = #value;));
    }

    /// A name that says what a value is, if a short one can.
    fn hint(&self, id: Id) -> Option<String> {
        if let Some(name) = self.names.get(&id).or_else(|| self.hints.get(&id)) {
            return Some(name.clone());
        }
        let name = match self.graph.op(id) {
            Op::Reciprocal(a) => format!("inv_{}", self.hint(*a)?),
            Op::Call(Function::Sqrt, _) => "root".to_owned(),
            Op::Product(factors) => {
                let mut names: Vec<String> = Vec::new();
                for (i, &factor) in factors.iter().enumerate() {
                    let times = factors.iter().filter(|&&f| f == factor).count();
                    if factors[..i].contains(&factor) {
                        continue;
                    }
                    let name = self.hint(factor)?;
                    names.push(power_name(name, times));
                }
                names.join("_")
            }
            _ => return None,
        };
        (name.len() <= 24).then_some(name)
    }

    /// Gives a value a name that is not taken.
    fn name(&mut self, id: Id, hint: Option<String>) -> String {
        let wish = hint.unwrap_or_else(|| {
            self.unnamed += 1;
            format!("v{}", self.unnamed)
        });
        let name = untaken(wish, &mut self.taken);
        self.names.insert(id, name.clone());
        name
    }

    /// The value, by name if it has one.
    pub(super) fn value(&mut self, id: Id) -> Piece {
        if let Some(tokens) = self.outside.get(&id) {
            return Piece::whole(tokens.clone());
        }
        match self.names.get(&id) {
            Some(name) => {
                let name = format_ident!("{name}");
                Piece::whole(quote!(#name))
            }
            None => self.compute(id),
        }
    }

    /// The value of a root.
    pub(super) fn root(&mut self, root: Signed) -> TokenStream {
        let value = self.value(root.id);
        if root.negative {
            self.operations.additions += 1;
            value.negate().tokens
        } else {
            value.tokens
        }
    }

    fn compute(&mut self, id: Id) -> Piece {
        let graph = self.graph;
        match graph.op(id) {
            Op::Number(bits) if *bits == 0 => Piece::whole(quote!(R::zero())),
            Op::Number(bits) => {
                let number = literal(f64::from_bits(*bits));
                Piece::whole(quote!(R::from_f64(#number)))
            }
            Op::Input(Symbol::Pi) => Piece::whole(quote!(R::from_f64(std::f64::consts::PI))),
            Op::Input(symbol) => unreachable!("{symbol:?} has a name outside"),
            Op::Sum(terms) => self.sum(terms),
            Op::Product(factors) => self.product(factors),
            Op::Reciprocal(a) => {
                self.operations.divisions += 1;
                self.value(*a).call("recip", &TokenStream::new())
            }
            Op::Power(a, exponent) => {
                self.operations.others += 1;
                let value = f64::from_bits(*exponent);
                let (size, sign) = (literal(value.abs()), (value < 0.0).then(|| quote!(-)));
                self.value(*a).call("powf", &quote!(#sign #size))
            }
            Op::Call(function, a) => {
                if *function == Function::Sqrt {
                    self.operations.roots += 1;
                } else {
                    self.operations.others += 1;
                }
                self.value(*a).call(method(*function), &TokenStream::new())
            }
        }
    }

    /// A sum, a positive term first where there is one.
    fn sum(&mut self, terms: &[Signed]) -> Piece {
        let mut ordered: Vec<Signed> = terms.to_vec();
        if let Some(first) = ordered.iter().position(|t| !t.negative) {
            let first = ordered.remove(first);
            ordered.insert(0, first);
        } else {
            self.operations.additions += 1;
        }
        self.operations.additions += ordered.len() - 1;
        let first = self.value(ordered[0].id);
        let mut sum = if ordered[0].negative { first.negate() } else { first };
        for term in &ordered[1..] {
            let value = self.value(term.id);
            sum = if term.negative { sum.subtract(&value) } else { sum.add(&value) };
        }
        sum
    }

    /// A product; reciprocals that serve only here become divisions.
    fn product(&mut self, factors: &[Id]) -> Piece {
        let graph = self.graph;
        let divisor = |body: &Self, id: Id| match graph.op(id) {
            Op::Reciprocal(a) if !body.names.contains_key(&id) && !body.outside.contains_key(&id) => Some(*a),
            _ => None,
        };
        let mut product: Option<Piece> = None;
        for &factor in factors {
            if divisor(self, factor).is_some() {
                continue;
            }
            let value = self.value(factor);
            self.operations.multiplications += usize::from(product.is_some());
            product = Some(product.map_or_else(|| value.clone(), |p| p.multiply(&value)));
        }
        for &factor in factors {
            let Some(divisor) = divisor(self, factor) else { continue };
            let value = self.value(divisor);
            self.operations.divisions += 1;
            product = Some(product.map_or_else(|| value.call("recip", &TokenStream::new()), |p| p.divide(&value)));
        }
        product.unwrap_or_else(|| unreachable!("a product has factors"))
    }

    /// Whether the function needs a value, one that stands outside included.
    pub(super) fn needs(&self, id: Id) -> bool {
        self.uses.contains_key(&id)
    }

    /// The statements written so far and what they cost.
    pub(super) fn finish(self) -> (Vec<TokenStream>, Operations) {
        (self.statements, self.operations)
    }
}
