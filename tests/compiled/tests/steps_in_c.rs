//! Steps of golden mechanisms in C, compared with those in Rust.

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use qrm_core::{Equations, Generated, Kernel, KernelState, Model, rk4_step};
use qrm_language::Code;
use qrm_model::{double_pendulum, four_bar, n_four_bar_2, pendulum, quick_return, quick_return_driven, shaper};
use qrm_scene::resolve;
use qrm_sim::run::{End, Request, simulate};

/// The largest difference, relative to the largest number of its kind: sines and cosines of stages are computed anew in
/// C, and follow turns in Rust.
const TOLERANCE: f64 = 1e-12;

const COMPILERS: [&str; 2] = ["gcc", "clang"];

#[test]
fn steps_of_order_4_agree_with_those_in_rust() {
    for compiler in COMPILERS {
        order_4::<double_pendulum::DoublePendulum, 2, 0>(compiler, "double_pendulum", 200);
        order_4::<pendulum::Pendulum, 2, 1>(compiler, "pendulum", 200);
        // Two revolutions.
        order_4::<quick_return::QuickReturn, 3, 2>(compiler, "quick_return", 1756);
        order_4::<quick_return_driven::QuickReturnDriven, 3, 3>(compiler, "quick_return_driven", 1756);
        order_4::<shaper::Shaper, 3, 2>(compiler, "shaper", 200);
    }
}

#[test]
fn steps_of_order_8_agree_with_many_short_ones() {
    for compiler in COMPILERS {
        order_8::<double_pendulum::DoublePendulum, 2, 0>(compiler, "double_pendulum");
        order_8::<pendulum::Pendulum, 2, 1>(compiler, "pendulum");
        order_8::<quick_return_driven::QuickReturnDriven, 3, 3>(compiler, "quick_return_driven");
    }
}

#[test]
fn motions_go_on_where_the_kernel_does_not_suit() {
    for compiler in COMPILERS {
        through::<four_bar::FourBar, 3, 2>(compiler, "four_bar", 2000);
        through::<n_four_bar_2::NFourBar2, 5, 4>(compiler, "n_four_bar_2", 2000);
        through::<pendulum::Pendulum, 2, 1>(compiler, "pendulum", 2000);
    }
}

/// Compares the end of a motion with that of a run, which makes some steps by the plain functions.
fn through<K: Generated<N, M> + Kernel<f64, N, M> + Default, const N: usize, const M: usize>(
    compiler: &str,
    name: &str,
    steps: usize,
) {
    let rows = rows(compiler, name, &MOTION.replace("STEPS", &steps.to_string()));
    let model = Model::from_generated::<K, N, M>();
    let mechanism = model.mechanism(&|_| None);
    let end = mechanism.schedule().step * steps as f64;
    let request = Request { end: Some(End::Time(end)), ..Request::default() };
    let outcome = simulate(&*mechanism, &request, &mut ()).expect("a run");
    assert_eq!(outcome.end_time, end, "{name}");
    let kernel = K::default();
    let suits = |row: &Vec<f64>| {
        let numbers = |from: usize| row[from..from + N].try_into().expect("a row");
        rk4_step(&kernel, 0.0, 1e-3, &KernelState::new(&kernel, 0.0, numbers(0), numbers(N))).is_good(1e-12)
    };
    assert!(!rows.iter().all(suits), "{name}: the kernel suits everywhere");
    let numbers = outcome.q.iter().chain(&outcome.qd);
    for (wanted, given) in numbers.zip(&rows[steps]) {
        assert!((wanted - given).abs() <= 1e-10 * wanted.abs().max(1.0), "{name}: {given:e}, not {wanted:e}");
    }
}

/// Makes the steps of a motion in both languages.
fn order_4<K: Equations<f64, N, M> + Default, const N: usize, const M: usize>(
    compiler: &str,
    name: &str,
    steps: usize,
) {
    let kernel = K::default();
    let rows = rows(compiler, name, &MOTION.replace("STEPS", &steps.to_string()));
    assert_eq!(rows.len(), steps + 1, "{name}: rows");
    let step = kernel.schedule().step;
    let mut state = first(&kernel, &rows);
    for (i, row) in rows[1..].iter().enumerate() {
        let made = rk4_step(&kernel, i as f64 * step, step, &state);
        assert!(made.is_good(1e-12), "{name}: step {i}");
        state = made.end;
        agree(&format!("{name}: step {i}"), &state, row, TOLERANCE);
    }
}

/// Makes steps of order 8 in C, and many short ones of order 4 in Rust.
fn order_8<K: Equations<f64, N, M> + Default, const N: usize, const M: usize>(compiler: &str, name: &str) {
    let kernel = K::default();
    let rows = rows(compiler, name, LONG_STEPS);
    let mut errors = Vec::new();
    for row in &rows[1..] {
        let (&[h, error], row) = row.split_first_chunk().expect("a length and an error");
        let mut state = first(&kernel, &rows);
        let parts = 1000;
        let step = h / f64::from(parts);
        for i in 0..parts {
            state = rk4_step(&kernel, f64::from(i) * step, step, &state).end;
        }
        agree(&format!("{name}: step of {h} s"), &state, row, 1e-9);
        errors.push(error);
    }
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((128.0..1024.0).contains(&ratio), "{name}: errors {errors:?}");
    }
}

/// The state in the first row.
fn first<K: Equations<f64, N, M>, const N: usize, const M: usize>(
    kernel: &K,
    rows: &[Vec<f64>],
) -> KernelState<f64, N, M> {
    let numbers = |from: usize| rows[0][from..from + N].try_into().expect("a row");
    let (q, qd): ([f64; N], [f64; N]) = (numbers(0), numbers(N));
    // What the scene gives stays, and the loops are closed.
    let start = kernel.start();
    for i in 0..N {
        assert!(!start.given[i] || q[i] == start.q[i], "coordinate {i}: {}, not {}", q[i], start.q[i]);
        assert!(!start.given_rates[i] || qd[i] == start.qd[i], "rate {i}: {}, not {}", qd[i], start.qd[i]);
    }
    let loops = kernel.loop_constraints(0.0, &q);
    for k in 0..M {
        let rate = (0..N).map(|i| loops.constraint_jacobian[k][i] * qd[i]).sum::<f64>() + loops.constraint_rate[k];
        assert!(loops.residuals[k].abs() <= 1e-15 && rate.abs() <= 1e-14, "constraint {k} at the start: {rate:e}");
    }
    KernelState::new(kernel, 0.0, q, qd)
}

/// Compares a state with a row.
fn agree<const N: usize, const M: usize>(what: &str, state: &KernelState<f64, N, M>, row: &[f64], tolerance: f64) {
    let parts: [&[f64]; 4] = [&state.q, &state.qd, &state.qdd, &state.multipliers];
    let mut rest = row;
    for part in parts {
        let largest = part.iter().fold(1.0, |largest: f64, number| largest.max(number.abs()));
        let (given, others) = rest.split_at(part.len());
        for (wanted, given) in part.iter().zip(given) {
            assert!((wanted - given).abs() <= tolerance * largest, "{what}: {given:e}, not {wanted:e}");
        }
        rest = others;
    }
}

/// The states of a motion in C: coordinates, rates, accelerations, multipliers.
fn rows(compiler: &str, name: &str, motion: &str) -> Vec<Vec<f64>> {
    let module = |model: &&Model| model.description.name.replace('-', "_") == name;
    let model = qrm_model::MODELS.iter().find(module).expect("a scene");
    let source = model.description.source;
    let (scene, _) = resolve::read(name, source).unwrap_or_else(|report| panic!("{report}"));
    let code = Code { path: "", scene: &scene, source, tape: model.named_tape() };
    let files = qrm_language::c(&code.program()).expect("code");
    let folder =
        std::env::temp_dir().join(format!("qrm-steps-{}-{compiler}-{name}-{}", std::process::id(), motion.len()));
    fs::create_dir_all(&folder).expect("a folder");
    let write = |file: String, text: &str| -> PathBuf {
        let path = folder.join(file);
        fs::write(&path, text).expect("a file");
        path
    };
    for file in &files {
        write(file.name.clone(), &file.text);
    }
    let main = MAIN.replace("MOTION", motion).replace("scene", name).replace("SCENE", &name.to_uppercase());
    let sources = [folder.join(format!("{name}.c")), write("main.c".to_owned(), &main)];
    let program = folder.join("program");
    let flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2"];
    let output = Command::new(compiler).args(flags).args(sources).arg("-o").arg(&program).arg("-lm").output();
    let output = output.expect("a compiler");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(&program).output().expect("the program runs");
    assert!(output.status.success(), "{name}: {}", output.status);
    fs::remove_dir_all(&folder).expect("the folder can be removed");
    let row = |line: &str| line.split_whitespace().map(|number| number.parse().expect("a number")).collect();
    String::from_utf8(output.stdout).expect("text").lines().map(row).collect()
}

/// Prints the first state of the scene's motion, and those after it.
const MAIN: &str = r#"
#include "scene.h"

#include <stdio.h>

static void print(const double *numbers, int count)
{
    for (int i = 0; i < count; i++) {
        printf("%.17g ", numbers[i]);
    }
}

static void print_state(const struct scene_state *state)
{
    print(state->q, SCENE_COORDINATES);
    print(state->qd, SCENE_COORDINATES);
    print(state->qdd, SCENE_COORDINATES);
    print(state->multipliers, SCENE_CONSTRAINTS);
    printf("\n");
}

int main(void)
{
    struct scene_parameters p;
    struct scene m;
    struct scene_step step;
    double h, end_time;
    scene_default_parameters(&p);
    scene_new(&p, &m);
    scene_schedule(&m, &h, &end_time);
    if (!scene_initial_state(&m, &step.end)) {
        return 1;
    }
    print_state(&step.end);
MOTION    return 0;
}
"#;

/// Steps of order 4.
const MOTION: &str = r#"
    for (int i = 0; i < STEPS; i++) {
        scene_rk4_step(&m, i * h, h, &step.end, &step);
        if (!scene_is_good(&step, 1e-12)) {
            return 2;
        }
        print_state(&step.end);
    }
"#;

/// Steps of order 8 from the same state: their lengths, estimated errors, and ends.
const LONG_STEPS: &str = r#"
    for (double length = 0.08; length > 0.015; length /= 2.0) {
        struct scene_step end;
        double error = scene_dop853_step(&m, 0.0, length, 1e-6, &step.end, &end);
        if (h <= 0.0 || !scene_is_good(&end, 1e-12)) {
            return 2;
        }
        printf("%.17g %.17g ", length, error);
        print_state(&end.end);
    }
"#;
