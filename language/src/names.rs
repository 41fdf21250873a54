//! Names that a language keeps for itself.

use std::collections::BTreeMap;

use super::Untranslated;

/// What names of the plain form are called in a language.
#[derive(Debug, Default)]
pub(super) struct Names {
    given: BTreeMap<String, String>,
}

impl Names {
    /// Gives each name one that the language does not keep for itself, and none the same: underscores are added.
    pub(super) fn new<'n>(
        names: impl IntoIterator<Item = &'n str>,
        is_reserved: impl Fn(&str) -> bool,
    ) -> Result<Self, Untranslated> {
        let mut given: BTreeMap<String, String> = BTreeMap::new();
        for name in names {
            if !name.is_ascii() {
                return Err(Untranslated(format!("the name `{name}`")));
            }
            if given.contains_key(name) {
                continue;
            }
            let mut free = name.to_owned();
            while is_reserved(&free) || given.values().any(|taken| *taken == free) {
                free.push('_');
            }
            given.insert(name.to_owned(), free);
        }
        Ok(Self { given })
    }

    pub(super) fn get<'n>(&'n self, name: &'n str) -> &'n str {
        self.given.get(name).map_or(name, String::as_str)
    }
}
