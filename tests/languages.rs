//! Motions in C, CUDA and MATLAB, compiled, or run by Octave: they show what `qrm run` writes.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::common;
use crate::common::chains::chain;
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

/// Prints the largest difference between accelerations by the kernel and by full matrices, relative to the largest
/// acceleration, then the coordinates at the start and after 100 steps.
const CHAIN_MAIN: &str = r#"
#include "relative_13.c"
#include <stdio.h>

static void print_row(double t, const double *q)
{
    printf("\n%.17g", t);
    for (int i = 0; i < N; i++) {
        printf(" %.17g", q[i]);
    }
}

int main(void)
{
    struct relative_13_parameters parameters;
    struct relative_13 mechanism;
    struct relative_13_step step;
    double x[N + M], largest = 0.0, difference = 0.0;
    relative_13_default_parameters(&parameters);
    relative_13_new(&parameters, &mechanism);
    if (!relative_13_initial_state(&mechanism, &step.end)) {
        return 1;
    }
    struct relative_13_state start = step.end;
    for (int i = 0; i < 100; i++) {
        relative_13_rk4_step(&mechanism, i * 1e-3, 1e-3, &step.end, &step);
    }
    plain_accelerations(&mechanism, 0.1, step.end.q, step.end.qd, x);
    for (int i = 0; i < N; i++) {
        largest = fmax(largest, fabs(x[i]));
        difference = fmax(difference, fabs(x[i] - step.end.qdd[i]));
    }
    printf("%.17g", difference / largest);
    print_row(0.0, start.q);
    print_row(0.1, step.end.q);
    return 0;
}
"#;

#[test]
#[ignore = "full tier: engine"]
fn large_trees_have_the_same_motion_in_c() {
    let (_scenes, scene) = chain();
    let folder = code(&scene, "c");
    fs::write(folder.path().join("main.c"), CHAIN_MAIN).expect("written");
    let wanted = run(&[&scene, "--end-time", "0.1", "--every", "100"]).trajectory();
    let names: Vec<String> = std::iter::once("t".to_owned()).chain((0..13).map(|i| format!("a{i}"))).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for compiler in ["gcc", "clang"] {
        let options = ["-std=c99", "-O1", "-pedantic", "-o", "motion", "main.c", "-lm"];
        compile(compiler, &options, folder.path());
        let output = Command::new(folder.path().join("motion")).output().expect("it starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let (difference, rows) = text.split_once('\n').expect("two lines");
        assert!(difference.parse::<f64>().expect("a number") < 1e-12, "{compiler}: {difference}");
        compare(&rows_of(rows), &wanted, &names);
    }
}

/// The accelerations by the kernel and by full matrices.
const CHAIN: &str = "
p = relative_13_parameters();
state = relative_13_initial_state(p);
[mass_matrix, forces, jacobian, bias] = relative_13_dynamics(0, state.q, state.qd, p);
rows = [state.qdd, mass_matrix \\ forces, mass_matrix(:, 1) - mass_matrix(1, :).'];
";

#[test]
#[ignore = "full tier: engine"]
fn large_trees_have_full_matrices_in_matlab() {
    let (_scenes, scene) = chain();
    for row in rows(&scene, CHAIN) {
        assert!((row[0] - row[1]).abs() < 1e-9 * row[0].abs().max(1.0) && row[2].abs() < 1e-14, "{row:?}");
    }
}

/// Prints a motion of the quick-return by steps of both methods.
const CUDA_MAIN: &str = r#"
#include "quick_return.cuh"
#include <stdio.h>

int main()
{
    struct quick_return_parameters parameters;
    struct quick_return mechanism;
    struct quick_return_step step;
    quick_return_default_parameters(&parameters);
    quick_return_new(&parameters, &mechanism);
    if (!quick_return_initial_state(&mechanism, &step.end)) {
        return 1;
    }
    for (int i = 0; i <= 100; i++) {
        printf("%.17g %.17g %.17g %.17g\n", i * 1e-3, step.end.q[0], step.end.q[1], step.end.q[2]);
        if (i % 2) {
            quick_return_rk4_step(&mechanism, i * 1e-3, 1e-3, &step.end, &step);
        } else {
            quick_return_dop853_step(&mechanism, i * 1e-3, 1e-3, 1e-9, &step.end, &step);
        }
    }
    return 0;
}
"#;

/// A kernel whose parameters come from the host.
const KERNEL: &str = r#"
#include "quick_return.cuh"

__global__ void run(const quick_return_parameters *p, quick_return_state *end, int count)
{
    const int i = blockIdx.x * blockDim.x + threadIdx.x;
    quick_return mechanism;
    quick_return_step step;
    if (i < count) {
        quick_return_new(&p[i], &mechanism);
        quick_return_initial_state(&mechanism, &step.end);
        quick_return_rk4_step(&mechanism, 0.0, 1e-3, &step.end, &step);
        end[i] = step.end;
    }
}

quick_return_parameters of_host()
{
    quick_return_parameters parameters;
    quick_return_default_parameters(&parameters);
    return parameters;
}
"#;

/// Without a device, the header is compiled as C++; where there is a compiler of CUDA, by that too.
#[test]
#[ignore = "full tier: languages"]
fn the_header_in_cuda_gives_the_motion() {
    let folder = code("quick-return", "cuda");
    fs::write(folder.path().join("main.cpp"), CUDA_MAIN).expect("written");
    let wanted = run(&["quick-return", "--step", "1e-3", "--end-time", "0.1"]).trajectory();
    for compiler in ["g++", "clang++"] {
        let options = ["-std=c++17", "-O1", "-Wno-unused-function", "-o", "motion", "main.cpp"];
        compile(compiler, &options, folder.path());
        let output = Command::new(folder.path().join("motion")).output().expect("it starts");
        compare(&rows_of(&String::from_utf8_lossy(&output.stdout)), &wanted, &["t", "phi2", "phi4", "phi5"]);
    }
    if Command::new("nvcc").arg("--version").output().is_ok_and(|output| output.status.success()) {
        fs::write(folder.path().join("kernel.cu"), KERNEL).expect("written");
        let options = ["-c", "kernel.cu", "-o", "kernel.o"];
        let output = Command::new("nvcc").args(options).current_dir(folder.path()).output().expect("nvcc");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
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
