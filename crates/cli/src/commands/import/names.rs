//! Names of a scene: valid, and each only once.

use std::collections::BTreeSet;

use qrm_language::identifier::is_identifier;
use qrm_scene::function::Function;
use qrm_scene::names::module_name;

/// The names that are taken. Links may have the names of joints and loads.
pub(super) struct Names {
    links: BTreeSet<String>,
    others: BTreeSet<String>,
}

impl Names {
    pub(super) fn new() -> Self {
        // Names of time, of a number, of the link that does not move, and of the variables of laws and profiles.
        let taken =
            BTreeSet::from(["t", "pi", "ground", "s", "s_dot", "theta", "energy", "gravity"].map(str::to_owned));
        Self { links: taken.clone(), others: taken }
    }

    /// Makes a new name of a link from that of the model.
    pub(super) fn link(&mut self, wanted: &str, otherwise: &str) -> String {
        unique(&mut self.links, wanted, otherwise)
    }

    /// Makes a new name of a point, a joint, a load or an output from that of the model.
    pub(super) fn unique(&mut self, wanted: &str, otherwise: &str) -> String {
        unique(&mut self.others, wanted, otherwise)
    }
}

fn unique(taken: &mut BTreeSet<String>, wanted: &str, otherwise: &str) -> String {
    let mut name = valid(wanted, otherwise);
    // Coordinates and their rates have names of their own.
    if name.starts_with("phi_") || name.starts_with("s_") {
        name.insert_str(0, &format!("{otherwise}_"));
    }
    if name.ends_with("_dot") || name.ends_with("_ddot") {
        name.push('_');
        name.push_str(otherwise);
    }
    let is_free = |name: &str| !taken.contains(name) && Function::named(name).is_none();
    let numbered = (2_usize..).map(|i| format!("{name}_{i}"));
    let free = std::iter::once(name.clone()).chain(numbered).find(|name| is_free(name)).unwrap_or(name);
    taken.insert(free.clone());
    free
}

/// Replaces the characters that a name of a scene cannot contain.
fn valid(wanted: &str, otherwise: &str) -> String {
    // The name of an object may be a path.
    let last = wanted.rsplit(['/', '#']).find(|part| !part.is_empty()).unwrap_or_default();
    let mut name = String::new();
    for c in last.chars().take(40) {
        if c.is_ascii_alphanumeric() {
            name.push(c);
        } else if !name.ends_with('_') {
            name.push('_');
        }
    }
    let name = name.trim_matches('_');
    match name.chars().next() {
        None => otherwise.to_owned(),
        Some(first) if first.is_ascii_alphabetic() => name.to_owned(),
        Some(_) => format!("{otherwise}_{name}"),
    }
}

/// Makes the name of a scene from that of a file.
pub(super) fn scene_name(stem: &str) -> String {
    let mut name = String::new();
    for c in stem.chars().take(60) {
        if c.is_ascii_alphanumeric() {
            name.push(c.to_ascii_lowercase());
        } else if !name.is_empty() && !name.ends_with('-') {
            name.push('-');
        }
    }
    let name = name.trim_end_matches('-');
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        format!("model-{name}").trim_end_matches('-').to_owned()
    } else if WORDS_OF_CODE.contains(&name) || !is_identifier(&module_name(name)) {
        format!("{name}-model")
    } else {
        name.to_owned()
    }
}

/// Words that generated code has for itself.
const WORDS_OF_CODE: [&str; 22] = [
    "alloc",
    "angles",
    "bool",
    "char",
    "constants",
    "core",
    "default",
    "description",
    "dynamics",
    "equations",
    "gen",
    "kernel",
    "option",
    "parameters",
    "position",
    "qrm",
    "scalar",
    "schedule",
    "start",
    "std",
    "str",
    "test",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_unique() {
        let mut names = Names::new();
        let mut unique = |wanted| names.unique(wanted, "link");
        assert_eq!(unique("Part 1"), "Part_1");
        assert_eq!(unique("Part#1"), "link_1");
        assert_eq!(unique("Part_1"), "Part_1_2");
        assert_eq!(unique("sin"), "sin_2");
        assert_eq!(unique("t"), "t_2");
        assert_eq!(unique("a_dot"), "a_dot_link");
        assert_eq!(unique("phi_a"), "link_phi_a");
        assert_eq!(unique("クランク"), "link");
        assert_eq!(unique(""), "link_2");
        assert_eq!(unique("/Assembly/crank"), "crank");
    }

    #[test]
    fn scenes_have_valid_names() {
        assert_eq!(scene_name("Four Bar_2"), "four-bar-2");
        assert_eq!(scene_name("00backhoe"), "model-00backhoe");
        assert_eq!(scene_name("ü"), "model");
        assert_eq!([scene_name("loop"), scene_name("test")], ["loop-model", "test-model"]);
    }
}
