//! The functions of numbers, and the words that MATLAB and Octave keep for themselves.

use std::collections::BTreeSet;

use crate::program::{Expression, Function, Routine};

/// The function of a routine.
pub(super) fn function(routine: Routine) -> &'static str {
    match routine {
        Routine::Sin => "sin",
        Routine::Cos => "cos",
        Routine::Tan => "tan",
        Routine::Asin => "real_asin",
        Routine::Acos => "real_acos",
        Routine::Atan => "atan",
        Routine::Sinh => "sinh",
        Routine::Cosh => "cosh",
        Routine::Tanh => "tanh",
        Routine::Exp => "exp",
        Routine::Ln => "real_log",
        Routine::Sqrt => "real_sqrt",
        Routine::Abs => "abs",
        Routine::Floor => "floor",
        Routine::Power => "real_power",
        Routine::Hypot => "hypot",
        Routine::Atan2 => "atan2",
        Routine::Sign => "sign",
        Routine::Min => "smaller",
        Routine::Max => "larger",
        Routine::Given => "value_of",
    }
}

/// The local functions that a function needs.
pub(super) fn helpers(function: &Function) -> String {
    let mut used = BTreeSet::new();
    for statement in &function.body {
        statement.visit(&mut |value| {
            if let Expression::Call(routine, _) = value {
                used.insert(*routine);
            }
        });
    }
    used.into_iter().filter_map(helper).map(|text| format!("\n{text}\n")).collect()
}

/// The definition of a routine that MATLAB does not have in this form: its roots, powers and inverse functions are
/// complex numbers where they are not real, and its extremes leave out what is not a number.
fn helper(routine: Routine) -> Option<String> {
    let real = |call: &str, library: &str, condition: &str| {
        format!(
            "function y = {call}\n    % NaN where it is not real.\n    y = NaN;\n    if {condition}\n        y = {library};\n    \
             end\nend"
        )
    };
    Some(match routine {
        Routine::Sqrt => real("real_sqrt(x)", "sqrt(x)", "x >= 0"),
        Routine::Ln => real("real_log(x)", "log(x)", "x >= 0"),
        Routine::Asin => real("real_asin(x)", "asin(x)", "abs(x) <= 1"),
        Routine::Acos => real("real_acos(x)", "acos(x)", "abs(x) <= 1"),
        Routine::Power => real("real_power(x, exponent)", "x^exponent", "x >= 0 || exponent == floor(exponent)"),
        Routine::Min => "function z = smaller(x, y)\n    z = y;\n    if x < y\n        z = x;\n    end\nend".to_owned(),
        Routine::Max => "function z = larger(x, y)\n    z = y;\n    if x > y\n        z = x;\n    end\nend".to_owned(),
        Routine::Given => {
            "function value = value_of(replace, name, value)\n    if isfield(replace, name)\n        value = \
                           replace.(name);\n    end\nend"
                .to_owned()
        }
        _ => return None,
    })
}

/// Whether no value can be called so: a word, or what generated functions call.
pub(super) fn is_reserved(name: &str) -> bool {
    WORDS.contains(&name) || FUNCTIONS.contains(&name)
}

const WORDS: [&str; 41] = [
    "arguments",
    "break",
    "case",
    "catch",
    "classdef",
    "continue",
    "do",
    "else",
    "elseif",
    "end",
    "end_try_catch",
    "end_unwind_protect",
    "endfor",
    "endfunction",
    "endif",
    "endparfor",
    "endswitch",
    "endwhile",
    "enumeration",
    "events",
    "for",
    "function",
    "global",
    "if",
    "methods",
    "otherwise",
    "parfor",
    "persistent",
    "properties",
    "return",
    "spmd",
    "switch",
    "try",
    "until",
    "unwind_protect",
    "unwind_protect_cleanup",
    "while",
    "endclassdef",
    "endmethods",
    "endproperties",
    "import",
];

const FUNCTIONS: [&str; 38] = [
    "Inf",
    "NaN",
    "abs",
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "cosh",
    "error",
    "exp",
    "false",
    "fieldnames",
    "floor",
    "value_of",
    "hypot",
    "isempty",
    "isfield",
    "larger",
    "log",
    "nargin",
    "pi",
    "real_acos",
    "real_asin",
    "real_log",
    "real_power",
    "real_sqrt",
    "setdiff",
    "sign",
    "sin",
    "sinh",
    "smaller",
    "sqrt",
    "struct",
    "tan",
    "tanh",
    "true",
    "zeros",
];
