//! The struct of the mechanism.

use proc_macro2::TokenStream;
use quote::{format_ident, quote};

use qrm_scene::names::struct_name;
use qrm_scene::scene::Scene;

use super::doc_lines;
use crate::texts;

pub(super) fn mechanism_struct(scene: &Scene, has_constants: bool, source: &str) -> TokenStream {
    let own = format_ident!("{}", struct_name(&scene.name));
    let docs = doc_lines(&texts::mechanism(scene, source));
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
