//! Random conditions end motions where rows of a hundredth of the step say that they become true first.

use qrm_core::{Model, Schedule, TapeEvaluator};
use qrm_sim::batch::{LaneCount, SweepRequest, sweep};
use qrm_sim::integrate::{DOP853, DOPRI5, GAUSS, Method, MethodSettings, RK4};
use qrm_sim::run::{End, Observer, Request, Row, Status, simulate};

use crate::common::{event, mechanism, model};

const SCENES: [&str; 4] = ["pendulum", "slider-crank", "four-bar", "double-pendulum"];
/// The rows of the reference in each step of the scene.
const FINER: f64 = 100.0;
/// The number of steps of the scene.
const STEPS: f64 = 1500.0;
const METHODS: [(&Method, f64); 6] =
    [(RK4, 1.0), (RK4, 1.7), (DOP853, 1.0), (DOP853, 30.0), (DOPRI5, 3.0), (GAUSS, 10.0)];

#[derive(Default)]
struct Rows(Vec<[Vec<f64>; 5]>);

impl Observer for Rows {
    fn row(&mut self, row: &Row) -> std::io::Result<()> {
        self.0.push([vec![row.t], row.q.to_vec(), row.qd.to_vec(), row.qdd.to_vec(), row.multipliers.to_vec()]);
        Ok(())
    }
}

/// A motion in fine rows.
struct Motion {
    model: &'static Model,
    rows: Rows,
}

impl Motion {
    fn new(scene: &str) -> Self {
        let (model, mechanism) = (model(scene), mechanism(scene, &[]));
        let Schedule { step, end_time } = mechanism.schedule();
        let mut rows = Rows::default();
        let end = Some(End::Time(end_time.min(STEPS * step)));
        let request = Request { step: Some(step / FINER), end, ..Request::default() };
        simulate(&*mechanism, &request, &mut rows).expect("a start");
        Self { model, rows }
    }

    /// The distance of a condition from true, negative before, in every row.
    fn values(&self, condition: &str) -> Vec<f64> {
        let tape = event(self.model, condition);
        let mut evaluator = TapeEvaluator::<Vec<f64>>::new(&tape);
        let value = |[t, q, qd, qdd, multipliers]: &[Vec<f64>; 5]| evaluator.event(t[0], q, qd, qdd, multipliers);
        self.rows.0.iter().map(value).map(|value| value.expect("an event")).collect()
    }

    /// Names of numbers that change, with the middle of their range and half of its width.
    fn terms(&self) -> Vec<(String, f64, f64)> {
        let columns = qrm_sim::columns::columns(self.model.description);
        let names = columns.into_iter().map(|column| column.name.to_string());
        let terms = names.filter(|name| !name.starts_with("residual")).filter_map(|name| {
            let [low, high] = range(&self.values(&format!("{name} >= 0 + 0*t")));
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            (half > 1e-9 * middle.abs().max(1.0)).then_some((name, middle, half))
        });
        terms.collect()
    }
}

fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)])
}

/// A random expression of terms between -1 and 1.
pub(crate) fn expression(random: &mut fastrand::Rng, terms: &[(String, f64, f64)], depth: u32) -> String {
    if depth == 0 || random.f64() < 0.15 {
        let (name, middle, half) = &terms[random.usize(..terms.len())];
        let term = format!("(({name} - ({middle:.3e}))/{half:.3e})");
        return match random.u32(..8) {
            0 => format!("sin({}*{term})", [2, 5, 20, 100][random.usize(..4)]),
            1 => format!("{term}^2"),
            _ => term,
        };
    }
    let mut operand = || expression(random, terms, depth - 1);
    let [a, b] = [operand(), operand()];
    match random.u32(..9) {
        0 => format!("abs({a})"),
        1 => format!("(-({a}))"),
        2 => format!("(0.5*sign({a}) + {b})"),
        3 | 4 => format!("min({a}, {b})"),
        5 => format!("max({a}, {b})"),
        6 => format!("({a} * {b})"),
        7 => format!("({a} / (3 + abs({b})))"),
        _ => format!("({a} + {b})"),
    }
}

/// A bound for the values of an expression, often a little below a maximum.
fn bound(random: &mut fastrand::Rng, values: &[f64]) -> f64 {
    let [low, high] = range(values);
    let maxima: Vec<f64> = values.windows(3).filter(|v| v[1] >= v[0] && v[1] > v[2]).map(|v| v[1]).collect();
    if maxima.is_empty() || random.bool() {
        return low + (high - low) * random.f64();
    }
    maxima[random.usize(..maxima.len().min(50))] - (high - low) * 10.0_f64.powf(-7.0 + 5.0 * random.f64())
}

/// Compares the ends of motions by all methods, and of a sweep in lanes, with the first row at which a condition holds.
fn compare(count: u32, seed: u64) {
    let mut random = fastrand::Rng::with_seed(seed);
    let motions = SCENES.map(Motion::new);
    let terms = motions.each_ref().map(Motion::terms);
    let mut compared = 0;
    while compared < count {
        let number = random.usize(..SCENES.len());
        let (motion, depth) = (&motions[number], random.u32(1..4));
        let formula = expression(&mut random, &terms[number], depth);
        let values = motion.values(&format!("{formula} >= 0"));
        let [low, high] = range(&values);
        let bound = bound(&mut random, &values);
        let first = values.iter().position(|value| *value >= bound);
        let Some(first) = first.filter(|first| *first > 0 && high - low > 1e-6) else { continue };
        compared += 1;
        let condition = format!("{formula} >= {bound:?}");
        let until = event(motion.model, &condition);
        let time = |row: usize| motion.rows.0[row][0][0];
        // The largest value that a motion passed over by, which ends at a time.
        let passed = |t: f64| {
            let rows = (first..values.len()).take_while(|row| time(row + 1) < t);
            rows.map(|row| (values[row] - bound) / (high - low)).fold(0.0, f64::max)
        };
        let mechanism = mechanism(SCENES[number], &[]);
        for (method, rows) in METHODS {
            let what = format!("{} by {} with {rows} steps a row: {condition}", SCENES[number], method.name);
            let settings = MethodSettings::new(method, 1e-11);
            let step = Some(rows * mechanism.schedule().step);
            let mut last = Rows::default();
            let end = Some(End::Event(&until));
            let request = Request { settings, step, end, estimate_error: true, ..Request::default() };
            let outcome = simulate(&*mechanism, &request, &mut last).expect("a start");
            if outcome.estimated_error().is_none_or(|error| error > 1e-9) {
                // Long steps are not accurate enough to be compared.
                continue;
            }
            assert!(matches!(outcome.status, Status::Stopped), "{what}: {:?}", outcome.status);
            assert!(passed(outcome.end_time) < 1e-6, "{what}: {} after {}", outcome.end_time, time(first));
            let [t, q, qd, qdd, multipliers] = last.0.last().expect("a row");
            let mut evaluator = TapeEvaluator::<Vec<f64>>::new(&until);
            let value = evaluator.event(t[0], q, qd, qdd, multipliers).expect("an event");
            assert!(value >= -1e-12 * (1.0 + bound.abs()), "{what}: {value} at {}", t[0]);
        }
        let request = SweepRequest { end: Some(End::Event(&until)), ..SweepRequest::default() };
        for design in sweep(motion.model, &[&|_| None], &request, LaneCount::Most) {
            let what = format!("{} in lanes: {condition}", SCENES[number]);
            assert!(matches!(design.status, Ok(Status::Stopped)), "{what}: {:?}", design.status);
            assert!(passed(design.end_time) < 1e-6, "{what}: {} after {}", design.end_time, time(first));
        }
    }
}

#[test]
fn no_condition_is_passed_over() {
    compare(60, 1);
}

#[test]
#[ignore = "full tier: compiled"]
fn none_of_many_conditions_is_passed_over() {
    compare(2000, 2);
}
