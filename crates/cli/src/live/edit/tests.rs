//! Mechanisms that are drawn and changed.

use qrm_scene::resolve;

use super::{Request, length_parameters};

fn applied(text: &str, edit: &str, places: &str) -> Result<(String, Vec<String>), String> {
    let request = format!("{{\"edit\": {edit}, \"places\": {places}}}");
    serde_json::from_str::<Request>(&request).expect("a request").apply(text)
}

/// The text after a change, which is a scene, and the names of the ends of a new bar.
fn changed(text: &str, edit: &str, places: &str) -> (String, String) {
    let (text, ends) = applied(text, edit, places).expect("a change");
    resolve::read("drawn.toml", &text).map_err(|report| report.render(false)).expect("a scene");
    (text, ends.join(" "))
}

fn refused(text: &str, edit: &str, places: &str) -> String {
    applied(text, edit, places).expect_err("no change")
}

const EMPTY: &str =
    "name = \"drawn\" # nothing yet\nrun = { step = 1e-3, end_time = 1 }\n[links]\nground = { points = {} }\n";

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
    let expected = r#"name = "drawn" # nothing yet
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { A = [0.0, 0.0], D = [0.4, 0.0] } }
bar1 = { bar = ["A", "B"], length = 0.1, mass = 1 }
bar2 = { bar = ["B", "C"], length = 0.32311, mass = 1, angle = '21.8 deg' }
bar3 = { bar = ["C", "D"], length = 0.20396, mass = 1, angle = '-78.69 deg' }

[joints]
A = { revolute = ["bar1", "ground"], drive = '53.13 deg + 60rpm*t' }
B = { revolute = ["bar1", "bar2"] }
C = { revolute = ["bar2", "bar3"] }
D = { revolute = ["bar3", "ground"] }

[outputs]
F_C = { joint = "C" }

[drawing]
path_C = { path = "C" }
"#;
    assert_eq!(text, expected);
    // A removed drive, force or path leaves what was there before.
    let (text, _) = changed(&text, r#"{"drive": {"point": "A"}}"#, places);
    assert!(text.contains("length = 0.1, mass = 1, angle = '53.13 deg' }"), "{text}");
    let (text, _) = changed(&text, r#"{"force": {"point": "C"}}"#, places);
    let (text, _) = changed(&text, r#"{"path": {"point": "C"}}"#, places);
    assert!(!text.contains("F_C") && !text.contains("path_C"), "{text}");
    for (edit, reason) in [
        (r#"{"pin": {"point": "A"}}"#, "`A` is on the ground already"),
        (r#"{"pin": {"point": "X"}}"#, "`X` is no point of a link"),
        (r#"{"bar": {"from": {"point": "A"}, "to": {"point": "B"}}}"#, "both points are on one link"),
        (r#"{"bar": {"from": {"place": [1, 1]}, "to": {"place": [1, 1]}}}"#, "two points that are apart"),
        (r#"{"move": {"point": "B", "to": [0, 0]}}"#, "`bar1` would have no length"),
        (r#"{"point": {"link": "bar9", "to": [0, 0]}}"#, "[links] has no table `bar9`"),
    ] {
        let said = refused(&text, edit, places);
        assert!(said.contains(reason), "{said}");
    }
    assert!(refused(&text, r#"{"pin": {"point": "C"}}"#, "{}").contains("does not show where point `C`"));
}

/// A slider-crank in units, with comments, sub-tables and line ends of another system.
const CRANK: &str = r#"
name = "crank"
run = { step = 1e-3, end_time = 1 }
[parameters]
r = { value = 80, unit = "mm" } # crank
k = 0.08
l = '3*k'
[links.crank]
bar = ["O", "A"]
length = 'r' # by the parameter
[links]
ground = { points = { O = [0, '0 mm'] } }
rod = { bar = ["A", "B"], length = '240 mm', mass = 1 }
[joints]
O = { revolute = ["ground", "crank"], drive = '-100*t' }
A = { revolute = ["crank", "rod"], near = [ 0.08 , 0.0 ] }
guide = { pin_in_slot = ["rod.B", "ground.O"], start = 0.32 }
"#;

#[test]
fn moved_points_set_lengths_in_their_units() {
    let places = r#"{"O": [0, 0], "A": [0.08, 0], "B": [0.32, 0]}"#;
    let text = CRANK.replace('\n', "\r\n");
    let (moved, _) = changed(&text, r#"{"move": {"point": "A", "to": [0, 0.1]}}"#, places);
    let expected = text
        .replace("value = 80,", "value = 100.0,")
        .replace("'240 mm'", "'335.26 mm'")
        .replace("'-100*t'", "'-90 deg - 100*t'")
        .replace("[ 0.08 , 0.0 ]", "[ 0.0 , 0.1 ]");
    assert_eq!(moved, expected);
    // A point on a line of the ground stays on it.
    let (moved, _) = changed(&text, r#"{"move": {"point": "B", "to": [0.4, 0.1]}}"#, places);
    assert_eq!(moved, text.replace("'240 mm'", "'320 mm'"));
    // A length that is a formula is left to the file.
    let formula = text.replace("'240 mm'", "'l'");
    let said = refused(&formula, r#"{"move": {"point": "A", "to": [0.05, 0.1]}}"#, places);
    assert!(said.contains("`parameters.l` is the formula `3*k`"), "{said}");
    // So is a parameter that also sets something else.
    let said = refused(&text.replace("3*k", "3*r"), r#"{"move": {"point": "A", "to": [0, 0.1]}}"#, places);
    assert!(said.contains("parameter `r` has other uses too"), "{said}");
    // Places of another state of the file are refused.
    let said = refused(
        &text,
        r#"{"move": {"point": "A", "to": [0, 0.1]}}"#,
        r#"{"O": [0, 0], "A": [0.08, 0], "B": [0.4, 0]}"#,
    );
    assert!(said.contains("does not show the file as it is"), "{said}");
    // A mark at the beginning and a last line without an end stay.
    let marked = format!("\u{feff}{}", text.trim_end());
    let (moved, _) = changed(&marked, r#"{"move": {"point": "B", "to": [0.4, 0]}}"#, places);
    assert_eq!(moved, marked.replace("'240 mm'", "'320 mm'"));
}

#[test]
fn triangles_plates_and_rods_follow_a_point() {
    let text = r#"
name = "plate"
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { O = [0, 0], Q = [2, 0] } }
plate = { triangle = ["O", "A", "P"], sides = [1, 1, 'sqrt(2)'], mass = 1, angle = 0 }
arm = { points = { A = [0.5, 0], C = [0.5, 1] }, mass = 1, com = "A", inertia = 1, angle = '0 deg' }
[joints]
O = { revolute = ["plate", "ground"] }
A = { revolute = ["plate", "arm"] }
rope = { rod = ["arm.C", "ground.Q"], length = 'sqrt(2)' }
"#;
    let places = r#"{"O": [0, 0], "A": [1, 0], "P": [1, 1], "C": [1, 1], "Q": [2, 0]}"#;
    let (moved, _) = changed(text, r#"{"move": {"point": "P", "to": [0, 1]}}"#, places);
    assert_eq!(moved, text.replace("[1, 1, 'sqrt(2)']", "[1, 1.4142, 1.0]"));
    let (moved, _) = changed(text, r#"{"move": {"point": "C", "to": [2, 2]}}"#, places);
    assert_eq!(moved, text.replace("C = [0.5, 1]", "C = [1.5, 2.0]").replace("length = 'sqrt(2)'", "length = 2.0"));
    let (moved, _) = changed(text, r#"{"move": {"point": "Q", "to": [1, 3]}}"#, places);
    assert_eq!(moved, text.replace("Q = [2, 0]", "Q = [1.0, 3.0]").replace("length = 'sqrt(2)'", "length = 2.0"));
    let said = refused(text, r#"{"move": {"point": "P", "to": [0, -1]}}"#, places);
    assert!(said.contains("triangle `plate` would turn over"), "{said}");
    // A point in the frame of a link that is turned.
    let places = r#"{"O": [0, 0], "A": [0, 1], "P": [-1, 1], "C": [0, 2], "Q": [2, 0]}"#;
    let (added, _) = changed(text, r#"{"point": {"link": "plate", "to": [-2, 3]}}"#, places);
    assert!(added.contains("points = { B = [3.0, 2.0] } }"), "{added}");
    assert!(added.contains("path_B = { path = \"B\" }"), "{added}");
}

#[test]
fn bars_join_pins_and_points_of_links() {
    let text = r#"
name = "joined"
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { O = [0, 0] } }
a = { bar = ["O", "A"], length = 1, mass = 1, angle = 0, points = { P = [0.5, 0.5] } }
b = { bar = ["A", "B"], length = 1, mass = 1, angle = 0 }
[joints]
O = { revolute = ["a", "ground"] }
A = { revolute = ["a", "b"] }
"#;
    let places = r#"{"O": [0, 0], "A": [1, 0], "B": [2, 0], "P": [0.5, 0.5]}"#;
    let (joined, made) = changed(text, r#"{"bar": {"from": {"point": "A"}, "to": {"place": [1, 1]}}}"#, places);
    assert!(joined.contains(r#"A = { revolute = ["a", "b", "bar1"] }"#) && made == "A C", "{joined}");
    let (joined, _) = changed(text, r#"{"bar": {"from": {"point": "P"}, "to": {"place": [1, 1]}}}"#, places);
    assert!(joined.contains(r#"P = { revolute = ["a", "bar1"] }"#), "{joined}");
    let (joined, _) = changed(text, r#"{"bar": {"from": {"place": [3, 0]}, "to": {"point": "B"}}}"#, places);
    assert!(joined.contains(r#"C = { revolute = ["bar1", "ground"] }"#), "{joined}");
    assert!(joined.contains(r#"B = { revolute = ["b", "bar1"] }"#), "{joined}");
    let (held, _) = changed(text, r#"{"slider": {"point": "B", "direction": 1.5707963267948966}}"#, places);
    assert!(held.contains(r#"guide_B = { pin_in_slot = ["b.B", "ground.B0"], direction = '90 deg' }"#), "{held}");
    // A pin of three links has no drive; a second pin holds the bar instead.
    let said = refused(&changed(text, r#"{"pin": {"point": "A"}}"#, places).0, r#"{"drive": {"point": "A"}}"#, places);
    assert!(said.contains("3 links meet at `A`"), "{said}");
}

#[test]
fn lengths_become_parameters_with_the_values_of_the_file() {
    let text = length_parameters::with_length_parameters(CRANK).expect("lengths");
    resolve::read("drawn.toml", &text).map_err(|report| report.render(false)).expect("a scene");
    for part in [
        "O = ['qrm_links_ground_points_O_0', 'qrm_links_ground_points_O_1']",
        "length = 'qrm_links_rod_length'",
        "length = 'r' # by the parameter",
        "qrm_links_rod_length = { value = 0.24, unit = \"m\", runtime = true }",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let values = length_parameters::values(CRANK);
    assert_eq!((values["r"], values["qrm_links_rod_length"]), (80.0, 0.24));
    let driven = CRANK.replace("'-100*t'", "'30 deg - 100*t'");
    let text = length_parameters::with_length_parameters(&driven).expect("lengths");
    assert!(text.contains("drive = 'qrm_joints_O_drive - 100*t'"), "{text}");
    assert_eq!(length_parameters::with_length_parameters("name = \"none\""), None);
}

#[test]
fn what_ties_a_link_follows_or_refuses() {
    let text = r#"
name = "tied"
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { O = [0, 0], E = [1, 0], G = [0, 2] } }
boom = { bar = ["O", "M"], length = 1, mass = 1, angle = '90 deg' }
wheel = { bar = ["E", "W"], length = 0.5, mass = 1, angle = 0 }
piece = { bar = ["M", "Q"], length = 1, mass = 1 }
[joints]
O = { revolute = ["boom", "ground"] }
E = { revolute = ["wheel", "ground"] }
M = { weld = ["piece", "boom"] }
mesh = { gear = ["wheel", "boom"], ratio = -2 }
lift = { cylinder = ["ground.E", "boom.M"], length = '1.41421 m + 0.1 m/s*(1 s)*sin(t/(1 s))' }
"#;
    let places = r#"{"O": [0, 0], "E": [1, 0], "M": [0, 1], "W": [1.5, 0], "Q": [0, 2]}"#;
    let untied = |text: &str| -> String {
        let is_tie = |line: &&str| ["mesh", "M =", "piece"].iter().any(|start| line.starts_with(start));
        text.lines().filter(|line| !is_tie(line)).map(|line| format!("{line}\n")).collect()
    };
    let free = untied(text);
    let (moved, _) = changed(&free, r#"{"move": {"point": "M", "to": [1, 1]}}"#, places);
    let expected = free
        .replace("length = 1, mass = 1, angle = '90 deg'", "length = 1.4142, mass = 1, angle = '45 deg'")
        .replace("'1.41421 m + ", "'1 m + ");
    assert_eq!(moved, expected);
    for (point, joint) in [("M", "M"), ("W", "mesh")] {
        let said = refused(text, &format!(r#"{{"move": {{"point": "{point}", "to": [0.9, 0.7]}}}}"#), places);
        assert!(said.contains(&format!("joint `{joint}` ties the angle of link")), "{said}");
    }
    // A point on a line of the ground that no bearing shows.
    let slider =
        text.replace("lift = {", "line = { pin_in_slot = [\"boom.M\", \"ground.G\"], direction = '90 deg' }\nlift = {");
    let slider = untied(&slider);
    let (moved, _) = changed(&slider, r#"{"move": {"point": "M", "to": [0.3, 0.5]}}"#, places);
    assert!(moved.contains("length = 0.5, mass = 1, angle = '90 deg'"), "{moved}");
    let said = refused(&slider, r#"{"drive": {"point": "M"}}"#, r#"{"M": [1e300, 0]}"#);
    assert!(said.contains("places lie within 1000000 m"), "{said}");
}

#[test]
fn what_is_not_changed_keeps_its_form() {
    let text = r#"
name="tight"
run={step=1e-3,end_time=1}
[links]
ground={points={O=[0,0]}}
a={bar=["O","A"],length='1e3 mm',mass=1,angle=0,points={P=[0.5,0.5],Q=[0.25,0]}}
[joints]
O={revolute=["a","ground"],drive='2*pi*t'}
[drawing]
path_A={path="P"}
"#;
    let places = r#"{"O": [0, 0], "A": [1, 0], "P": [0.5, 0.5], "Q": [0.25, 0]}"#;
    let (added, _) = changed(text, r#"{"path": {"point": "A"}}"#, places);
    assert_eq!(added, text.to_owned() + "path_A2 = { path = \"A\" }\n");
    let (pinned, _) = changed(text, r#"{"drive": {"point": "O"}}"#, places);
    assert_eq!(
        pinned,
        text.replace(",drive='2*pi*t'", "")
            .replace("length='1e3 mm',mass=1,angle=0,", "length='1e3 mm',mass=1,")
            .replace("Q=[0.25,0]}}", "Q=[0.25,0]}, angle = '0 deg'}")
    );
    // Other points of a bar stay in place when it turns.
    let (moved, _) = changed(text, r#"{"move": {"point": "A", "to": [0, 2]}}"#, places);
    let expected = text
        .replace("'1e3 mm'", "'2000 mm'")
        .replace("angle=0", "angle=1.57080")
        .replace("P=[0.5,0.5],Q=[0.25,0]", "P=[0.5,-0.5],Q=[0.0,-0.25]")
        .replace("'2*pi*t'", "'90 deg + 2*pi*t'");
    assert_eq!(moved.replace("1.5708", "1.57080"), expected);
    // A move along the bar turns nothing.
    let (moved, _) = changed(text, r#"{"move": {"point": "A", "to": [2, 0]}}"#, places);
    assert_eq!(moved, text.replace("'1e3 mm'", "'2000 mm'"));
    let said = refused("r = 'r'\n", r#"{"path": {"point": "A"}}"#, places);
    assert!(said.contains("the file has an error"), "{said}");
}
