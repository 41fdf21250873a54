//! Values that a page writes back to its scene file.

use std::collections::BTreeMap;
use std::ops::Range;

use toml_edit::{Document, Item};

/// The text of a scene with other values of parameters, and of coordinates and rates at the start. The rest of the text is
/// unchanged.
pub(super) fn with_values(text: &str, values: &BTreeMap<String, f64>) -> Result<String, String> {
    let document = Document::parse(text).map_err(|_| "the file is not valid TOML at present".to_owned())?;
    let replacement = |(name, number): (&String, &f64)| {
        let place = span(&document, name).or_else(|| span_in_links(&document, name));
        let span =
            place.ok_or_else(|| format!("the file has no value for `{name}`{}", where_to_add(&document, name)))?;
        Ok((span, format!("{number:?}")))
    };
    let mut replacements = values.iter().map(replacement).collect::<Result<Vec<_>, String>>()?;
    replacements.sort_by_key(|(span, _)| span.start);
    let mut changed = text.to_owned();
    replacements.into_iter().rev().for_each(|(span, number)| changed.replace_range(span, &number));
    Ok(changed)
}

/// The location of the value of a parameter, a coordinate or a rate.
fn span(document: &Document<&str>, name: &str) -> Option<Range<usize>> {
    let parameter = document.get("parameters").and_then(|table| table.get(name));
    parameter.map_or_else(|| document.get("initial")?.get("given")?.get(name)?.span(), value_span)
}

/// The location of the angle or rate of a link, or of the position or rate along a slider.
fn span_in_links(document: &Document<&str>, name: &str) -> Option<Range<usize>> {
    let (section, own, key) = start_key(document, name)?;
    document.get(section)?.get(&own)?.get(key)?.span()
}

/// A hint with the key of the link or joint for a value; empty if there is no such key.
fn where_to_add(document: &Document<&str>, name: &str) -> String {
    start_key(document, name).map_or_else(String::new, |(section, own, key)| {
        format!(": add `{key} = ...` to `{own}` under [{section}], and it can be written")
    })
}

/// The section, the name in it and the key for the start value of a coordinate or a rate of links and joints.
fn start_key(document: &Document<&str>, name: &str) -> Option<(&'static str, String, &'static str)> {
    let (coordinate, is_rate) = match name.strip_suffix("_dot") {
        Some(coordinate) => (coordinate, true),
        None => (name, false),
    };
    let names = |section: &str| {
        let entries = document.get(section).and_then(Item::as_table_like).into_iter().flat_map(|table| table.iter());
        entries.map(|(name, item)| (name.to_owned(), item)).collect::<Vec<_>>()
    };
    for (link, item) in names("links") {
        let own = item.get("coordinate").and_then(Item::as_str).map_or_else(|| format!("phi_{link}"), str::to_owned);
        if own == coordinate {
            return Some(("links", link, if is_rate { "rate" } else { "angle" }));
        }
    }
    let slider = coordinate.strip_prefix("s_")?;
    let joint = names("joints").into_iter().find(|(joint, _)| joint == slider)?.0;
    Some(("joints", joint, if is_rate { "rate" } else { "start" }))
}

/// The location of a parameter's value, which is written directly or in a table.
fn value_span(parameter: &Item) -> Option<Range<usize>> {
    parameter.as_table_like().map_or_else(|| parameter.span(), |table| table.get("value")?.span())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_layout_stay() {
        let text = "# a scene\n[parameters]\na  = { value = 0.2,   unit = \"m\" } # crank\nb = 3 # rod\n\
                    [parameters.c]\nvalue = '2*pi' # angle\n[initial]\ngiven = { phi = 0, phi_dot = 'w' } # start\n";
        let values = [("a", 0.25), ("b", 4.0), ("c", 1e-7), ("phi_dot", -2.5)].map(|(name, x)| (name.to_owned(), x));
        let values = BTreeMap::from(values);
        let expected =
            text.replace("0.2,", "0.25,").replace("b = 3", "b = 4.0").replace("'2*pi'", "1e-7").replace("'w'", "-2.5");
        assert_eq!(with_values(text, &values), Ok(expected.clone()));
        // One file may contain both kinds of line ends.
        let ends = |text: &str| text.replace("\n", "\r\n").replacen("\r\n", "\n", 3);
        assert_eq!(with_values(&ends(text), &values), Ok(ends(&expected)));
        let unknown = with_values(text, &BTreeMap::from([("d".to_owned(), 1.0)]));
        assert_eq!(unknown, Err("the file has no value for `d`".to_owned()));
    }

    #[test]
    fn starts_of_links_and_sliders_are_written() {
        let text = "[links]\ncrank = { bar = [\"O\", \"A\"], angle = 0.5, rate = 3 } # driven\nrod = { coordinate = \
                    \"psi\" }\n\
                    [joints]\nguide = { prismatic = [\"a\", \"b\"], start = 0.1 }\n";
        let values = [("phi_crank", 0.75), ("phi_crank_dot", 4.0), ("s_guide", 0.2)];
        let values = BTreeMap::from(values.map(|(name, x)| (name.to_owned(), x)));
        let expected =
            text.replace("0.5,", "0.75,").replace("rate = 3", "rate = 4.0").replace("start = 0.1", "start = 0.2");
        assert_eq!(with_values(text, &values), Ok(expected));
        let missing = with_values(text, &BTreeMap::from([("psi".to_owned(), 1.0)])).expect_err("there is none");
        assert!(missing.contains("add `angle = ...` to `rod` under [links]"), "{missing}");
    }
}
