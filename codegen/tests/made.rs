//! Checks that generated scenes in the repository match their generator.

#[path = "../examples/make.rs"]
#[allow(dead_code, unreachable_pub, reason = "the command around it is not used")]
mod make;

use qrm_scene::resolve;

#[test]
fn large_scenes_are_as_made() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/large/n-four-bar-40.toml");
    let text = std::fs::read_to_string(path).expect("the scene");
    assert!(text == make::four_bars(40), "run: cargo run -p qrm-codegen --example make -- four-bars 40 > {path}");
}

#[test]
fn every_kind_is_a_scene() {
    let chains = [make::Chain::Relative, make::Chain::Angles, make::Chain::Absolute];
    let texts = chains.map(|kind| make::chain(5, kind)).into_iter().chain([make::four_bars(1)]);
    for text in texts {
        let read = resolve::read("made.toml", &text);
        let (_, report) = read.unwrap_or_else(|report| panic!("{report}"));
        assert!(report.diagnostics.is_empty(), "{report}");
    }
}
