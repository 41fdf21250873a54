//! The text of a scene without comments and formatting, to decide whether two texts contain the same formulae.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a scene without comments and formatting; `None` if it is not TOML.
///
/// Values are omitted if `is_free` returns true for their path of keys and whether they are numbers.
pub fn without_layout(source: &str, is_free: impl Fn(&[&str], bool) -> bool) -> Option<String> {
    let table = DeTable::parse(source).ok()?;
    let mut text = String::new();
    Writer { source, is_free, text: &mut text }.table(table.get_ref(), &mut Vec::new());
    Some(text)
}

/// Whether a path of keys refers to the value of a parameter.
pub fn is_parameter_value(keys: &[&str]) -> bool {
    matches!(keys, ["parameters", _] | ["parameters", _, "value"])
}

struct Writer<'a, F> {
    source: &'a str,
    is_free: F,
    text: &'a mut String,
}

impl<F: Fn(&[&str], bool) -> bool> Writer<'_, F> {
    fn table<'t>(&mut self, table: &'t DeTable, keys: &mut Vec<&'t str>) {
        self.text.push('{');
        for (key, value) in table {
            keys.push(key.get_ref());
            *self.text += &format!("{:?}=", key.get_ref());
            self.value(value, keys);
            keys.pop();
        }
        self.text.push_str("},");
    }

    fn value<'t>(&mut self, value: &'t Spanned<DeValue>, keys: &mut Vec<&'t str>) {
        match value.get_ref() {
            DeValue::Table(table) => self.table(table, keys),
            DeValue::Array(array) => {
                self.text.push('[');
                array.iter().for_each(|value| self.value(value, keys));
                self.text.push_str("],");
            }
            scalar => {
                let is_number = matches!(scalar, DeValue::Integer(_) | DeValue::Float(_));
                if !(self.is_free)(keys, is_number) {
                    *self.text += &self.source[value.span()];
                }
                self.text.push(',');
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_layout_do_not_matter_and_values_do_unless_they_are_free() {
        let text = |source: &str| without_layout(source, |keys, _| is_parameter_value(keys)).expect("TOML");
        let own = "[parameters]\nc = { value = 4, unit = 'N' } # spring\nm = 2\n[points]\nA = ['c', '0']\n";
        for (from, to) in
            [("4", "5.25"), ("4", "'2*m'"), ("m = 2", "m = '3*c'"), (" # spring", ""), ("A = [", "A   = [ ")]
        {
            assert_eq!(text(own), text(&own.replace(from, to)), "{to}");
        }
        for (from, to) in [("'N'", "'kN'"), ("'0'", "'1'"), ("A =", "B ="), ("c = {", "k = {")] {
            assert_ne!(text(own), text(&own.replace(from, to)), "{to}");
        }
        let numbers = |source: &str| without_layout(source, |_, is_number| is_number).expect("TOML");
        assert_eq!(numbers(own), numbers(&own.replace("m = 2", "m = 3")));
        assert_ne!(numbers(own), numbers(&own.replace("m = 2", "m = '2'")));
        assert_eq!(without_layout("a = = 1", |_, _| false), None);
    }
}
