//! Steps of golden mechanisms in C, compared with those in Rust.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use qrm_codegen::language;
use qrm_core::{Equations, KernelState, rk4_step};

macro_rules! golden {
    ($($name:ident),*) => {
        $(
            #[allow(dead_code, missing_docs, non_snake_case, unreachable_pub)]
            mod $name {
                include!(concat!(env!("CARGO_MANIFEST_DIR"), "/../qrm-model/golden/", stringify!($name), ".rs"));
            }
        )*
    };
}

golden!(double_pendulum, pendulum, quick_return_driven, shaper);

/// Steps of each motion.
const STEPS: usize = 200;
/// The largest difference, relative to the largest number of its kind: sines and cosines of stages are computed anew in
/// C, and follow turns in Rust.
const TOLERANCE: f64 = 1e-12;

#[test]
fn steps_in_c_agree_with_those_in_rust() {
    let Some(compiler) = ["gcc", "clang"].into_iter().find(|name| Command::new(name).arg("--version").output().is_ok())
    else {
        eprintln!("skipped: there is neither `gcc` nor `clang`");
        return;
    };
    compare::<double_pendulum::DoublePendulum, 2, 0>(compiler, "double_pendulum");
    compare::<pendulum::Pendulum, 2, 1>(compiler, "pendulum");
    compare::<quick_return_driven::QuickReturnDriven, 3, 3>(compiler, "quick_return_driven");
    compare::<shaper::Shaper, 3, 2>(compiler, "shaper");
}

/// Makes the steps of a motion in both languages.
fn compare<K: Equations<f64, N, M> + Default, const N: usize, const M: usize>(compiler: &str, name: &str) {
    let kernel = K::default();
    let rows = rows(compiler, name);
    assert_eq!(rows.len(), STEPS + 1, "{name}: rows");
    let step = kernel.schedule().step;
    let numbers = |row: &[f64]| row[..N].try_into().expect("coordinates");
    let mut state = KernelState::new(&kernel, 0.0, numbers(&rows[0]), numbers(&rows[0][N..]));
    for (i, row) in rows[1..].iter().enumerate() {
        let made = rk4_step(&kernel, i as f64 * step, step, &state);
        assert!(made.is_good(1e-12), "{name}: step {i}");
        state = made.end;
        let parts: [&[f64]; 4] = [&state.q, &state.qd, &state.qdd, &state.multipliers];
        let mut rest = &row[..];
        for part in parts {
            let largest = part.iter().fold(1.0, |largest: f64, number| largest.max(number.abs()));
            let (given, others) = rest.split_at(part.len());
            for (wanted, given) in part.iter().zip(given) {
                assert!((wanted - given).abs() <= TOLERANCE * largest, "{name}: step {i}: {given:e}, not {wanted:e}");
            }
            rest = others;
        }
    }
}

/// The states of a motion in C: coordinates, rates, accelerations, multipliers.
fn rows(compiler: &str, name: &str) -> Vec<Vec<f64>> {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../qrm-model/golden/{name}.rs"));
    let module = language::syntax(&fs::read_to_string(golden).expect("a module")).expect("Rust");
    let code = language::c(name, &module).expect("a translation");
    let folder = std::env::temp_dir().join(format!("qrm-steps-{}-{name}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let write = |file: String, text: &str| -> PathBuf {
        let path = folder.join(file);
        fs::write(&path, text).expect("a file");
        path
    };
    write(format!("{name}.h"), &code.header);
    let main = MAIN.replace("scene", name).replace("SCENE", &name.to_uppercase()).replace("STEPS", &STEPS.to_string());
    let sources = [write(format!("{name}.c"), &code.source), write("main.c".to_owned(), &main)];
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

/// Closes the loops from the start of the scene, and prints the states of a motion.
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
    int given[SCENE_COORDINATES], given_rates[SCENE_COORDINATES];
    double h, end_time;
    scene_default_parameters(&p);
    scene_new(&p, &m);
    scene_start(&m, step.end.q, given, step.end.qd, given_rates);
    scene_schedule(&m, &h, &end_time);
    int tries = 0;
    while (!scene_project(&m, 0.0, 1e-12, &step.end)) {
        if (++tries == 10 || !scene_project(&m, 0.0, 1.0, &step.end)) {
            return 1;
        }
    }
    print_state(&step.end);
    for (int i = 0; i < STEPS; i++) {
        scene_rk4_step(&m, i * h, h, &step.end, &step);
        if (!scene_is_good(&step, 1e-12)) {
            return 2;
        }
        print_state(&step.end);
    }
    return 0;
}
"#;
