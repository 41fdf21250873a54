//! Builtin functions.

use std::collections::BTreeSet;

use crate::ir::{Builtin, Function, Program};

/// The C function for a builtin.
pub(super) fn function(builtin: Builtin) -> &'static str {
    match builtin {
        Builtin::Sin => "sin",
        Builtin::Cos => "cos",
        Builtin::Tan => "tan",
        Builtin::Asin => "asin",
        Builtin::Acos => "acos",
        Builtin::Atan => "atan",
        Builtin::Sinh => "sinh",
        Builtin::Cosh => "cosh",
        Builtin::Tanh => "tanh",
        Builtin::Exp => "exp",
        Builtin::Ln => "log",
        Builtin::Sqrt => "sqrt",
        Builtin::Abs => "fabs",
        Builtin::Floor => "floor",
        Builtin::Power => "pow",
        Builtin::Hypot => "hypot",
        Builtin::Atan2 => "atan2",
        Builtin::Sign => "sign",
        Builtin::Min => "minimum",
        Builtin::Max => "maximum",
        Builtin::ValueOr => "number_or",
    }
}

/// The functions that a program needs and the C library lacks.
pub(super) fn helpers(program: &Program) -> String {
    let used: BTreeSet<Builtin> = program.functions.iter().flat_map(Function::builtins).collect();
    used.into_iter().filter_map(helper).map(|text| format!("\n{text}\n")).collect()
}

fn helper(builtin: Builtin) -> Option<&'static str> {
    match builtin {
        Builtin::Sign => Some(
            "// -1, 0 or 1; what is not a number stays what it is.\n\
             static double sign(double x)\n{\n    return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x;\n}",
        ),
        Builtin::Min => Some("static double minimum(double x, double y)\n{\n    return x < y || isnan(x) ? x : y;\n}"),
        Builtin::Max => Some("static double maximum(double x, double y)\n{\n    return x > y || isnan(x) ? x : y;\n}"),
        Builtin::ValueOr => {
            Some("static double number_or(double x, double otherwise)\n{\n    return isnan(x) ? otherwise : x;\n}")
        }
        _ => None,
    }
}
