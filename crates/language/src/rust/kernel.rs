//! The trait implementations through which steps and simulators call the functions.

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::function::Printer;
use super::scene_items::{event, linearization, schedule, start, time_argument};
use crate::identifier::ident;
use qrm_core::named_tape::Argument;

pub(super) fn link(printer: &Printer) -> TokenStream {
    let (scene, tape, own) = (printer.scene, printer.tape, &printer.own);
    let [n, m] = printer.sizes();
    let has_angle = &tape.has_angle;
    let is_length = scene.coordinates.iter().map(|coordinate| coordinate.unit != "rad");
    let kept: Vec<_> = scene.parameters.iter().filter(|p| !p.left_out).collect();
    let parameters = kept.iter().enumerate().map(|(i, p)| {
        let (name, i) = (ident(&p.name), Literal::usize_unsuffixed(i));
        quote!(#name: value(#i),)
    });
    let marker = kept.is_empty().then(|| quote!(marker: core::marker::PhantomData));
    let value = if kept.is_empty() { quote!(_value) } else { quote!(value) };
    let operations = Literal::usize_unsuffixed(tape.solution.sum());
    let (start, schedule, event) = (start(printer), schedule(printer), event(printer));
    let linearization = tape.function("linearization").map(|_| linearization(printer));
    let [outputs_at, outputs] = [
        quote!(outputs_at(self, position, t, q, qd, qdd, multipliers, angles)),
        quote!(self::outputs(self, t, q, qd, qdd, multipliers)),
    ]
    .map(|values| (!scene.outputs.is_empty()).then(|| quote!(qrm_core::copy_outputs(&#values, outputs);)));
    let takes = |name: &str, argument| tape.function(name).is_some_and(|own| own.arguments.contains(&argument));
    let (t, at) = time_argument(takes("position", Argument::Time));
    let (driven_t, driven_at) = time_argument(scene.is_driven());
    let [qdd, multipliers] = [(Argument::Accelerations, "qdd"), (Argument::Multipliers, "multipliers")]
        .map(|(argument, name)| (takes("power", argument), format_ident!("{name}")));
    let power_results = [&qdd, &multipliers].map(|(is_used, name)| is_used.then(|| quote!(, #name)));
    let [qdd, multipliers] =
        [qdd, multipliers].map(|(is_used, name)| if is_used { name } else { format_ident!("_{name}") });
    let (dynamics, mass_matrix) = match tape.function("momenta") {
        Some(_) => (
            quote! {
                fn dynamics(&self, t: R, q: &[R; #n], qd: &[R; #n]) -> Dynamics<R, #n, #m> {
                    Dynamics {
                        mass_matrix: self.mass_matrix(q),
                        generalized_forces: generalized_forces(self, t, q, qd),
                        constraint_jacobian: [],
                        constraint_bias: [],
                    }
                }
            },
            quote!(qrm_core::mass_matrix_from_momenta(|qd| momenta(self, q, qd))),
        ),
        None => (
            quote! {
                #[inline(always)]
                fn dynamics(&self, t: R, q: &[R; #n], qd: &[R; #n]) -> Dynamics<R, #n, #m> {
                    dynamics(self, t, q, qd)
                }
            },
            quote!(mass_matrix(self, q)),
        ),
    };
    quote! {
        impl<R: Scalar> Kernel<R, #n, #m> for #own<R> {
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
            fn residuals(&self, position: &Position<R>) -> [R; #m] {
                residuals(self, position)
            }

            #[inline(always)]
            fn growth_factor(&self, position: &Position<R>) -> R {
                growth_factor(self, position)
            }

            #[inline(always)]
            fn velocity_residual(&self, position: &Position<R>, qd: &[R; #n]) -> [R; #m] {
                velocity_residual(self, position, qd)
            }

            #[inline(always)]
            fn correction(&self, position: &Position<R>, residuals: &[R; #m]) -> [R; #n] {
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
            ) -> ([R; #n], [R; #m]) {
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
                multipliers: &[R; #m],
                outputs: &mut [R],
            ) {
                #outputs_at
            }

            #event

            #[inline(always)]
            fn power(&self, t: R, q: &[R; #n], qd: &[R; #n], #qdd: &[R; #n], #multipliers: &[R; #m]) -> R {
                power(self, t, q, qd #(#power_results)*)
            }
        }

        impl<R: Scalar> Equations<R, #n, #m> for #own<R> {
            #[inline(always)]
            fn with_values(#value: &dyn Fn(usize) -> R) -> Self {
                Self::new(Parameters { #(#parameters)* #marker })
            }

            #start

            #schedule

            #dynamics

            #[inline(always)]
            fn loop_constraints(&self, #driven_t: R, q: &[R; #n]) -> LoopConstraints<R, #n, #m> {
                loop_constraints(self, #driven_at q)
            }

            fn mass_matrix(&self, q: &[R; #n]) -> [[R; #n]; #n] {
                #mass_matrix
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
                multipliers: &[R; #m],
                outputs: &mut [R],
            ) {
                #outputs
            }

            #linearization
        }
    }
}
