//! A scene's functions as the text of a Rust module.

mod body;
mod constants;
mod formulae;
mod inverse;
mod kernel;
mod layout;
mod naming;
mod own_struct;
mod piece;
mod plain;
mod scene_items;

use std::collections::{HashMap, HashSet};

use proc_macro2::{Ident, TokenStream};
use qrm_core::OwnedTape;
use quote::{format_ident, quote};

use crate::graph::{Graph, Id, Op, Signed};
use crate::tape;
use crate::term::{Equations, Symbol};
use body::Body;
pub use body::Operations;
use layout::{Argument, Layout, Plan, Shape};
use plain::ident;
use qrm_scene::names::struct_name;
use qrm_scene::scene::Scene;
pub use scene_items::until;

/// Writes the module of a scene. The result has no header yet, and has been parsed once: it is Rust.
///
/// # Panics
/// If the module is not Rust, which would be a mistake of this generator.
pub fn module(scene: &Scene, equations: &Equations, source: &str) -> Module {
    let layout = Layout::new(scene, equations);
    let writer = Writer::new(scene, &layout);
    let mut operations = Vec::new();
    let functions: Vec<TokenStream> = layout.plans.iter().map(|plan| writer.function(plan, &mut operations)).collect();
    let kernel = kernel::Emitter::new(&writer, &layout.kernel).items();
    operations.extend(kernel.operations);
    let inverse = layout.inverse.as_ref().map(|inverse| inverse::inverse_dynamics(&writer, inverse));
    let inverse = inverse.map(|(tokens, cost)| {
        operations.push(("inverse_dynamics", cost));
        tokens
    });
    let kernel_solution = kernel.solution;
    let kernel = kernel.tokens;
    let constants = writer.constants();
    let scene_items::Items { parameters, mechanism, link, description } =
        scene_items::items(scene, !writer.constants.is_empty(), source);
    let has_parameters = scene.parameters.iter().any(|p| !p.left_out);
    let linearization = equations.linearization.is_some().then(|| quote!(Linearization,));
    let parameter_description = has_parameters.then(|| quote!(ParameterDescription,));
    let tokens = quote! {
        use qrm_core::{
            Angles, Description, Dynamics, Equations, Generated, Kernel, #linearization LoopConstraints, #parameter_description
            QuantityDescription, Scalar, Schedule, Start,
        };
        #parameters
        #mechanism
        #constants
        #(#functions)*
        #kernel
        #inverse
        #link
        #description
    };
    let file =
        syn::parse2(tokens.clone()).unwrap_or_else(|e| panic!("the generated module is not Rust: {e}\n{tokens}"));
    let tape = tape::of_module(scene, &file, kernel_solution.sum())
        .unwrap_or_else(|e| panic!("the generated module cannot be run: {e}"));
    Module { file, tape, operations, solution: kernel_solution }
}

/// A generated module.
pub struct Module {
    /// Its syntax.
    pub file: syn::File,
    /// Its functions as a tape, which follows the rest of the text.
    pub tape: OwnedTape,
    /// What each function costs.
    pub operations: Vec<(&'static str, Operations)>,
    /// What accelerations and multipliers cost by the kernel.
    pub solution: Operations,
}

/// The field of a parameter.
pub(crate) fn field_name(parameter: &str) -> String {
    ident(parameter).to_string()
}

/// Names of arguments and of the two halves of a mechanism.
const RESERVED: [&str; 11] =
    ["p", "k", "q", "qd", "qdd", "m", "multipliers", "rows", "angles", "position", "residuals"];

/// Names that no value of a function may have: those above, and that of time.
fn reserved() -> HashSet<String> {
    RESERVED.into_iter().chain(["t"]).map(str::to_owned).collect()
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
    /// Coordinates of points, and sines and cosines of sums of coordinates.
    named_values: HashSet<Id>,
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
            named_values: HashSet::new(),
            constants: Vec::new(),
        };
        for (id, op) in graph.ops().iter().enumerate() {
            let Op::Input(symbol) = op else { continue };
            let (hint, tokens) = match *symbol {
                // Its name is given where it is computed.
                Symbol::Local(_) => continue,
                Symbol::Parameter(i) => {
                    let name = &scene.parameters[i].name;
                    let field = ident(name);
                    (name.to_lowercase(), quote!(p.#field))
                }
                Symbol::Pi => ("pi".to_owned(), quote!(R::pi())),
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
        let is_new = |value: &Signed| !graph.is_constant(value.id) && !graph.op(value.id).is_leaf() && !value.negative;
        for (name, value) in layout.named_values.iter().filter(|(_, value)| is_new(value)) {
            writer.hints.entry(value.id).or_insert_with(|| name.clone());
            writer.named_values.insert(value.id);
        }
        for (name, value) in layout.names.iter().filter(|(_, value)| is_new(value)) {
            writer.hints.entry(value.id).or_insert_with(|| name.clone());
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
            Symbol::Residual(i) => format!("{}_open", self.scene.constraints[i].name),
            _ => "t".to_owned(),
        };
        let name = ident(&name).to_string();
        let mut name = name.strip_prefix("r#").map_or(name.clone(), |word| format!("{word}_"));
        // The arguments and the two halves of a mechanism are in the same scope, and a raw identifier cannot be part of
        // a longer name.
        while RESERVED.contains(&name.as_str()) || self.inputs.values().any(|bound| *bound == name) {
            name.push('_');
        }
        name
    }

    fn function(&self, plan: &Plan<Signed>, operations: &mut Vec<(&'static str, Operations)>) -> TokenStream {
        let roots: Vec<Signed> = plan.values().copied().collect();
        let mut taken = reserved();
        taken.extend(self.inputs.values().map(ToString::to_string));
        let mut body = Body::new(self.graph, &self.outside, &self.hints, &self.named_values, taken, &roots);
        let fields: Vec<TokenStream> = plan.parts.iter().map(|(_, shape)| result(&mut body, shape)).collect();
        let used: Vec<Id> = self.outside.keys().copied().filter(|&id| body.needs(id)).collect();
        let (statements, cost) = body.finish();
        operations.push((plan.name, cost));

        let (bindings, parameters) = self.arguments(plan.arguments, &used);
        let uses = |test: fn(&Op) -> bool| used.iter().any(|&id| test(self.graph.op(id)));
        let p = uses(|op| matches!(op, Op::Input(Symbol::Parameter(_)))).then(|| quote!(let p = &m.parameters;));
        // Of what stands outside, the constants alone are computed from something.
        let k = uses(|op| !op.is_leaf()).then(|| quote!(let k = &m.constants;));
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
        // The quantities of a row share their sines and cosines where all are in one place.
        let is_inner = ["dynamics", "loop_constraints", "outputs", "energy", "power"].contains(&plan.name);
        let inline = if is_inner { quote!(#[inline(always)]) } else { quote!(#[inline]) };
        let docs = self.doc_lines(plan, cost);
        let aliases = plan.aliases.iter();
        quote! {
            #(#[doc = #docs])*
            #(#[doc(alias = #aliases)])*
            #inline
            pub fn #name<R: Scalar>(#m: &#own<R>, #(#parameters),*) -> #output {
                #p
                #k
                #(#bindings)*
                #(#statements)*
                #value
            }
        }
    }

    fn doc_lines(&self, plan: &Plan<Signed>, cost: Operations) -> Vec<String> {
        let coordinates = || self.scene.coordinates.iter().map(|c| c.name.clone());
        let list = |argument: &Argument| {
            let (name, of): (&str, Vec<String>) = match argument {
                Argument::Time => return "`t` in s".to_owned(),
                Argument::Coordinates => ("q", coordinates().collect()),
                Argument::Rates => ("qd", coordinates().map(|name| format!("{name}_dot")).collect()),
                Argument::Accelerations => ("qdd", coordinates().map(|name| format!("{name}_ddot")).collect()),
                Argument::Multipliers => {
                    ("multipliers", self.scene.constraints.iter().map(|c| c.name.clone()).collect())
                }
                Argument::Residuals => ("residuals", self.scene.constraints.iter().map(|c| c.name.clone()).collect()),
            };
            format!("`{name} = [{}]`", of.join(", "))
        };
        let arguments: Vec<String> = plan.arguments.iter().map(list).collect();
        let text = format!("{}\n\nArguments: {}.\n\nOperations: {cost}.", plan.doc, arguments.join(", "));
        text.lines().map(|line| format!(" {line}").trim_end().to_owned()).collect()
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
                Argument::Residuals => ("residuals", c, Symbol::Residual),
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
        Shape::Matrix(rows) if is_sparse(body, rows) => sparse(body, rows),
        Shape::Matrix(rows) => {
            let rows = rows.iter().map(|row| {
                let values = row.iter().map(|root| body.root(*root));
                quote!([#(#values),*])
            });
            quote!([#(#rows),*])
        }
    }
}

/// Matrices with more entries than this are written by those that are not zero, if these are few.
const LARGE: usize = 100;

fn is_sparse(body: &Body, rows: &[Vec<Signed>]) -> bool {
    let entries = rows.iter().map(Vec::len).sum::<usize>();
    let filled = rows.iter().flatten().filter(|entry| !body.is_zero(**entry)).count();
    entries > LARGE && filled < entries / 4
}

/// A matrix by its entries that are not zero: the code of a large mechanism grows with what is in it, not with its
/// square.
fn sparse(body: &mut Body, rows: &[Vec<Signed>]) -> TokenStream {
    let (height, width) = (rows.len(), rows.first().map_or(0, Vec::len));
    let [height, width] = [height, width].map(proc_macro2::Literal::usize_unsuffixed);
    let mut entries = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        for (j, entry) in row.iter().enumerate().filter(|(_, entry)| !body.is_zero(**entry)).collect::<Vec<_>>() {
            let value = body.root(*entry);
            let [i, j] = [i, j].map(proc_macro2::Literal::usize_unsuffixed);
            entries.push(quote!(rows[#i][#j] = #value;));
        }
    }
    quote!({
        let mut rows = [[R::zero(); #width]; #height];
        #(#entries)*
        rows
    })
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
