//! Any text as a scene: a report or a scene, never a panic. What is accepted is evaluated too.

#![no_main]

use libfuzzer_sys::fuzz_target;
use qrm_scene::evaluate::{State, parameter_values};
use qrm_scene::resolve::{read, read_condition};

fuzz_target!(|text: &str| {
    let Ok((scene, warnings)) = read("scene.toml", text) else { return };
    let _ = warnings.to_string();
    let parameters = parameter_values(&scene, |_| None);
    let n = scene.coordinates.len();
    let state = State::plain(&scene, &parameters, 0.5, &vec![0.3; n], &vec![-0.7; n]);
    for constraint in &scene.constraints {
        let _ = state.value(&constraint.residual);
    }
    // The second half of a text is a condition as good as any.
    let middle = (text.len() / 2..text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(0);
    let _ = read_condition(&scene, &text[middle..]);
});
