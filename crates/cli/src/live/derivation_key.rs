//! Decides whether two texts of a scene have the same functions.

use qrm_scene::layout::{is_parameter_value, without_layout};
use qrm_scene::scene::Scene;

/// The data that determine the functions of a scene: its text without comments and parameter values, and the set of
/// parameters that are zero.
///
/// Values also determine the order of elimination in the kernel. The order of the first derivation is kept, so results
/// may differ from those of a new derivation in the last digit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DerivationKey {
    text: String,
    left_out: Vec<bool>,
}

impl DerivationKey {
    /// Computes the key of a valid scene.
    pub(super) fn new(source: &str, scene: &Scene) -> Self {
        let left_out = scene.parameters.iter().map(|parameter| parameter.left_out).collect();
        let text = without_layout(source, |keys, _| is_parameter_value(keys));
        Self { text: text.unwrap_or_else(|| source.to_owned()), left_out }
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
        DerivationKey::new(&source, &scene)
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
