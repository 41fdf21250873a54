//! Texts found by a fuzzer, each of which follows a different path through the reading of scenes: none may cause a
//! panic.

use std::path::Path;

use qrm_scene::evaluate::{State, parameter_values};
use qrm_scene::resolve::{read, read_condition};

#[test]
fn every_text_gives_a_scene_or_a_report() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/corpus/scene_text");
    let (mut scenes, mut reports) = (0, 0);
    for entry in std::fs::read_dir(folder).expect("the corpus") {
        let bytes = std::fs::read(entry.expect("an entry").path()).expect("a file");
        let Ok(text) = String::from_utf8(bytes) else { continue };
        match read("scene.toml", &text) {
            Err(report) => {
                assert!(report.to_string().contains("error: "), "{report}");
                reports += 1;
            }
            Ok((scene, warnings)) => {
                let _ = (warnings.to_string(), read_condition(&scene, &text));
                let n = scene.coordinates.len();
                let state =
                    State::plain(&scene, &parameter_values(&scene, |_| None), 0.5, &vec![0.3; n], &vec![-0.7; n]);
                scene.constraints.iter().for_each(|constraint| {
                    let _ = state.value(&constraint.residual);
                });
                scenes += 1;
            }
        }
    }
    assert!(scenes > 5 && reports > 100, "{scenes} scenes and {reports} reports");
}
