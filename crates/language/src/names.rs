//! Names that avoid the reserved words of a language.

use std::collections::BTreeMap;

use crate::untranslated::Untranslated;

/// The names of the intermediate representation in a target language.
#[derive(Debug, Default)]
pub(super) struct Names {
    renamed: BTreeMap<String, String>,
}

impl Names {
    /// Creates the names. Reserved ones get underscores as suffix; no reserved word ends with one, so all names stay
    /// distinct.
    pub(super) fn new<'n>(
        names: impl IntoIterator<Item = &'n str>,
        is_reserved: impl Fn(&str) -> bool,
    ) -> Result<Self, Untranslated> {
        let mut renamed: BTreeMap<String, String> = BTreeMap::new();
        for name in names {
            if !name.is_ascii() {
                return Err(Untranslated(format!("the name `{name}`")));
            }
            if renamed.contains_key(name) {
                continue;
            }
            let mut free = name.to_owned();
            while is_reserved(&free) || renamed.values().any(|taken| *taken == free) {
                free.push('_');
            }
            renamed.insert(name.to_owned(), free);
        }
        Ok(Self { renamed })
    }

    /// The names in the language.
    pub(super) fn iter(&self) -> impl Iterator<Item = &str> {
        self.renamed.values().map(String::as_str)
    }

    pub(super) fn get<'n>(&'n self, name: &'n str) -> &'n str {
        self.renamed.get(name).map_or(name, String::as_str)
    }
}
