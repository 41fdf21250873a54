//! Builtin functions, and the reserved words of C and its library.

use std::collections::BTreeSet;

use crate::ir::{Builtin, Function, Program};

/// The function that is called for a builtin.
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
        Builtin::Min => "min",
        Builtin::Max => "max",
        Builtin::ValueOr => "number_or",
    }
}

/// The functions that a program needs and the library does not have.
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
        Builtin::Min => Some("static double min(double x, double y)\n{\n    return x < y ? x : y;\n}"),
        Builtin::Max => Some("static double max(double x, double y)\n{\n    return x > y ? x : y;\n}"),
        Builtin::ValueOr => {
            Some("static double number_or(double x, double otherwise)\n{\n    return isnan(x) ? otherwise : x;\n}")
        }
        _ => None,
    }
}

/// Whether no value can be called so: a keyword, or what generated functions call.
pub(super) fn is_reserved(name: &str) -> bool {
    is_keyword(name) || FUNCTIONS.contains(&name)
}

/// Whether a name is a keyword of C99 or C++, or a macro of the C library.
pub(super) fn is_keyword(name: &str) -> bool {
    let is_constant = |name: &str| CONSTANTS.contains(&name);
    // No macro ends with an underscore.
    let is_macro = |prefix: &str| name.starts_with(prefix) && !name.ends_with('_');
    KEYWORDS.contains(&name)
        || MACROS.into_iter().any(is_macro)
        || is_constant(name)
        || name.strip_suffix('l').is_some_and(is_constant)
}

/// Whether a header of the C library has this name.
pub(super) fn is_header(name: &str) -> bool {
    HEADERS.contains(&name)
}

const KEYWORDS: [&str; 148] = [
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
    "typeof",
    "typeof_unqual",
    "typename",
    "using",
    "virtual",
    "wchar_t",
    "alignas",
    "alignof",
    "char8_t",
    "char16_t",
    "char32_t",
    "concept",
    "consteval",
    "constexpr",
    "constinit",
    "co_await",
    "co_return",
    "co_yield",
    "decltype",
    "noexcept",
    "nullptr",
    "requires",
    "static_assert",
    "thread_local",
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
    "MAXFLOAT",
    "X_TLOSS",
    "NULL",
    "DECIMAL_DIG",
    "I",
    "complex",
    "imaginary",
    "errno",
    "stdin",
    "stdout",
    "stderr",
    "EOF",
    "BUFSIZ",
    "FILENAME_MAX",
    "FOPEN_MAX",
    "L_tmpnam",
    "TMP_MAX",
    "RAND_MAX",
    "MB_CUR_MAX",
    "CLOCKS_PER_SEC",
    "EDOM",
    "ERANGE",
    "EILSEQ",
    "CHAR_BIT",
    "WEOF",
];

/// Beginnings of the names of macros of the C library.
const MACROS: [&str; 13] =
    ["FP_", "MATH_", "DBL_", "FLT_", "LDBL_", "INT_", "UINT_", "LONG_", "ULONG_", "EXIT_", "SEEK_", "LC_", "SIG_"];

const HEADERS: [&str; 29] = [
    "assert",
    "complex",
    "ctype",
    "errno",
    "fenv",
    "float",
    "inttypes",
    "iso646",
    "limits",
    "locale",
    "math",
    "setjmp",
    "signal",
    "stdalign",
    "stdarg",
    "stdatomic",
    "stdbool",
    "stddef",
    "stdint",
    "stdio",
    "stdlib",
    "stdnoreturn",
    "string",
    "tgmath",
    "threads",
    "time",
    "uchar",
    "wchar",
    "wctype",
];

/// Constants that `math.h` has beside those of C99; the GNU compilers have them in `long double` too, as `M_PIl`.
const CONSTANTS: [&str; 13] = [
    "M_E",
    "M_LOG2E",
    "M_LOG10E",
    "M_LN2",
    "M_LN10",
    "M_PI",
    "M_PI_2",
    "M_PI_4",
    "M_1_PI",
    "M_2_PI",
    "M_2_SQRTPI",
    "M_SQRT2",
    "M_SQRT1_2",
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

#[cfg(test)]
mod tests {
    use super::is_keyword;

    #[test]
    fn macros_of_compilers_are_no_names() {
        assert!(["M_PI", "M_PIl", "FP_NAN", "DBL_MIN", "nullptr", "NULL", "I", "errno"].into_iter().all(is_keyword));
        assert!(!["M_1", "M_rod", "l", "PI", "FP_NAN_"].into_iter().any(is_keyword));
    }
}
