//! The struct that is the mechanism, and what it is in words.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use crate::words::Words;
use qrm_scene::names::struct_name;
use qrm_scene::scene::{Body, Constraint, Coordinate, Load, Point, Scene};

pub(super) fn own_struct(scene: &Scene, has_constants: bool, source: &str) -> TokenStream {
    let own = format_ident!("{}", struct_name(&scene.name));
    let docs = own_doc(scene, source);
    let field = has_constants.then(|| quote!(constants: Constants<R>,));
    let value = has_constants.then(|| quote!(constants: Constants::new(&parameters),));
    quote! {
        #(#[doc = #docs])*
        #[derive(Clone, Copy, Debug)]
        pub struct #own<R = f64> {
            parameters: Parameters<R>,
            #field
        }

        impl<R: Scalar> #own<R> {
            /// The mechanism with these parameters.
            #[inline(always)]
            pub fn new(parameters: Parameters<R>) -> Self {
                Self { #value parameters }
            }

            /// The parameters.
            pub fn parameters(&self) -> &Parameters<R> {
                &self.parameters
            }
        }

        impl Default for #own {
            fn default() -> Self {
                Self::new(Parameters::default())
            }
        }
    }
}

/// The mechanism as the scene describes it, line by line.
fn own_doc(scene: &Scene, source: &str) -> Vec<String> {
    let words = Words { source };
    let mut text = if scene.doc.is_empty() { scene.name.clone() } else { scene.doc.clone() };
    let mut list = |title: &str, items: Vec<String>| {
        if !items.is_empty() {
            text += &format!("\n\n{title}:\n- {}", items.join("\n- "));
        }
    };
    let coordinate = |c: &Coordinate| format!("`{}`{}", c.name, described(&[&c.doc, &c.unit]));
    list("Coordinates", scene.coordinates.iter().map(coordinate).collect());
    let point = |p: &Point| format!("`{} = {}`", p.name, words.pair(&p.position));
    list("Points", scene.points.iter().map(point).collect());
    let body = |b: &Body| format!("`{}`: {}", b.name, words.body(b));
    list("Bodies", scene.bodies.iter().map(body).collect());
    let constraint =
        |c: &Constraint| format!("`{}`: `{} = 0`{}", c.name, words.formula(&c.residual), described(&[&c.doc]));
    list("Loops", scene.constraints.iter().map(constraint).collect());
    let load = |l: &Load| format!("`{}`: {}", l.name, words.load(&l.kind));
    list("Loads", scene.loads.iter().map(load).collect());
    text += "\n\nThe struct holds its parameters, and what depends on them alone.";
    text.lines().map(|line| format!(" {line}").trim_end().to_owned()).collect()
}

/// Words after a name, those that there are.
fn described(words: &[&str]) -> String {
    words.iter().filter(|word| !word.is_empty()).map(|word| format!(", {word}")).collect()
}
