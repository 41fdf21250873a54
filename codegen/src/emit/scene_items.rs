//! What a generated module holds beside the functions: parameters, description, the link to simulators.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::own_struct::own_struct;
use super::plain::{Plain, ident};
use qrm_scene::lexer::Comparison;
use qrm_scene::names::{module_name, struct_name};
use qrm_scene::scene::{Coordinate, Parameter, Quantity, Scene, Start, Value};

/// The parts of a module beside its functions.
pub(super) struct Items {
    pub(super) parameters: TokenStream,
    /// The struct that is the mechanism.
    pub(super) mechanism: TokenStream,
    /// What simulators use.
    pub(super) link: TokenStream,
    pub(super) description: TokenStream,
}

pub(super) fn items(scene: &Scene, has_constants: bool, source: &str) -> Items {
    Items {
        parameters: parameters(scene),
        mechanism: own_struct(scene, has_constants, source),
        link: link(scene),
        description: description(scene, source),
    }
}

fn kept(scene: &Scene) -> impl Iterator<Item = &Parameter> {
    scene.parameters.iter().filter(|p| !p.left_out)
}

fn parameters(scene: &Scene) -> TokenStream {
    let plain = Plain { scene, parameters: TokenStream::new(), number: quote!(R) };
    let names: Vec<_> = kept(scene).map(|p| ident(&p.name)).collect();
    let texts: Vec<&str> = kept(scene).map(|p| p.name.as_str()).collect();
    let values: Vec<TokenStream> = kept(scene).map(|p| plain.tokens(&p.formula)).collect();
    let docs = kept(scene).map(|p| {
        let unit = if p.unit.is_empty() { String::new() } else { format!(" ({})", p.unit) };
        format!(" {}{unit}", if p.doc.is_empty() { &p.name } else { &p.doc })
    });
    // A struct without fields still has to mention its number type.
    let marker = names
        .is_empty()
        .then(|| (quote!(marker: core::marker::PhantomData<R>,), quote!(marker: core::marker::PhantomData)));
    let (marker_field, marker_value) = marker.unzip();
    // A parameter of the same name would hide the closure.
    let mut replace = String::from(if names.is_empty() { "_replace" } else { "replace" });
    while texts.contains(&replace.as_str()) {
        replace.push('_');
    }
    let replace = format_ident!("{replace}");
    quote! {
        /// The numbers of the scene that can be changed, under their names in the scene.
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

/// The method that gives the derivatives by the state, in scenes that have them.
pub(super) fn linearization(scene: &Scene) -> TokenStream {
    let n = Literal::usize_unsuffixed(scene.coordinates.len());
    let m = Literal::usize_unsuffixed(scene.constraints.len());
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

/// The entry of the mechanism, on any number.
fn link(scene: &Scene) -> TokenStream {
    let own = format_ident!("{}", struct_name(&scene.name));
    let (n, m) = (scene.coordinates.len(), scene.constraints.len());
    let (n, m) = (Literal::usize_unsuffixed(n), Literal::usize_unsuffixed(m));
    let has_linearization = scene.run.stiff.then(|| {
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
            const TAPE: &'static qrm_core::Tape<'static> = &TAPE;

            #has_linearization

            #is_driven

            const LANE_STEPS: qrm_core::LaneStepsTable = LANE_STEPS;
        }

        qrm_core::lane_steps!(#own, #n, #m);
    }
}

/// The name of time where it is an argument for some scenes' sake, and how it is handed on.
pub(super) fn time_argument(is_needed: bool) -> (proc_macro2::Ident, TokenStream) {
    if is_needed { (format_ident!("t"), quote!(t,)) } else { (format_ident!("_t"), quote!()) }
}

/// Binds `p` if any of the formulae needs it.
fn with_parameters(values: &[&Value], body: TokenStream) -> TokenStream {
    let is_parameter = |q: &Quantity| matches!(q, Quantity::Parameter(_));
    let binding = values.iter().any(|v| v.names().any(is_parameter)).then(|| quote!(let p = &self.parameters;));
    quote!(#binding #body)
}

/// The method that gives the start of the motion.
pub(super) fn start(scene: &Scene) -> TokenStream {
    let plain = Plain { scene, parameters: quote!(p.), number: quote!(R) };
    let mut formulae = Vec::new();
    let mut values = |start: fn(&Coordinate) -> &Start| -> (Vec<TokenStream>, Vec<bool>) {
        let each = scene.coordinates.iter().map(|coordinate| match start(coordinate) {
            Start::Given(value) | Start::Guess(value) => {
                formulae.push(value);
                (plain.tokens(value), matches!(start(coordinate), Start::Given(_)))
            }
            Start::Free => (quote!(R::zero()), false),
        });
        each.unzip()
    };
    let (q, given) = values(|c| &c.position);
    let (qd, given_rates) = values(|c| &c.rate);
    let body = with_parameters(
        &formulae,
        quote! {
            Start { q: [#(#q),*], given: [#(#given),*], qd: [#(#qd),*], given_rates: [#(#given_rates),*] }
        },
    );
    let n = Literal::usize_unsuffixed(scene.coordinates.len());
    quote! {
        fn start(&self) -> Start<R, #n> {
            #body
        }
    }
}

/// The method that gives step and end of the motion.
pub(super) fn schedule(scene: &Scene) -> TokenStream {
    let plain = Plain { scene, parameters: quote!(p.), number: quote!(R) };
    let formulae = [&scene.run.step, &scene.run.end_time];
    let [step, end_time] = formulae.map(|formula| plain.tokens(formula));
    let body = with_parameters(&formulae, quote!(Schedule { step: #step, end_time: #end_time }));
    quote! {
        fn schedule(&self) -> Schedule<R> {
            #body
        }
    }
}

/// The method that gives the value of the stop condition.
pub(super) fn event(scene: &Scene) -> TokenStream {
    let plain = Plain { scene, parameters: quote!(p.), number: quote!(R) };
    let n = Literal::usize_unsuffixed(scene.coordinates.len());
    let Some(condition) = &scene.run.until else {
        return quote! {
            fn event(&self, _t: R, _q: &[R; #n], _qd: &[R; #n]) -> Option<R> {
                None
            }
        };
    };
    let points = plain.points(&condition.difference);
    let difference = plain.tokens(&condition.difference);
    let rising = match condition.comparison {
        Comparison::GreaterOrEqual => quote!(#difference),
        Comparison::LessOrEqual => quote!(-(#difference)),
    };
    let quantities = plain.quantities(&condition.difference);
    let uses = |test: fn(&Quantity) -> bool| quantities.iter().any(test);
    let argument = |name: &str, is_used: bool| format_ident!("{}{name}", if is_used { "" } else { "_" });
    let t = argument("t", uses(|q| *q == Quantity::Time));
    let q = argument("q", uses(|q| matches!(q, Quantity::Coordinate(_))));
    let qd = argument("qd", uses(|q| matches!(q, Quantity::Rate(_))));
    let p = uses(|q| matches!(q, Quantity::Parameter(_))).then(|| quote!(let p = &self.parameters;));
    quote! {
        #[inline(always)]
        fn event(&self, #t: R, #q: &[R; #n], #qd: &[R; #n]) -> Option<R> {
            #p
            #(#points)*
            Some(#rising)
        }
    }
}

fn description(scene: &Scene, source: &str) -> TokenStream {
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
    let [code_file, derivation_file] = ["rs", "md"].map(|extension| format!("{}.{extension}", module_name(name)));
    quote! {
        /// Names, units and meanings.
        pub const DESCRIPTION: Description = Description {
            name: #name,
            doc: #doc,
            source: SOURCE,
            code: include_str!(#code_file),
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

        /// The scene that this module was generated from.
        pub const SOURCE: &str = #text;
    }
}

/// The stop condition as written; empty if there is none.
pub fn until<'s>(scene: &Scene, source: &'s str) -> &'s str {
    scene.run.until.as_ref().map_or("", |c| source.get(c.difference.whole_span()).unwrap_or_default())
}

/// A string literal that reads like the text itself.
fn raw_string(text: &str) -> TokenStream {
    let mut fence = String::from("#");
    while text.contains(&format!("\"{fence}")) {
        fence.push('#');
    }
    // A raw literal cannot hold a bare carriage return.
    let raw = (!text.contains('\r')).then(|| format!("r{fence}\"{text}\"{fence}").parse().ok()).flatten();
    raw.unwrap_or_else(|| quote!(#text))
}
