//! Designs in lanes against runs of their own.
//!
//! `QRM_RUNS=100000 QRM_SEED=1 cargo test --release --test sweep -- --nocapture` makes so many random designs, others
//! with another seed, and prints what they are like.

use fastrand::Rng;
use qrm_core::{Model, ParameterOverrides};
use qrm_sim::batch::{DesignResult, LaneCount, SweepRequest};
use qrm_sim::integrate::{DOP853, MethodSettings, StepBounds};
use qrm_sim::run::{End, RejectionReason, Request, StartError, Status, simulate};

use crate::common::{event, mechanism, model};

/// The parameters of a design.
type Design = Vec<(&'static str, f64)>;

fn sweep(model: &Model, designs: &[Design], request: &SweepRequest, lanes: LaneCount) -> Vec<DesignResult> {
    let value = |design: &Design, name: &str| design.iter().find(|(own, _)| *own == name).map(|(_, value)| *value);
    let replacements: Vec<_> = designs.iter().map(|design| move |name: &str| value(design, name)).collect();
    let replacements: Vec<ParameterOverrides> =
        replacements.iter().map(|replace| replace as ParameterOverrides).collect();
    qrm_sim::batch::sweep(model, &replacements, request, lanes)
}

fn by_tolerance(tolerance: f64) -> SweepRequest<'static> {
    SweepRequest { settings: MethodSettings::new(DOP853, tolerance), ..SweepRequest::default() }
}

/// By the fixed steps of the scene, one design by itself after the other.
fn by_steps() -> SweepRequest<'static> {
    SweepRequest { settings: MethodSettings::default(), ..SweepRequest::default() }
}

/// Quick-returns of some lengths, inertias and speeds, one in ten of which cannot close.
fn quick_returns(count: usize) -> Vec<Design> {
    let mut random = Rng::with_seed(7);
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let design = |_| {
        let (crank, inertia, speed) = (between(0.1, 0.28), between(20.0, 200.0), between(6.0, 10.0));
        let rod = if between(0.0, 1.0) < 0.1 { 0.2 } else { between(0.5, 0.8) };
        vec![("O2A", crank), ("J2", inertia), ("w0", speed), ("BC", rod)]
    };
    (0..count).map(design).collect()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn each_design_ends_as_it_does_alone() {
    let designs = quick_returns(60);
    for end in [None, Some(0.3004)] {
        let request = |tolerance| SweepRequest { end: end.map(End::Time), ..by_tolerance(tolerance) };
        let alone = sweep(model("quick-return"), &designs, &request(1e-12), LaneCount::One);
        for lanes in [LaneCount::Most, LaneCount::Four] {
            let finished = sweep(model("quick-return"), &designs, &request(1e-9), lanes);
            assert_eq!(finished.len(), designs.len());
            let mut failed = 0;
            for (finished, alone) in finished.iter().zip(&alone) {
                match (&finished.status, &alone.status) {
                    (Ok(status), Ok(own)) => {
                        assert_eq!(std::mem::discriminant(status), std::mem::discriminant(own), "{status:?}");
                        let stated = finished.estimated_error.expect("an estimate");
                        let late = (finished.end_time - alone.end_time).abs();
                        assert!(late < stated && distance(&finished.q, &alone.q) < stated, "{finished:?}, {alone:?}");
                    }
                    (Err(StartError::NotAssembled(status)), Err(StartError::NotAssembled(own))) => {
                        assert_eq!(status, own);
                        failed += 1;
                    }
                    (status, own) => panic!("{status:?} and {own:?}"),
                }
            }
            assert!((1..30).contains(&failed), "{failed} of {} designs cannot start", designs.len());
        }
    }
}

#[test]
fn a_stop_condition_is_met_where_a_run_meets_it() {
    let designs = quick_returns(60);
    for tolerance in [1e-6, 1e-9, 1e-12] {
        let finished = sweep(model("quick-return"), &designs, &by_tolerance(tolerance), LaneCount::Most);
        let mut stopped = 0;
        for (design, finished) in designs.iter().zip(&finished) {
            let request = Request { settings: MethodSettings::new(DOP853, 1e-13), ..Request::default() };
            let Ok(exact) = simulate(&*mechanism("quick-return", design), &request, &mut ()) else {
                assert!(finished.status.is_err(), "{design:?}: {:?}", finished.status);
                continue;
            };
            let is_same =
                matches!(&finished.status, Ok(s) if std::mem::discriminant(s) == std::mem::discriminant(&exact.status));
            assert!(is_same, "{design:?}: {:?} instead of {:?}", finished.status, exact.status);
            if !matches!(exact.status, Status::Stopped) {
                continue;
            }
            stopped += usize::from(!finished.is_alone);
            assert!((finished.q[0].abs() - 4.0 * std::f64::consts::PI).abs() < 1e-13, "{:e}", finished.q[0]);
            // All coordinates follow from the one that the condition gives; their error is one of time.
            let late = (finished.end_time - exact.end_time).abs() * exact.qd[0].abs();
            let stated = finished.estimated_error.expect("an estimate");
            assert!(late < stated, "{design:?}: {late:e} instead of {stated:e}");
            assert!(distance(&finished.qd, &exact.qd) < 100.0 * stated, "{design:?}");
        }
        assert!(stopped > 40, "{stopped}");
    }
}

/// The last step towards a force that grows fast is short: the time by which it passes the condition is a rounding
/// error of its length, but not of the speed, which grows too.
#[test]
fn extremes_do_not_count_what_lies_behind_the_end() {
    let own = model("quick-return-driven");
    let speed = own.description.outputs.iter().position(|output| output.name == "x6_dot").expect("an output");
    let condition = event(own, "N3 >= 1000");
    let designs: Vec<Design> = (0..40).map(|i| vec![("O2A", 0.13 + 0.003 * f64::from(i))]).collect();
    let request = |tolerance| SweepRequest { end: Some(End::Event(&condition)), ..by_tolerance(tolerance) };
    let alone = sweep(own, &designs, &request(1e-13), LaneCount::One);
    for lanes in [LaneCount::Most, LaneCount::Four] {
        let finished = sweep(own, &designs, &request(1e-9), lanes);
        let mut compared = 0;
        for (design, (finished, alone)) in designs.iter().zip(finished.iter().zip(&alone)) {
            if finished.is_alone || alone.extremes.is_empty() {
                continue;
            }
            let stated = finished.extreme_errors[speed][1] + alone.extreme_errors[speed][1];
            let off = (finished.extremes[speed][1] - alone.extremes[speed][1]).abs();
            assert!(off <= 3.0 * stated + 1e-14, "{design:?}: {off:e}, stated {stated:e}");
            compared += 1;
        }
        assert!(compared > 20, "{compared}");
    }
}

#[test]
fn a_condition_that_is_true_within_a_step_only_is_met() {
    // True for a third of a step's turn.
    let below = event(model("quick-return"), "-0.5 - sin(20*phi2) >= 0");
    let first = (1.5 * std::f64::consts::PI - 0.5_f64.acos()) / 20.0;
    let designs = quick_returns(24);
    let request = SweepRequest { end: Some(End::Event(&below)), ..by_tolerance(1e-9) };
    for lanes in [LaneCount::Most, LaneCount::Four] {
        let finished = sweep(model("quick-return"), &designs, &request, lanes);
        let ended = finished.iter().filter(|finished| matches!(finished.status, Ok(Status::Stopped)));
        let late = ended.map(|finished| (finished.q[0].abs() - first).abs() / first);
        let late: Vec<f64> = late.collect();
        assert!(late.len() > 12 && late.iter().all(|late| *late < 1e-9), "{late:?}");
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn extremes_are_found_inside_steps() {
    let designs = quick_returns(20);
    let finished = sweep(model("quick-return"), &designs, &by_tolerance(1e-9), LaneCount::Most);
    // Rows of a run alone, which are many.
    let alone = sweep(
        model("quick-return"),
        &designs,
        &SweepRequest { step: Some(2e-5), ..by_tolerance(1e-11) },
        LaneCount::One,
    );
    let mut compared = 0;
    for (design, (finished, alone)) in designs.iter().zip(finished.iter().zip(&alone)) {
        // A run by itself takes extremes from its rows.
        if finished.is_alone {
            continue;
        }
        for (output, (found, rows)) in finished.extremes.iter().zip(&alone.extremes).enumerate() {
            let range = rows[1] - rows[0];
            compared += 1;
            for k in 0..2 {
                let difference = (found[k] - rows[k]).abs();
                assert!(difference < 3e-6 * range, "{design:?}, output {output}: {found:?} instead of {rows:?}");
            }
        }
    }
    assert!(compared > 50, "{compared}");
}

#[test]
#[ignore = "full tier: compiled"]
fn a_design_does_not_depend_on_its_neighbours() {
    // Cranks without inertia, designs that cannot close or stall: some lanes are left, or hold numbers that are none.
    let design = |i: usize| {
        let crank = 0.15 + 0.2 * (i % 29) as f64 / 28.0;
        let inertia = [0.0, 1e-3, 1.0, 20.0, 100.0, 1000.0][i % 6];
        let speed = [15.0, 1.0, -1.0, 7.0][i % 4];
        vec![("O2A", crank), ("J2", inertia), ("w0", speed)]
    };
    let designs: Vec<Design> = (0..40).map(design).collect();
    let show = |finished: &DesignResult| format!("{finished:?}");
    for end in [None, Some(0.8)] {
        let request = SweepRequest { end: end.map(End::Time), ..by_tolerance(1e-8) };
        let together = sweep(model("quick-return"), &designs, &request, LaneCount::Most);
        let four = sweep(model("quick-return"), &designs, &request, LaneCount::Four);
        assert!(
            together.iter().any(|finished| finished.is_alone) && together.iter().any(|finished| !finished.is_alone)
        );
        for (i, design) in designs.iter().enumerate() {
            let alone = &sweep(model("quick-return"), std::slice::from_ref(design), &request, LaneCount::Most)[0];
            assert_eq!(show(&together[i]), show(alone), "design {i}");
            assert_eq!(show(&together[i]), show(&four[i]), "design {i}");
        }
    }
}

#[test]
fn no_step_is_longer_or_later_than_its_bounds() {
    let designs = quick_returns(8);
    let bounds = |design: usize| StepBounds::new(if design == 0 { 1e-3 } else { f64::INFINITY }, &[0.1, 0.2, 0.3]);
    let request = SweepRequest { step_bounds: Some(&bounds), end: Some(End::Time(1.0)), ..by_tolerance(1e-6) };
    let finished = sweep(model("quick-return"), &designs, &request, LaneCount::Most);
    let steps: Vec<u64> = finished.iter().filter(|finished| !finished.is_alone).map(|f| f.steps).collect();
    assert!(steps[0] >= 1000 && (20..100).contains(&steps[1]), "{steps:?}");
}

#[test]
fn a_small_swing_is_judged_by_its_range() {
    // Off by more than 1e-3 of a range of 1e-2 rad, with the energy kept.
    let replace = |name: &str| (name == "a0").then_some(5e-3);
    let end = Some(End::Time(60.0));
    let request = SweepRequest { step: Some(0.05), end, extremes: false, ..by_steps() };
    let finished = &qrm_sim::batch::sweep(model("double-pendulum"), &[&replace], &request, LaneCount::Most)[0];
    assert!(matches!(finished.rejection_reasons[..], [RejectionReason::Error { .. }]), "{finished:?}");
}

#[test]
fn designs_of_few_steps_have_an_error() {
    // Designs that stop in their third step, where the companion meets them at the end alone, and in the fourth one.
    for stop in ["t >= 2.5e-3", "t >= 3.5e-3"] {
        let stop = event(model("quick-return"), stop);
        let request = SweepRequest { end: Some(End::Event(&stop)), ..by_steps() };
        let finished = sweep(model("quick-return"), &quick_returns(2), &request, LaneCount::Most);
        assert!(finished.iter().all(|finished| finished.estimated_error.is_some()), "{finished:?}");
    }
}

#[test]
fn designs_that_break_off_do_not_stop_the_others() {
    // The rod of every second design is too short for a full turn: the crank never gets there.
    let design = |i: usize| if i % 2 == 1 { vec![("BC", 0.37)] } else { Vec::new() };
    let designs: Vec<Design> = (0..9).map(design).collect();
    let finished = sweep(model("quick-return"), &designs, &SweepRequest::default(), LaneCount::Most);
    for (i, finished) in finished.iter().enumerate() {
        let stopped = matches!(finished.status, Ok(Status::Stopped));
        assert_eq!(stopped, i % 2 == 0, "design {i}: {:?}", finished.status);
    }
}

#[test]
#[ignore = "full tier: compiled"]
fn what_a_design_says_of_its_error_holds() {
    let number = |variable: &str, otherwise: u64| {
        std::env::var(variable).map_or(otherwise, |text| text.parse().expect("a number"))
    };
    let (seed, runs) = (number("QRM_SEED", 1), number("QRM_RUNS", 480));
    const DESIGNS: u64 = 24;
    let (mut ratios, mut wrong, mut alone, mut refused) = (Vec::new(), Vec::new(), 0, 0);
    for round in 0..runs / DESIGNS {
        let mut random = Rng::with_seed(seed.wrapping_mul(1_000_003).wrapping_add(round));
        // Where loads have corners designs are run one by one; through singular positions no reference is quick.
        let is_tried = |model: &&Model| !model.description.has_corners && model.description.name != "n-four-bar-2";
        let models: Vec<&Model> = qrm_model::MODELS.iter().filter(is_tried).collect();
        let model = models[random.usize(..models.len())];
        let own = model.mechanism(&|_| None);
        let names: Vec<&'static str> = model.description.parameters.iter().map(|parameter| parameter.name).collect();
        let spread = [0.01, 0.1, 0.5][random.usize(..3)];
        let mut designs: Vec<Design> = Vec::new();
        for _ in 0..DESIGNS {
            let values = names.iter().copied().zip(own.parameters().iter().copied());
            let mut design: Design = values.filter(|_| random.bool()).collect();
            design.iter_mut().for_each(|(_, value)| *value *= (spread * (2.0 * random.f64() - 1.0)).exp());
            designs.push(design);
        }
        let end = own.schedule().end_time * random.f64().max(0.05);
        let tolerance = 10.0_f64.powf(-3.0 - 8.0 * random.f64());
        let request =
            |tolerance| SweepRequest { end: Some(End::Time(end)), extremes: false, ..by_tolerance(tolerance) };
        let finished = sweep(model, &designs, &request(tolerance), LaneCount::Most);
        let exact = sweep(model, &designs, &request((1e-4 * tolerance).max(1e-13)), LaneCount::Most);
        for ((design, finished), exact) in designs.iter().zip(&finished).zip(&exact) {
            let is_done = |result: &DesignResult| {
                matches!(result.status, Ok(Status::Completed)) && result.rejection_reasons.is_empty()
            };
            if !is_done(finished) || !is_done(exact) {
                refused += 1;
                continue;
            }
            if finished.is_alone {
                alone += 1;
                continue;
            }
            let (Some(stated), Some(known)) = (finished.estimated_error, exact.estimated_error) else { continue };
            let error = distance(&finished.q, &exact.q);
            let size = finished.q.iter().fold(1.0, |size: f64, q| size.max(q.abs()));
            let stated = stated.max(1e-12 * size);
            ratios.push(error / stated);
            if error > 4.0 * stated && known < 0.1 * error {
                let scene = model.description.name;
                wrong.push(format!(
                    "{error:.1e} instead of {stated:.1e}: {scene} to {end} by {tolerance:.1e}, {design:?}"
                ));
            }
        }
    }
    ratios.sort_by(f64::total_cmp);
    let at = |part: f64| ratios.get((part * ratios.len() as f64) as usize).copied().unwrap_or(0.0);
    println!(
        "{} compared, {alone} alone, {refused} refused; true over stated: 1 % {:.3}, median {:.2}, 99 % {:.2}, 99.9 % \
         {:.2}, most {:.2}",
        ratios.len(),
        at(0.01),
        at(0.5),
        at(0.99),
        at(0.999),
        ratios.last().copied().unwrap_or(0.0)
    );
    assert!(ratios.len() as u64 > runs / 3, "{} of {runs}", ratios.len());
    assert!(wrong.is_empty(), "{} of {runs}:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_landing_that_is_rejected_is_made_again() {
    let lengths = (0..40).map(|i| vec![("l", 0.5 + 2.5 * f64::from(i) / 39.0)]);
    let designs: Vec<Design> = lengths.collect();
    let below = event(model("pendulum"), "x <= 0");
    let request = SweepRequest { end: Some(End::Event(&below)), ..by_tolerance(1e-13) };
    for lanes in [LaneCount::Most, LaneCount::Four] {
        for finished in sweep(model("pendulum"), &designs, &request, lanes) {
            assert!(matches!(finished.status, Ok(Status::Stopped)) && finished.q[0].abs() < 1e-12, "{finished:?}");
        }
    }
}

#[test]
fn extremes_of_a_run_by_itself_lie_between_rows_too() {
    let design = vec![("l3", 0.225789473684211)];
    let by = |step| SweepRequest { step: Some(step), ..by_tolerance(1e-12) };
    let [coarse, fine] = [1e-2, 2e-4].map(|step| {
        sweep(model("four-bar"), std::slice::from_ref(&design), &by(step), LaneCount::One).remove(0).extremes
    });
    for (coarse, fine) in coarse.iter().flatten().zip(fine.iter().flatten()) {
        assert!((coarse - fine).abs() < 1e-4 * fine.abs(), "{coarse} instead of {fine}");
    }
}
