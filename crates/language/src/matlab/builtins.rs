//! Builtin functions, and the reserved words of MATLAB and Octave.

use crate::ir::{Builtin, Function};

/// The MATLAB function for a builtin.
pub(super) fn function(builtin: Builtin) -> &'static str {
    match builtin {
        Builtin::Sin => "sin",
        Builtin::Cos => "cos",
        Builtin::Tan => "tan",
        Builtin::Asin => "real_asin",
        Builtin::Acos => "real_acos",
        Builtin::Atan => "atan",
        Builtin::Sinh => "sinh",
        Builtin::Cosh => "cosh",
        Builtin::Tanh => "tanh",
        Builtin::Exp => "exp",
        Builtin::Ln => "real_log",
        Builtin::Sqrt => "real_sqrt",
        Builtin::Abs => "abs",
        Builtin::Floor => "floor",
        Builtin::Power => "real_power",
        Builtin::Hypot => "hypot",
        Builtin::Atan2 => "atan2",
        Builtin::Sign => "sign",
        Builtin::Min => "smaller",
        Builtin::Max => "larger",
        Builtin::ValueOr => "value_of",
    }
}

/// The local functions that a function needs.
pub(super) fn helpers(function: &Function) -> String {
    function.builtins().into_iter().filter_map(helper).map(|text| format!("\n{text}\n")).collect()
}

/// The definition of a builtin that MATLAB lacks in this form: its roots, powers and inverse functions return complex
/// numbers outside the real domain, and its extremes ignore NaN.
fn helper(builtin: Builtin) -> Option<String> {
    let real = |call: &str, library: &str, condition: &str| {
        format!(
            "function y = {call}\n    % NaN where it is not real.\n    y = NaN;\n    if {condition}\n        y = \
             {library};\n    end\nend"
        )
    };
    Some(match builtin {
        Builtin::Sqrt => real("real_sqrt(x)", "sqrt(x)", "x >= 0"),
        Builtin::Ln => real("real_log(x)", "log(x)", "x >= 0"),
        Builtin::Asin => real("real_asin(x)", "asin(x)", "abs(x) <= 1"),
        Builtin::Acos => real("real_acos(x)", "acos(x)", "abs(x) <= 1"),
        Builtin::Power => real("real_power(x, exponent)", "x^exponent", "x >= 0 || exponent == floor(exponent)"),
        Builtin::Min => {
            "function z = smaller(x, y)\n    z = y;\n    if x < y || isnan(x)\n        z = x;\n    end\nend".to_owned()
        }
        Builtin::Max => {
            "function z = larger(x, y)\n    z = y;\n    if x > y || isnan(x)\n        z = x;\n    end\nend".to_owned()
        }
        Builtin::ValueOr => {
            "function value = value_of(replace, name, value)\n    if isfield(replace, name)\n        value = \
                           replace.(name);\n    end\nend"
                .to_owned()
        }
        _ => return None,
    })
}

/// Whether a value cannot have this name: a keyword, or the name of a function that generated code calls.
pub(super) fn is_reserved(name: &str) -> bool {
    KEYWORDS.contains(&name) || FUNCTIONS.contains(&name)
}

const KEYWORDS: [&str; 41] = [
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

const FUNCTIONS: [&str; 39] = [
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
    "isstruct",
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
