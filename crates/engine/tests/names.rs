//! Scenes cannot have names that generated code already uses.

use std::collections::BTreeSet;
use std::fs;

use proc_macro2::{TokenStream, TokenTree};
use qrm_codegen::names::{RESERVED_STRUCTS, refusal};
use qrm_scene::names::struct_name;

#[test]
fn names_that_would_not_compile_are_refused() {
    for name in ["option", "Option", "default", "r", "R", "start", "parameters", "loop-constraints", "scalar"] {
        let said = refusal(name).unwrap_or_else(|| panic!("{name} is accepted"));
        assert!(said.starts_with("the generated code has another type `"), "{name}: {said}");
    }
    for name in ["qrm_core", "qrm-core", "core", "f64", "self", "gen", "fn", "scenes", "async"] {
        let said = refusal(name).unwrap_or_else(|| panic!("{name} is accepted"));
        assert!(said.starts_with("a module cannot be called `"), "{name}: {said}");
    }
    for name in ["quick-return", "qrm_mechanism", "some", "vec", "clone", "options", "f64-x", "n-four-bar-40"] {
        assert_eq!(refusal(name), None, "{name}");
    }
}

/// Derives and variants have separate namespaces; the others follow the path of their crate, or are keywords as
/// modules.
const OTHER_NAMESPACES: [&str; 9] =
    ["Clone", "Copy", "Debug", "PartialEq", "Some", "None", "Tape", "LaneStepsTable", "Fn"];

#[test]
fn every_type_that_generated_code_names_is_reserved() {
    let mut missing = BTreeSet::new();
    // Their parameters and coordinates do not look like types.
    for module in ["double_pendulum", "pendulum", "shaper"] {
        let path = format!("{}/../../qrm-model/golden/{module}.rs", env!("CARGO_MANIFEST_DIR"));
        let text = fs::read_to_string(path).expect("a module");
        let own = struct_name(module);
        let mut types = BTreeSet::new();
        // The tape is in a block with its own imports.
        let text = text.split("static TAPE").next().expect("the module before its tape");
        types_in(text.parse().expect("Rust"), &mut types);
        let is_known = |name: &String| *name == own || RESERVED_STRUCTS.contains(&name.as_str());
        missing.extend(types.into_iter().filter(|name| !is_known(name) && !OTHER_NAMESPACES.contains(&name.as_str())));
    }
    assert!(missing.is_empty(), "not reserved: {missing:?}");
}

/// Collects identifiers in camel case, except fields.
fn types_in(tokens: TokenStream, found: &mut BTreeSet<String>) {
    let mut is_field = false;
    for token in tokens {
        let is_dot = matches!(&token, TokenTree::Punct(mark) if mark.as_char() == '.');
        match token {
            TokenTree::Group(group) => types_in(group.stream(), found),
            TokenTree::Ident(word) if !is_field => {
                let word = word.to_string();
                let is_camel = word.starts_with(|c: char| c.is_ascii_uppercase())
                    && word.chars().all(|c| c.is_ascii_alphanumeric())
                    && word.chars().any(|c| c.is_ascii_lowercase());
                if is_camel {
                    found.insert(word);
                }
            }
            _ => {}
        }
        is_field = is_dot;
    }
}
