//! Verification must find every wrong function. The equations of a pendulum on a spring are written here by hand, and
//! one sign is changed at a time.

use num_rational::BigRational;
use qrm_codegen::term::{Equations, KernelEquations, Linearization, Row, Symbol, Term};
use qrm_codegen::{functions, verify};
use qrm_language::{Code, rust};
use qrm_scene::function::Function;
use qrm_scene::resolve;

const SCENE: &str = r"
name = 'pendulum'
coordinates = [{ name = 'r', unit = 'm' }, 'phi']
[parameters]
m = 2
k = 100
cd = 3
[points]
P = ['r*cos(phi)', 'r*sin(phi)']
[bodies]
bob = { mass = 'm', com = 'P' }
[constraints]
rod = { residual = 'r*sin(phi) - 1', unit = 'm' }
[loads]
spring = { along = 'r', spring = 'k', damper = 'cd' }
[initial]
given = { phi = 1, phi_dot = 0 }
solve = { r = 1 }
[outputs]
height = 'P.y'
[run]
step = 1e-3
until = 'phi >= 2 + t'
max_time = 10
stiff = true
";

fn number(value: i32) -> Term {
    Term::Number(BigRational::from_integer(value.into()))
}

fn product(factors: &[Term]) -> Term {
    Term::Product(factors.to_vec())
}

fn sum(terms: &[Term]) -> Term {
    Term::Sum(terms.to_vec())
}

/// The derivatives of the pendulum's equations, with accelerations and multiplier held constant.
fn linearization() -> Linearization {
    let symbol = Term::Symbol;
    let [m, k, cd] = [0, 1, 2].map(|i| symbol(Symbol::Parameter(i)));
    let [r, phi] = [0, 1].map(|i| symbol(Symbol::Coordinate(i)));
    let [v, w] = [0, 1].map(|i| symbol(Symbol::Rate(i)));
    let [a, b] = [0, 1].map(|i| symbol(Symbol::Acceleration(i)));
    let lambda = symbol(Symbol::Multiplier(0));
    let sin = Term::Call(Function::Sin, Box::new(phi.clone()));
    let cos = Term::Call(Function::Cos, Box::new(phi));
    let times = |n: i32, factors: &[&Term]| {
        let factors: Vec<Term> = factors.iter().map(|factor| (*factor).clone()).collect();
        product(&[&[number(n)], &factors[..]].concat())
    };
    Linearization {
        stiffness: vec![
            vec![sum(&[times(-1, &[&m, &w, &w]), k]), times(1, &[&lambda, &cos])],
            vec![
                sum(&[times(2, &[&m, &r, &b]), times(1, &[&lambda, &cos]), times(2, &[&m, &v, &w])]),
                times(-1, &[&lambda, &r, &sin]),
            ],
        ],
        damping: vec![vec![cd, times(-2, &[&m, &r, &w])], vec![times(2, &[&m, &r, &w]), times(2, &[&m, &r, &v])]],
        constraint_stiffness: vec![vec![
            sum(&[times(1, &[&cos, &b]), times(-1, &[&w, &w, &sin])]),
            sum(&[
                times(1, &[&cos, &a]),
                times(-1, &[&r, &sin, &b]),
                times(-2, &[&v, &w, &sin]),
                times(-1, &[&r, &w, &w, &cos]),
            ]),
        ]],
        constraint_damping: vec![vec![
            times(2, &[&w, &cos]),
            sum(&[times(2, &[&v, &cos]), times(-2, &[&r, &w, &sin])]),
        ]],
        forcing: vec![Term::zero(), Term::zero()],
        constraint_forcing: vec![Term::zero()],
    }
}

/// The equations as the engine would derive them.
fn equations() -> Equations {
    let symbol = Term::Symbol;
    let (m, k, cd) = (symbol(Symbol::Parameter(0)), symbol(Symbol::Parameter(1)), symbol(Symbol::Parameter(2)));
    let (r, phi) = (symbol(Symbol::Coordinate(0)), symbol(Symbol::Coordinate(1)));
    let (v, w) = (symbol(Symbol::Rate(0)), symbol(Symbol::Rate(1)));
    let sin = Term::Call(Function::Sin, Box::new(phi.clone()));
    let cos = Term::Call(Function::Cos, Box::new(phi));
    let minus = |factors: &[Term]| product(&[&[number(-1)], factors].concat());
    let squared = |t: &Term| Term::Power(Box::new(t.clone()), BigRational::from_integer(2.into()));
    let half = Term::Number(BigRational::new(1.into(), 2.into()));
    let x = [product(&[r.clone(), cos.clone()]), product(&[r.clone(), sin.clone()])];
    let gradients =
        [vec![cos.clone(), minus(&[r.clone(), sin.clone()])], vec![sin.clone(), product(&[r.clone(), cos.clone()])]];
    let bias = [
        sum(&[
            product(&[number(-2), v.clone(), w.clone(), sin.clone()]),
            minus(&[r.clone(), squared(&w), cos.clone()]),
        ]),
        sum(&[product(&[number(2), v.clone(), w.clone(), cos]), minus(&[r.clone(), squared(&w), sin])]),
    ];
    let inertia = product(&[m.clone(), squared(&r)]);
    let mut equations = Equations {
        rows: [0, 1].map(|axis| Row { body: 0, axis, inertia: m.clone() }).into(),
        com_positions: x.to_vec(),
        com_jacobian: gradients.to_vec(),
        com_bias: bias.to_vec(),
        constraints: vec![sum(&[x[1].clone(), number(-1)])],
        constraint_jacobian: vec![gradients[1].clone()],
        constraint_hessians: vec![vec![
            vec![Term::zero(), gradients[0][0].clone()],
            vec![gradients[0][0].clone(), minus(&[x[1].clone()])],
        ]],
        constraint_rate: vec![Term::zero()],
        constraint_bias: vec![bias[1].clone()],
        mass_matrix: vec![vec![m.clone(), Term::zero()], vec![Term::zero(), inertia.clone()]],
        generalized_forces: vec![
            sum(&[
                product(&[m.clone(), r.clone(), squared(&w)]),
                minus(&[k.clone(), r.clone()]),
                minus(&[cd.clone(), v.clone()]),
            ]),
            product(&[number(-2), m.clone(), r.clone(), v.clone(), w.clone()]),
        ],
        energy: vec![
            sum(&[product(&[half.clone(), m, squared(&v)]), product(&[half.clone(), inertia, squared(&w)])]),
            product(&[half, k, squared(&r)]),
        ],
        power: vec![minus(&[cd, squared(&v)])],
        outputs: vec![x[1].clone()],
        linearization: Some(linearization()),
        points: vec![x],
        ..Equations::default()
    };
    equations.kernel = KernelEquations::without_roots(&equations);
    equations
}

fn check(equations: &Equations) -> Result<(), verify::Unverified> {
    check_in(SCENE, equations)
}

fn check_in(text: &str, equations: &Equations) -> Result<(), verify::Unverified> {
    let (scene, _) = resolve::read("pendulum.toml", text).expect("the scene is right");
    let tape = functions::tape(&scene, equations).expect("a possible form");
    verify::verify(&scene, equations, &tape, &tape.placed())
}

/// The scene in several sizes: unchanged, with a steel rod, on a chip, and with both extremes.
fn scenes() -> [String; 4] {
    [("2", "100", "3"), ("2", "4e9", "3"), ("1e-12", "0.5", "2e-9"), ("1e-6", "1e12", "1e-3")].map(|(m, k, cd)| {
        let text = SCENE.replace("m = 2\n", &format!("m = {m}\n")).replace("k = 100\n", &format!("k = {k}\n"));
        text.replace("cd = 3\n", &format!("cd = {cd}\n"))
    })
}

#[test]
fn right_equations_pass() {
    for text in scenes() {
        assert_eq!(check_in(&text, &equations()), Ok(()), "{text}");
    }
}

#[test]
fn one_wrong_sign_is_found_wherever_it_is() {
    type Spoil = fn(&mut Equations) -> &mut Term;
    let places: [(&str, Spoil); 25] = [
        ("com_positions", |e| &mut e.com_positions[1]),
        ("com_jacobian", |e| &mut e.com_jacobian[0][1]),
        ("com_jacobian", |e| &mut e.com_jacobian[1][0]),
        ("com_bias", |e| &mut e.com_bias[1]),
        ("constraints", |e| &mut e.constraints[0]),
        ("constraint_jacobian", |e| &mut e.constraint_jacobian[0][0]),
        ("constraint_bias", |e| &mut e.constraint_bias[0]),
        ("C_qq", |e| &mut e.constraint_hessians[0][1][1]),
        ("mass_matrix", |e| &mut e.mass_matrix[1][1]),
        ("generalized_forces", |e| &mut e.generalized_forces[0]),
        ("generalized_forces", |e| &mut e.generalized_forces[1]),
        ("energy", |e| &mut e.energy[0]),
        ("energy", |e| &mut e.energy[1]),
        ("power", |e| &mut e.power[0]),
        ("outputs", |e| &mut e.outputs[0]),
        ("residuals", |e| &mut e.kernel.constraints[0]),
        ("velocity_residual", |e| &mut e.kernel.constraint_jacobian[0][0]),
        ("accelerations", |e| &mut e.kernel.constraint_bias[0]),
        ("accelerations", |e| &mut e.kernel.mass_matrix[1][1]),
        ("accelerations", |e| &mut e.kernel.effort_groups[0].total[0]),
        ("linearization", |e| &mut e.linearization.as_mut().expect("derivatives").stiffness[0][0]),
        ("linearization", |e| &mut e.linearization.as_mut().expect("derivatives").stiffness[1][0]),
        ("linearization", |e| &mut e.linearization.as_mut().expect("derivatives").damping[0][1]),
        ("linearization", |e| &mut e.linearization.as_mut().expect("derivatives").constraint_stiffness[0][1]),
        ("linearization", |e| &mut e.linearization.as_mut().expect("derivatives").constraint_damping[0][1]),
    ];
    for (text, (name, place)) in scenes().iter().flat_map(|text| places.map(|spoil| (text, spoil))) {
        let mut wrong = equations();
        let term = place(&mut wrong);
        *term = product(&[number(-1), term.clone()]);
        let said = check_in(text, &wrong).expect_err(name).to_string();
        // A Jacobian occurs in several functions; the first one with the error is named.
        assert!(said.contains("is wrong: "), "{name}: {said}");
        assert!(
            said.contains(name) || said.contains("dynamics") || said.contains("loop_constraints"),
            "{name}: {said}"
        );
    }
}

#[test]
fn a_wrong_sign_of_a_small_term_is_found_beside_large_ones() {
    for text in &scenes()[..3] {
        for (place, factor) in [(0, -1), (0, 2), (2, -1), (2, 2)] {
            let mut wrong = equations();
            let Term::Sum(terms) = &mut wrong.generalized_forces[0] else { panic!("not a sum") };
            // The centrifugal force, or the damper, acts together with the spring.
            terms[place] = product(&[number(factor), terms[place].clone()]);
            assert!(check_in(text, &wrong).is_err(), "term {place} times {factor}\n{text}");
            let mut wrong = equations();
            let linearization = wrong.linearization.as_mut().expect("derivatives");
            let Term::Sum(terms) = &mut linearization.stiffness[0][0] else { panic!("not a sum") };
            terms[0] = product(&[number(factor), terms[0].clone()]);
            assert!(check_in(text, &wrong).is_err(), "stiffness times {factor}\n{text}");
        }
    }
}

#[test]
fn a_small_error_is_found_too() {
    let mut wrong = equations();
    let nearly_one = Term::Number(BigRational::new(1_000_000_100.into(), 1_000_000_000.into()));
    wrong.mass_matrix[1][1] = product(&[nearly_one, wrong.mass_matrix[1][1].clone()]);
    assert!(check(&wrong).is_err());
}

#[test]
fn a_wrong_tape_is_found() {
    let mut wrong = equations();
    wrong.power[0] = product(&[number(2), wrong.power[0].clone()]);
    let (scene, _) = resolve::read("pendulum.toml", SCENE).expect("the scene is right");
    let [right, wrong] =
        [equations(), wrong].map(|equations| functions::tape(&scene, &equations).expect("a possible form"));
    let said = verify::verify(&scene, &equations(), &right, &wrong.placed()).expect_err("a wrong tape").to_string();
    assert!(said.contains("generated tape of `power` is wrong"), "{said}");
}

#[test]
fn changed_text_is_found() {
    // Here the text is changed instead of the equations: parentheses removed, operands exchanged, numbers changed.
    let (scene, _) = resolve::read("pendulum.toml", SCENE).expect("the scene is right");
    let equations = equations();
    let tape = functions::tape(&scene, &equations).expect("a possible form");
    let text = rust::text(&Code { path: "pendulum.toml", scene: &scene, source: SCENE, tape: &tape });
    assert_eq!(rust::check(&tape, &text), Ok(()));
    for (right, wrong) in [
        ("q: [R::from_number(1.0), R::from_number(1.0)]", "q: [R::from_number(1.0), R::from_number(1.5)]"),
        ("step: R::from_number(0.001)", "step: R::from_number(0.01)"),
        ("unwrap_or(R::from_number(100.0))", "unwrap_or(R::from_number(10.0))"),
        ("phi - (R::from_number(2.0) + t)", "phi - R::from_number(2.0) + t"),
    ] {
        assert!(text.contains(right), "{right} is not in\n{text}");
        assert!(rust::check(&tape, &text.replace(right, wrong)).is_err(), "{wrong}");
    }
}

#[test]
fn a_scene_without_value_at_almost_any_state_is_refused() {
    // The output has a value only in a strip of width 1/1000.
    let text = SCENE.replace("height = 'P.y'", "height = 'P.y'\nroot = 'sqrt(1e-6 - (r - 1.3)^2)'");
    let r = || {
        Box::new(sum(&[Term::Symbol(Symbol::Coordinate(0)), Term::Number(BigRational::new((-13).into(), 10.into()))]))
    };
    let strip = sum(&[
        Term::Number(BigRational::new(1.into(), 1_000_000.into())),
        product(&[number(-1), (*r()).clone(), (*r()).clone()]),
    ]);
    let mut equations = equations();
    equations.outputs.push(Term::Call(Function::Sqrt, Box::new(strip)));
    let refused = check_in(&text, &equations);
    assert!(
        matches!(&refused, Err(verify::Unverified::NoDomain(text)) if text.contains("random states")),
        "{refused:?}"
    );
}
