//! Designs in lanes against runs of their own.

mod common;

use std::io;

use common::{mechanism, model};
use qrm_core::Replace;
use qrm_sim::batch::{DesignResult, LaneCount, SweepEnd, SweepRequest};
use qrm_sim::integrate::MethodSettings;
use qrm_sim::run::{Doubt, End, Observer, Request, Row, StartError, Status, simulate};

/// The parameters of a design.
type Design = Vec<(&'static str, f64)>;

/// Runs designs of the quick-return mechanism.
fn sweep(designs: &[Design], request: &SweepRequest, lanes: LaneCount) -> Vec<DesignResult> {
    let value = |design: &Design, name: &str| design.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    let replacements: Vec<_> = designs.iter().map(|design| move |name: &str| value(design, name)).collect();
    let replacements: Vec<Replace> = replacements.iter().map(|replace| replace as Replace).collect();
    qrm_sim::batch::sweep(model("quick-return"), &replacements, request, lanes)
}

/// Designs that differ in length, inertia and speed, so that no two end after the same number of steps; some cannot
/// close.
fn designs(count: usize) -> Vec<Design> {
    let mut random = fastrand::Rng::with_seed(5);
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let design = |_| {
        let (crank, inertia, speed) = (between(0.1, 0.28), between(20.0, 200.0), between(6.0, 10.0));
        let rod = if between(0.0, 1.0) < 0.1 { 0.2 } else { between(0.5, 0.8) };
        vec![("O2A", crank), ("J2", inertia), ("w0", speed), ("BC", rod)]
    };
    (0..count).map(design).collect()
}

#[derive(Default)]
struct Extremes(Vec<[f64; 2]>);

impl Observer for Extremes {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        if self.0.is_empty() {
            self.0 = row.outputs.iter().map(|value| [*value; 2]).collect();
        }
        for (extremes, value) in self.0.iter_mut().zip(row.outputs) {
            *extremes = [extremes[0].min(*value), extremes[1].max(*value)];
        }
        Ok(())
    }
}

fn assert_near(what: &str, got: f64, expected: f64, allowed: f64) {
    let scale = expected.abs().max(1.0);
    assert!((got - expected).abs() <= allowed * scale, "{what}: {got:e} instead of {expected:e}");
}

fn assert_same(design: &Design, finished: &DesignResult, end: Option<f64>) {
    let request =
        Request { settings: MethodSettings::default(), step: None, end: end.map(End::Time), estimate_error: true };
    let mut extremes = Extremes::default();
    match (simulate(&*mechanism("quick-return", design), &request, &mut extremes), &finished.status) {
        (Ok(outcome), Ok(status)) => {
            assert_eq!(std::mem::discriminant(&outcome.status), std::mem::discriminant(status), "{status:?}");
            assert_eq!(outcome.counts.accepted, finished.steps);
            assert_near("end time", finished.end_time, outcome.end_time, 1e-12);
            outcome.q.iter().zip(&finished.q).for_each(|(own, lane)| assert_near("q", *lane, *own, 1e-12));
            outcome.qd.iter().zip(&finished.qd).for_each(|(own, lane)| assert_near("qd", *lane, *own, 1e-11));
            for (own, lane) in extremes.0.iter().flatten().zip(finished.extremes.iter().flatten()) {
                assert_near("extreme", *lane, *own, 1e-9);
            }
            let (own, lane) = (outcome.estimated_error(), finished.estimated_error);
            let (own, lane) = (own.expect("known"), lane.expect("known"));
            assert!((own - lane).abs() <= 0.02 * own + 1e-15, "estimate: {lane:e} instead of {own:e}");
        }
        (Err(StartError::NotAssembled(own)), Err(StartError::NotAssembled(lane))) => assert_eq!(own, *lane),
        (own, lane) => panic!("{own:?} and {lane:?}"),
    }
}

#[test]
fn each_design_ends_as_it_does_alone() {
    let designs = designs(60);
    for end in [None, Some(0.3004)] {
        let request = SweepRequest { end: end.map(SweepEnd::Time), ..SweepRequest::default() };
        for width in [LaneCount::Most, LaneCount::Four, LaneCount::One] {
            let finished = sweep(&designs, &request, width);
            assert_eq!(finished.len(), designs.len());
            designs.iter().zip(&finished).for_each(|(design, finished)| assert_same(design, finished, end));
            let failed = finished.iter().filter(|f| f.status.is_err()).count();
            assert!((1..30).contains(&failed), "{failed} of {} designs cannot start", designs.len());
        }
    }
}

#[test]
fn a_small_swing_is_judged_by_its_range() {
    // Off by more than 1e-3 of a range of 1e-2 rad, with the energy kept.
    let replace = |name: &str| (name == "a0").then_some(5e-3);
    let end = Some(SweepEnd::Time(60.0));
    let request = SweepRequest { step: Some(0.05), end, extremes: false, ..SweepRequest::default() };
    for width in [LaneCount::Most, LaneCount::One] {
        let finished = &qrm_sim::batch::sweep(model("double-pendulum"), &[&replace], &request, width)[0];
        assert!(matches!(finished.doubts[..], [Doubt::Error { .. }]), "{width:?}: {finished:?}");
    }
}

#[test]
fn a_companion_that_never_met_its_design_says_nothing() {
    // Designs that stop in their third step, where the companion is not compared with them, and in the fourth one.
    let stop = |design: usize, t: f64, _: &[f64], _: &[f64]| t - if design == 0 { 2.5e-3 } else { 3.5e-3 };
    let designs = designs(2);
    let request = SweepRequest { end: Some(SweepEnd::Condition(&stop)), ..SweepRequest::default() };
    for width in [LaneCount::Most, LaneCount::One] {
        let known: Vec<bool> = sweep(&designs, &request, width).iter().map(|f| f.estimated_error.is_some()).collect();
        assert_eq!(known, [false, true], "{width:?}");
    }
}

#[test]
fn a_design_does_not_depend_on_neighbours_in_trouble() {
    // Cranks without inertia, designs that cannot close or stall, steps near the limit: some lanes leave the fast way
    // at every step, hold numbers that are none, or end early.
    let design = |i: usize| {
        let crank = 0.15 + 0.2 * (i % 29) as f64 / 28.0;
        let inertia = [0.0, 1e-3, 1.0, 20.0, 100.0, 1000.0][i % 6];
        let speed = [15.0, 1.0, -1.0, 7.0][i % 4];
        vec![("O2A", crank), ("J2", inertia), ("w0", speed)]
    };
    let designs: Vec<Design> = (0..60).map(design).collect();
    for (step, end) in [(2e-2, None), (1e-2, Some(3.0)), (5e-3, None)] {
        let end = || end.map(SweepEnd::Time);
        let request = SweepRequest { step: Some(step), end: end(), ..SweepRequest::default() };
        let show = |finished: &DesignResult| format!("{finished:?}");
        let together: Vec<String> = sweep(&designs, &request, LaneCount::Most).iter().map(show).collect();
        let four: Vec<String> = sweep(&designs, &request, LaneCount::Four).iter().map(show).collect();
        let alone: Vec<String> = designs
            .iter()
            .flat_map(|design| sweep(std::slice::from_ref(design), &request, LaneCount::Most))
            .map(|f| show(&f))
            .collect();
        for i in 0..designs.len() {
            assert_eq!(together[i], alone[i], "design {i}, step {step}");
            assert_eq!(together[i], four[i], "design {i}, step {step}");
        }
    }
}

#[test]
fn a_design_does_not_depend_on_its_neighbours() {
    let designs = designs(23);
    let request = SweepRequest::default();
    for width in [LaneCount::Most, LaneCount::Four, LaneCount::One] {
        let together = sweep(&designs, &request, width);
        for (i, design) in designs.iter().enumerate() {
            let alone = &sweep(std::slice::from_ref(design), &request, width)[0];
            assert_eq!(
                (&alone.q, &alone.qd, &alone.extremes),
                (&together[i].q, &together[i].qd, &together[i].extremes)
            );
            assert_eq!((alone.end_time, alone.estimated_error), (together[i].end_time, together[i].estimated_error));
        }
    }
    // Both kinds of lanes round alike.
    let (eight, four) = (sweep(&designs, &request, LaneCount::Most), sweep(&designs, &request, LaneCount::Four));
    eight.iter().zip(&four).for_each(|(eight, four)| assert_eq!(eight.q, four.q));
}

#[test]
fn designs_that_break_off_do_not_stop_the_others() {
    // The rod of every second design is too short for a full turn: the crank never gets there.
    let design = |i: usize| if i % 2 == 1 { vec![("BC", 0.37)] } else { Vec::new() };
    let designs: Vec<Design> = (0..9).map(design).collect();
    let finished = sweep(&designs, &SweepRequest::default(), LaneCount::Most);
    for (i, finished) in finished.iter().enumerate() {
        let stopped = matches!(finished.status, Ok(Status::Stopped));
        assert_eq!(stopped, i % 2 == 0, "design {i}: {:?}", finished.status);
    }
}

#[test]
fn errors_are_estimated_as_alone_however_few_the_steps() {
    let designs = designs(5);
    for count in 1..=6 {
        let at_row = SweepEnd::Time(0.02 * f64::from(count));
        let t = 0.02 * (f64::from(count) - 0.5);
        let between = |_: usize, now: f64, _: &[f64], _: &[f64]| now - t;
        for end in [at_row, SweepEnd::Condition(&between)] {
            let request = SweepRequest { step: Some(0.02), end: Some(end), extremes: false, ..SweepRequest::default() };
            let [lanes, alone] = [LaneCount::Most, LaneCount::One].map(|lanes| sweep(&designs, &request, lanes));
            for (lanes, alone) in lanes.iter().zip(&alone) {
                match (lanes.estimated_error, alone.estimated_error) {
                    (Some(lanes), Some(alone)) => assert_near("error", lanes, alone, 1e-6 * alone),
                    (lanes, alone) => assert_eq!(lanes, alone, "{count} steps"),
                }
            }
        }
    }
}
