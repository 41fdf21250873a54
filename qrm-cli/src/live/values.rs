//! Values that a page writes back to its scene file.

use std::path::Path;

use qrm_scene::files::write_whole;
use qrm_scene::resolve;
use qrm_scene::source::read_text;
use toml_edit::{DocumentMut, Item, Value};

/// Writes values of parameters, and of coordinates and rates at the start, to a scene file. Everything else in it stays as
/// it is.
pub(super) fn write(path: &Path, values: &[(String, f64)]) -> Result<(), String> {
    let name = path.display().to_string();
    let failed = |e: std::io::Error| format!("{name} cannot be written: {e}");
    let text = read_text(path).map_err(|report| report.render(false))?;
    let text = with_values(&text, values).map_err(|reason| format!("{name}: {reason}"))?;
    resolve::read(&name, &text).map_err(|report| report.render(false))?;
    // The file that a link leads to, with the permissions that it has.
    let file = path.canonicalize().map_err(failed)?;
    let permissions = std::fs::metadata(&file).map_err(failed)?.permissions();
    if permissions.readonly() {
        return Err(format!("{name} is write-protected"));
    }
    write_whole(&file, text.as_bytes()).map_err(failed)?;
    std::fs::set_permissions(&file, permissions).map_err(failed)
}

/// The text of a scene with other values.
fn with_values(text: &str, values: &[(String, f64)]) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|_| "the file holds no scene at present".to_owned())?;
    for (name, number) in values {
        let place = place(&mut document, name).ok_or_else(|| format!("the file has no value for `{name}`"))?;
        let mut value: Value = format!("{number:?}").parse().map_err(|_| format!("`{name}` cannot be {number}"))?;
        *value.decor_mut() = place.decor().clone();
        *place = value;
    }
    let changed = document.to_string();
    Ok(if text.contains("\r\n") { changed.replace('\n', "\r\n") } else { changed })
}

/// Where the value of a parameter, a coordinate or a rate stands.
fn place<'d>(document: &'d mut DocumentMut, name: &str) -> Option<&'d mut Value> {
    let is_parameter = document.get("parameters").is_some_and(|table| table.get(name).is_some());
    let item = if is_parameter {
        let parameter = document.get_mut("parameters")?.get_mut(name)?;
        if parameter.is_table_like() { parameter.get_mut("value")? } else { parameter }
    } else {
        document.get_mut("initial")?.get_mut("given")?.get_mut(name)?
    };
    Item::as_value_mut(item)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_layout_stay() {
        let text = "# a scene\n[parameters]\na  = { value = 0.2,   unit = \"m\" } # crank\nb = 3 # rod\n\
                    [parameters.c]\nvalue = '2*pi' # angle\n[initial]\ngiven = { phi = 0, phi_dot = 'w' } # start\n";
        let values = [("a", 0.25), ("b", 4.0), ("c", 1e-7), ("phi_dot", -2.5)].map(|(name, x)| (name.to_owned(), x));
        let expected =
            text.replace("0.2,", "0.25,").replace("b = 3", "b = 4.0").replace("'2*pi'", "1e-7").replace("'w'", "-2.5");
        assert_eq!(with_values(text, &values), Ok(expected.clone()));
        let of_windows = text.replace('\n', "\r\n");
        assert_eq!(with_values(&of_windows, &values), Ok(expected.replace('\n', "\r\n")));
        let unknown = with_values(text, &[("d".to_owned(), 1.0)]);
        assert_eq!(unknown, Err("the file has no value for `d`".to_owned()));
    }
}
