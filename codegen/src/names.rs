//! Names of scenes that the generated code has no room for.

use qrm_language::identifier::is_identifier;
use qrm_scene::names::{module_name, struct_name};

/// SourceExcerpts that a module cannot have as its name: the list of modules, crates and types that the crate around it
/// names.
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
/// The names that every generated module uses itself: its items, and what it takes from the prelude.
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

/// Why a scene cannot have this name, if so.
pub fn refusal(scene: &str) -> Option<String> {
    let (module, mechanism) = (module_name(scene), struct_name(scene));
    if RESERVED_MODULES.contains(&module.as_str()) || !is_identifier(&module) {
        return Some(format!("a module cannot be called `{module}`: give the scene another `name`"));
    }
    let is_taken = RESERVED_STRUCTS.contains(&mechanism.as_str());
    is_taken.then(|| format!("the generated code has another type `{mechanism}`: give the scene another `name`"))
}
