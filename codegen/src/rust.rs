//! A tape as the text of a Rust module.

mod expression;
mod function;
mod kernel;
mod own_struct;
mod read;
mod scene_items;

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::identifier::ident;
use crate::tape::{Function, Tape};
use function::Printer;
use qrm_scene::scene::Scene;
pub use read::check;
pub use scene_items::until;

/// The syntax of a scene's module. It has been parsed once: it is Rust.
///
/// # Panics
/// If the module is not Rust, which would be a mistake of this generator.
pub fn module(scene: &Scene, tape: &Tape, source: &str) -> syn::File {
    let printer = Printer::new(scene, tape);
    let is_free = |name: &&str| !METHODS.contains(name);
    let functions = tape.functions.iter().filter(|function| is_free(&function.name));
    let functions = functions.map(|function| {
        let position = (function.name == "position").then(|| position(function));
        let function = printer.function(function);
        quote!(#position #function)
    });
    let constants = constants(&printer, tape);
    let link = kernel::link(&printer);
    let actuated = actuated(tape);
    let scene_items::Items { parameters, mechanism, generated, description } = scene_items::items(&printer, source);
    let linearization = tape.function("linearization").map(|_| quote!(Linearization,));
    let parameter_description = (tape.sizes()[0] > 0).then(|| quote!(ParameterDescription,));
    let tokens = quote! {
        use qrm_core::{
            Angles, Description, Dynamics, Equations, Generated, Kernel, #linearization LoopConstraints, #parameter_description
            QuantityDescription, Scalar, Schedule, Start,
        };
        #parameters
        #mechanism
        #constants
        #(#functions)*
        #actuated
        #link
        #generated
        #description
    };
    syn::parse2(tokens.clone()).unwrap_or_else(|e| panic!("the generated module is not Rust: {e}\n{tokens}"))
}

/// Functions that are methods of a type of the module.
const METHODS: [&str; 5] = ["parameters", "constants", "start", "schedule", "event"];

/// The struct of the constants, and how they are computed.
fn constants(printer: &Printer, tape: &Tape) -> TokenStream {
    let Some(function) = tape.function("constants") else { return TokenStream::new() };
    let names: Vec<_> = function.parts.iter().map(|part| ident(&part.name)).collect();
    let docs = function.parts.iter().map(|part| format!(" {}", part.doc));
    let (statements, values) = printer.constants(function);
    let fields = names.iter().zip(&values).map(|(name, value)| match *name == value.to_string() {
        true => quote!(#name),
        false => quote!(#name: #value),
    });
    quote! {
        /// Values that depend on parameters alone, computed once.
        #[derive(Clone, Copy, Debug)]
        pub struct Constants<R = f64> {
            #(#[doc = #docs] pub #names: R,)*
        }

        impl<R: Scalar> Constants<R> {
            #[inline(always)]
            fn new(p: &Parameters<R>) -> Self {
                #(#statements)*
                Self { #(#fields),* }
            }
        }
    }
}

/// The struct of what follows from a position.
fn position(function: &Function) -> TokenStream {
    let nothing = function.parts.is_empty().then(|| quote!(pub nothing: R,));
    let fields = function.parts.iter().map(|part| format_ident!("{}", part.name));
    quote! {
        /// What follows from the position alone.
        #[derive(Clone, Copy, Debug)]
        #[allow(missing_docs)]
        pub struct Position<R> {
            #(pub #fields: R,)*
            #nothing
        }
    }
}

/// The coordinates of inverse dynamics.
fn actuated(tape: &Tape) -> Option<TokenStream> {
    tape.function("inverse_dynamics")?;
    let count = proc_macro2::Literal::usize_unsuffixed(tape.actuated.len());
    let places = tape.actuated.iter().map(|i| proc_macro2::Literal::usize_unsuffixed(*i));
    Some(quote! {
        /// The coordinates along which `inverse_dynamics` gives forces and torques, by their numbers.
        pub const ACTUATED: [usize; #count] = [#(#places),*];
    })
}
