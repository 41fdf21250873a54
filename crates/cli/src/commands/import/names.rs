//! Names of a scene: valid, and each only once.

use std::collections::BTreeSet;

use qrm_scene::function::Function;

/// The names that are taken.
pub(super) struct Names(BTreeSet<String>);

impl Names {
    pub(super) fn new() -> Self {
        // Names of time, of a number, of the link that does not move, and of the variables of laws and profiles.
        Self(["t", "pi", "ground", "s", "s_dot", "theta", "energy"].map(str::to_owned).into())
    }

    /// A new name that is like that of the model.
    pub(super) fn unique(&mut self, wanted: &str, otherwise: &str) -> String {
        let name = valid(wanted, otherwise);
        let is_free = |names: &BTreeSet<String>, name: &str| {
            // Coordinates, rates and points of links have names of their own.
            !names.contains(name)
                && Function::named(name).is_none()
                && !name.ends_with("_dot")
                && !name.ends_with("_ddot")
        };
        let free = if is_free(&self.0, &name) {
            name
        } else {
            (2_usize..).map(|i| format!("{name}_{i}")).find(|name| is_free(&self.0, name)).unwrap_or(name)
        };
        self.0.insert(free.clone());
        free
    }
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

/// The name of a scene, from that of a file.
pub(super) fn of_scene(stem: &str) -> String {
    let mut name = String::new();
    for c in stem.chars().take(60) {
        if c.is_ascii_alphanumeric() {
            name.push(c.to_ascii_lowercase());
        } else if !name.is_empty() && !name.ends_with('-') {
            name.push('-');
        }
    }
    let name = name.trim_end_matches('-');
    if name.starts_with(|c: char| c.is_ascii_lowercase()) {
        name.to_owned()
    } else {
        format!("model-{name}").trim_end_matches('-').to_owned()
    }
}

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
        assert_eq!(unique("phi_dot"), "phi_dot_2");
        assert_eq!(unique("クランク"), "link");
        assert_eq!(unique(""), "link_2");
        assert_eq!(unique("/Assembly/crank"), "crank");
    }

    #[test]
    fn scenes_have_valid_names() {
        assert_eq!(of_scene("Four Bar_2"), "four-bar-2");
        assert_eq!(of_scene("00backhoe"), "model-00backhoe");
        assert_eq!(of_scene("ü"), "model");
    }
}
