//! Names of scenes that conflict with generated code.

use qrm_language::identifier::is_identifier;
use qrm_scene::names::{module_name, struct_name};

/// Names that a module cannot have: the list of modules, and the crates and types that the surrounding crate uses.
const RESERVED_MODULES: [&str; 29] = [
    "scenes",
    "gen",
    "self",
    "super",
    "crate",
    "twin",
    "alloc",
    "core",
    "proc_macro",
    "qrm",
    "qrm_core",
    "std",
    "test",
    "bool",
    "char",
    "f32",
    "f64",
    "i8",
    "i16",
    "i32",
    "i64",
    "i128",
    "isize",
    "str",
    "u8",
    "u16",
    "u32",
    "u64",
    "usize",
];
/// The names that every generated module uses: its own items, and those of the prelude.
pub const RESERVED_STRUCTS: [&str; 21] = [
    "Angles",
    "Constants",
    "Default",
    "Description",
    "Dynamics",
    "Equations",
    "Generated",
    "Kernel",
    "Linearization",
    "LoopConstraints",
    "Option",
    "ParameterDescription",
    "Parameters",
    "Position",
    "QuantityDescription",
    "R",
    "Scalar",
    "Schedule",
    "Self",
    "Start",
    "StoredTape",
];

/// The reason why a scene cannot have this name; `None` if it can.
pub fn refusal(scene: &str) -> Option<String> {
    let (module, mechanism) = (module_name(scene), struct_name(scene));
    if RESERVED_MODULES.contains(&module.as_str()) || !is_identifier(&module) {
        return Some(format!("a module cannot be called `{module}`: give the scene another `name`"));
    }
    let is_taken = RESERVED_STRUCTS.contains(&mechanism.as_str());
    is_taken.then(|| format!("the generated code has another type `{mechanism}`: give the scene another `name`"))
}
