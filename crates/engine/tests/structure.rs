//! Equations of scenes whose formulae would become very long if they were expanded before differentiation.

#[path = "../../../codegen/examples/make.rs"]
#[allow(dead_code, unreachable_pub, reason = "the command around it is not used")]
mod make;

use qrm_codegen::{functions, verify};
use qrm_core::{NamedTape, Tape, TapeEvaluator};
use qrm_language::{Code, rust};
use qrm_scene::resolve;
use qrm_scene::scene::{EliminationForm, Scene};

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

/// Fourteen coordinates of a tree with a branch, with all that named quantities occur in: roots of points, drives by
/// time, loads along rates, outputs of accelerations and powers, a point without a body.
const TREE: &str = r"
name = 'tree'
coordinates = [
    'a', 'b', 'c', 'd', 'e', 'f', 'g', { name = 'x', unit = 'm' }, 'h', 'i', 'j', 'k', 'l', { name = 'y', unit = 'm' },
]
[parameters]
r = 0.5
m = 1.2
J = 0.1
k1 = 40
cd = 2
w = 3
[points]
A = ['r*sin(a) + r*sin(a + b)', '-r*cos(a) - r*cos(a + b)']
B = ['A.x + r*sin(a + b + c)', 'A.y - r*cos(a + b + c)']
C = ['B.x + (r + x)*sin(a + b + c + d)', 'B.y - (r + x)*cos(a + b + c + d)']
D = ['C.x + r*sin(a + b + c + d + e)', 'C.y - r*cos(a + b + c + d + e)']
E = ['D.x + r*sin(f) + r*sin(g)', 'D.y - r*cos(f) - r*cos(g)']
F = ['A.x + r*sin(a + b + h)', 'A.y - r*cos(a + b + h)']
G = ['F.x + r*sin(a + b + h + i)', 'F.y - r*cos(a + b + h + i)']
H = ['G.x + r*sin(j) + r*cos(k)', 'G.y - r*cos(j) + r*sin(k)']
I = ['H.x + y*sin(l)', 'H.y - y*cos(l)']
[bodies]
one = { mass = 'm', com = 'A', angle = 'a + b', inertia = 'J' }
two = { mass = 'm', com = ['(A.x + B.x)/2', '(A.y + B.y)/2'], angle = 'a + b + c', inertia = 'J' }
three = { mass = 'm', com = 'C', angle = 'a + b + c + d', inertia = 'J' }
four = { mass = 'm', com = ['(C.x + D.x)/2', '(C.y + D.y)/2'], angle = 'a + b + c + d + e', inertia = 'J' }
five = { mass = 'm', com = 'E', angle = 'f', inertia = 'J' }
six = { angle = 'g', inertia = 'J' }
seven = { mass = 'm', com = 'F', angle = 'a + b + h', inertia = 'J' }
eight = { mass = 'm', com = 'G', angle = 'a + b + h + i', inertia = 'J' }
nine = { mass = 'm', com = 'H', angle = 'j', inertia = 'J' }
ten = { angle = 'k', inertia = 'J' }
eleven = { mass = 'm', com = 'I', angle = 'l', inertia = 'J' }
[loads]
weight = { gravity = ['0', '-9.81'] }
spring = { along = 'hypot(E.x - I.x + r/9*sin(w*t), E.y - I.y)', spring = 'k1', rest = 'r', damper = 'cd' }
push = { force = ['-cd*B.x_dot', '3*t'], at = 'H' }
turn = { torque = 'k1*sin(a + b + c + d)', on = 'three' }
brake = { torque = '-cd*h_dot', on = 'seven' }
[initial.given]
a = 0.9
b = 0.3
c = -0.2
d = 0.4
e = 0.3
f = 0.1
g = 0.5
x = 0.1
h = -0.4
i = 0.2
j = 0.3
k = 0.7
l = 0.2
y = 0.6
a_dot = 0
b_dot = 1
c_dot = 0
d_dot = 0
e_dot = 0
f_dot = 0
g_dot = 0
x_dot = 0
h_dot = 0
i_dot = 0
j_dot = 0
k_dot = 0
l_dot = 0
y_dot = 0
[outputs]
place = 'C.y'
speed = { rate = 'I.x' }
acceleration = { second_rate = 'sqrt(B.x^2 + I.y^2)' }
power = { power = 'spring' }
[run]
step = 1e-3
end_time = 1
";

fn read(text: &str) -> Scene {
    let (scene, _) = resolve::read("made.toml", text).unwrap_or_else(|report| panic!("{report}"));
    scene
}

/// The chain with a massless link, whose coordinates have no pivots of their own, and a spring between two links.
fn without_inertia(chain: &str) -> String {
    let massless = |line: &str| line.starts_with("link3 = ");
    let kept = chain.lines().filter(|line| !massless(line)).collect::<Vec<_>>().join("\n");
    let spring = "[loads]\nspring = { along = 'hypot(x5 - x1, y5 - y1 + 1)', spring = 40, rest = 0.2 }";
    kept.replacen("[loads]", spring, 1)
}

fn operations(tape: &NamedTape, function: &str) -> usize {
    let function = tape.function(function).unwrap_or_else(|| panic!("no function `{function}`"));
    tape.operations(function).sum()
}

/// Compares products of the mass matrix of a large tree with its momenta, and with its kinetic energy.
fn mass_matrix_follows_from_momenta(tape: &Tape) {
    let n = tape.coordinates as usize;
    let mut evaluator = TapeEvaluator::<Vec<f64>>::new(tape);
    let [q, qd] = [0.7, 1.3].map(|by| (0..n).map(|i| (by * (i + 1) as f64).sin()).collect::<Vec<f64>>());
    let (mut mass_matrix, mut momenta) = (vec![0.0; n * n], vec![0.0; n]);
    evaluator.mass_matrix(&q, &mut mass_matrix);
    assert!(evaluator.momenta(&q, &qd, &mut momenta), "no momenta");
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    for (row, momentum) in mass_matrix.chunks_exact(n).zip(&momenta) {
        assert!((dot(row, &qd) - momentum).abs() < 1e-12 * momentum.abs().max(1.0), "{row:?}: {momentum}");
    }
    let [kinetic, _] = evaluator.energy(&q, &qd);
    assert!((dot(&momenta, &qd) / 2.0 - kinetic).abs() < 1e-12 * kinetic, "{kinetic}");
    let mut dynamics = vec![0.0; tape.dynamics_length()];
    evaluator.dynamics(0.0, &q, &qd, &mut dynamics);
    assert_eq!(tape.split_dynamics(&dynamics)[0], mass_matrix);
}

/// The engine can be used once in a process, so one test contains all checks.
#[test]
fn formulae_grow_with_the_mechanism_and_not_with_their_expansion() {
    let stiff = |text: String| text.replace("[run]\n", "[run]\nstiff = true\n");
    let texts = [
        make::chain(6, make::Chain::Relative),
        make::chain(12, make::Chain::Relative),
        LOOP.to_owned(),
        stiff(make::chain(4, make::Chain::Relative)),
        make::chain(6, make::Chain::Relative),
        make::chain(7, make::Chain::Relative),
        make::chain(14, make::Chain::Relative),
        make::chain(28, make::Chain::Relative),
        make::chain(7, make::Chain::Angles),
        make::chain(14, make::Chain::Angles),
        make::chain(28, make::Chain::Angles),
        TREE.to_owned(),
        without_inertia(&make::chain(7, make::Chain::Absolute)),
    ];
    let scenes = texts.each_ref().map(|text| read(text));
    let equations = qrm_engine::derive(&scenes.each_ref(), &|_| ()).expect("the equations");
    let tapes: Vec<NamedTape> = (0..texts.len())
        .map(|i| {
            let tape = functions::tape(&scenes[i], &equations[i]).expect("a possible form");
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
    // The kernel of a tree has about as many operations for each of its links.
    for (scene, most) in [(5, 490), (6, 1060), (7, 2200), (8, 380), (9, 840), (10, 1750)] {
        let kernel = tapes[scene].solution.sum();
        assert!(kernel <= most, "scene {scene}: {kernel} operations, more than {most}");
    }
    // So has every other function of a large tree.
    for function in &tapes[7].functions {
        let [small, large] = [6, 7].map(|i| operations(&tapes[i], &function.name));
        assert!(10 * large <= 24 * small, "{}: {small} operations, twice as many links {large}", function.name);
    }
    mass_matrix_follows_from_momenta(&tapes[6].placed());
    for function in ["com_velocities", "momenta", "generalized_forces", "accelerations"] {
        let mut wrong = tapes[6].clone();
        wrong.set_number(function, 3, 0.5);
        let refused = verify::verify(&scenes[6], &equations[6], &wrong, &wrong.placed());
        let said = refused.expect_err("a wrong number").to_string();
        assert!(said.contains(&format!("generated `{function}` is wrong")), "{said}");
    }
    // The sparse elimination of twelve links has smaller rounding errors than the one of their mass matrix.
    let full =
        functions::tape_of_form(&scenes[1], &equations[1], Some(EliminationForm::NullSpace)).expect("a possible form");
    let [sparse, full] = [&tapes[1], &full].map(|tape| {
        let errors = verify::accuracy(&scenes[1], tape, 40).into_iter().map(|at| at.error);
        errors.fold(0.0, f64::max)
    });
    assert!(0.0 < sparse && 5.0 * sparse < full && full < 1e-11, "{sparse:e} and {full:e}");
    // The output for a scene does not depend on scenes derived earlier.
    let code =
        |i: usize| rust::text(&Code { path: "made.toml", scene: &scenes[i], source: &texts[i], tape: &tapes[i] });
    assert!(code(0) == code(4), "the same scene becomes other code");
}
