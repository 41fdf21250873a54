//! The functions of numbers, and the words that C and its library keep for themselves.

use std::collections::BTreeSet;

use crate::program::{Expression, Program, Routine};

/// The function of a routine.
pub(super) fn function(routine: Routine) -> &'static str {
    match routine {
        Routine::Sin => "sin",
        Routine::Cos => "cos",
        Routine::Tan => "tan",
        Routine::Asin => "asin",
        Routine::Acos => "acos",
        Routine::Atan => "atan",
        Routine::Sinh => "sinh",
        Routine::Cosh => "cosh",
        Routine::Tanh => "tanh",
        Routine::Exp => "exp",
        Routine::Ln => "log",
        Routine::Sqrt => "sqrt",
        Routine::Abs => "fabs",
        Routine::Floor => "floor",
        Routine::Power => "pow",
        Routine::Hypot => "hypot",
        Routine::Atan2 => "atan2",
        Routine::Sign => "sign",
        Routine::Min => "min",
        Routine::Max => "max",
        Routine::Given => "number_or",
    }
}

/// The functions that a program needs and the library does not have.
pub(super) fn helpers(program: &Program) -> String {
    let mut used = BTreeSet::new();
    for statement in program.functions.iter().flat_map(|function| &function.body) {
        statement.visit(&mut |value| {
            if let Expression::Call(routine, _) = value {
                used.insert(*routine);
            }
        });
    }
    used.into_iter().filter_map(helper).map(|text| format!("\n{text}\n")).collect()
}

fn helper(routine: Routine) -> Option<&'static str> {
    match routine {
        Routine::Sign => Some(
            "// -1, 0 or 1; what is not a number stays what it is.\n\
             static double sign(double x)\n{\n    return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x;\n}",
        ),
        Routine::Min => Some("static double min(double x, double y)\n{\n    return x < y ? x : y;\n}"),
        Routine::Max => Some("static double max(double x, double y)\n{\n    return x > y ? x : y;\n}"),
        Routine::Given => {
            Some("static double number_or(double x, double otherwise)\n{\n    return isnan(x) ? otherwise : x;\n}")
        }
        _ => None,
    }
}

/// Whether no value can be called so: a word, or what generated functions call.
pub(super) fn is_reserved(name: &str) -> bool {
    is_word(name) || FUNCTIONS.contains(&name)
}

/// Whether a name is a word of C99 or C++, or a macro of `math.h`.
pub(super) fn is_word(name: &str) -> bool {
    WORDS.contains(&name) || name.starts_with("FP_") || name.starts_with("MATH_")
}

const WORDS: [&str; 104] = [
    "auto",
    "break",
    "case",
    "char",
    "const",
    "continue",
    "default",
    "do",
    "double",
    "else",
    "enum",
    "extern",
    "float",
    "for",
    "goto",
    "if",
    "inline",
    "int",
    "long",
    "register",
    "restrict",
    "return",
    "short",
    "signed",
    "sizeof",
    "static",
    "struct",
    "switch",
    "typedef",
    "union",
    "unsigned",
    "void",
    "volatile",
    "while",
    "asm",
    "bool",
    "catch",
    "class",
    "const_cast",
    "delete",
    "dynamic_cast",
    "explicit",
    "export",
    "false",
    "friend",
    "mutable",
    "namespace",
    "new",
    "operator",
    "private",
    "protected",
    "public",
    "reinterpret_cast",
    "static_cast",
    "template",
    "this",
    "throw",
    "true",
    "try",
    "typeid",
    "typename",
    "using",
    "virtual",
    "wchar_t",
    "and",
    "and_eq",
    "bitand",
    "bitor",
    "compl",
    "not",
    "not_eq",
    "or",
    "or_eq",
    "xor",
    "xor_eq",
    "HUGE_VAL",
    "HUGE_VALF",
    "HUGE_VALL",
    "INFINITY",
    "INLINE",
    "NAN",
    "linux",
    "unix",
    "math_errhandling",
    "isfinite",
    "isinf",
    "isnan",
    "isnormal",
    "signbit",
    "fpclassify",
    "isgreater",
    "isgreaterequal",
    "isless",
    "islessequal",
    "islessgreater",
    "isunordered",
    "DOMAIN",
    "SING",
    "OVERFLOW",
    "UNDERFLOW",
    "PLOSS",
    "TLOSS",
    "HUGE",
    "NULL",
];

const FUNCTIONS: [&str; 21] = [
    "sin",
    "cos",
    "tan",
    "asin",
    "acos",
    "atan",
    "sinh",
    "cosh",
    "tanh",
    "exp",
    "log",
    "sqrt",
    "fabs",
    "floor",
    "pow",
    "hypot",
    "atan2",
    "sign",
    "min",
    "max",
    "number_or",
];
