//! Equations of scenes whose formulae would become very long if they were expanded before differentiation.

#[path = "../../../codegen/examples/make.rs"]
#[allow(dead_code, unreachable_pub, reason = "the command around it is not used")]
mod make;

use qrm_codegen::{functions, verify};
use qrm_core::NamedTape;
use qrm_language::{Code, rust};
use qrm_scene::resolve;
use qrm_scene::scene::Scene;

/// Five relative angles, with everything that names occur in: a driven closed loop, roots of named points, rates in
/// loads, reactions, a point that moves with time.
const LOOP: &str = r"
name = 'loop'
coordinates = ['a', 'b', 'c', 'd', 'e']
[parameters]
l = 0.5
m = 1.2
J = 0.1
k = 40
cd = 2
w = 3
[points]
A = ['l*sin(a) + l*sin(a + b)', '-l*cos(a) - l*cos(a + b)']
B = ['A.x + l*sin(a + b + c + d)', 'A.y - l*cos(a + b + c + d)']
C = ['B.x + l*sin(a + b + c + d + e)', 'B.y - l*cos(a + b + c + d + e)']
D = ['C.x', 'C.y + l/9*sin(w*t)']
[bodies]
one = { mass = 'm', com = 'A', angle = 'a + b', inertia = 'J' }
two = { mass = 'm', com = ['(A.x + B.x)/2', '(A.y + B.y)/2'], angle = 'a + b + c + d', inertia = 'J' }
three = { mass = 'm', com = 'C', angle = 'a + b + c + d + e', inertia = 'J' }
[constraints]
distance = { residual = 'sqrt((D.x - 2*l)^2 + (D.y + l)^2) - l*(1 + sin(w*t)/5)', unit = 'm' }
line = { residual = 'B.x - l', unit = 'm' }
[loads]
weight = { gravity = ['0', '-9.81'] }
spring = { along = 'hypot(B.x, D.y + 2*l)', spring = 'k', rest = 'l', damper = 'cd' }
push = { force = ['-cd*B.x_dot', '3*t'], at = 'B' }
turn = { torque = 'k*sin(a + b + c + d)', on = 'three' }
[initial]
given = { a = 0.9, b = 0.3, c = -0.2, a_dot = 0, b_dot = 0, c_dot = 0 }
solve = { d = 0.4, e = 0.3 }
[outputs]
place = 'C.y'
speed = { rate = 'C.x' }
acceleration = { second_rate = 'sqrt(B.x^2 + C.y^2)' }
rod = { reaction = 'distance', at = 'D', along = ['1', '0'] }
[run]
step = 1e-3
end_time = 1
";

fn read(text: &str) -> Scene {
    let (scene, _) = resolve::read("made.toml", text).unwrap_or_else(|report| panic!("{report}"));
    scene
}

fn operations(tape: &NamedTape, function: &str) -> usize {
    let function = tape.function(function).unwrap_or_else(|| panic!("no function `{function}`"));
    tape.operations(function).sum()
}

/// The engine can be used once in a process, so one test contains all checks.
#[test]
fn formulae_grow_with_the_mechanism_and_not_with_their_expansion() {
    let stiff = |text: String| text.replace("[run]\n", "[run]\nstiff = true\n");
    let texts = [
        make::chain(8, make::Chain::Relative),
        make::chain(16, make::Chain::Relative),
        LOOP.to_owned(),
        stiff(make::chain(4, make::Chain::Relative)),
        make::chain(8, make::Chain::Relative),
    ];
    let scenes = texts.each_ref().map(|text| read(text));
    let equations = qrm_engine::derive(&scenes.each_ref(), &|_| ()).expect("the equations");
    let tapes: Vec<NamedTape> = (0..texts.len())
        .map(|i| {
            let tape = functions::tape(&scenes[i], &equations[i]);
            verify::verify(&scenes[i], &equations[i], &tape, &tape.placed()).unwrap_or_else(|wrong| panic!("{wrong}"));
            tape
        })
        .collect();

    let degrees = [
        ("com_positions", 1),
        ("com_bias", 1),
        ("energy", 1),
        ("com_jacobian", 2),
        ("generalized_forces", 2),
        ("mass_matrix", 3),
    ];
    for (function, degree) in degrees {
        let [small, large] = [0, 1].map(|i| operations(&tapes[i], function));
        assert!(
            10 * large <= 12 * small * 2_usize.pow(degree),
            "{function}: {small} operations, twice as many links {large}"
        );
    }
    // The output for a scene does not depend on scenes derived earlier.
    let code =
        |i: usize| rust::text(&Code { path: "made.toml", scene: &scenes[i], source: &texts[i], tape: &tapes[i] });
    assert!(code(0) == code(4), "the same scene becomes other code");
}
