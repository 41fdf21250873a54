//! The reserved words of C and its library.

/// Whether a value cannot have this name: a keyword, or the name of a function that generated code calls.
pub(super) fn is_reserved(name: &str) -> bool {
    is_keyword(name) || FUNCTIONS.contains(&name)
}

/// Whether a name is a keyword of C99 or C++, a macro of the C library, or a type of CUDA.
pub(super) fn is_keyword(name: &str) -> bool {
    let is_constant = |name: &str| CONSTANTS.contains(&name);
    // No such macro ends with an underscore.
    let is_macro = |prefix: &str| name.starts_with(prefix) && !name.ends_with('_');
    KEYWORDS.contains(&name)
        || MACROS.into_iter().any(is_macro)
        || is_constant(name)
        || is_vector(name)
        || name.strip_suffix('l').is_some_and(is_constant)
}

/// Whether CUDA has a vector type of this name, such as `float2`.
fn is_vector(name: &str) -> bool {
    let is_of = |of: &str| name.strip_prefix(of).is_some_and(|length| ["1", "2", "3", "4"].contains(&length));
    name == "dim3" || VECTORS.into_iter().any(is_of)
}

const VECTORS: [&str; 12] =
    ["char", "double", "float", "int", "long", "longlong", "short", "uchar", "uint", "ulong", "ulonglong", "ushort"];

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

/// Prefixes of macro names in the C library.
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

/// Constants of `math.h` in addition to those of C99; the GNU compilers also have them as `long double`, such as
/// `M_PIl`.
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

const FUNCTIONS: [&str; 23] = [
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
    "max",
    "maximum",
    "min",
    "minimum",
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
