//! The shapes of arguments and results, from their types.

use syn::{Expr, ExprLit, GenericArgument, Lit, PathArguments, PathSegment, Type};

use super::Untranslated;
use crate::ir::{Shape, StructKind, Variable};

/// How many coordinates and constraints there are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sizes {
    pub(super) coordinates: usize,
    pub(super) constraints: usize,
}

impl Sizes {
    /// From the arguments of `Kernel<R, N, M>`.
    pub(super) fn of(segment: &PathSegment) -> Result<Self, Untranslated> {
        let PathArguments::AngleBracketed(arguments) = &segment.arguments else {
            return Err(Untranslated::new("the trait", segment));
        };
        let numbers = arguments.args.iter().filter_map(|argument| match argument {
            GenericArgument::Const(value) => whole(value).ok(),
            _ => None,
        });
        match numbers.collect::<Vec<_>>()[..] {
            [coordinates, constraints] => Ok(Self { coordinates, constraints }),
            _ => Err(Untranslated::new("the trait", segment)),
        }
    }

    /// The results of a function.
    pub(super) fn results(self, function: &str, of: &Type) -> Result<Vec<Variable>, Untranslated> {
        let Self { coordinates: n, constraints: m } = self;
        let unknown = || Untranslated::new("the result", of);
        let named = |variables: &[(&str, Shape)]| {
            variables.iter().map(|&(name, shape)| Variable { name: name.to_owned(), shape }).collect::<Vec<_>>()
        };
        match of {
            Type::Array(_) => Ok(named(&[(function, shape(of)?)])),
            Type::Tuple(tuple) => {
                let names = match function {
                    "accelerations" => ["qdd", "multipliers"],
                    "inverse_dynamics" => ["forces", "multipliers"],
                    _ => return Err(unknown()),
                };
                let shapes = tuple.elems.iter().map(shape).collect::<Result<Vec<_>, _>>()?;
                Ok(names.iter().zip(shapes).flat_map(|(name, shape)| named(&[(name, shape)])).collect())
            }
            _ => match last_segment(of)?.ident.to_string().as_str() {
                "R" | "Option" => Ok(named(&[(function, Shape::Scalar)])),
                "Position" => Ok(named(&[("position", Shape::Struct(StructKind::Position))])),
                "Dynamics" => Ok(named(&[
                    ("mass_matrix", Shape::Matrix(n, n)),
                    ("generalized_forces", Shape::Vector(n)),
                    ("constraint_jacobian", Shape::Matrix(m, n)),
                    ("constraint_bias", Shape::Vector(m)),
                ])),
                "LoopConstraints" => Ok(named(&[
                    ("residuals", Shape::Vector(m)),
                    ("constraint_jacobian", Shape::Matrix(m, n)),
                    ("constraint_rate", Shape::Vector(m)),
                ])),
                "Linearization" => Ok(named(&[
                    ("stiffness", Shape::Matrix(n, n)),
                    ("damping", Shape::Matrix(n, n)),
                    ("constraint_stiffness", Shape::Matrix(m, n)),
                    ("constraint_damping", Shape::Matrix(m, n)),
                    ("forcing", Shape::Vector(n)),
                    ("constraint_forcing", Shape::Vector(m)),
                ])),
                "Start" => Ok(named(&[
                    ("q", Shape::Vector(n)),
                    ("given", Shape::Booleans(n)),
                    ("qd", Shape::Vector(n)),
                    ("given_rates", Shape::Booleans(n)),
                ])),
                "Schedule" => Ok(named(&[("step", Shape::Scalar), ("end_time", Shape::Scalar)])),
                _ => Err(unknown()),
            },
        }
    }
}

/// The shape of an argument, or of a result that is a list.
pub(super) fn shape(of: &Type) -> Result<Shape, Untranslated> {
    let unknown = || Untranslated::new("the type", of);
    match of {
        Type::Reference(inner) => shape(&inner.elem),
        Type::Array(array) => {
            let count = whole(&array.len)?;
            match shape(&array.elem)? {
                Shape::Scalar => Ok(Shape::Vector(count)),
                Shape::Vector(columns) => Ok(Shape::Matrix(count, columns)),
                _ => Err(unknown()),
            }
        }
        _ => match last_segment(of)?.ident.to_string().as_str() {
            "R" => Ok(Shape::Scalar),
            name => struct_kind(name).map(Shape::Struct).ok_or_else(unknown),
        },
    }
}

/// The kind of the struct of this name.
pub(super) fn struct_kind(name: &str) -> Option<StructKind> {
    match name {
        "Parameters" => Some(StructKind::Parameters),
        "Constants" => Some(StructKind::Constants),
        "Position" => Some(StructKind::Position),
        "Angles" => Some(StructKind::Angles),
        _ => None,
    }
}

/// The name at the end of a type.
pub(super) fn last_segment(of: &Type) -> Result<&PathSegment, Untranslated> {
    match of {
        Type::Reference(inner) => last_segment(&inner.elem),
        Type::Path(path) => path.path.segments.last().ok_or_else(|| Untranslated::new("the type", of)),
        _ => Err(Untranslated::new("the type", of)),
    }
}

/// A whole number.
pub(super) fn whole(value: &Expr) -> Result<usize, Untranslated> {
    match value {
        Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => {
            number.base10_parse().map_err(|_| Untranslated::new("the number", value))
        }
        _ => Err(Untranslated::new("the number", value)),
    }
}
