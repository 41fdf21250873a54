//! Whether two texts of a scene have the same functions.

use qrm_scene::scene::Scene;
use toml_edit::{DocumentMut, Item, Table, Value};

/// What the functions of a scene depend on: its text without comments and without the values of parameters, and
/// which of them are zero.
///
/// Values also decide the order of elimination in the kernel. The order of the first derivation stays, so that numbers may
/// differ from those of a new derivation in the last digit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DerivationKey {
    text: String,
    left_out: Vec<bool>,
}

impl DerivationKey {
    /// The key of a scene without mistakes.
    pub(super) fn of(source: &str, scene: &Scene) -> Self {
        let left_out = scene.parameters.iter().map(|parameter| parameter.left_out).collect();
        Self { text: canonical(source).unwrap_or_else(|| source.to_owned()), left_out }
    }
}

/// The canonical text of a scene: values of parameters are zero, comments and layout are removed.
fn canonical(source: &str) -> Option<String> {
    let mut document: DocumentMut = source.parse().ok()?;
    if let Some(parameters) = document.get_mut("parameters").and_then(Item::as_table_like_mut) {
        for (_, parameter) in parameters.iter_mut() {
            let value = match parameter.as_table_like_mut() {
                Some(table) => table.get_mut("value"),
                None => Some(parameter),
            };
            if let Some(value) = value {
                *value = toml_edit::value(0);
            }
        }
    }
    strip(document.as_item_mut());
    document.set_trailing("");
    Some(document.to_string())
}

/// Removes comments and spaces from an item and all within it.
fn strip(item: &mut Item) {
    match item {
        Item::None => {}
        Item::Value(value) => strip_value(value),
        Item::Table(table) => strip_table(table),
        Item::ArrayOfTables(tables) => tables.iter_mut().for_each(strip_table),
    }
}

fn strip_table(table: &mut Table) {
    table.decor_mut().clear();
    for (mut key, item) in table.iter_mut() {
        key.leaf_decor_mut().clear();
        key.dotted_decor_mut().clear();
        strip(item);
    }
}

fn strip_value(value: &mut Value) {
    value.decor_mut().clear();
    match value {
        Value::Array(array) => {
            array.set_trailing("");
            array.set_trailing_comma(false);
            array.iter_mut().for_each(strip_value);
        }
        Value::InlineTable(table) => {
            for (mut key, value) in table.iter_mut() {
                key.leaf_decor_mut().clear();
                key.dotted_decor_mut().clear();
                strip_value(value);
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use qrm_scene::resolve;

    use super::*;

    const SCENE: &str = r#"
name = "block"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
c = { value = 4, unit = "N/m" } # spring
m = { value = '2*c', unit = "kg" }
g = { value = 0, unit = "m/s^2" }
[bodies]
block = { mass = 'm', com = ['x', '0'] }
[loads]
spring = { force = ['-c*x', '0'], on = "block" }
gravity = { gravity = ['g', '0'] }
[initial]
given = { x = 1, x_dot = 0 }
[run]
step = 1e-3
end_time = 1
"#;

    fn key(replaced: &str, by: &str) -> DerivationKey {
        let source = SCENE.replace(replaced, by);
        assert!(replaced == by || source != SCENE);
        let (scene, _) = resolve::read("block.toml", &source).expect("the scene is right");
        DerivationKey::of(&source, &scene)
    }

    #[test]
    fn values_of_parameters_do_not_matter_unless_they_are_zero() {
        let own = key("", "");
        assert_eq!(own, key("4", "5.25"));
        assert_eq!(own, key("2*c", "3*c + 1"));
        assert_eq!(own, key("# spring\n", "\n# mass,\n\n  # of steel\n"));
        assert_eq!(own, key("{ mass = 'm', com", "{mass='m',   com"));
        assert_ne!(own, key("value = 0", "value = 9.81"));
        assert_ne!(own, key("-c*x", "-2*c*x"));
        assert_ne!(own, key("x = 1", "x = 2"));
    }
}
