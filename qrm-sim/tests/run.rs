//! Runs of a handwritten mechanism: one mass on a line, with any force.

use std::io;

use qrm_core::Operation::{self, Mul, Number, Sub};
use qrm_core::{
    Description, DynamicsMut, LoopConstraintsMut, Mechanism, QuantityDescription, Schedule, StartMut, StateRef, Tape,
    TapeFunction,
};
use qrm_sim::integrate::{AUTO, METHODS, MethodSettings, StepError};
use qrm_sim::run::{End, NonFiniteQuantity, Observer, Outcome, Request, Row, StartError, Status, simulate};

/// A mass on a line with a force that depends on its position: `mass x'' = force(x) - damping x'`.
struct Line {
    mass: f64,
    damping: f64,
    potential: fn(f64) -> f64,
    force: fn(f64) -> f64,
    output: fn(f64) -> f64,
}

const X: QuantityDescription = QuantityDescription { name: "x", unit: "m", doc: "" };

static DESCRIPTION: Description = Description {
    name: "line",
    doc: "",
    source: "",
    derivation: "",
    coordinates: &[X],
    constraints: &[],
    outputs: &[X],
    parameters: &[],
    left_out: &[],
    has_corners: false,
    friction: &[],
    until: "",
};

impl Mechanism for Line {
    fn description(&self) -> &'static Description {
        &DESCRIPTION
    }

    fn parameters(&self) -> &[f64] {
        &[]
    }

    fn is_driven(&self) -> bool {
        false
    }

    fn operations(&self) -> usize {
        0
    }

    fn start(&self, start: StartMut) {
        start.q[0] = 0.0;
        start.qd[0] = 1.0;
        start.given.fill(true);
        start.given_rates.fill(true);
    }

    fn schedule(&self) -> Schedule<f64> {
        Schedule { step: 0.01, end_time: 50.0 }
    }

    fn event(&self, _: &StateRef) -> Option<f64> {
        None
    }

    fn dynamics(&self, _: f64, q: &[f64], qd: &[f64], dynamics: DynamicsMut) {
        dynamics.mass_matrix[0] = self.mass;
        dynamics.generalized_forces[0] = (self.force)(q[0]) - self.damping * qd[0];
    }

    fn loop_constraints(&self, _: f64, _: &[f64], _: LoopConstraintsMut) {}

    fn mass_matrix(&self, _: &[f64], mass_matrix: &mut [f64]) {
        mass_matrix[0] = self.mass;
    }

    fn energy(&self, q: &[f64], qd: &[f64]) -> [f64; 2] {
        [0.5 * self.mass * qd[0] * qd[0], (self.potential)(q[0])]
    }

    fn power(&self, _: f64, _: &[f64], _: &[f64], _: &[f64], _: &[f64]) -> f64 {
        0.0
    }

    fn outputs(&self, _: f64, q: &[f64], _: &[f64], _: &[f64], _: &[f64], outputs: &mut [f64]) {
        outputs[0] = (self.output)(q[0]);
    }
}

/// Records the times of rows; stops on request.
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

    fn keep_running(&mut self, _: f64, _: f64) -> io::Result<bool> {
        Ok(self.stop_after.is_none_or(|rows| self.times.len() < rows))
    }

    fn finish(&mut self, _last: &[f64]) -> io::Result<()> {
        self.finished += 1;
        Ok(())
    }
}

/// A tape with an event. Time has the place 0; coordinate, rate and acceleration have 1 to 3; results begin at 6.
fn event(operations: &'static [Operation], results: &'static [u32]) -> Tape {
    Tape { coordinates: 1, event: Some(TapeFunction::new(operations, results)), ..Tape::default() }
}

fn run(line: &Line, end: Option<End>, notes: &mut Notes) -> Result<Outcome, StartError> {
    simulate(line, &Request { end, estimate_error: true, ..Request::default() }, notes)
}

fn line() -> Line {
    Line { mass: 1.0, damping: 0.0, potential: |_| 0.0, force: |_| 0.0, output: |x| x }
}

#[test]
fn an_output_without_value_ends_the_run_before_its_row() {
    let mut notes = Notes::default();
    let outcome = run(&Line { output: |x| (0.5 - x).sqrt(), ..line() }, None, &mut notes).expect("starts");
    assert!(
        matches!(outcome.status, Status::NotFinite { what: NonFiniteQuantity::Output(0), t } if (t - 0.51).abs() < 1e-12),
        "{outcome:?}"
    );
    assert_eq!((notes.times.len(), notes.finished), (51, 1));
    assert_eq!((outcome.end_time, outcome.counts.accepted), (notes.times[50], 50));
}

#[test]
fn an_energy_without_value_ends_the_run_before_its_row() {
    let line = Line { potential: |x| if x > 0.995 { f64::INFINITY } else { 0.0 }, ..line() };
    let mut notes = Notes::default();
    let outcome = run(&line, None, &mut notes).expect("it begins");
    assert!(
        matches!(outcome.status, Status::NotFinite { t, what: NonFiniteQuantity::Energy } if (t - 1.0).abs() < 1e-9)
    );
    assert_eq!((notes.times.len(), notes.finished), (100, 1));
    assert!((outcome.end_time - 0.99).abs() < 1e-12);
}

#[test]
fn a_tolerance_that_double_precision_cannot_meet_ends_the_run() {
    let line = Line { force: |x| if x < 0.5 { 0.0 } else { 1e20 * (1e12 * x).sin() }, ..line() };
    let dop853 = METHODS.iter().find(|method| method.name == "dop853").expect("a method");
    let settings = MethodSettings::new(dop853, 1e-14);
    let request = Request { settings, end: Some(End::Time(1.0)), ..Request::default() };
    let outcome = simulate(&line, &request, &mut Notes::default()).expect("it begins");
    assert!(matches!(outcome.status, Status::Failed(StepError::StepTooShort { h }) if h > 0.0), "{:?}", outcome.status);
}

#[test]
fn explicit_steps_that_stability_bounds_are_counted() {
    // The motion comes to rest after a millisecond; steps of 0.01 s would be accurate enough, but are unstable.
    let bound = |damping: f64| {
        let line = Line { damping, force: |x| -x, ..line() };
        let settings = MethodSettings::new(AUTO, 1e-6);
        let request = Request { settings, end: Some(End::Time(2.0)), ..Request::default() };
        let outcome = simulate(&line, &request, &mut Notes::default()).expect("it begins");
        assert!(outcome.status.is_done() && outcome.counts.implicit == 0);
        (outcome.counts.stability_bound, outcome.counts.accepted)
    };
    let (stiff, steps) = bound(1e4);
    assert!(stiff > steps / 2, "{stiff} of {steps}");
    assert_eq!(bound(1.0).0, 0);
}

#[test]
fn a_force_without_value_fails_the_run() {
    let outcome =
        run(&Line { force: |x| 1e3 * (0.2 - x).sqrt(), ..line() }, None, &mut Notes::default()).expect("starts");
    assert!(matches!(outcome.status, Status::Failed(StepError::ForcesNotFinite)), "{outcome:?}");
    assert!(outcome.q[0] < 0.2);
}

#[test]
fn no_mass_is_named() {
    let error = run(&Line { mass: 0.0, ..line() }, None, &mut Notes::default()).expect_err("cannot start");
    assert_eq!(error, StartError::Step(StepError::Massless(0)));
}

#[test]
fn a_condition_without_value_is_no_condition() {
    let nothing = event(&[Number(f64::NAN)], &[6]);
    let error = run(&line(), Some(End::Event(&nothing)), &mut Notes::default()).expect_err("cannot start");
    assert_eq!(error, StartError::ConditionNotFinite);
}

#[test]
fn the_stop_is_where_the_condition_becomes_true() {
    let far = event(&[Mul(1, 1), Number(2.0), Sub(6, 7)], &[8]);
    let outcome = run(&line(), Some(End::Event(&far)), &mut Notes::default()).expect("starts");
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
