//! Motions in C and MATLAB, compiled and run by Octave: they show what `qrm run` writes.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::common;
use crate::common::{Table, qrm, run};

/// The largest difference, relative to the largest number of a column or to 1.
const TOLERANCE: f64 = 1e-10;
/// The longest that the script may take.
const LONGEST: Duration = Duration::from_secs(60);

/// Runs the script without windows: the columns of the motion and the curves of the figures.
const DRIVER: &str = "
set(0, 'defaultfigurevisible', 'off');
run('SCRIPT');
rows = [motion.t, motion.q, motion.qd, motion.qdd, motion.multipliers];
for number = 6:11
    curves = flipud(findobj(get(number, 'CurrentAxes'), 'Type', 'line'));
    for i = 1:numel(curves)
        if ~isequal(get(curves(i), 'XData')(:), motion.t)
            error('figure %d has another abscissa', number);
        end
        rows = [rows, get(curves(i), 'YData')(:)];
    end
end
";
/// Simulates the motion of the four-bar.
const FOUR_BAR: &str = "
motion = four_bar_motion();
rows = [motion.t, motion.q];
";
/// Writes the rows.
const WRITE: &str = "
file = fopen('rows.txt', 'w');
fprintf(file, [repmat('%.17g ', 1, columns(rows)), '\\n'], rows.');
fclose(file);
";

/// The columns in the order of the driver.
const COLUMNS: [&str; 21] = [
    "t",
    "phi2",
    "phi4",
    "phi5",
    "phi2_dot",
    "phi4_dot",
    "phi5_dot",
    "phi2_ddot",
    "phi4_ddot",
    "phi5_ddot",
    "lambda_slot",
    "lambda_guide",
    // The figures.
    "phi2_dot",
    "phi4_dot",
    "phi5_dot",
    "x6",
    "x6_dot",
    "x6_ddot",
    "v_slide",
    "N3",
    "N6",
];

#[test]
#[ignore = "full tier: languages"]
fn figures_in_matlab_show_the_run() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/matlab/quick_return_figures.m");
    let begun = Instant::now();
    let rows = rows("quick-return", &DRIVER.replace("SCRIPT", &script.to_string_lossy()));
    assert!(begun.elapsed() < LONGEST, "{:?}", begun.elapsed());
    compare(&rows, &run(&["quick-return"]).trajectory(), &COLUMNS);
}

/// The rods of this four-bar come to lie in one line, where the kernel does not suit.
#[test]
#[ignore = "full tier: languages"]
fn motions_in_matlab_go_on_where_the_kernel_does_not_suit() {
    let rows = rows("four-bar", FOUR_BAR);
    let coordinates = &common::model("four-bar").description.coordinates;
    let names: Vec<&str> = coordinates.iter().map(|coordinate| coordinate.name).collect();
    compare(&rows, &run(&["four-bar"]).trajectory(), &[&["t"], &names[..]].concat());
}

/// A scene whose names are words, macros or arguments somewhere in generated code.
const NAMES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/functions/names.toml");
const NAMES_COORDINATES: [&str; 4] = ["angles", "position", "residuals", "FP_NAN"];

#[test]
#[ignore = "full tier: engine"]
fn names_that_mean_something_in_matlab_are_changed() {
    let script = "motion = names_motion(names_parameters(struct('replace', 0.6)));\nrows = [motion.t, motion.q];\n";
    let rows = rows(NAMES, script);
    let wanted = run(&[NAMES, "--set", "replace=0.6"]).trajectory();
    compare(&rows, &wanted, &[&["t"], &NAMES_COORDINATES[..]].concat());
}

/// Prints the motion of the scene above.
const NAMES_MAIN: &str = r#"
#include "names.h"
#include <math.h>
#include <stdio.h>

int main(void)
{
    struct names_parameters replace, parameters;
    struct names mechanism;
    struct names_step step;
    names_default_parameters(&replace);
    replace.replace = 0.6;
    replace.unknown = NAN;
    names_parameters_with(&replace, &parameters);
    names_new(&parameters, &mechanism);
    if (!names_initial_state(&mechanism, &step.end)) {
        return 1;
    }
    for (int i = 0; i <= 1000; i++) {
        printf("%.17g", i * 1e-3);
        for (int k = 0; k < 4; k++) {
            printf(" %.17g", step.end.q[k]);
        }
        printf("\n");
        names_rk4_step(&mechanism, i * 1e-3, 1e-3, &step.end, &step);
    }
    return 0;
}
"#;

#[test]
#[ignore = "full tier: engine"]
fn names_that_mean_something_in_c_are_changed() {
    let folder = code(NAMES, "c");
    fs::write(folder.path().join("main.c"), NAMES_MAIN).expect("written");
    // The header is for C++ too.
    compile("g++", &["-std=c++20", "-fsyntax-only", "-x", "c++", "main.c"], folder.path());
    let wanted = run(&[NAMES, "--set", "replace=0.6"]).trajectory();
    for compiler in ["gcc", "clang"] {
        let rows = rows_of(&output_of(compiler, "names", folder.path()));
        compare(&rows, &wanted, &[&["t"], &NAMES_COORDINATES[..]].concat());
    }
}

/// Prints whether a mechanism with constraints that repeat others starts, whether its step is good, and what is known.
const LIFT_MAIN: &str = r#"
#include "scissor_lift.h"
#include <math.h>
#include <stdio.h>

int main(void)
{
    struct scissor_lift_parameters parameters;
    struct scissor_lift mechanism;
    struct scissor_lift_step step;
    scissor_lift_default_parameters(&parameters);
    scissor_lift_new(&parameters, &mechanism);
    printf("%d", scissor_lift_initial_state(&mechanism, &step.end));
    scissor_lift_rk4_step(&mechanism, 0.0, 1e-3, &step.end, &step);
    printf(" %d %d", scissor_lift_is_good(&step, 1.0), scissor_lift_project(&mechanism, 1e-3, 1.0, &step.end));
    printf(" %d %d", isfinite(step.end.qdd[0]) != 0, isnan(step.end.multipliers[0]) != 0);
    return 0;
}
"#;

#[test]
#[ignore = "full tier: engine"]
fn constraints_that_repeat_others_are_told_in_c() {
    let folder = code(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/linkages/scissor-lift.toml"), "c");
    fs::write(folder.path().join("main.c"), LIFT_MAIN).expect("written");
    for compiler in ["gcc", "clang"] {
        assert_eq!(output_of(compiler, "scissor_lift", folder.path()), "0 0 0 1 1");
    }
}

/// Compiles files of C in a folder.
fn compile(compiler: &str, arguments: &[&str], folder: &Path) {
    let warnings = ["-Wall", "-Wextra", "-Werror"];
    let output = Command::new(compiler).args(warnings).args(arguments).current_dir(folder).output().expect(compiler);
    assert!(output.status.success(), "{compiler}: {}", String::from_utf8_lossy(&output.stderr));
}

/// The output of `main.c` in a folder, compiled with the code of a scene.
fn output_of(compiler: &str, scene: &str, folder: &Path) -> String {
    let source = format!("{scene}.c");
    let arguments = ["-std=c99", "-O1", "-pedantic", "-o", "motion", "main.c", &source, "-lm"];
    compile(compiler, &arguments, folder);
    let output = Command::new(folder.join("motion")).output().expect("it starts");
    assert!(output.status.success());
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A folder with the code of a scene.
fn code(scene: &str, language: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let arguments = ["code", scene, "--language", language, "--out"];
    let output = qrm(&arguments).arg(folder.path()).output().expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    folder
}

/// The numbers in each line.
fn rows_of(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| line.split_whitespace().map(|number| number.parse().expect("a number")).collect();
    text.lines().map(row).collect()
}

/// The rows that a script writes into `rows.txt`, with the functions of a scene.
fn rows(scene: &str, script: &str) -> Vec<Vec<f64>> {
    let folder = code(scene, "matlab");
    fs::write(folder.path().join("driver.m"), script.to_owned() + WRITE).expect("written");
    let mut octave = Command::new("octave-cli");
    octave.args(["--quiet", "--norc", "--path"]).arg(folder.path()).arg("driver.m").current_dir(folder.path());
    let output = octave.output().expect("octave-cli");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    rows_of(&fs::read_to_string(folder.path().join("rows.txt")).expect("rows"))
}

/// Compares rows with the columns of a trajectory.
fn compare(given: &[Vec<f64>], trajectory: &Table, columns: &[&str]) {
    assert_eq!(given.len(), trajectory.rows.len(), "rows");
    for (i, name) in columns.iter().enumerate() {
        let column: Vec<f64> = (0..given.len()).map(|row| trajectory.number(row, name)).collect();
        let largest = column.iter().fold(1.0, |largest: f64, number| largest.max(number.abs()));
        for (row, wanted) in given.iter().zip(&column) {
            let difference = (row[i] - wanted).abs() / largest;
            assert!(difference <= TOLERANCE, "{name} at {} s: {} is not {wanted}", row[0], row[i]);
        }
    }
}
