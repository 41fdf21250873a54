//! Values that a page writes back to its scene file.

use std::collections::BTreeMap;
use std::io::{Error, Write};
use std::ops::Range;
use std::path::Path;

use qrm_scene::files::write_whole_with;
use qrm_scene::resolve;
use qrm_scene::source::read_text;
use toml_edit::{Document, Item};

/// Writes values of parameters, and of coordinates and rates at the start, to a scene file. The rest of the file stays.
pub(super) fn write_back(path: &Path, values: &BTreeMap<String, f64>) -> Result<(), String> {
    let name = path.display().to_string();
    let failed = |e: Error| format!("{name} cannot be written: {e}");
    let text = read_text(path).map_err(|report| report.render(false))?;
    let changed = with_values(&text, values).map_err(|reason| format!("{name}: {reason}"))?;
    resolve::read(&name, &changed).map_err(|report| report.render(false))?;
    // Where the path is a link, the file behind it is written.
    let file = path.canonicalize().map_err(failed)?;
    let permissions = std::fs::metadata(&file).map_err(failed)?.permissions();
    if permissions.readonly() {
        return Err(format!("{name} is write-protected"));
    }
    let write = |part: &mut std::fs::File| {
        part.write_all(changed.as_bytes())?;
        part.set_permissions(permissions)?;
        let is_same = read_text(path).is_ok_and(|now| now == text);
        if is_same { Ok(()) } else { Err(Error::other("another program has just saved it; try again")) }
    };
    write_whole_with(&file, write).map_err(failed)
}

/// The text of a scene with other values.
fn with_values(text: &str, values: &BTreeMap<String, f64>) -> Result<String, String> {
    let document = Document::parse(text).map_err(|_| "the file holds no scene at present".to_owned())?;
    let replacement = |(name, number): (&String, &f64)| {
        let span = span(&document, name).ok_or_else(|| format!("the file has no value for `{name}`"))?;
        Ok((span, format!("{number:?}")))
    };
    let mut replacements = values.iter().map(replacement).collect::<Result<Vec<_>, String>>()?;
    replacements.sort_by_key(|(span, _)| span.start);
    let mut changed = text.to_owned();
    replacements.into_iter().rev().for_each(|(span, number)| changed.replace_range(span, &number));
    Ok(changed)
}

/// The place of the value of a parameter, a coordinate or a rate.
fn span(document: &Document<&str>, name: &str) -> Option<Range<usize>> {
    let parameter = document.get("parameters").and_then(|table| table.get(name));
    parameter.map_or_else(|| document.get("initial")?.get("given")?.get(name)?.span(), value_span)
}

/// The place of the value of a parameter, which stands alone or in a table.
pub(super) fn value_span(parameter: &Item) -> Option<Range<usize>> {
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
        // Lines may end in two ways, also within one file.
        let ends = |text: &str| text.replace("\n", "\r\n").replacen("\r\n", "\n", 3);
        assert_eq!(with_values(&ends(text), &values), Ok(ends(&expected)));
        let unknown = with_values(text, &BTreeMap::from([("d".to_owned(), 1.0)]));
        assert_eq!(unknown, Err("the file has no value for `d`".to_owned()));
    }
}
