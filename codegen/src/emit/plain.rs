//! Formulae that are evaluated as they stand: values of parameters, the start, the schedule, the stop condition.

use std::collections::BTreeSet;

use proc_macro2::{Literal, TokenStream};
use quote::{format_ident, quote};

use super::piece::{Piece, literal};
use qrm_scene::expression::Node;
use qrm_scene::function::Function;
use qrm_scene::scene::{Quantity, Scene, Value};

/// How names are written in a plain formula.
pub(super) struct Plain<'s> {
    pub(super) scene: &'s Scene,
    /// What a parameter's name follows: `p.` or nothing.
    pub(super) parameters: TokenStream,
    /// The type of numbers: `f64` or `R`.
    pub(super) number: TokenStream,
}

impl Plain<'_> {
    /// The formula in Rust, on doubles.
    pub(super) fn tokens(&self, value: &Value) -> TokenStream {
        let number = &self.number;
        let value = &value.without_splines();
        let mut pieces: Vec<Piece> = Vec::with_capacity(value.nodes().len());
        for node in value.nodes() {
            let piece = match node {
                Node::Number(number) => Piece::whole(self.literal(number.value)),
                Node::Name(quantity) => self.name(*quantity),
                Node::Negate(a) => pieces[*a].negate(),
                Node::Add(a, b) => pieces[*a].add(&pieces[*b]),
                Node::Subtract(a, b) => pieces[*a].subtract(&pieces[*b]),
                Node::Multiply(a, b) => pieces[*a].multiply(&pieces[*b]),
                Node::Divide(a, b) => pieces[*a].divide(&pieces[*b]),
                Node::Power(a, b) => match &value.nodes()[*b] {
                    Node::Number(n) if n.value.fract() == 0.0 && n.value <= 1024.0 => {
                        let (base, exponent) = (&pieces[*a].tokens, Literal::i32_unsuffixed(n.value as i32));
                        Piece::whole(quote!(#number::powi(#base, #exponent)))
                    }
                    _ => {
                        let (base, exponent) = (&pieces[*a].tokens, &pieces[*b].tokens);
                        let power = if self.is_generic() { quote!(pow) } else { quote!(powf) };
                        Piece::whole(quote!(#number::#power(#base, #exponent)))
                    }
                },
                Node::Call(function, arguments) => {
                    let method = format_ident!("{}", method(*function));
                    let arguments = arguments.iter().map(|&i| &pieces[i].tokens);
                    Piece::whole(quote!(#number::#method(#(#arguments),*)))
                }
                Node::Spline(..) => unreachable!("splines are written out"),
            };
            pieces.push(piece);
        }
        pieces.pop().map(|piece| piece.tokens).unwrap_or_default()
    }

    /// Statements that define the points a formula needs.
    pub(super) fn points(&self, value: &Value) -> Vec<TokenStream> {
        let define = |(point, axis): (usize, usize)| {
            let name = point_name(self.scene, point, axis);
            let value = self.tokens(&self.scene.points[point].position[axis]);
            quote!(let #name = #value;)
        };
        let needed = self.quantities(value).into_iter().filter_map(|quantity| match quantity {
            Quantity::Point(point, axis) => Some((point, axis)),
            _ => None,
        });
        needed.map(define).collect()
    }

    /// All that a formula needs, through points too; left-out parameters not counted.
    pub(super) fn quantities(&self, value: &Value) -> BTreeSet<Quantity> {
        let mut needed = BTreeSet::new();
        let mut pending = vec![value];
        while let Some(value) = pending.pop() {
            for name in value.names() {
                let is_left_out = matches!(name, Quantity::Parameter(i) if self.scene.parameters[*i].left_out);
                if let (true, Quantity::Point(point, axis)) = (!is_left_out && needed.insert(*name), name) {
                    pending.push(&self.scene.points[*point].position[*axis]);
                }
            }
        }
        needed
    }

    fn is_generic(&self) -> bool {
        self.number.to_string() == "R"
    }

    fn literal(&self, value: f64) -> TokenStream {
        let number = literal(value);
        if self.is_generic() { quote!(R::from_f64(#number)) } else { number }
    }

    fn name(&self, quantity: Quantity) -> Piece {
        let prefix = &self.parameters;
        let tokens = match quantity {
            Quantity::Parameter(i) => {
                let parameter = &self.scene.parameters[i];
                if parameter.left_out {
                    self.literal(0.0)
                } else {
                    let name = ident(&parameter.name);
                    quote!(#prefix #name)
                }
            }
            Quantity::Coordinate(i) => {
                let i = Literal::usize_unsuffixed(i);
                quote!(q[#i])
            }
            Quantity::Rate(i) => {
                let i = Literal::usize_unsuffixed(i);
                quote!(qd[#i])
            }
            Quantity::Point(point, axis) => {
                let name = point_name(self.scene, point, axis);
                quote!(#name)
            }
            // The resolver lets no rate of a point into these formulae, and no scene with unknown names gets here.
            Quantity::PointRate(..) | Quantity::Stretch | Quantity::StretchRate | Quantity::Unknown => {
                unreachable!("they occur in loads alone")
            }
            Quantity::Time => quote!(t),
            Quantity::Pi if self.is_generic() => quote!(R::pi()),
            Quantity::Pi => quote!(core::f64::consts::PI),
        };
        Piece::whole(tokens)
    }
}

fn point_name(scene: &Scene, point: usize, axis: usize) -> proc_macro2::Ident {
    format_ident!("{}_{}", scene.points[point].name, ["x", "y"][axis])
}

/// A name of the scene as a Rust identifier.
pub(super) fn ident(name: &str) -> proc_macro2::Ident {
    match syn::parse_str::<proc_macro2::Ident>(name) {
        // As patterns these would mean a constant.
        Ok(_) if ["None", "Some", "Ok", "Err", "DESCRIPTION", "SOURCE", "TAPE"].contains(&name) => {
            format_ident!("{name}_")
        }
        // A word of the language since its edition of 2024.
        Ok(_) if name == "gen" => format_ident!("r#gen"),
        Ok(_) => format_ident!("{name}"),
        Err(_) if ["self", "Self", "super", "crate"].contains(&name) => format_ident!("{name}_"),
        Err(_) => format_ident!("r#{name}"),
    }
}

/// The method of `f64` and of `Scalar` that computes a function.
pub(super) fn method(function: Function) -> &'static str {
    match function {
        Function::Log => "ln",
        other => other.name(),
    }
}
