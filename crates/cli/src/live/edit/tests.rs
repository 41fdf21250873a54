//! Mechanisms that are drawn and changed.

use qrm_scene::resolve;

use super::Request;

/// The text after a change, which is a scene, and the point that was made.
fn changed(text: &str, edit: &str, places: &str) -> (String, String) {
    let request = format!("{{\"edit\": {edit}, \"places\": {places}}}");
    let request: Request = serde_json::from_str(&request).expect("a request");
    let (text, made) = request.apply(text).expect("a change");
    resolve::read("drawn.toml", &text).map_err(|report| report.render(false)).expect("a scene");
    (text, made)
}

fn refused(text: &str, edit: &str, places: &str) -> String {
    let request = format!("{{\"edit\": {edit}, \"places\": {places}}}");
    let request: Request = serde_json::from_str(&request).expect("a request");
    request.apply(text).expect_err("no change")
}

const EMPTY: &str = "name = \"drawn\" # nothing yet\nrun = { step = 1e-3, end_time = 1 }\n[links]\nground = { points = {} }\n";

#[test]
fn a_four_bar_is_drawn_from_nothing() {
    let (text, made) = changed(EMPTY, r#"{"bar": {"from": {"place": [0, 0]}, "to": {"place": [0.06, 0.08]}}}"#, "{}");
    assert_eq!(made, "A B");
    let places = r#"{"A": [0, 0], "B": [0.06, 0.08]}"#;
    let (text, made) = changed(&text, r#"{"bar": {"from": {"point": "B"}, "to": {"place": [0.36, 0.2]}}}"#, places);
    assert_eq!(made, "B C");
    let places = r#"{"A": [0, 0], "B": [0.06, 0.08], "C": [0.36, 0.2]}"#;
    let (text, made) = changed(&text, r#"{"bar": {"from": {"point": "C"}, "to": {"place": [0.4, 0]}}}"#, places);
    assert_eq!(made, "C D");
    let places = r#"{"A": [0, 0], "B": [0.06, 0.08], "C": [0.36, 0.2], "D": [0.4, 0]}"#;
    let (text, _) = changed(&text, r#"{"pin": {"point": "D"}}"#, places);
    let (text, _) = changed(&text, r#"{"drive": {"point": "A"}}"#, places);
    let (text, _) = changed(&text, r#"{"force": {"point": "C"}}"#, places);
    let (text, _) = changed(&text, r#"{"path": {"point": "C"}}"#, places);
    println!("{text}");
}
