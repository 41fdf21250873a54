//! Link lengths of a quick-return mechanism, its crank driven at constant speed, that give a wanted stroke and time
//! ratio with the least peak force between block and rocker. The optimiser (L-BFGS of the crate argmin) gets exact
//! gradients: the motion with its derivatives takes a millisecond.

use argmin::core::{CostFunction, Error, Executor, Gradient, State};
use argmin::solver::linesearch::BacktrackingLineSearch;
use argmin::solver::linesearch::condition::ArmijoCondition;
use argmin::solver::quasinewton::LBFGS;
use qrm_core::Model;
use qrm_model::quick_return_driven::{DESCRIPTION, Parameters, QuickReturnDriven};
use qrm_sim::analysis::{Derivatives, OutputValues, SensitivityRequest, sensitivity};

/// The mechanism.
const MODEL: Model = Model::from_generated::<QuickReturnDriven, 3, 3>();

/// The lengths that may change.
const LENGTHS: [&str; 5] = ["O2A", "O4O2", "O4B", "BC", "yC"];
/// How far, in m: what fits into the frame.
const BOUNDS: [[f64; 2]; 5] = [[0.1, 0.3], [0.25, 0.4], [0.4, 0.9], [0.4, 0.8], [0.6, 1.0]];
/// The wanted stroke in m.
const STROKE: f64 = 0.8;
/// The wanted ratio of the time of the slow stroke to that of the fast one.
const TIME_RATIO: f64 = 2.0;

/// A number and its derivatives by the lengths.
#[derive(Clone)]
struct Number(f64, Vec<f64>);

impl Number {
    /// A function of others, with its derivatives by them.
    fn from_parts(value: f64, parts: &[(f64, &Derivatives)]) -> Self {
        let by = |i: usize| parts.iter().map(|(slope, part)| slope * part.by[i]).sum();
        Self(value, (0..LENGTHS.len()).map(by).collect())
    }
}

/// The properties of a mechanism that the optimiser needs.
struct Design {
    stroke: Number,
    time_ratio: Number,
    peak: Number,
}

impl Design {
    fn new(lengths: &[f64]) -> Result<Self, Error> {
        let replace = |name: &str| LENGTHS.iter().position(|length| *length == name).map(|i| lengths[i]);
        let request = SensitivityRequest { by: &LENGTHS, ..SensitivityRequest::default() };
        let found = sensitivity(&MODEL, &replace, &request).map_err(|e| Error::msg(format!("{e:?}")))?;
        let output = |name| &found.outputs[DESCRIPTION.outputs.iter().position(|o| o.name == name).unwrap_or(0)];
        let OutputValues { minimum: [low, low_time], maximum: [high, high_time], .. } = output("x6");
        let stroke = Number::from_parts(high.value - low.value, &[(1.0, high), (-1.0, low)]);
        // One stroke lies between the two, the other one takes the rest of the turn.
        let between = (high_time.value - low_time.value).abs();
        let (turn, sign) = (found.end_time.value, (high_time.value - low_time.value).signum());
        let (ratio, slope) = if between > 0.5 * turn {
            (between / (turn - between), turn / (turn - between).powi(2))
        } else {
            ((turn - between) / between, -turn / between.powi(2))
        };
        let time_ratio = Number::from_parts(ratio, &[(sign * slope, high_time), (-sign * slope, low_time)]);
        let OutputValues { minimum: [pull, _], maximum: [push, _], .. } = output("N3");
        let peak = if push.value > -pull.value {
            Number::from_parts(push.value, &[(1.0, push)])
        } else {
            Number::from_parts(-pull.value, &[(-1.0, pull)])
        };
        Ok(Self { stroke, time_ratio, peak })
    }

    /// How far it is from what is wanted, relatively.
    fn misses(&self) -> [Number; 2] {
        [(&self.stroke, STROKE), (&self.time_ratio, TIME_RATIO)].map(|(number, wanted)| {
            Number(number.0 / wanted - 1.0, number.1.iter().map(|slope| slope / wanted).collect())
        })
    }
}

/// The peak force, with what is wanted as constraints (augmented Lagrangian). Lengths are `middle + half * sin(u)` of
/// their bounds, so that any `u` will do.
#[derive(Clone)]
struct Wish {
    /// The peak force of the start.
    unit: f64,
    multipliers: [f64; 2],
}

/// How much a miss weighs.
const WEIGHT: f64 = 100.0;

/// Lengths, and their derivatives by `u`.
fn lengths(u: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let each = u.iter().zip(BOUNDS).map(|(u, [low, high])| {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        (middle + half * u.sin(), half * u.cos())
    });
    each.unzip()
}

impl CostFunction for Wish {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, u: &Vec<f64>) -> Result<f64, Error> {
        // Lengths that cannot be assembled or do not turn are no way to go.
        let Ok(design) = Design::new(&lengths(u).0) else { return Ok(f64::INFINITY) };
        let constraints = design.misses().into_iter().zip(self.multipliers);
        Ok(constraints.fold(design.peak.0 / self.unit, |sum, (miss, l)| sum + l * miss.0 + WEIGHT * miss.0.powi(2)))
    }
}

impl Gradient for Wish {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, u: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let (lengths, slopes) = lengths(u);
        let design = Design::new(&lengths)?;
        let misses = design.misses();
        let by = |i: usize| {
            let constraints =
                misses.iter().zip(self.multipliers).map(|(miss, l)| (l + 2.0 * WEIGHT * miss.0) * miss.1[i]);
            (design.peak.1[i] / self.unit + constraints.sum::<f64>()) * slopes[i]
        };
        Ok((0..LENGTHS.len()).map(by).collect())
    }
}

fn main() -> Result<(), Error> {
    let p = Parameters::<f64>::default();
    let start = vec![p.O2A, p.O4O2, p.O4B, p.BC, p.yC];
    print_head();
    let unit = print("start", &start)?.peak.0;
    // What a textbook gives: the crank sets the time ratio, the rocker the stroke, rod and guide stay.
    let by_hand = print("by hand", &[0.5 * p.O4O2, p.O4O2, STROKE, p.BC, p.yC])?.peak.0;
    let mut wish = Wish { unit, multipliers: [0.0; 2] };
    let place = |(length, [low, high]): (&f64, [f64; 2])| ((2.0 * length - low - high) / (high - low)).asin();
    let mut u: Vec<f64> = start.iter().zip(BOUNDS).map(place).collect();
    for round in 1..=6 {
        let search = BacktrackingLineSearch::new(ArmijoCondition::new(1e-4)?).rho(0.5)?;
        let solver = LBFGS::new(search, 7);
        let result =
            Executor::new(wish.clone(), solver).configure(|state| state.param(u.clone()).max_iters(60)).run()?;
        u = result.state().get_best_param().cloned().unwrap_or(u);
        let design = print(&format!("round {round}"), &lengths(&u).0)?;
        for (multiplier, miss) in wish.multipliers.iter_mut().zip(design.misses()) {
            *multiplier += 2.0 * WEIGHT * miss.0;
        }
    }
    let found = Design::new(&lengths(&u).0)?;
    let worst = found.misses().iter().map(|miss| miss.0.abs()).fold(0.0, f64::max);
    println!(
        "\nstroke and time ratio within {:.4} % of the wish, peak force {:.1} % of the start's, {:.1} % of that by \
         hand",
        100.0 * worst,
        100.0 * found.peak.0 / unit,
        100.0 * found.peak.0 / by_hand
    );
    if worst < 1e-3 && found.peak.0 < unit.min(by_hand) {
        Ok(())
    } else {
        Err(Error::msg("no mechanism was found that is better"))
    }
}

fn print_head() {
    print!("{:10}", "");
    for name in LENGTHS.iter().chain(&["stroke", "ratio", "peak N3"]) {
        print!("{name:>11}");
    }
    println!();
}

fn print(what: &str, lengths: &[f64]) -> Result<Design, Error> {
    let design = Design::new(lengths)?;
    print!("{what:10}");
    for number in lengths.iter().chain([&design.stroke.0, &design.time_ratio.0]) {
        print!("{number:11.5}");
    }
    println!("{:11.1}", design.peak.0);
    Ok(design)
}
