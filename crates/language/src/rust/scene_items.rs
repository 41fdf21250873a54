//! Items of a generated module other than functions: parameters, description, the connection to simulators.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use super::function::Printer;
use super::mechanism_struct::mechanism_struct;
use crate::identifier::ident;
use crate::texts;
use qrm_scene::names::module_name;
use qrm_scene::scene::{Coordinate, Parameter, Scene, Start};

/// The parts of a module other than its functions.
pub(super) struct Items {
    pub(super) parameters: TokenStream,
    /// The struct of the mechanism.
    pub(super) mechanism: TokenStream,
    /// The entry for simulators.
    pub(super) generated: TokenStream,
    pub(super) description: TokenStream,
}

pub(super) fn items(printer: &Printer, source: &str) -> Items {
    Items {
        parameters: parameters(printer),
        mechanism: mechanism_struct(printer.scene, printer.tape.function("constants").is_some(), source),
        generated: generated(printer),
        description: description(printer.scene, source),
    }
}

fn kept(scene: &Scene) -> impl Iterator<Item = &Parameter> {
    scene.parameters.iter().filter(|p| !p.left_out)
}

fn parameters(printer: &Printer) -> TokenStream {
    let scene = printer.scene;
    let names: Vec<_> = kept(scene).map(|p| ident(&p.name)).collect();
    let texts: Vec<&str> = kept(scene).map(|p| p.name.as_str()).collect();
    let values = printer.tape.function("parameters").map(|function| printer.parameters(function)).unwrap_or_default();
    let docs = kept(scene).map(|p| format!(" {}", texts::parameter(p)));
    let doc = format!(" {}", texts::PARAMETERS);
    // A struct without fields must still use its number type.
    let marker = names
        .is_empty()
        .then(|| (quote!(marker: core::marker::PhantomData<R>,), quote!(marker: core::marker::PhantomData)));
    let (marker_field, marker_value) = marker.unzip();
    // A parameter with this name would hide the closure.
    let mut replace = String::from(if names.is_empty() { "_replace" } else { "replace" });
    while texts.contains(&replace.as_str()) {
        replace.push('_');
    }
    let replace = format_ident!("{replace}");
    quote! {
        #[doc = #doc]
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(non_snake_case)]
        pub struct Parameters<R = f64> {
            #(#[doc = #docs] pub #names: R,)*
            #marker_field
        }

        impl<R: Scalar> Parameters<R> {
            /// The scene's values, some of them replaced; those that the scene computes from others follow.
            #[allow(non_snake_case)]
            #[inline]
            pub fn with(#replace: impl Fn(&str) -> Option<R>) -> Self {
                #(let #names = #replace(#texts).unwrap_or(#values);)*
                Self { #(#names,)* #marker_value }
            }
        }

        impl Default for Parameters {
            fn default() -> Self {
                Self::with(|_| None)
            }
        }
    }
}

/// The method for the derivatives with respect to the state, in scenes that have them.
pub(super) fn linearization(printer: &Printer) -> TokenStream {
    let [n, m] = printer.sizes();
    quote! {
        fn linearization(
            &self,
            t: R,
            q: &[R; #n],
            qd: &[R; #n],
            qdd: &[R; #n],
            multipliers: &[R; #m],
        ) -> Option<Linearization<R, #n, #m>> {
            Some(linearization(self, t, q, qd, qdd, multipliers))
        }
    }
}

/// The entry of the mechanism, generic over the number type.
fn generated(printer: &Printer) -> TokenStream {
    let (scene, own) = (printer.scene, &printer.own);
    let [n, m] = printer.sizes();
    let has_linearization = printer.tape.function("linearization").map(|_| {
        quote!(
            const HAS_LINEARIZATION: bool = true;
        )
    });
    let is_driven = scene.is_driven().then(|| {
        quote!(
            const IS_DRIVEN: bool = true;
        )
    });
    quote! {
        impl Generated<#n, #m> for #own {
            type Kernel<R: Scalar> = #own<R>;

            const DESCRIPTION: &'static Description = {
                static STORED: Description = DESCRIPTION;
                &STORED
            };
            const TAPE: &'static qrm_core::StoredTape = &TAPE;

            #has_linearization

            #is_driven

            const LANE_STEPS: qrm_core::LaneStepsTable = LANE_STEPS;
        }

        qrm_core::lane_steps!(#own, #n, #m);
    }
}

/// The name of time as an argument that only some scenes use, and the tokens that pass it on.
pub(super) fn time_argument(is_needed: bool) -> (proc_macro2::Ident, TokenStream) {
    if is_needed { (format_ident!("t"), quote!(t,)) } else { (format_ident!("_t"), quote!()) }
}

/// The method for the start of the motion.
pub(super) fn start(printer: &Printer) -> TokenStream {
    let Some(function) = printer.tape.function("start") else { return TokenStream::new() };
    let printed = printer.body(function, &quote!(self));
    let (statements, parts) = (&printed.statements, &printed.parts);
    let given = |start: fn(&Coordinate) -> &Start| {
        let coordinates = printer.scene.coordinates.iter();
        let given = coordinates.map(|coordinate| matches!(start(coordinate), Start::Given(_)));
        quote!([#(#given),*])
    };
    let (given, given_rates) = (given(|c| &c.position), given(|c| &c.rate));
    let (q, qd) = (&parts[0], &parts[1]);
    let [n, _] = printer.sizes();
    quote! {
        fn start(&self) -> Start<R, #n> {
            #statements
            Start { q: #q, given: #given, qd: #qd, given_rates: #given_rates }
        }
    }
}

/// The method for the step and the end of the motion.
pub(super) fn schedule(printer: &Printer) -> TokenStream {
    let Some(function) = printer.tape.function("schedule") else { return TokenStream::new() };
    let printed = printer.body(function, &quote!(self));
    let statements = &printed.statements;
    let (step, end_time) = (&printed.parts[0], &printed.parts[1]);
    quote! {
        fn schedule(&self) -> Schedule<R> {
            #statements
            Schedule { step: #step, end_time: #end_time }
        }
    }
}

/// The method for the value of the stop condition.
pub(super) fn event(printer: &Printer) -> TokenStream {
    let Some(function) = printer.tape.function("event") else {
        let [n, m] = printer.sizes();
        return quote! {
            fn event(&self, _t: R, _q: &[R; #n], _qd: &[R; #n], _qdd: &[R; #n], _multipliers: &[R; #m]) -> Option<R> {
                None
            }
        };
    };
    let printed = printer.body(function, &quote!(self));
    let (statements, rising) = (&printed.statements, &printed.parts[0]);
    let arguments = function.arguments.iter().map(|argument| printer.argument(*argument, function, &printed.used));
    quote! {
        #[inline(always)]
        fn event(&self, #(#arguments),*) -> Option<R> {
            #statements
            Some(#rising)
        }
    }
}

pub(super) fn description(scene: &Scene, source: &str) -> TokenStream {
    let (name, doc) = (&scene.name, &scene.doc);
    let quantity =
        |name: &str, unit: &str, doc: &str| quote!(QuantityDescription { name: #name, unit: #unit, doc: #doc });
    let coordinates = scene.coordinates.iter().map(|c| quantity(&c.name, &c.unit, &c.doc));
    let constraints = scene.constraints.iter().map(|c| quantity(&c.name, &c.unit, &c.doc));
    let outputs = scene.outputs.iter().map(|o| quantity(&o.name, &o.unit, &o.doc));
    let parameters = kept(scene).map(|p| {
        let (name, unit, doc, formula) = (&p.name, &p.unit, &p.doc, &p.text);
        quote!(ParameterDescription { name: #name, unit: #unit, doc: #doc, formula: #formula })
    });
    let has_corners = scene.has_corners();
    let friction = scene.friction_by_forces();
    let left_out = scene.left_out().map(|p| &p.name);
    let until = until(scene, source);
    let text = raw_string(source);
    let [tape_file, derivation_file] = ["tape", "md"].map(|extension| format!("{}.{extension}", module_name(name)));
    quote! {
        /// Names, units and meanings.
        pub const DESCRIPTION: Description = Description {
            name: #name,
            doc: #doc,
            source: SOURCE,
            derivation: include_str!(#derivation_file),
            coordinates: &[#(#coordinates),*],
            constraints: &[#(#constraints),*],
            outputs: &[#(#outputs),*],
            parameters: &[#(#parameters),*],
            left_out: &[#(#left_out),*],
            has_corners: #has_corners,
            friction: &[#(#friction),*],
            until: #until,
        };

        /// The functions with their names, for evaluators and for printers.
        pub static TAPE: qrm_core::StoredTape = qrm_core::StoredTape::new(include_bytes!(#tape_file));

        /// The scene that this module was generated from.
        pub const SOURCE: &str = #text;
    }
}

/// The stop condition as written; empty if there is none.
pub fn until<'s>(scene: &Scene, source: &'s str) -> &'s str {
    scene.run.until.as_ref().map_or("", |c| source.get(c.difference.whole_span()).unwrap_or_default())
}

/// A string literal that shows the text literally.
fn raw_string(text: &str) -> TokenStream {
    let mut fence = String::from("#");
    while text.contains(&format!("\"{fence}")) {
        fence.push('#');
    }
    // A raw literal cannot contain a bare carriage return.
    let raw = (!text.contains('\r')).then(|| format!("r{fence}\"{text}\"{fence}").parse().ok()).flatten();
    raw.unwrap_or_else(|| quote!(#text))
}
