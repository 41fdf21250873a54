//! A scene's functions as the text of a Rust module.

mod body;
mod layout;
mod piece;
mod plain;
mod scene_items;

use std::collections::{BTreeMap, HashMap, HashSet};

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::graph::{Graph, Id, Op, Signed};
use crate::scene::Scene;
use crate::term::{Equations, Symbol};
use body::{Body, Operations};
use layout::{Argument, Layout, Plan, Shape};
use plain::ident;

/// Writes the module of a scene. The result has no header yet, and has been parsed once: it is Rust.
///
/// # Panics
/// If the module is not Rust, which would be a mistake of this generator.
pub fn module(scene: &Scene, equations: &Equations, source: &str) -> Module {
    let layout = Layout::new(scene, equations);
    let writer = Writer::new(scene, &layout);
    let mut operations = Vec::new();
    let functions: Vec<TokenStream> = layout.plans.iter().map(|plan| writer.function(plan, &mut operations)).collect();
    let items = scene_items::items(scene, &layout, source);
    let constants = writer.constants();
    let tokens = quote! {
        use qrm_mechanism::{
            Closure, Description, Dynamics, Mechanism, ParameterDescription, QuantityDescription, Real, Schedule, Start,
        };
        #items
        #constants
        #(#functions)*
    };
    let file =
        syn::parse2(tokens.clone()).unwrap_or_else(|e| panic!("the generated module is not Rust: {e}\n{tokens}"));
    Module { file, operations }
}

/// A generated module.
pub struct Module {
    /// Its syntax.
    pub file: syn::File,
    /// What each function costs, in words.
    pub operations: Vec<(&'static str, String)>,
}

/// The name of a scene's struct: `quick-return` becomes `QuickReturn`.
pub fn struct_name(scene: &str) -> String {
    let words = scene.split(['-', '_']).filter(|w| !w.is_empty());
    words.map(|word| word[..1].to_uppercase() + &word[1..]).collect()
}

/// The name of a scene's module: `quick-return` becomes `quick_return`.
pub fn module_name(scene: &str) -> String {
    scene.to_lowercase().replace('-', "_")
}

/// The field of a parameter.
pub(crate) fn field_name(parameter: &str) -> String {
    ident(parameter).to_string()
}

struct Writer<'a> {
    scene: &'a Scene,
    layout: &'a Layout,
    graph: &'a Graph,
    /// Names of inputs, parameters and precomputed constants.
    outside: HashMap<Id, TokenStream>,
    /// The inputs' names as they are bound in a function.
    inputs: HashMap<Symbol, Ident>,
    hints: HashMap<Id, String>,
    constants: Vec<(Ident, Id)>,
}

impl<'a> Writer<'a> {
    fn new(scene: &'a Scene, layout: &'a Layout) -> Self {
        let graph = &layout.graph;
        let mut writer = Self {
            scene,
            layout,
            graph,
            outside: HashMap::new(),
            inputs: HashMap::new(),
            hints: HashMap::new(),
            constants: Vec::new(),
        };
        for (id, op) in graph.ops().iter().enumerate() {
            let Op::Input(symbol) = op else { continue };
            let (hint, tokens) = match *symbol {
                Symbol::Parameter(i) => {
                    let name = &scene.parameters[i].name;
                    let field = ident(name);
                    (name.to_lowercase(), quote!(p.#field))
                }
                Symbol::Pi => ("pi".to_owned(), quote!(R::from_f64(std::f64::consts::PI))),
                input => {
                    let name = writer.input_name(input);
                    writer.inputs.insert(input, format_ident!("{name}"));
                    let bound = &writer.inputs[&input];
                    (name, quote!(#bound))
                }
            };
            writer.hints.insert(id, hint);
            writer.outside.insert(id, tokens);
        }
        writer.name_constants();
        for (place, point) in layout.points.iter().enumerate() {
            for (axis, value) in point.iter().enumerate() {
                let is_new = !graph.is_constant(value.id) && !graph.op(value.id).is_leaf();
                if is_new && !value.negative {
                    let name = format!("{}_{}", scene.points[place].name.to_lowercase(), ["x", "y"][axis]);
                    writer.hints.entry(value.id).or_insert(name);
                }
            }
        }
        writer
    }

    fn input_name(&self, symbol: Symbol) -> String {
        let coordinate = |i: usize| self.scene.coordinates[i].name.as_str();
        let name = match symbol {
            Symbol::Coordinate(i) => coordinate(i).to_owned(),
            Symbol::Rate(i) => format!("{}_dot", coordinate(i)),
            Symbol::Acceleration(i) => format!("{}_ddot", coordinate(i)),
            Symbol::Multiplier(i) => format!("lambda_{}", self.scene.constraints[i].name),
            _ => "t".to_owned(),
        };
        // The arguments and the two halves of a mechanism are in the same scope.
        let clashes = ["p", "k", "q", "qd", "qdd", "m", "multipliers"].contains(&name.as_str());
        if clashes || syn::parse_str::<Ident>(&name).is_err() { format!("{name}_") } else { name }
    }

    /// Values that keep their size during a run and are not just parameters get a field each.
    fn name_constants(&mut self) {
        let roots = self.layout.plans.iter().flat_map(|plan| plan.parts.iter().flat_map(|(_, shape)| shape.values()));
        let roots: Vec<Id> = roots.map(|root| root.id).collect();
        let mut fields: BTreeMap<Id, ()> = BTreeMap::new();
        let mut note = |id: Id| {
            if self.graph.is_constant(id) && !self.graph.op(id).is_leaf() {
                fields.insert(id, ());
            }
        };
        roots.iter().for_each(|&id| note(id));
        for id in self.graph.reachable(roots) {
            if !self.graph.is_constant(id) {
                self.graph.op(id).operands().into_iter().for_each(&mut note);
            }
        }
        let mut taken = HashSet::new();
        for (number, id) in fields.into_keys().enumerate() {
            let base = self.constant_name(id).unwrap_or_else(|| format!("k{}", number + 1));
            let mut name = base.clone();
            let mut suffix = 2;
            while !taken.insert(name.clone()) {
                name = format!("{base}_{suffix}");
                suffix += 1;
            }
            let field = ident(&name);
            self.outside.insert(id, quote!(k.#field));
            self.hints.insert(id, name);
            self.constants.push((field, id));
        }
    }

    /// A product of parameters is called after them.
    fn constant_name(&self, id: Id) -> Option<String> {
        let Op::Product(factors) = self.graph.op(id) else { return None };
        let mut names: Vec<String> = Vec::new();
        for (i, factor) in factors.iter().enumerate() {
            if factors[..i].contains(factor) {
                continue;
            }
            let times = factors.iter().filter(|f| *f == factor).count();
            let name = match self.graph.op(*factor) {
                Op::Number(bits) if f64::from_bits(*bits) == 2.0 => "twice".to_owned(),
                Op::Number(bits) if f64::from_bits(*bits) == 0.5 => "half".to_owned(),
                Op::Input(_) => self.hints[factor].clone(),
                _ => return None,
            };
            names.push(if times == 1 {
                name
            } else if times == 2 {
                format!("{name}_sq")
            } else {
                format!("{name}_pow{times}")
            });
        }
        let name = names.join("_");
        (name.len() <= 24).then_some(name)
    }

    fn constants(&self) -> TokenStream {
        let parameters: HashMap<Id, TokenStream> = self
            .outside
            .iter()
            .filter(|(id, _)| self.graph.op(**id).is_leaf())
            .map(|(id, t)| (*id, t.clone()))
            .collect();
        let roots: Vec<Signed> = self.constants.iter().map(|(_, id)| Signed { negative: false, id: *id }).collect();
        let hints = HashMap::new();
        let mut body = Body::new(self.graph, &parameters, &hints, HashSet::from(["p".to_owned()]), &roots);
        let values: Vec<TokenStream> = roots.iter().map(|root| body.root(*root)).collect();
        let (statements, _) = body.finish();
        let names: Vec<&Ident> = self.constants.iter().map(|(name, _)| name).collect();
        let docs = self.constants.iter().map(|(_, id)| format!(" `{}`", self.formula(*id)));
        let p = if values.is_empty() { quote!(_p) } else { quote!(p) };
        // A struct without fields still has to mention its number type.
        let marker = values
            .is_empty()
            .then(|| (quote!(marker: std::marker::PhantomData<R>,), quote!(marker: std::marker::PhantomData)));
        let (marker_field, marker_value) = marker.unzip();
        quote! {
            /// Values that depend on parameters alone, computed once.
            #[derive(Clone, Copy, Debug)]
            pub struct Constants<R = f64> {
                #(#[doc = #docs] pub #names: R,)*
                #marker_field
            }

            impl<R: Real> Constants<R> {
                fn new(#p: &Parameters<R>) -> Self {
                    #(#statements)*
                    Self { #(#names: #values,)* #marker_value }
                }
            }
        }
    }

    /// A constant's formula in the notation of scenes.
    fn formula(&self, id: Id) -> String {
        let inner = |id: Id| {
            let text = self.formula(id);
            if matches!(self.graph.op(id), Op::Sum(_)) { format!("({text})") } else { text }
        };
        match self.graph.op(id) {
            Op::Number(bits) => format!("{}", f64::from_bits(*bits)),
            Op::Input(Symbol::Parameter(i)) => self.scene.parameters[*i].name.clone(),
            Op::Input(_) => "pi".to_owned(),
            Op::Sum(terms) => {
                let mut text = String::new();
                for term in terms {
                    text += match (text.is_empty(), term.negative) {
                        (true, false) => "",
                        (true, true) => "-",
                        (false, false) => " + ",
                        (false, true) => " - ",
                    };
                    text += &inner(term.id);
                }
                text
            }
            Op::Product(factors) => {
                let mut parts: Vec<String> = Vec::new();
                for (i, factor) in factors.iter().enumerate() {
                    let times = factors.iter().filter(|f| *f == factor).count();
                    if !factors[..i].contains(factor) {
                        parts.push(if times == 1 { inner(*factor) } else { format!("{}^{times}", inner(*factor)) });
                    }
                }
                parts.join("*")
            }
            Op::Reciprocal(a) => format!("1/({})", self.formula(*a)),
            Op::Power(a, exponent) => format!("({})^{}", self.formula(*a), f64::from_bits(*exponent)),
            Op::Call(function, a) => format!("{}({})", function.name(), self.formula(*a)),
        }
    }

    fn function(&self, plan: &Plan<Signed>, operations: &mut Vec<(&'static str, String)>) -> TokenStream {
        let roots: Vec<Signed> = plan.parts.iter().flat_map(|(_, shape)| shape.values()).copied().collect();
        let mut taken: HashSet<String> =
            ["p", "k", "q", "qd", "qdd", "m", "t", "multipliers"].map(str::to_owned).into();
        taken.extend(self.inputs.values().map(ToString::to_string));
        let mut body = Body::new(self.graph, &self.outside, &self.hints, taken, &roots);
        let fields: Vec<TokenStream> = plan.parts.iter().map(|(_, shape)| result(&mut body, shape)).collect();
        let (statements, cost) = body.finish();
        operations.push((plan.name, cost.to_string()));

        let used = self.graph.reachable(roots.iter().map(|r| r.id));
        let (bindings, parameters) = self.arguments(plan.arguments, &used);
        let uses = |what: &str| -> Option<TokenStream> {
            let is_used = used.iter().any(|id| match self.outside.get(id) {
                Some(tokens) => tokens.to_string().starts_with(what) && self.reached_from_outside(*id, &roots),
                None => false,
            });
            let name = format_ident!("{}", &what[..1]);
            let field = format_ident!("{}", if what.starts_with('p') { "parameters" } else { "constants" });
            is_used.then(|| quote!(let #name = &m.#field;))
        };
        let (p, k) = (uses("p ."), uses("k ."));
        let m = if p.is_some() || k.is_some() { quote!(m) } else { quote!(_m) };
        let (n, c) = (self.scene.coordinates.len(), self.scene.constraints.len());
        let (n, c) = (proc_macro2::Literal::usize_unsuffixed(n), proc_macro2::Literal::usize_unsuffixed(c));
        let (output, value) = match plan.structure {
            Some(structure) => {
                let structure = format_ident!("{structure}");
                let names = plan.parts.iter().map(|(name, _)| format_ident!("{name}"));
                (quote!(#structure<R, #n, #c>), quote!(#structure { #(#names: #fields),* }))
            }
            None => (shape_type(&plan.parts[0].1, &n), fields[0].clone()),
        };
        let (name, own) = (format_ident!("{}", plan.name), format_ident!("{}", struct_name(&self.scene.name)));
        // What a step calls must not pass its matrices through memory.
        let inline = if plan.structure.is_some() { quote!(#[inline(always)]) } else { quote!(#[inline]) };
        let docs = doc_lines(plan, cost);
        let aliases = plan.aliases.iter();
        quote! {
            #(#[doc = #docs])*
            #(#[doc(alias = #aliases)])*
            #inline
            pub fn #name<R: Real>(#m: &#own<R>, #(#parameters),*) -> #output {
                #p
                #k
                #(#bindings)*
                #(#statements)*
                #value
            }
        }
    }

    /// Whether a value is needed by something that is computed in the function itself.
    fn reached_from_outside(&self, id: Id, roots: &[Signed]) -> bool {
        let mut pending: Vec<Id> = roots.iter().map(|r| r.id).collect();
        let mut seen = HashSet::new();
        while let Some(at) = pending.pop() {
            if at == id {
                return true;
            }
            if !self.outside.contains_key(&at) && seen.insert(at) {
                pending.extend(self.graph.op(at).operands());
            }
        }
        false
    }

    /// The bindings of the inputs that are used, and the function's parameters.
    fn arguments(&self, arguments: &[Argument], used: &[Id]) -> (Vec<TokenStream>, Vec<TokenStream>) {
        let is_used = |symbol: Symbol| used.iter().any(|&id| *self.graph.op(id) == Op::Input(symbol));
        let (n, c) = (self.scene.coordinates.len(), self.scene.constraints.len());
        let (mut bindings, mut parameters) = (Vec::new(), Vec::new());
        for argument in arguments {
            let (name, count, symbol): (&str, usize, fn(usize) -> Symbol) = match argument {
                Argument::Time => {
                    let name = format_ident!("{}", if is_used(Symbol::Time) { "t" } else { "_t" });
                    parameters.push(quote!(#name: R));
                    continue;
                }
                Argument::Coordinates => ("q", n, Symbol::Coordinate),
                Argument::Rates => ("qd", n, Symbol::Rate),
                Argument::Accelerations => ("qdd", n, Symbol::Acceleration),
                Argument::Multipliers => ("multipliers", c, Symbol::Multiplier),
            };
            let any = (0..count).any(|i| is_used(symbol(i)));
            let name = format_ident!("{}{name}", if any { "" } else { "_" });
            let size = proc_macro2::Literal::usize_unsuffixed(count);
            parameters.push(quote!(#name: &[R; #size]));
            if any {
                let names = (0..count).map(|i| match self.inputs.get(&symbol(i)) {
                    Some(bound) if is_used(symbol(i)) => quote!(#bound),
                    _ => quote!(_),
                });
                bindings.push(quote!(let [#(#names),*] = *#name;));
            }
        }
        (bindings, parameters)
    }
}

fn result(body: &mut Body, shape: &Shape<Signed>) -> TokenStream {
    match shape {
        Shape::Scalar(root) => body.root(*root),
        Shape::Vector(roots) => {
            let values = roots.iter().map(|root| body.root(*root));
            quote!([#(#values),*])
        }
        Shape::Matrix(rows) => {
            let rows = rows.iter().map(|row| {
                let values = row.iter().map(|root| body.root(*root));
                quote!([#(#values),*])
            });
            quote!([#(#rows),*])
        }
    }
}

fn shape_type(shape: &Shape<Signed>, columns: &proc_macro2::Literal) -> TokenStream {
    match shape {
        Shape::Scalar(_) => quote!(R),
        Shape::Vector(values) => {
            let rows = proc_macro2::Literal::usize_unsuffixed(values.len());
            quote!([R; #rows])
        }
        Shape::Matrix(rows) => {
            let rows = proc_macro2::Literal::usize_unsuffixed(rows.len());
            quote!([[R; #columns]; #rows])
        }
    }
}

fn doc_lines(plan: &Plan<Signed>, cost: Operations) -> Vec<String> {
    let text = format!("{}\n\nOperations: {cost}.", plan.doc);
    text.lines().map(|line| format!(" {line}").trim_end().to_owned()).collect()
}
