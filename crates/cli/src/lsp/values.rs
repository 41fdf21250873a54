//! Numbers of a scene at the start of its motion.

use qrm_core::Model;
use qrm_scene::evaluate::{State, parameter_values};
use qrm_scene::resolve;

use crate::api::{LoadedScene, RunOptions};
use crate::format::decimals;

/// A time within which nothing moves, in s.
const MOMENT: &str = "1e-9";

/// Numbers at the start, with their units.
#[derive(Default)]
pub(super) struct Values(Vec<(String, f64, String)>);

impl Values {
    /// The numbers of a scene; none if it has mistakes or cannot be assembled.
    pub(super) fn at_start(models: &'static [Model], path: &str, source: &str) -> Self {
        let mut values = Vec::new();
        let Ok((scene, _)) = resolve::read(path, source) else { return Self::default() };
        let parameters = parameter_values(&scene, |_: &str| None);
        for (parameter, value) in scene.parameters.iter().zip(&parameters) {
            values.push((parameter.name.clone(), *value, parameter.unit.clone()));
        }
        let options = RunOptions { end_time: Some(MOMENT.to_owned()), ..RunOptions::default() };
        let run = LoadedScene::from_source(models, path, source).and_then(|scene| scene.run(&options, 1, false));
        if let Ok(run) = run {
            let first: Vec<(String, f64)> =
                run.columns.iter().zip(&run.values).map(|(column, value)| (column.name.clone(), *value)).collect();
            let value = |name: &str| first.iter().find(|(own, _)| own == name).map_or(f64::NAN, |(_, value)| *value);
            let q: Vec<f64> = scene.coordinates.iter().map(|coordinate| value(&coordinate.name)).collect();
            let qd = scene.coordinates.iter().map(|coordinate| value(&format!("{}_dot", coordinate.name))).collect();
            let state = State::new(&scene, &parameters, 0.0, q, qd);
            for (number, point) in scene.points.iter().enumerate() {
                for (axis, value) in ["x", "y"].into_iter().zip(state.point(number)) {
                    values.push((format!("{}.{axis}", point.name), value, "m".to_owned()));
                }
            }
            values.extend(
                run.columns.iter().zip(first).map(|(column, (name, value))| (name, value, column.unit.clone())),
            );
        }
        Self(values)
    }

    /// The numbers of a word, or of the name in it: `x = 0.1 m`.
    pub(super) fn describe(&self, word: &str, stem: &str) -> Vec<String> {
        let components =
            |name: &str| [name.to_owned(), format!("{name}.x"), format!("{name}.y"), format!("phi_{name}")];
        let of = |name: &str| -> Vec<String> {
            let names = components(name);
            let found = self.0.iter().filter(|(own, value, _)| names.contains(own) && value.is_finite());
            found
                .map(|(name, value, unit)| format!("{name} = {} {unit}", decimals(*value)).trim_end().to_owned())
                .collect()
        };
        let own = of(word);
        if own.is_empty() { of(stem) } else { own }
    }
}
