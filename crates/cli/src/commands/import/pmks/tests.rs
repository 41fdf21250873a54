//! Tests of mechanisms of PMKS.

use super::super::imported;

fn lines(text: &str, begin: &str) -> Vec<String> {
    let scene = imported(text).expect("a scene");
    let line = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
    scene.lines().map(line).filter(|line| line.starts_with(begin)).collect()
}

#[test]
fn a_four_bar_is_links_and_pins() {
    let scene = imported("ground, input,R,0,0\ninput coupler,R,0,8\ncoupler,output ,R,19,22\nground, output,R,21,2\n");
    let scene = scene.expect("a scene");
    let shown = "\
[parameters]
speed = { value = 10, unit = \"rpm\", doc = \"speed of the input\" }
[links]
ground  = { points = { A = [0, 0], D = [21, 2] } }
input   = { points = { A = [0, 0], B = [0, 8] } }
coupler = { points = { B = [0, 0], C = [19, 14] }, angle = 0 }
output  = { points = { C = [0, 0], D = [2, -20] }, angle = 0 }
[joints]
A = { revolute = [\"input\", \"ground\"], drive = 'speed*t' }
B = { revolute = [\"input\", \"coupler\"] }
C = { revolute = [\"coupler\", \"output\"] }
D = { revolute = [\"output\", \"ground\"] }
";
    assert!(scene.ends_with(shown), "{scene}");
    assert!(scene.contains("run = { step = 0.006, end_time = 6 }"), "{scene}");
}

#[test]
fn a_link_has_its_speed_and_its_input() {
    let text = "http://x/pmks.html?set=s-20|f5&mech=ground%20crank%20R%200%200%200%20ffff|\
                crank,rod,R,1,0,0,ffff|rod ground RP 2 0 45 ffff|crank R 1 1 0 tfff|ram ground2 P 5 5 30 ffft|\
                ram rod RP 1 2 0 ffff|";
    assert_eq!(lines(text, "speed"), ["speed = { value = -20, unit = \"m/s\", doc = \"speed of the input slider\" }"]);
    let joints = ["A = { revolute = [\"crank\", \"ground\"] }", "B = { revolute = [\"crank\", \"rod\"] }"];
    assert_eq!([lines(text, "A ="), lines(text, "B =")].concat(), joints);
    // The slot is on the first link, the pin on the second one.
    let slot = "C = { pin_in_slot = [\"ground\", \"rod.C_line\"], direction = 0.7853981633974483, start = 0 }";
    assert_eq!(lines(text, "C ="), [slot]);
    let slider = "D = { prismatic = [\"ram\", \"ground.D_line\"], direction = 0.5235987755982988, drive = 'speed*t' }";
    assert_eq!(lines(text, "D ="), [slider]);
    assert_eq!(lines(text, "x_P1"), ["x_P1 = { value = 'P1.x', unit = \"m\" }"]);
}

#[test]
fn teeth_become_gears_and_racks() {
    let outside = "ground a R 0 0\na b G 4 0\nb ground R 10 0";
    assert_eq!(lines(outside, "teeth"), ["teeth = { gear = [\"a\", \"b\"], ratio = -1.5 }"]);
    let inside = "ground a R 0 0\na b G 12 0\nb ground R 9 0";
    assert_eq!(lines(inside, "teeth"), ["teeth = { gear = [\"a\", \"b\"], ratio = 0.25 }"]);
    let rack = "ground a R 0 2\na b G 0 0\nground b P 5 0 0";
    assert_eq!(lines(rack, "teeth"), ["teeth = { rack = [\"a\", \"b.teeth_line\"], radius = 2 }"]);
}

#[test]
fn errors_name_their_place() {
    let error = |text: &str| imported(text).expect_err("no scene");
    for (text, said) in [
        ("ground a R 1e400 0", "model:1:12"),
        ("ground a R 0", "this joint has no place"),
        ("ground a R 0 0\nx 1 2", "model:2:1"),
        ("ground a R 0 0\na b R 1 0\nb c R 2 0", "the input does not determine the motion of: `b`, `c`"),
        ("ground a R 0 0\na b G 1 0", "these teeth have no carrier"),
        ("a b R 0 0", "no joint is on the ground"),
        ("ground a RP 0 0 0 ffft", "cannot be the input"),
        ("ground a b P 0 0 0", "too many links"),
        ("ground a a R 0 0 0", "names a link twice"),
        ("ground a R 0 0\na ground R 0 0", "model:2:1"),
        ("ground a R 0 0\na ground R 0 0", "this joint is written twice"),
    ] {
        assert!(error(text).contains(said), "{}", error(text));
    }
}

#[test]
fn the_motion_of_many_links_is_checked() {
    let mut text = "ground input R 0 0\n".to_owned();
    for i in 0..120 {
        text += &format!("input c{i} R 0 8\nc{i} r{i} R 19 22\nground r{i} R 21 {}\n", 2.0 + f64::from(i) / 1000.0);
    }
    assert!(imported(&text).is_ok());
    let error = imported(&(text + "input loose R 0 8\n")).expect_err("no scene");
    assert!(error.contains("the input does not determine the motion of: `loose`"), "{error}");
}

#[test]
fn further_inputs_are_driven_or_listed() {
    let four_bar = "ground a R 0 0 0 ffft\na b R 0 8\nb c R 19 22\nground c R 21 2 0 ffft";
    assert_eq!(lines(four_bar, "# - the input"), ["# - the input at [0, 0], whose motion the other input determines"]);
    assert_eq!(lines(four_bar, "D ="), ["D = { revolute = [\"c\", \"ground\"], drive = 'speed*t' }"]);
    // The rocker is at rest where crank and rod are in line.
    let dead = "ground a R 0 0 0 ffft\na b R 1 1\nb c R 3 3\nc ground R 4 0 0 ffft";
    assert_eq!(lines(dead, "# - the input"), ["# - the input at [4, 0], whose motion the other input determines"]);
    let five_bar = "ground a R 0 0 0 ffft\na b R 0 8\nb c R 10 12\nc d R 19 8\nd ground R 20 0 0 ffft";
    let speeds = [
        "speed = { value = 10, unit = \"rpm\", doc = \"speed of the input\" }",
        "speed_2 = { value = 10, unit = \"rpm\", doc = \"speed of the input A\" }",
    ];
    assert_eq!([lines(five_bar, "speed ="), lines(five_bar, "speed_2")].concat(), speeds);
    assert_eq!(lines(five_bar, "A ="), ["A = { revolute = [\"a\", \"ground\"], drive = 'speed_2*t' }"]);
    assert!(lines(five_bar, "# - the input").is_empty());
}
