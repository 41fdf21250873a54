//! Straight-line function bodies: sines and cosines first, then named intermediate values, then the result.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::naming::{power_name, untaken};
use super::piece::{Piece, literal};
use super::plain::method;
use crate::graph::{Graph, Id, Op, Signed};
use crate::term::Symbol;
use qrm_scene::function::Function;

/// How many operations of each kind a function takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions, subtractions and changes of sign that stand by themselves.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Divisions.
    pub divisions: usize,
    /// Square roots.
    pub roots: usize,
    /// Pairs of a sine and a cosine.
    pub sines: usize,
    /// Other functions.
    pub others: usize,
}

impl Operations {
    /// All of them but sines and cosines.
    pub fn sum(&self) -> usize {
        self.additions + self.multiplications + self.divisions + self.roots + self.others
    }
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

/// Sums of more than twice so many terms are made in parts, which need not wait for each other.
const CHAIN: usize = 8;

/// Writes the statements of one function.
pub(super) struct Body<'g> {
    graph: &'g Graph,
    /// Names of values that stand outside the function: inputs, parameters, precomputed constants.
    outside: &'g HashMap<Id, TokenStream>,
    uses: HashMap<Id, usize>,
    /// The sine and the cosine of each angle, as far as the function needs them.
    angles: BTreeMap<Id, [Option<Id>; 2]>,
    hints: &'g HashMap<Id, String>,
    taken: HashSet<String>,
    names: HashMap<Id, String>,
    statements: Vec<TokenStream>,
    /// The comment of the next statement.
    comment: Option<&'static str>,
    operations: Operations,
    unnamed: usize,
    /// After how much work each value is there, if that decides the order of operations.
    depths: Option<&'g [u32]>,
}

impl<'g> Body<'g> {
    /// The body that computes `roots`. Values that have a name outside are not computed; `named` ones get a
    /// statement of their own even if they serve only once.
    pub(super) fn new(
        graph: &'g Graph,
        outside: &'g HashMap<Id, TokenStream>,
        hints: &'g HashMap<Id, String>,
        named: &HashSet<Id>,
        taken: HashSet<String>,
        roots: &[Signed],
    ) -> Self {
        let mut body = Self::begin(graph, outside, hints, taken, roots, None);
        body.define_all(roots, named);
        body
    }

    /// A body in which nothing is defined yet. With the `depths` of values, products and sums are joined, the deepest
    /// last.
    pub(super) fn begin(
        graph: &'g Graph,
        outside: &'g HashMap<Id, TokenStream>,
        hints: &'g HashMap<Id, String>,
        taken: HashSet<String>,
        roots: &[Signed],
        depths: Option<&'g [u32]>,
    ) -> Self {
        let mut body = Self {
            graph,
            outside,
            uses: HashMap::new(),
            angles: BTreeMap::new(),
            hints,
            taken,
            names: HashMap::new(),
            statements: Vec::new(),
            comment: None,
            operations: Operations::default(),
            unnamed: 0,
            depths,
        };
        let needed = body.needed(roots);
        for root in roots {
            *body.uses.entry(root.id).or_default() += 1;
        }
        for &id in &needed {
            for operand in graph.op(id).operands() {
                *body.uses.entry(operand).or_default() += 1;
            }
            match graph.op(id) {
                Op::Call(Function::Sin, angle) => body.angles.entry(*angle).or_default()[0] = Some(id),
                Op::Call(Function::Cos, angle) => body.angles.entry(*angle).or_default()[1] = Some(id),
                _ => {}
            }
        }
        body
    }

    /// Defines what serves more than once on the way to `roots`, and what is `named`.
    pub(super) fn define_all(&mut self, roots: &[Signed], named: &HashSet<Id>) {
        let graph = self.graph;
        let needed = self.needed(roots);
        // Of inputs first.
        let angles = needed.iter().filter_map(|&id| self.angle(id)).filter(|&angle| graph.op(angle).is_leaf());
        for angle in angles.collect::<BTreeSet<Id>>() {
            self.define_pair(angle);
        }
        for id in needed {
            if self.names.contains_key(&id) || graph.op(id).is_leaf() {
                continue;
            }
            if let Some(angle) = self.angle(id) {
                self.define_pair(angle);
            } else if self.uses[&id] > 1 || named.contains(&id) {
                self.define(id);
            }
        }
    }

    /// Defines a value under a name, under which `input` stands for it from now on.
    pub(super) fn define_local(&mut self, value: Id, input: Id, name: &str, named: &HashSet<Id>) {
        if let Some(outside) = self.outside.get(&value) {
            self.names.insert(input, outside.to_string());
            return;
        }
        let only: Vec<Signed> =
            self.graph.op(value).operands().iter().map(|&id| Signed { negative: false, id }).collect();
        self.define_all(&only, named);
        if !self.names.contains_key(&value) {
            let computed = self.compute(value).tokens;
            let name = format_ident!("{}", self.name(value, Some(name.to_owned())));
            self.push(quote!(let #name = #computed;));
        }
        let name = self.names[&value].clone();
        self.names.insert(input, name);
    }

    /// Gives the next statement a line of comment.
    pub(super) fn comment(&mut self, text: &'static str) {
        self.comment = Some(text);
    }

    /// Forgets a comment that no statement followed.
    pub(super) fn end_comment(&mut self) {
        self.comment = None;
    }

    /// Adds a statement. The printer keeps documentation alone; `generate` makes comments of it.
    fn push(&mut self, statement: TokenStream) {
        let comment = self.comment.take().map(|text| format!(" {text}"));
        let comment = comment.iter();
        self.statements.push(quote!(#(#[doc = #comment])* #statement));
    }

    /// The name of a value that has been defined.
    pub(super) fn name_of(&self, id: Id) -> Option<&str> {
        self.names.get(&id).map(String::as_str)
    }

    /// The values to compute, operands first.
    fn needed(&self, roots: &[Signed]) -> Vec<Id> {
        let mut needed = BTreeSet::new();
        let mut pending: Vec<Id> = roots.iter().map(|r| r.id).collect();
        while let Some(id) = pending.pop() {
            if !self.outside.contains_key(&id) && !self.names.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
            }
        }
        needed.into_iter().collect()
    }

    /// The angle that an operation is the sine or cosine of.
    fn angle(&self, id: Id) -> Option<Id> {
        match self.graph.op(id) {
            Op::Call(Function::Sin | Function::Cos, angle) => Some(*angle),
            _ => None,
        }
    }

    /// Defines sine and cosine of an angle by one call.
    fn define_pair(&mut self, angle: Id) {
        let pair = self.angles[&angle];
        self.operations.sines += 1;
        let value = self.value(angle);
        let hint = self.hint(angle);
        let names = [("sin", pair[0]), ("cos", pair[1])].map(|(what, id)| {
            let name = self.name(id?, hint.as_ref().map(|angle| format!("{what}_{angle}")));
            Some(format_ident!("{name}"))
        });
        let call = |what: &str| value.call(what, &TokenStream::new()).tokens;
        self.push(match names {
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
        self.push(quote!(let #name = #value;));
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

    /// Whether a value is always zero.
    pub(super) fn is_zero(&self, value: Signed) -> bool {
        *self.graph.op(value.id) == Op::Number(0)
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
            Op::Input(Symbol::Pi) => Piece::whole(quote!(R::pi())),
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
        if let Some(depths) = self.depths {
            return self.joined_sum(terms, depths);
        }
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

    /// A sum whose products are added as they are made, the deepest last.
    fn joined_sum(&mut self, terms: &[Signed], depths: &[u32]) -> Piece {
        let is_product = |body: &Self, id: Id| {
            matches!(body.graph.op(id), Op::Product(_))
                && !body.names.contains_key(&id)
                && !body.outside.contains_key(&id)
        };
        let mut ordered = terms.to_vec();
        ordered.sort_by_key(|term| (is_product(self, term.id), depths[term.id]));
        if ordered.len() > 2 * CHAIN {
            self.operations.additions += ordered.len().div_ceil(CHAIN) - 1;
            let parts: Vec<Piece> = ordered.chunks(CHAIN).map(|part| self.joined_sum(part, depths)).collect();
            let mut parts = parts.into_iter();
            let first = parts.next().unwrap_or_else(|| Piece::whole(quote!(R::zero())));
            return parts.fold(first, |sum, part| sum.add(&part));
        }
        let first = ordered.iter().position(|t| !t.negative && (ordered.len() == 1 || !is_product(self, t.id)));
        let first = first.or_else(|| ordered.iter().position(|t| !is_product(self, t.id)));
        let first = first.or_else(|| ordered.iter().position(|t| !t.negative)).unwrap_or(0);
        let first = ordered.remove(first);
        self.operations.additions += ordered.len() + usize::from(first.negative && ordered.is_empty());
        let value = self.value(first.id);
        let mut sum = if first.negative { value.negate() } else { value };
        for term in ordered {
            let graph = self.graph;
            sum = match graph.op(term.id) {
                Op::Product(factors) if is_product(self, term.id) => {
                    let factors = self.by_depth(factors);
                    self.operations.multiplications += 1;
                    let last = self.value(factors[factors.len() - 1]);
                    let others = self.product(&factors[..factors.len() - 1]);
                    others.multiply_add(&last, term.negative, &sum)
                }
                _ => {
                    let value = self.value(term.id);
                    if term.negative { sum.subtract(&value) } else { sum.add(&value) }
                }
            };
        }
        sum
    }

    fn by_depth(&self, factors: &[Id]) -> Vec<Id> {
        let mut factors = factors.to_vec();
        if let Some(depths) = self.depths {
            factors.sort_by_key(|&id| depths[id]);
        }
        factors
    }

    /// A product; reciprocals that serve only here become divisions.
    fn product(&mut self, factors: &[Id]) -> Piece {
        let graph = self.graph;
        let factors = &self.by_depth(factors)[..];
        let divisor = |body: &Self, id: Id| match graph.op(id) {
            // A kernel keeps them apart: they need not wait for the other factors.
            Op::Reciprocal(a)
                if body.depths.is_none() && !body.names.contains_key(&id) && !body.outside.contains_key(&id) =>
            {
                Some(*a)
            }
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
