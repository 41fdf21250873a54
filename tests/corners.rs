//! Corners and jumps of the equations of motion against closed forms: blocks under forces that switch.

use std::fmt::Write as _;
use std::fs;

use qrm_sim::integrate::METHODS;

use crate::common;
use crate::common::{Run, near, qrm, run};

/// A block of 1 kg that moves along a line by itself.
struct Block {
    force: &'static str,
    /// Position and velocity at the start.
    start: [f64; 2],
    end_time: f64,
}

impl Block {
    fn scene(&self) -> String {
        let Self { force, start: [x, v], end_time } = self;
        format!(
            r#"name = "block"
coordinates = [{{ name = "x", unit = "m" }}]
[parameters]
m = 1
[tables]
pulse = {{ x = [0.3, 0.50037, 0.500371, 0.500372, 0.7], y = [0, 0, 1e6, 0, 0] }}
brake = {{ x = [0, 1, 1.0001, 3], y = [0, 2, 4, 6] }}
[points]
P = ['x', '0']
[bodies]
b = {{ mass = 'm', com = "P" }}
[loads]
F = {{ force = ['{force}', '0'], on = "b" }}
[initial]
given = {{ x = {x}, x_dot = {v} }}
[run]
stiff = true
step = 1e-2
end_time = {end_time}
"#
        )
    }

    /// Runs it by `qrm run`.
    fn run(&self, arguments: &[&str]) -> Run {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("block.toml");
        fs::write(&path, self.scene()).expect("written");
        run(&[&[path.to_str().expect("a path"), "--no-figures"], arguments].concat())
    }

    /// Position and velocity at the end, by every method; a fixed step must agree within `by_steps`, the others within
    /// `by_tolerance`.
    #[track_caller]
    fn ends_at(&self, exact: [f64; 2], by_steps: f64, by_tolerance: f64) {
        for method in METHODS {
            let (arguments, allowed): (&[&str], _) = if method.is_adaptive() {
                (&["--method", method.name, "--tolerance", "1e-10"], by_tolerance)
            } else {
                (&["--method", method.name], by_steps)
            };
            let run = self.run(arguments);
            assert_eq!(run.status(), 0, "{}: {}", method.name, run.stderr());
            let table = run.trajectory();
            for (column, exact) in ["x", "x_dot"].into_iter().zip(exact) {
                let what = format!("{column} by {} under {}", method.name, self.force);
                near(&what, table.number(table.last(), column), exact, allowed);
            }
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn pulses_shorter_than_a_step_are_seen() {
    let start = [0.0; 2];
    // One microsecond, and two of half the height on average; steps have ten milliseconds.
    let rectangle = Block { force: "1e6*(sign(t - 0.50037) - sign(t - 0.500371))/2", start, end_time: 1.0 };
    rectangle.ends_at([1.0 - 0.5003705, 1.0], 1e-9, 1e-9);
    let triangle = Block { force: "1e6*max(0, 1 - abs(t - 0.50037)*1e6)", start, end_time: 1.0 };
    triangle.ends_at([1.0 - 0.50037, 1.0], 1e-9, 1e-9);
}

/// The value that `max` or `min` leaves out may be so large that the other one is less than its last digit.
#[test]
#[ignore = "full tier: engine"]
fn values_that_are_not_chosen_cost_no_digits() {
    let limited = Block { force: "-min(100*x, 1e17)", start: [0.0, 1.0], end_time: 1.0 };
    limited.ends_at([0.1 * 10.0_f64.sin(), 10.0_f64.cos()], 1e-5, 1e-9);
    let start = [0.0; 2];
    let triangle = Block { force: "1e12*max(0, 1e-6 - abs(t - 0.50037))", start, end_time: 1.0 };
    triangle.ends_at([1.0 - 0.50037, 1.0], 1e-9, 1e-9);
    let table = Block { force: "pulse(t)", start, end_time: 1.0 };
    table.ends_at([1.0 - 0.500371, 1.0], 1e-9, 1e-9);
    let parabola = Block { force: "0.75e18*max(0, 1e-12 - (t - 0.50037)^2)", start, end_time: 1.0 };
    let stop = Block { force: "-1e10*max(0, x - 0.50037)", start: [0.0, 1.0], end_time: 1.0 };
    // Half a period in contact.
    let thrown_back = 0.50037 - (1.0 - 0.50037 - 1e-5 * std::f64::consts::PI);
    for (block, exact) in [(parabola, [1.0 - 0.50037, 1.0]), (stop, [thrown_back, -1.0])] {
        let run = block.run(&["--method", "dop853", "--tolerance", "1e-10"]);
        assert_eq!(run.status(), 0, "{}", run.stderr());
        let table = run.trajectory();
        for (column, exact) in ["x", "x_dot"].into_iter().zip(exact) {
            near(&format!("{column} under {}", block.force), table.number(table.last(), column), exact, 1e-9);
        }
    }
}

/// The last stages of a step see the steep piece of the table while its end is before that.
#[test]
#[ignore = "full tier: engine"]
fn steep_corners_are_met_where_they_are() {
    let block = Block { force: "5 - brake(x_dot)", start: [0.0, 0.0], end_time: 1.5 };
    // Velocities relax towards the line of each piece: times of its ends, then the place at the end.
    let relaxed = |[x, v]: [f64; 2], [a, slope]: [f64; 2], t: f64| {
        let (decay, rest) = ((-slope * t).exp(), v + a / slope);
        [x + rest * t - a / slope * (1.0 - decay) / slope, rest - a / slope * decay]
    };
    let [steep, last] = [2.0 / (1.0001 - 1.0), 2.0 / (3.0 - 1.0001)];
    let times = [0.6_f64.ln() / -2.0, 3.0_f64.ln() / steep];
    let at_first = relaxed([0.0; 2], [5.0, 2.0], times[0]);
    let at_second = relaxed(at_first, [3.0, steep], times[1]);
    let exact = relaxed(at_second, [1.0, last], 1.5 - times[0] - times[1]);
    block.ends_at(exact, 1e-8, 1e-9);
}

/// An extreme at a corner is known as well as the time of the corner.
#[test]
#[ignore = "full tier: engine"]
fn peaks_of_short_pulses_have_the_error_of_their_time() {
    let triangle = Block { force: "1e6*max(0, 1 - abs(t - 0.50037)*1e6)", start: [0.0; 2], end_time: 1.0 };
    let run = triangle.run(&["--method", "dop853", "--tolerance", "1e-10"]);
    let [found, error] =
        ["max", "max_error"].map(|key| run.summary()["extremes"]["x_ddot"][key].as_f64().expect("a number"));
    assert!((1e6 - found).abs() <= 3.0 * error && error < 1e-2, "{found:?} with an error of {error:e}");
}

#[test]
#[ignore = "full tier: engine"]
fn two_jumps_in_one_step_are_met() {
    // The force does work along a micrometre.
    let band = Block { force: "1e5*(sign(x - 0.50037) - sign(x - 0.500371))/2", start: [0.0, 1.0], end_time: 1.0 };
    let v = 1.2_f64.sqrt();
    let left = 0.50037 + (v - 1.0) / 1e5;
    band.ends_at([0.500371 + v * (1.0 - left), v], 1e-9, 1e-9);
}

#[test]
#[ignore = "full tier: engine"]
fn a_stop_that_is_grazed_is_met() {
    // A throw that comes ten micrometres deep into a spring, and is there for two milliseconds.
    let (g, rate, v) = (9.81_f64, 1e3_f64, 4.4294692_f64);
    let at_stop = (v * v - 2.0 * g).sqrt();
    let leaves = (v - at_stop) / g + 2.0 / rate * (at_stop * rate / g).atan();
    let left = 0.9 - leaves;
    let graze = Block { force: "-9.81 - 1e6*max(0, x - 1)", start: [0.0, v], end_time: 0.9 };
    let exact = [1.0 - at_stop * left - 0.5 * g * left * left, -at_stop - g * left];
    for method in METHODS.iter().filter(|method| method.is_adaptive()) {
        let run = graze.run(&["--method", method.name, "--tolerance", "1e-10"]);
        let table = run.trajectory();
        near(method.name, table.number(table.last(), "x"), exact[0], 1e-8);
        near(method.name, table.number(table.last(), "x_dot"), exact[1], 1e-8);
    }
    // Steps of a tenth of the contact resolve it; those that are longer than it do not, and say so.
    let run = graze.run(&["--step", "2e-4"]);
    near("rk4", run.trajectory().number(4500, "x"), exact[0], 1e-5);
    let run = graze.run(&[]);
    assert!(run.status() == 1 && run.stderr().contains("estimated error"), "{}", run.stderr());
}

#[test]
#[ignore = "full tier: engine"]
fn a_jump_where_the_motion_turns_back_costs_nothing() {
    // A block on an incline with dry friction stops after 1/4 s, a row of some steps, and slides back.
    let incline = Block { force: "-5 - 3*sign(x_dot)", start: [0.0, 2.0], end_time: 1.0 };
    incline.ends_at([-0.3125, -1.5], 1e-12, 1e-9);
    for step in ["3e-3", "1.7e-3", "7e-4"] {
        let run = incline.run(&["--step", step]);
        let table = run.trajectory();
        near(step, table.number(table.last(), "x"), -0.3125, 1e-12);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_motion_along_a_jump_ends() {
    // On a flatter incline it stays where it stops, which a force that jumps cannot describe.
    let stick = Block { force: "-2 - 3*sign(x_dot)", start: [0.0, 2.0], end_time: 1.0 };
    for method in METHODS.iter().filter(|method| method.is_adaptive()) {
        let run = stick.run(&["--method", method.name, "--tolerance", "1e-10"]);
        let text = run.stderr();
        assert!(run.status() == 1 && text.contains("broke off after t = 0.4 s"), "{}: {text}", method.name);
    }
    let run = stick.run(&[]);
    assert!(run.status() == 1 && run.stderr().contains("do not trust"), "{}", run.stderr());
}

/// The errors of columns of the shaper in the rows that a run shares with a reference.
fn errors(run: &Run, reference: &Run, columns: [&str; 2]) -> [f64; 2] {
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let (table, exact) = (run.trajectory(), reference.trajectory());
    let mut shared = 0;
    let mut largest = [0.0_f64; 2];
    let mut at = 0;
    for row in 0..table.last() {
        let t = table.number(row, "t");
        while exact.number(at, "t") < t - 1e-9 {
            at += 1;
        }
        if (exact.number(at, "t") - t).abs() < 1e-9 {
            shared += 1;
            for (largest, column) in largest.iter_mut().zip(columns) {
                *largest = largest.max((table.number(row, column) - exact.number(at, column)).abs());
            }
        }
    }
    assert!(shared > 500, "{shared} rows are compared");
    largest
}

#[test]
fn methods_keep_their_order_between_corners() {
    let shaper = |arguments: &[&str]| run(&[&["shaper", "--no-figures"], arguments].concat());
    let reference = shaper(&["--method", "dop853", "--tolerance", "1e-13", "--max-step", "2e-4", "--step", "2.5e-4"]);
    let columns = ["phi2", "phi4_dot"];
    let steps = [4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4];
    let mut log_errors = Vec::new();
    let mut told = String::new();
    for step in steps {
        let [_, error] = errors(&shaper(&["--step", &format!("{step:e}")]), &reference, columns);
        log_errors.push(error.ln());
        let _ = write!(told, "{step:e} s: {error:.1e}; ");
    }
    // The slope of a line through the logarithms, over steps each half as long as the one before.
    let slope: f64 = log_errors.iter().zip(-2..).map(|(log, i)| log * f64::from(-i)).sum::<f64>() / (10.0 * 2_f64.ln());
    assert!((3.8..=4.2).contains(&slope), "order {slope}: {told}");
    for (method, allowed) in [("dop853", 1e-9), ("gauss", 1e-9), ("dopri5", 1e-9), ("auto", 1e-9)] {
        let own = shaper(&["--method", method, "--tolerance", "1e-10"]);
        let [error, _] = errors(&own, &reference, columns);
        assert!(error <= allowed, "{method}: {error:e}");
    }
}

#[test]
#[ignore = "full tier: engine"]
fn a_corner_at_the_start_and_a_corner_in_a_row_are_passed() {
    // The force begins with the motion, and doubles at a row.
    let block = Block { force: "max(0, x_dot + t) + sign(t - 0.5)", start: [0.0, 0.0], end_time: 1.0 };
    let exact = block.run(&["--method", "dop853", "--tolerance", "1e-12"]).trajectory();
    let own = block.run(&[]).trajectory();
    for column in ["x", "x_dot"] {
        near(column, own.number(own.last(), column), exact.number(exact.last(), column), 1e-9);
    }
}

#[test]
#[ignore = "full tier: engine"]
fn sweeps_end_steps_at_corners_too() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let block = Block { force: "-5 - 3*m*sign(x_dot)", start: [0.0, 2.0], end_time: 1.0 };
    let path = folder.path().join("block.toml");
    fs::write(&path, block.scene()).expect("written");
    let mut command = qrm(&["sweep", path.to_str().expect("a path"), "--vary", "m=1:2:2"]);
    let out = folder.path().join("out.csv");
    let output = command.arg("--out").arg(&out).output().expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = common::Table::read(&out);
    near("x", table.number(0, "x"), -0.3125, 1e-9);
}
