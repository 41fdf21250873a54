//! The kernel as functions: what follows from a position, and what is made of it.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::Writer;
use super::body::{Body, Operations};
use super::layout::{Argument, power_arguments};
use super::plain::ident;
use super::scene_items::{event, linearization, schedule, start, time_argument};
use crate::graph::{Graph, Id, Op, Signed};
use crate::kernel::{Block, Kernel, Local};
use crate::term::Symbol;
use qrm_scene::function::Function;
use qrm_scene::names::struct_name;

/// The functions of a kernel and what they cost.
pub(super) struct KernelItems {
    pub(super) tokens: TokenStream,
    pub(super) operations: Vec<(&'static str, Operations)>,
    /// The operations of accelerations and multipliers, sines and cosines given.
    pub(super) solution: Operations,
}

/// A function of a kernel.
struct Part<'k> {
    name: &'static str,
    doc: &'static str,
    arguments: &'static [Argument],
    blocks: &'static [Block],
    results: Vec<&'k [Signed]>,
}

/// Writes the functions of a kernel.
pub(super) struct Emitter<'a> {
    writer: &'a Writer<'a>,
    kernel: &'a Kernel,
    graph: &'a Graph,
    /// Names that stand for values in every function: arguments, parameters, constants, sines and cosines.
    outside: HashMap<Id, TokenStream>,
    /// Which values follow from the position alone.
    is_position: Vec<bool>,
    depths: Vec<u32>,
    taken: HashSet<String>,
}

impl<'a> Emitter<'a> {
    pub(super) fn new(writer: &'a Writer<'a>, kernel: &'a Kernel) -> Self {
        let graph = writer.graph;
        let mut outside = writer.outside.clone();
        for (id, op) in graph.ops().iter().enumerate() {
            if let Some((function, i)) = angle_of(graph, op) {
                let name = format_ident!("{}", angle_name(writer, function, i));
                outside.insert(id, quote!(#name));
            }
        }
        let mut taken = super::reserved();
        let results = |id: Id| matches!(graph.op(id), Op::Input(Symbol::Acceleration(_) | Symbol::Multiplier(_)));
        taken.extend(outside.iter().filter(|(id, _)| !results(**id)).map(|(_, tokens)| tokens.to_string()));
        let inputs: HashMap<Id, &Local> = kernel.locals.iter().map(|local| (local.input.id, local)).collect();
        let mut emitter = Self { writer, kernel, graph, outside, is_position: Vec::new(), depths: Vec::new(), taken };
        for (id, op) in graph.ops().iter().enumerate() {
            let local = inputs.get(&id);
            let follows = match (op, local) {
                (_, Some(local)) => local.block.is_position(),
                // Where closures or lengths need time, a position is one at a time.
                (Op::Input(Symbol::Time), None) => kernel.is_timed,
                (Op::Input(symbol), None) => symbol.is_constant() || matches!(symbol, Symbol::Coordinate(_)),
                (op, None) => op.operands().iter().all(|&operand| emitter.is_position[operand]),
            };
            emitter.is_position.push(follows);
            let depth = emitter.depth(id, op, local.map(|local| local.value.id));
            emitter.depths.push(depth);
        }
        emitter
    }

    /// After about how many cycles a value is there.
    fn depth(&self, id: Id, op: &Op, definition: Option<Id>) -> u32 {
        let deepest = op.operands().iter().map(|&operand| self.depths[operand]).max().unwrap_or(0);
        let more = |operands: usize| 3 * u32::try_from(operands.saturating_sub(1)).unwrap_or(u32::MAX / 4);
        match op {
            _ if self.outside.contains_key(&id) => 0,
            Op::Input(_) => definition.map_or(0, |id| self.depths[id]),
            Op::Number(_) => 0,
            Op::Sum(terms) => deepest + more(terms.len()),
            Op::Product(factors) => deepest + more(factors.len()),
            Op::Reciprocal(_) => deepest + 13,
            Op::Power(..) | Op::Call(..) => deepest + 20,
        }
    }

    /// All functions, and the link to a stepper.
    pub(super) fn items(&self) -> KernelItems {
        let kernel = self.kernel;
        let parts = [
            Part {
                name: "residuals",
                doc: "Residuals of the loop closures, `C(q)`.",
                arguments: &[],
                blocks: &[],
                results: vec![&kernel.residuals],
            },
            Part {
                name: "velocity_residual",
                doc: if self.writer.scene.is_driven() { "`C_q qd + C_t`." } else { "`C_q qd`." },
                arguments: &[Argument::Rates],
                blocks: &[],
                results: vec![&kernel.velocity_residual],
            },
            Part {
                name: "correction",
                doc: "The change of coordinates that is least in the metric of `Mbar` among those with `C_q dq = -residuals`.",
                arguments: &[Argument::Residuals],
                blocks: &[Block::Correction],
                results: vec![&kernel.correction],
            },
            Part {
                name: "accelerations",
                doc: "`qdd`, and the multipliers.",
                arguments: &[Argument::Time, Argument::Coordinates, Argument::Rates],
                blocks: &[
                    Block::Rates,
                    Block::NamedRates,
                    Block::Bias,
                    Block::Forces,
                    Block::Accelerations,
                    Block::Multipliers,
                    Block::Friction,
                ],
                results: vec![&kernel.accelerations, &kernel.multipliers],
            },
            Part {
                name: "outputs_at",
                doc: "What the scene asks for, at a position that is known.",
                arguments: &[
                    Argument::Time,
                    Argument::Coordinates,
                    Argument::Rates,
                    Argument::Accelerations,
                    Argument::Multipliers,
                ],
                blocks: &[Block::Rates, Block::NamedRates],
                results: vec![&kernel.outputs],
            },
        ];
        let fields = self.fields(&parts);
        let (names, position, cost) = self.position(&fields);
        let mut inside = self.outside.clone();
        inside.extend(names.iter().map(|(id, name)| (*id, quote!(#name))));
        let mut operations = vec![("position", cost)];
        let functions: Vec<TokenStream> = parts
            .iter()
            .map(|part| {
                let (tokens, cost) = self.function(part, &inside, &names);
                operations.push((part.name, cost));
                tokens
            })
            .collect();
        let growth_factor = self.growth_factor(&names);
        let solution = self.solution();
        let link = self.link(solution);
        let fields: BTreeSet<String> = names.values().map(ToString::to_string).collect();
        let nothing = fields.is_empty().then(|| quote!(pub nothing: R,));
        let fields = fields.iter().map(|name| format_ident!("{name}"));
        let tokens = quote! {
            /// What follows from the position alone.
            #[derive(Clone, Copy, Debug)]
            #[allow(missing_docs)]
            pub struct Position<R> {
                #(pub #fields: R,)*
                #nothing
            }
            #position
            #(#functions)*
            #growth_factor
            #link
        };
        KernelItems { tokens, operations, solution }
    }

    /// The values of a position that other functions need.
    fn fields(&self, parts: &[Part]) -> BTreeSet<Id> {
        let mut fields = self.computed_fields(parts);
        let definitions = self.definitions();
        // Functions that do not take coordinates or time find them there.
        for part in parts {
            let roots: Vec<Signed> = part.results.iter().copied().flatten().copied().collect();
            let (mut seen, mut pending) = (HashSet::new(), roots.iter().map(|root| root.id).collect::<Vec<Id>>());
            while let Some(id) = pending.pop() {
                if fields.contains(&id) || !seen.insert(id) {
                    continue;
                }
                let may_be_one = matches!(self.graph.op(id), Op::Input(Symbol::Coordinate(_) | Symbol::Time));
                if may_be_one && !self.is_argument(id, part.arguments) {
                    fields.insert(id);
                } else {
                    pending.extend(self.graph.op(id).operands());
                    pending.extend(definitions.get(&id));
                }
            }
        }
        fields
    }

    /// What stands behind each local.
    fn definitions(&self) -> HashMap<Id, Id> {
        self.kernel.locals.iter().map(|local| (local.input.id, local.value.id)).collect()
    }

    fn computed_fields(&self, parts: &[Part]) -> BTreeSet<Id> {
        let kernel = self.kernel;
        let values = parts.iter().flat_map(|part| part.results.iter().copied().flatten()).chain(&kernel.growth_factors);
        let mut pending: Vec<Id> = values.map(|value| value.id).collect();
        pending.extend(kernel.locals.iter().filter(|local| !local.block.is_position()).map(|local| local.value.id));
        let (mut seen, mut fields) = (HashSet::new(), BTreeSet::new());
        while let Some(id) = pending.pop() {
            if self.outside.contains_key(&id) || !seen.insert(id) {
                continue;
            }
            let op = self.graph.op(id);
            let is_local = matches!(op, Op::Input(Symbol::Local(_)));
            if self.is_position[id] && (is_local || !op.is_leaf()) {
                fields.insert(id);
            } else {
                pending.extend(op.operands());
            }
        }
        fields
    }

    fn position(&self, fields: &BTreeSet<Id>) -> (BTreeMap<Id, Ident>, TokenStream, Operations) {
        let locals: Vec<&Local> = self.kernel.locals.iter().filter(|local| local.block.is_position()).collect();
        let named: HashSet<Id> = fields.iter().copied().collect();
        let roots: Vec<Signed> = fields.iter().map(|&id| Signed { negative: false, id }).collect();
        let all: Vec<Signed> = locals.iter().map(|local| local.value).chain(roots.clone()).collect();
        let mut body = self.body(&self.outside, &all);
        define(&mut body, &locals, &named);
        body.define_all(&roots, &named);
        let name = |id: &Id| match (body.name_of(*id), self.outside.get(id)) {
            (Some(name), _) => Some((*id, format_ident!("{name}"))),
            (None, outside) => outside.map(|name| (*id, format_ident!("{}", name.to_string()))),
        };
        let names: BTreeMap<Id, Ident> = fields.iter().filter_map(name).collect();
        let distinct: BTreeSet<String> = names.values().map(ToString::to_string).collect();
        let distinct = distinct.iter().map(|name| format_ident!("{name}"));
        // A struct without a number would have no type.
        let value = match distinct.len() {
            0 => quote!(Position { nothing: R::zero() }),
            _ => quote!(Position { #(#distinct),* }),
        };
        let doc = "What follows from the position alone: the loops, their Jacobian, the mass matrix, and how the dependent \
                   coordinates follow the others.";
        let arguments: &[Argument] = match self.kernel.is_timed {
            true => &[Argument::Time, Argument::Coordinates],
            false => &[Argument::Coordinates],
        };
        let (tokens, cost) = self.wrapped("position", doc, arguments, (body, value), quote!(Position<R>), None);
        (names, tokens, cost)
    }

    fn function(
        &self,
        part: &Part,
        inside: &HashMap<Id, TokenStream>,
        names: &BTreeMap<Id, Ident>,
    ) -> (TokenStream, Operations) {
        let results = || part.results.iter().copied().flatten();
        let locals = self.needed_locals(results().copied(), inside);
        let locals: Vec<&Local> = locals.into_iter().filter(|local| part.blocks.contains(&local.block)).collect();
        let roots: Vec<Signed> = locals.iter().map(|local| &local.value).chain(results()).copied().collect();
        let mut body = self.body(inside, &roots);
        define(&mut body, &locals, &HashSet::new());
        let ends: Vec<Signed> = results().copied().collect();
        body.define_all(&ends, &HashSet::new());
        let (mut values, mut types) = (Vec::new(), Vec::new());
        for result in &part.results {
            let count = Literal::usize_unsuffixed(result.len());
            let roots = result.iter().map(|root| body.root(*root));
            values.push(quote!([#(#roots),*]));
            types.push(quote!([R; #count]));
        }
        let (value, output) = match values.len() {
            1 => (values[0].clone(), types[0].clone()),
            _ => (quote!((#(#values),*)), quote!((#(#types),*))),
        };
        self.wrapped(part.name, part.doc, part.arguments, (body, value), output, Some(names))
    }

    /// The locals that results need, through others and up to what stands outside.
    fn needed_locals(&self, results: impl Iterator<Item = Signed>, outside: &HashMap<Id, TokenStream>) -> Vec<&Local> {
        let definitions = self.definitions();
        let mut pending: Vec<Id> = results.map(|root| root.id).collect();
        let mut needed = HashSet::new();
        while let Some(id) = pending.pop() {
            if !outside.contains_key(&id) && needed.insert(id) {
                pending.extend(self.graph.op(id).operands());
                pending.extend(definitions.get(&id));
            }
        }
        self.kernel.locals.iter().filter(|local| needed.contains(&local.input.id)).collect()
    }

    /// What accelerations and multipliers cost from sines and cosines on.
    fn solution(&self) -> Operations {
        let results: Vec<Signed> = self.kernel.accelerations.iter().chain(&self.kernel.multipliers).copied().collect();
        let locals = self.needed_locals(results.iter().copied(), &self.outside);
        let roots: Vec<Signed> = locals.iter().map(|local| local.value).chain(results.clone()).collect();
        let mut body = self.body(&self.outside, &roots);
        define(&mut body, &locals, &HashSet::new());
        body.define_all(&results, &HashSet::new());
        body.finish().1
    }

    fn body<'b>(&'b self, outside: &'b HashMap<Id, TokenStream>, roots: &[Signed]) -> Body<'b> {
        let mut taken = self.taken.clone();
        // The fields of a position are bound in the same scope.
        taken.extend(outside.iter().filter(|(id, _)| !self.outside.contains_key(id)).map(|(_, name)| name.to_string()));
        Body::begin(self.graph, outside, &self.writer.hints, taken, roots, Some(&self.depths))
    }

    /// A function around a body.
    fn wrapped(
        &self,
        name: &'static str,
        doc: &str,
        arguments: &[Argument],
        (body, value): (Body, TokenStream),
        output: TokenStream,
        position: Option<&BTreeMap<Id, Ident>>,
    ) -> (TokenStream, Operations) {
        let is_field = |id: Id| position.is_some_and(|names| names.contains_key(&id));
        let used: Vec<Id> = self.outside.keys().copied().filter(|&id| body.needs(id)).collect();
        let used: Vec<Id> = used.into_iter().filter(|&id| !is_field(id) || self.is_argument(id, arguments)).collect();
        let (m, halves) = self.halves(&used);
        let fields: BTreeSet<String> = position
            .iter()
            .flat_map(|names| names.iter())
            .filter(|(id, _)| body.needs(**id) && !self.is_argument(**id, arguments))
            .map(|(_, name)| name.to_string())
            .collect();
        let (angles, bound) = self.angles(&used, &fields);
        let fields = fields.iter().map(|name| format_ident!("{name}")).collect::<Vec<_>>();
        let position_argument = position.map(|_| match fields.is_empty() {
            true => quote!(_position: &Position<R>,),
            false => quote!(position: &Position<R>,),
        });
        let unpack = (!fields.is_empty()).then(|| quote!(let Position { #(#fields),*, .. } = *position;));
        let has_angles = ["position", "accelerations", "outputs_at"].contains(&name);
        let n = Literal::usize_unsuffixed(self.writer.scene.coordinates.len());
        let angles_name = if bound.is_empty() { quote!(_angles) } else { quote!(angles) };
        let angles_argument = has_angles.then(|| quote!(#angles_name: &Angles<R, #n>,));
        let (bindings, parameters) = self.writer.arguments(arguments, &used);
        let (statements, cost) = body.finish();
        let own = format_ident!("{}", struct_name(&self.writer.scene.name));
        let name = format_ident!("{name}");
        let docs = [format!(" {doc}"), String::new(), format!(" Operations: {cost}.")];
        let too_many = (arguments.len() > 4).then(|| quote!(#[allow(clippy::too_many_arguments)]));
        debug_assert!(has_angles || angles.is_empty());
        let tokens = quote! {
            #(#[doc = #docs])*
            #[inline(always)]
            #too_many
            pub fn #name<R: Scalar>(#m: &#own<R>, #position_argument #(#parameters,)* #angles_argument) -> #output {
                #halves
                #(#bindings)*
                #(#angles)*
                #unpack
                #(#statements)*
                #value
            }
        };
        (tokens, cost)
    }

    /// The name of the mechanism in a function that needs these values, and the bindings of its parameters and constants.
    fn halves(&self, used: &[Id]) -> (TokenStream, TokenStream) {
        let uses = |test: &dyn Fn(Id, &Op) -> bool| used.iter().any(|&id| test(id, self.graph.op(id)));
        let p = uses(&|_, op| matches!(op, Op::Input(Symbol::Parameter(_)))).then(|| quote!(let p = &m.parameters;));
        let is_constant = |id: Id, op: &Op| {
            !op.is_leaf() && angle_of(self.graph, op).is_none() && self.writer.outside.contains_key(&id)
        };
        let k = uses(&is_constant).then(|| quote!(let k = &m.constants;));
        let m = if p.is_some() || k.is_some() { quote!(m) } else { quote!(_m) };
        (m, quote!(#p #k))
    }

    /// A function that needs no position: the name of the mechanism in it, its other parameters, its body, which gives
    /// all results, and its cost.
    pub(super) fn whole(
        &self,
        arguments: &[Argument],
        results: &[&[Signed]],
    ) -> (TokenStream, Vec<TokenStream>, TokenStream, Operations) {
        let ends: Vec<Signed> = results.iter().copied().flatten().copied().collect();
        let locals = self.needed_locals(ends.iter().copied(), &self.outside);
        let roots: Vec<Signed> = locals.iter().map(|local| local.value).chain(ends.clone()).collect();
        let mut body = self.body(&self.outside, &roots);
        define(&mut body, &locals, &HashSet::new());
        body.define_all(&ends, &HashSet::new());
        let values = results.iter().map(|result| {
            let roots = result.iter().map(|root| body.root(*root));
            quote!([#(#roots),*])
        });
        let values: Vec<TokenStream> = values.collect();
        let mut used: Vec<Id> = self.outside.keys().copied().filter(|&id| body.needs(id)).collect();
        used.sort_unstable();
        let mut sines: BTreeMap<usize, [TokenStream; 2]> = BTreeMap::new();
        for (function, i) in used.iter().filter_map(|&id| angle_of(self.graph, self.graph.op(id))) {
            let pair = sines.entry(i).or_insert_with(|| [quote!(_), quote!(_)]);
            let name = format_ident!("{}", angle_name(self.writer, function, i));
            pair[usize::from(function == Function::Cos)] = quote!(#name);
        }
        let is_turned = |op: &Op| matches!(op, Op::Input(Symbol::Coordinate(i)) if sines.contains_key(i));
        used.extend((0..self.graph.ops().len()).filter(|&id| is_turned(self.graph.op(id))));
        let sines = sines.iter().map(|(i, [sin, cos])| {
            let angle = &self.writer.inputs[&Symbol::Coordinate(*i)];
            quote!(let (#sin, #cos) = #angle.sin_cos();)
        });
        let (m, halves) = self.halves(&used);
        let (bindings, parameters) = self.writer.arguments(arguments, &used);
        let (statements, cost) = body.finish();
        let tokens = quote!(#halves #(#bindings)* #(#sines)* #(#statements)* (#(#values),*));
        (m, parameters, tokens, cost)
    }

    /// Whether a coordinate or time is among a function's arguments.
    fn is_argument(&self, id: Id, arguments: &[Argument]) -> bool {
        match self.graph.op(id) {
            Op::Input(Symbol::Coordinate(_)) => arguments.contains(&Argument::Coordinates),
            Op::Input(Symbol::Time) => arguments.contains(&Argument::Time),
            _ => false,
        }
    }

    /// The bindings of the sines and cosines that are used, without those that fields of the position bring.
    fn angles(&self, used: &[Id], fields: &BTreeSet<String>) -> (Vec<TokenStream>, Vec<(Function, usize)>) {
        let angles = used.iter().filter_map(|&id| angle_of(self.graph, self.graph.op(id)));
        let bound: Vec<(Function, usize)> =
            angles.filter(|&(function, i)| !fields.contains(&angle_name(self.writer, function, i))).collect();
        let n = self.writer.scene.coordinates.len();
        let list = |function: Function, field: &str| {
            let names = (0..n).map(|i| match bound.contains(&(function, i)) {
                true => {
                    let name = format_ident!("{}", angle_name(self.writer, function, i));
                    quote!(#name)
                }
                false => quote!(_),
            });
            let field = format_ident!("{field}");
            let is_used = bound.iter().any(|(f, _)| *f == function);
            is_used.then(|| quote!(let [#(#names),*] = angles.#field;))
        };
        ([list(Function::Sin, "sin"), list(Function::Cos, "cos")].into_iter().flatten().collect(), bound)
    }

    fn growth_factor(&self, names: &BTreeMap<Id, Ident>) -> TokenStream {
        let sizes: Vec<TokenStream> = self
            .kernel
            .growth_factors
            .iter()
            .filter_map(|value| {
                let name = names.get(&value.id)?;
                Some(quote!(position.#name.abs()))
            })
            .collect();
        let most = match (self.kernel.is_suited, sizes.split_first()) {
            (false, _) => quote!(R::from_f64(f64::INFINITY)),
            (_, Some((first, others))) => quote!(#first #(.max(#others))*),
            (_, None) => quote!(R::zero()),
        };
        let position = if sizes.is_empty() || !self.kernel.is_suited { quote!(_position) } else { quote!(position) };
        quote! {
            /// How much the elimination of dependent coordinates magnifies rounding errors.
            #[inline(always)]
            pub fn growth_factor<R: Scalar>(#position: &Position<R>) -> R {
                #most
            }
        }
    }

    /// The implementation of the trait that steps and simulators use.
    fn link(&self, solution: Operations) -> TokenStream {
        let scene = self.writer.scene;
        let own = format_ident!("{}", struct_name(&scene.name));
        let n = Literal::usize_unsuffixed(scene.coordinates.len());
        let c = Literal::usize_unsuffixed(scene.constraints.len());
        let needs = |i: usize| self.graph.ops().iter().any(|op| angle_of(self.graph, op).is_some_and(|(_, j)| i == j));
        let has_angle = (0..scene.coordinates.len()).map(needs);
        let is_length = scene.coordinates.iter().map(|coordinate| coordinate.unit != "rad");
        let kept: Vec<_> = scene.parameters.iter().filter(|p| !p.left_out).collect();
        let parameters = kept.iter().enumerate().map(|(i, p)| {
            let (name, i) = (ident(&p.name), Literal::usize_unsuffixed(i));
            quote!(#name: value(#i),)
        });
        let marker = kept.is_empty().then(|| quote!(marker: core::marker::PhantomData));
        let value = if kept.is_empty() { quote!(_value) } else { quote!(value) };
        let operations = Literal::usize_unsuffixed(solution.sum());
        let (start, schedule, event) = (start(scene), schedule(scene), event(scene));
        let linearization = scene.run.stiff.then(|| linearization(scene));
        let [outputs_at, outputs] = [
            quote!(outputs_at(self, position, t, q, qd, qdd, multipliers, angles)),
            quote!(self::outputs(self, t, q, qd, qdd, multipliers)),
        ]
        .map(|values| (!scene.outputs.is_empty()).then(|| quote!(qrm_core::copy_outputs(&#values, outputs);)));
        let (t, at) = time_argument(self.kernel.is_timed);
        let (driven_t, driven_at) = time_argument(scene.is_driven());
        let of_power = power_arguments(scene);
        let [qdd, multipliers] = [(Argument::Accelerations, "qdd"), (Argument::Multipliers, "multipliers")]
            .map(|(argument, name)| (of_power.contains(&argument), format_ident!("{name}")));
        let power_results = [&qdd, &multipliers].map(|(is_used, name)| is_used.then(|| quote!(, #name)));
        let [qdd, multipliers] =
            [qdd, multipliers].map(|(is_used, name)| if is_used { name } else { format_ident!("_{name}") });
        quote! {
            impl<R: Scalar> Kernel<R, #n, #c> for #own<R> {
                type Position = Position<R>;

                const OPERATIONS: usize = #operations;

                #[inline(always)]
                fn has_angle(&self) -> [bool; #n] {
                    [#(#has_angle),*]
                }

                #[inline(always)]
                fn is_length(&self) -> [bool; #n] {
                    [#(#is_length),*]
                }

                #[inline(always)]
                fn set_values(&mut self, value: &dyn Fn(usize) -> R) {
                    *self = Self::with_values(value);
                }

                #[inline(always)]
                fn position(&self, #t: R, q: &[R; #n], angles: &Angles<R, #n>) -> Position<R> {
                    position(self, #at q, angles)
                }

                #[inline(always)]
                fn residuals(&self, position: &Position<R>) -> [R; #c] {
                    residuals(self, position)
                }

                #[inline(always)]
                fn growth_factor(&self, position: &Position<R>) -> R {
                    growth_factor(position)
                }

                #[inline(always)]
                fn velocity_residual(&self, position: &Position<R>, qd: &[R; #n]) -> [R; #c] {
                    velocity_residual(self, position, qd)
                }

                #[inline(always)]
                fn correction(&self, position: &Position<R>, residuals: &[R; #c]) -> [R; #n] {
                    correction(self, position, residuals)
                }

                #[inline(always)]
                fn accelerations(
                    &self,
                    position: &Position<R>,
                    t: R,
                    q: &[R; #n],
                    qd: &[R; #n],
                    angles: &Angles<R, #n>,
                ) -> ([R; #n], [R; #c]) {
                    accelerations(self, position, t, q, qd, angles)
                }

                #[inline(always)]
                #[allow(unused_variables)]
                fn outputs_at(
                    &self,
                    position: &Position<R>,
                    t: R,
                    q: &[R; #n],
                    qd: &[R; #n],
                    angles: &Angles<R, #n>,
                    qdd: &[R; #n],
                    multipliers: &[R; #c],
                    outputs: &mut [R],
                ) {
                    #outputs_at
                }

                #event

                #[inline(always)]
                fn power(&self, t: R, q: &[R; #n], qd: &[R; #n], #qdd: &[R; #n], #multipliers: &[R; #c]) -> R {
                    power(self, t, q, qd #(#power_results)*)
                }
            }

            impl<R: Scalar> Equations<R, #n, #c> for #own<R> {
                #[inline(always)]
                fn with_values(#value: &dyn Fn(usize) -> R) -> Self {
                    Self::new(Parameters { #(#parameters)* #marker })
                }

                #start

                #schedule

                #[inline(always)]
                fn dynamics(&self, t: R, q: &[R; #n], qd: &[R; #n]) -> Dynamics<R, #n, #c> {
                    dynamics(self, t, q, qd)
                }

                #[inline(always)]
                fn loop_constraints(&self, #driven_t: R, q: &[R; #n]) -> LoopConstraints<R, #n, #c> {
                    loop_constraints(self, #driven_at q)
                }

                fn mass_matrix(&self, q: &[R; #n]) -> [[R; #n]; #n] {
                    mass_matrix(self, q)
                }

                #[inline(always)]
                fn energy(&self, q: &[R; #n], qd: &[R; #n]) -> [R; 2] {
                    energy(self, q, qd)
                }

                #[inline(always)]
                #[allow(unused_variables)]
                fn outputs(
                    &self,
                    t: R,
                    q: &[R; #n],
                    qd: &[R; #n],
                    qdd: &[R; #n],
                    multipliers: &[R; #c],
                    outputs: &mut [R],
                ) {
                    #outputs
                }

                #linearization
            }
        }
    }
}

/// Defines values with a name, with a comment where another part of the computation begins.
fn define(body: &mut Body, locals: &[&Local], named: &HashSet<Id>) {
    let mut block = None;
    for local in locals {
        if block != Some(local.block) {
            body.comment(local.block.title());
            block = Some(local.block);
        }
        body.define_local(local.value.id, local.input.id, &local.name, named);
    }
    body.end_comment();
}

/// The coordinate whose sine or cosine an operation is.
fn angle_of(graph: &Graph, op: &Op) -> Option<(Function, usize)> {
    match op {
        Op::Call(function @ (Function::Sin | Function::Cos), angle) => match graph.op(*angle) {
            Op::Input(Symbol::Coordinate(i)) => Some((*function, *i)),
            _ => None,
        },
        _ => None,
    }
}

fn angle_name(writer: &Writer, function: Function, coordinate: usize) -> String {
    format!("{}_{}", function.name(), writer.inputs[&Symbol::Coordinate(coordinate)])
}
