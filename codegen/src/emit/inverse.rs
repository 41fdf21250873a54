//! The function for inverse dynamics.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::Writer;
use super::body::Operations;
use super::kernel::Emitter;
use super::layout::Argument;
use crate::graph::Signed;
use crate::kernel::Kernel;
use qrm_scene::names::struct_name;

/// Writes the function that gives the forces and torques along the coordinates that move freely, and the multipliers.
pub(super) fn inverse_dynamics(writer: &Writer, kernel: &Kernel) -> (TokenStream, Operations) {
    let scene = writer.scene;
    let (places, forces): (Vec<usize>, Vec<Signed>) = kernel.forces.iter().copied().unzip();
    let arguments = [Argument::Time, Argument::Coordinates, Argument::Rates, Argument::Accelerations];
    let emitter = Emitter::new(writer, kernel);
    let (m, parameters, body, cost) = emitter.whole(&arguments, &[&forces, &kernel.multipliers]);
    let own = format_ident!("{}", struct_name(&scene.name));
    let [f, c] = [forces.len(), kernel.multipliers.len()].map(Literal::usize_unsuffixed);
    let names: Vec<String> = places.iter().map(|i| format!("`{}`", scene.coordinates[*i].name)).collect();
    let places = places.iter().map(|i| Literal::usize_unsuffixed(*i));
    let along = if names.is_empty() { String::new() } else { format!(" along {}", names.join(", ")) };
    let docs = [
        format!(" Inverse dynamics: the forces and torques{along} that accelerations take beside the loads, and the"),
        " multipliers: `Mbar qdd + C_q' lambda = fbar + forces`. Positions, rates and accelerations keep the constraints."
            .to_owned(),
        String::new(),
        format!(" Operations: {cost}."),
    ];
    let tokens = quote! {
        /// The coordinates along which `inverse_dynamics` gives forces and torques, by their numbers.
        pub const ACTUATED: [usize; #f] = [#(#places),*];

        #(#[doc = #docs])*
        #[inline]
        pub fn inverse_dynamics<R: Scalar>(#m: &#own<R>, #(#parameters),*) -> ([R; #f], [R; #c]) {
            #body
        }
    };
    (tokens, cost)
}
