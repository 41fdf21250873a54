//! Functions of a tape in Rust.

use std::collections::{BTreeSet, HashMap};

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::doc_lines;
use super::scope::Scope;
use crate::identifier::ident;
use crate::texts;
use qrm_core::NamedTape;
use qrm_core::named_tape::{Argument, Function, Shape, place};
use qrm_scene::names::struct_name;
use qrm_scene::scene::Scene;

/// Prints the functions of a tape.
pub(super) struct Printer<'t> {
    pub(super) scene: &'t Scene,
    pub(super) tape: &'t NamedTape,
    /// The struct of the mechanism.
    pub(super) own: Ident,
}

/// The printed result of a function: the preceding statements and the values of its parts.
pub(super) struct Printed {
    /// Bindings of arguments and statements.
    pub(super) statements: TokenStream,
    pub(super) parts: Vec<TokenStream>,
    /// The used inputs, constants and fields of a position.
    pub(super) used: BTreeSet<u32>,
}

impl<'t> Printer<'t> {
    pub(super) fn new(scene: &'t Scene, tape: &'t NamedTape) -> Self {
        Self { scene, tape, own: format_ident!("{}", struct_name(&scene.name)) }
    }

    /// The numbers of coordinates and constraints, as literals.
    pub(super) fn sizes(&self) -> [Literal; 2] {
        let [_, n, m] = self.tape.sizes();
        [n, m].map(Literal::usize_unsuffixed)
    }

    /// A free function.
    pub(super) fn function(&self, function: &Function) -> TokenStream {
        let printed = self.body(function, &quote!(m));
        let Printed { statements, parts, used } = &printed;
        let m = if self.uses_mechanism(used) { quote!(m) } else { quote!(_m) };
        let (own, name) = (&self.own, format_ident!("{}", function.name));
        let arguments = function.arguments.iter().map(|argument| self.argument(*argument, function, used));
        let (output, value) = self.output(function, parts);
        let docs = doc_lines(&texts::function(self.scene, self.tape, function));
        let aliases = &function.aliases;
        // Functions called by a step should not pass matrices through memory. The quantities of a row share sines and
        // cosines if they are computed in one place.
        let is_of_kernel = |argument| matches!(argument, &Argument::Position | &Argument::Angles);
        let is_inner = ["dynamics", "loop_constraints", "outputs", "energy", "power"].contains(&&*function.name)
            || function.arguments.iter().any(is_of_kernel);
        let inline = if is_inner { quote!(#[inline(always)]) } else { quote!(#[inline]) };
        let too_many = (function.arguments.len() > 6).then(|| quote!(#[allow(clippy::too_many_arguments)]));
        quote! {
            #(#[doc = #docs])*
            #(#[doc(alias = #aliases)])*
            #inline
            #too_many
            pub fn #name<R: Scalar>(#m: &#own<R>, #(#arguments),*) -> #output {
                #statements
                #value
            }
        }
    }

    /// The statements of a function and the values of its parts; `mechanism` is the name of the mechanism in that
    /// function or method.
    pub(super) fn body(&self, function: &Function, mechanism: &TokenStream) -> Printed {
        let mut scope = Scope { tape: self.tape, names: HashMap::new(), used: BTreeSet::new() };
        if function.arguments.contains(&Argument::Position) {
            scope.names.extend(self.fields().map(|(name, value)| (value, quote!(#name))));
        }
        let kept = 0..place(self.tape.sizes()[0]);
        scope.names.extend(kept.map(|input| {
            let field = ident(&self.tape.names[&input]);
            (input, quote!(p.#field))
        }));
        scope.names.extend(self.constant_fields().map(|(name, value)| (value, quote!(k.#name))));
        for argument in &function.arguments {
            scope.names.extend(self.inputs(*argument).map(|input| {
                let name = format_ident!("{}", self.tape.names[&input]);
                (input, quote!(#name))
            }));
        }
        let (statements, parts) = scope.print(function);
        let used = scope.used;
        let p = used.iter().any(|value| self.is_parameter(*value)).then(|| quote!(let p = &#mechanism.parameters;));
        let k = used.iter().any(|value| self.is_constant(*value)).then(|| quote!(let k = &#mechanism.constants;));
        let bindings = function.arguments.iter().map(|argument| self.binding(*argument, function, &used));
        let statements = quote!(#p #k #(#bindings)* #(#statements)*);
        Printed { statements, parts, used }
    }

    /// The statements that compute constants, and the values of the fields.
    pub(super) fn constants(&self, function: &Function) -> (Vec<TokenStream>, Vec<TokenStream>) {
        let kept = 0..place(self.tape.sizes()[0]);
        let names = kept.map(|input| {
            let field = ident(&self.tape.names[&input]);
            (input, quote!(p.#field))
        });
        Scope { tape: self.tape, names: names.collect(), used: BTreeSet::new() }.print(function)
    }

    /// The values of the parameters, in terms of other parameters.
    pub(super) fn parameters(&self, function: &Function) -> Vec<TokenStream> {
        let kept = 0..place(self.tape.sizes()[0]);
        let names = kept.map(|input| {
            let name = ident(&self.tape.names[&input]);
            (input, quote!(#name))
        });
        Scope { tape: self.tape, names: names.collect(), used: BTreeSet::new() }.print(function).1
    }

    fn uses_mechanism(&self, used: &BTreeSet<u32>) -> bool {
        used.iter().any(|value| self.is_parameter(*value) || self.is_constant(*value))
    }

    fn is_parameter(&self, value: u32) -> bool {
        (value as usize) < self.tape.sizes()[0]
    }

    fn is_constant(&self, value: u32) -> bool {
        !self.is_parameter(value) && self.constant_fields().any(|(_, constant)| constant == value)
    }

    /// The fields of the constants.
    fn constant_fields(&self) -> impl Iterator<Item = (Ident, u32)> {
        let parts = self.tape.function("constants").map(|function| &function.parts[..]).unwrap_or_default();
        parts.iter().flat_map(|part| part.values.values().into_iter().map(|value| (ident(&part.name), *value)))
    }

    /// The fields of a position.
    fn fields(&self) -> impl Iterator<Item = (Ident, u32)> {
        let parts = self.tape.function("position").map(|function| &function.parts[..]).unwrap_or_default();
        parts
            .iter()
            .flat_map(|part| part.values.values().into_iter().map(|value| (format_ident!("{}", part.name), *value)))
    }

    /// The inputs that belong to an argument.
    fn inputs(&self, argument: Argument) -> std::ops::Range<u32> {
        let [_, n, m] = self.tape.sizes();
        let count = match argument {
            Argument::Position => return 0..0,
            Argument::Time => 1,
            Argument::Coordinates | Argument::Rates | Argument::Accelerations => n,
            Argument::Multipliers | Argument::Residuals => m,
            Argument::Angles => 2 * n,
        };
        let first = self.tape.input(argument);
        first..first + place(count)
    }

    /// Whether a function uses an argument.
    pub(super) fn is_used(&self, argument: Argument, function: &Function, used: &BTreeSet<u32>) -> bool {
        match argument {
            Argument::Position => !self.used_fields(function, used).is_empty(),
            other => self.inputs(other).any(|input| used.contains(&input)),
        }
    }

    /// The fields of a position that a function uses.
    fn used_fields(&self, function: &Function, used: &BTreeSet<u32>) -> BTreeSet<Ident> {
        let is_argument =
            |value: u32| function.arguments.iter().any(|argument| self.inputs(*argument).contains(&value));
        let mut values = BTreeSet::new();
        let constants: BTreeSet<u32> = self.constant_fields().map(|(_, value)| value).collect();
        let is_field = |value: u32| used.contains(&value) && !is_argument(value) && !constants.contains(&value);
        // A value with two names is known by the last one.
        let names: HashMap<u32, Ident> = self.fields().map(|(name, value)| (value, name)).collect();
        values.extend(names.into_iter().filter(|(value, _)| is_field(*value)).map(|(_, name)| name));
        values
    }

    /// An argument of a function; its name begins with an underscore if it is unused.
    pub(super) fn argument(&self, argument: Argument, function: &Function, used: &BTreeSet<u32>) -> TokenStream {
        let [n, m] = self.sizes();
        let (name, of) = match argument {
            Argument::Position => ("position", quote!(&Position<R>)),
            Argument::Time => ("t", quote!(R)),
            Argument::Coordinates => ("q", quote!(&[R; #n])),
            Argument::Rates => ("qd", quote!(&[R; #n])),
            Argument::Accelerations => ("qdd", quote!(&[R; #n])),
            Argument::Multipliers => ("multipliers", quote!(&[R; #m])),
            Argument::Residuals => ("residuals", quote!(&[R; #m])),
            Argument::Angles => ("angles", quote!(&Angles<R, #n>)),
        };
        let name = format_ident!("{}{name}", if self.is_used(argument, function, used) { "" } else { "_" });
        quote!(#name: #of)
    }

    /// The statements that bind the used values of an argument.
    fn binding(&self, argument: Argument, function: &Function, used: &BTreeSet<u32>) -> TokenStream {
        if !self.is_used(argument, function, used) {
            return TokenStream::new();
        }
        let names = |inputs: std::ops::Range<u32>| {
            inputs.map(|input| match used.contains(&input) {
                true => {
                    let name = format_ident!("{}", self.tape.names[&input]);
                    quote!(#name)
                }
                false => quote!(_),
            })
        };
        let list = match argument {
            Argument::Time => return TokenStream::new(),
            Argument::Position => {
                let fields = self.used_fields(function, used);
                return quote!(let Position { #(#fields,)* .. } = *position;);
            }
            Argument::Angles => {
                let inputs = self.inputs(argument);
                let middle = (inputs.start + inputs.end) / 2;
                let halves = [("sin", inputs.start..middle), ("cos", middle..inputs.end)];
                let bindings = halves.into_iter().filter(|(_, half)| half.clone().any(|input| used.contains(&input)));
                let bindings = bindings.map(|(field, half)| {
                    let (names, field) = (names(half), format_ident!("{field}"));
                    quote!(let [#(#names),*] = angles.#field;)
                });
                return bindings.collect();
            }
            Argument::Coordinates => "q",
            Argument::Rates => "qd",
            Argument::Accelerations => "qdd",
            Argument::Multipliers => "multipliers",
            Argument::Residuals => "residuals",
        };
        let (list, names) = (format_ident!("{list}"), names(self.inputs(argument)));
        quote!(let [#(#names),*] = *#list;)
    }

    /// The type of a function's result, and the result.
    fn output(&self, function: &Function, parts: &[TokenStream]) -> (TokenStream, TokenStream) {
        let [n, m] = self.sizes();
        let shape = |shape: &Shape<u32>| match shape {
            Shape::Scalar(_) => quote!(R),
            Shape::Vector(values) => {
                let rows = Literal::usize_unsuffixed(values.len());
                quote!([R; #rows])
            }
            Shape::Matrix(rows) => {
                let rows = Literal::usize_unsuffixed(rows.len());
                quote!([[R; #n]; #rows])
            }
        };
        let Some(structure) = &function.structure else {
            let types = function.parts.iter().map(|part| shape(&part.values));
            return match parts {
                [part] => (quote!(#(#types)*), part.clone()),
                _ => (quote!((#(#types),*)), quote!((#(#parts),*))),
            };
        };
        let fields = function.parts.iter().zip(parts).map(|(part, value)| {
            let name = format_ident!("{}", part.name);
            if value.to_string() == part.name { quote!(#name) } else { quote!(#name: #value) }
        });
        // A struct without numbers would not determine its number type.
        let nothing = parts.is_empty().then(|| quote!(nothing: R::zero()));
        let sizes = (*structure != "Position").then(|| quote!(, #n, #m));
        let structure = format_ident!("{structure}");
        (quote!(#structure<R #sizes>), quote!(#structure { #(#fields,)* #nothing }))
    }
}
