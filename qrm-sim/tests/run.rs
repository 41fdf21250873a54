//! Runs of a mechanism written here by hand: one mass on a line, pulled as asked.

use std::io;

use qrm_core::{Closure, Description, Dynamics, Mechanism, NoKernel, QuantityDescription, Scalar, Schedule, Start};
use qrm_sim::motion::Breakdown;
use qrm_sim::observer::{Observer, Row};
use qrm_sim::outcome::{NoStart, Outcome, Status, Undefined};
use qrm_sim::simulate::{End, Request, simulate};

/// A mass on a line with a force that depends on its position.
struct Line {
    mass: f64,
    force: fn(f64) -> f64,
    output: fn(f64) -> f64,
}

const X: QuantityDescription = QuantityDescription { name: "x", unit: "m", doc: "" };

impl Mechanism<1, 0> for Line {
    type Kernel<R: Scalar> = NoKernel;

    const DESCRIPTION: Description = Description {
        name: "line",
        doc: "",
        source: "",
        code: "",
        derivation: "",
        coordinates: &[X],
        constraints: &[],
        outputs: &[X],
        parameters: &[],
        left_out: &[],
        until: "",
    };

    fn with_parameters(_: &dyn Fn(&str) -> Option<f64>) -> Self {
        Self { mass: 1.0, force: |_| 0.0, output: |x| x }
    }

    fn visit_parameters(&self, _: &mut dyn FnMut(f64)) {}

    fn start(&self) -> Start<f64, 1> {
        Start { q: [0.0], given: [true], qd: [1.0], given_rates: [true] }
    }

    fn schedule(&self) -> Schedule<f64> {
        Schedule { step: 0.01, end_time: 50.0 }
    }

    fn stop(&self, _: f64, _: &[f64; 1], _: &[f64; 1]) -> Option<f64> {
        None
    }

    fn dynamics(&self, _: f64, q: &[f64; 1], _: &[f64; 1]) -> Dynamics<f64, 1, 0> {
        Dynamics {
            mass_matrix: [[self.mass]],
            generalized_forces: [(self.force)(q[0])],
            constraint_jacobian: [],
            constraint_bias: [],
        }
    }

    fn closure(&self, _: f64, _: &[f64; 1]) -> Closure<f64, 1, 0> {
        Closure { constraints: [], constraint_jacobian: [], constraint_rate: [] }
    }

    fn mass_matrix(&self, _: &[f64; 1]) -> [[f64; 1]; 1] {
        [[self.mass]]
    }

    fn energy(&self, _: &[f64; 1], qd: &[f64; 1]) -> [f64; 2] {
        [0.5 * self.mass * qd[0] * qd[0], 0.0]
    }

    fn power(&self, _: f64, _: &[f64; 1], _: &[f64; 1], _: &[f64; 0]) -> f64 {
        0.0
    }

    fn outputs(&self, _: f64, q: &[f64; 1], _: &[f64; 1], _: &[f64; 1], _: &[f64; 0], outputs: &mut [f64]) {
        outputs[0] = (self.output)(q[0]);
    }
}

/// Notes the times of rows; gives up as asked.
#[derive(Default)]
struct Notes {
    times: Vec<f64>,
    full_after: Option<usize>,
    stop_after: Option<usize>,
    finished: u32,
}

impl Observer for Notes {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        assert!(row.q[0].is_finite() && row.outputs[0].is_finite());
        if self.full_after == Some(self.times.len()) {
            return Err(io::Error::other("full"));
        }
        self.times.push(row.t);
        Ok(())
    }

    fn goes_on(&mut self, _: f64, _: f64) -> io::Result<bool> {
        Ok(self.stop_after.is_none_or(|rows| self.times.len() < rows))
    }

    fn finish(&mut self) -> io::Result<()> {
        self.finished += 1;
        Ok(())
    }
}

fn run(line: &Line, end: Option<End>, notes: &mut Notes) -> Result<Outcome, NoStart> {
    simulate(line, &Request { method: Default::default(), step: None, end, estimate_error: true }, notes)
}

fn line() -> Line {
    Line::with_parameters(&|_| None)
}

#[test]
fn an_output_without_value_ends_the_run_before_its_row() {
    let mut notes = Notes::default();
    let outcome = run(&Line { output: |x| (0.5 - x).sqrt(), ..line() }, None, &mut notes).expect("starts");
    assert!(
        matches!(outcome.status, Status::NotFinite { what: Undefined::Output(0), t } if (t - 0.51).abs() < 1e-12),
        "{outcome:?}"
    );
    assert_eq!((notes.times.len(), notes.finished), (51, 1));
    assert_eq!((outcome.end_time, outcome.counts.accepted), (notes.times[50], 50));
}

#[test]
fn a_force_that_loses_its_value_breaks_the_run() {
    let outcome =
        run(&Line { force: |x| 1e3 * (0.2 - x).sqrt(), ..line() }, None, &mut Notes::default()).expect("starts");
    assert!(matches!(outcome.status, Status::Broken(Breakdown::NotFinite)), "{outcome:?}");
    assert!(outcome.q[0] < 0.2);
}

#[test]
fn no_mass_is_named() {
    let broken = run(&Line { mass: 0.0, ..line() }, None, &mut Notes::default()).expect_err("cannot start");
    assert_eq!(broken, NoStart::Broken(Breakdown::Massless(0)));
}

#[test]
fn a_condition_without_value_is_no_condition() {
    let nothing = |_: f64, _: &[f64], _: &[f64]| f64::NAN;
    let refused = run(&line(), Some(End::Condition(&nothing)), &mut Notes::default()).expect_err("cannot start");
    assert_eq!(refused, NoStart::ConditionNotFinite);
}

#[test]
fn the_stop_is_where_the_condition_becomes_true() {
    let far = |_: f64, q: &[f64], _: &[f64]| q[0] * q[0] - 2.0;
    let outcome = run(&line(), Some(End::Condition(&far)), &mut Notes::default()).expect("starts");
    assert!(matches!(outcome.status, Status::Stopped));
    assert!((outcome.end_time - 2.0_f64.sqrt()).abs() < 4e-16 && outcome.counts.accepted == 142, "{outcome:?}");
}

#[test]
fn who_takes_the_rows_may_end_the_run() {
    let mut notes = Notes { stop_after: Some(1), ..Notes::default() };
    let outcome = run(&line(), None, &mut notes).expect("starts");
    assert!(matches!(outcome.status, Status::Interrupted));
    assert!((notes.times[notes.times.len() - 1] - outcome.end_time).abs() < 1e-15 && notes.finished == 1);
    let mut notes = Notes { full_after: Some(10), ..Notes::default() };
    let outcome = run(&line(), None, &mut notes).expect("starts");
    assert!(matches!(outcome.status, Status::Unwritable(_)));
    assert_eq!(notes.times.len(), 10);
}
