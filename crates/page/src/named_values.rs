//! Named values received from a page, or sent to it.

use serde::{Serialize, Serializer};

/// Named values, received from a page.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct NamedValues {
    values: Vec<(String, f64)>,
}

/// Named values for a page.
pub(crate) struct Named(pub(crate) Vec<(&'static str, f64)>);

impl Serialize for Named {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

impl NamedValues {
    /// Reads lines `NAME=VALUE`.
    pub(crate) fn new(input: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(input).map_err(|_| "the values are no text")?;
        let value = |line: &str| {
            let (name, value) = line.split_once('=').ok_or_else(|| format!("`{line}` has no `=`"))?;
            let value: f64 = value.parse().map_err(|_| format!("`{value}` is no number"))?;
            if value.is_finite() { Ok((name.to_owned(), value)) } else { Err(format!("`{name}` cannot be {value}")) }
        };
        Ok(Self { values: text.lines().map(value).collect::<Result<_, String>>()? })
    }

    /// All values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.values.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// The value with a name.
    pub(crate) fn value(&self, name: &str) -> Option<f64> {
        self.iter().find(|(own, _)| *own == name).map(|(_, value)| value)
    }
}
