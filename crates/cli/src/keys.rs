//! The keys of scenes, as the reference in `docs/scene-format.md` describes them.

use std::sync::LazyLock;

/// The reference of the scene file.
const REFERENCE: &str = include_str!("../../../docs/scene-format.md");

/// The sections of a scene. The first one holds the keys outside of sections.
pub(crate) static SECTIONS: LazyLock<Vec<Section>> = LazyLock::new(|| sections(REFERENCE));

/// A section of a scene.
#[derive(Debug)]
pub(crate) struct Section {
    /// Its name, as `links`; empty for the keys outside of sections.
    pub(crate) name: &'static str,
    /// Its description.
    pub(crate) doc: String,
    pub(crate) keys: Vec<Key>,
}

/// A key of a section, or of an entry in it.
#[derive(Debug)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    /// The owner of the key, where the section has several of this name: `of a bar`.
    pub(crate) of: &'static str,
    /// The type of the value: `constant, positive`.
    pub(crate) kind: String,
    pub(crate) unit: String,
    pub(crate) default: String,
    pub(crate) meaning: String,
    pub(crate) example: String,
}

/// The section of a name.
pub(crate) fn section(name: &str) -> Option<&'static Section> {
    SECTIONS.iter().find(|section| section.name == name)
}

fn sections(reference: &'static str) -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    for text in reference.split("\n## ").skip(1) {
        let (title, text) = text.split_once('\n').unwrap_or((text, ""));
        let name = if title == "The scene" { "" } else { title.trim_matches(['`', '[', ']']) };
        let mut parts = text.split("\n### ");
        let doc = parts.next().unwrap_or_default();
        let keys: Vec<Key> = parts.map(key).collect();
        if !keys.is_empty() || title.starts_with('`') {
            sections.push(Section { name, doc: doc.trim().to_owned(), keys });
        }
    }
    sections
}

fn key(text: &'static str) -> Key {
    let (title, text) = text.split_once('\n').unwrap_or((text, ""));
    let (name, of) = title.trim_start_matches('`').split_once('`').unwrap_or((title, ""));
    let entry = |topic: &str| {
        let begin = text.find(&format!("- **{topic}**:")).map(|begin| begin + topic.len() + "- ****:".len());
        let rest = begin.map_or("", |begin| &text[begin..]);
        let end = ["\n- **", "\n#"].iter().filter_map(|next| rest.find(next)).min().unwrap_or(rest.len());
        let lines: Vec<&str> = rest[..end].lines().map(str::trim).collect();
        // Examples keep their lines.
        lines.join(if topic == "Example" { "\n" } else { " " }).trim().to_owned()
    };
    let [kind, unit, default, meaning, example] = ["Type", "Unit", "Default", "Meaning", "Example"].map(entry);
    Key { name, of: of.trim(), kind, unit, default, meaning, example }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_describes_every_key() {
        let names: Vec<&str> = SECTIONS.iter().map(|section| section.name).collect();
        let expected = [
            "",
            "coordinates",
            "parameters",
            "tables",
            "links",
            "joints",
            "points",
            "bodies",
            "constraints",
            "loads",
            "initial",
            "outputs",
            "drawing",
            "reference",
            "extreme",
            "run",
        ];
        assert_eq!(names, expected);
        for section in SECTIONS.iter() {
            for key in &section.keys {
                let is_whole =
                    [&key.kind, &key.unit, &key.default, &key.meaning, &key.example].iter().all(|t| !t.is_empty());
                assert!(is_whole, "{key:?} in `{}`", section.name);
            }
        }
        let bar = section("links").and_then(|links| links.keys.iter().find(|key| key.name == "bar")).expect("a key");
        assert_eq!((bar.of, bar.kind.as_str()), ("", "list of two names, with `length`"));
    }
}
