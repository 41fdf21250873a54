//! Means of outputs over a motion.

use nalgebra::{DMatrix, DVector};
use qrm_core::Mechanism;

use crate::integrate::{Integrator, MethodSettings, StepError, quintic};
use crate::quadrature::gauss_legendre;
use crate::solve::Solver;
use crate::state::State;

/// The number of nodes in a piece.
const NODES: usize = 3;
/// A piece is halved until that changes its integral by less than this part of the output's size over a part of a step.
const RESOLVED: f64 = 1e-12;
/// The most pieces that are halved, and the most halvings of a piece.
const MOST_PIECES: u32 = 20_000;
const MOST_HALVINGS: u32 = 40;

/// A difference at an end of a part that is a corner or a jump, in parts of the output's size; and the part of a group
/// in which it may lie without another sign.
const CORNER: f64 = 1e-9;
const BLIND: f64 = 0.03;
/// The number of parts of a step, between whose ends the motion is a polynomial of degree 5; and that of neighbouring
/// parts whose nodes together tell whether an output is smooth.
const PARTS: usize = 8;
const GROUP: usize = 4;

/// The means of all outputs over a motion from a state to a time, and their errors.
///
/// Parts of steps are integrated by Gauss's formula of order 6. Steps end at corners and jumps of loads; parts are
/// halved where outputs have others.
///
/// # Errors
/// The motion does not come to its end.
pub(super) fn output_means(
    mechanism: &dyn Mechanism,
    settings: MethodSettings,
    first: &State,
    end_time: f64,
) -> Result<Vec<(f64, f64)>, StepError> {
    let mut sums = Sums::new(mechanism);
    // The first pass finds the steps.
    let (mut from, mut to) = (first.clone(), first.clone());
    let mut integrator = Integrator::new(mechanism, settings, first, end_time)?;
    integrator.advance(mechanism, &from, end_time, &mut to)?;
    let steps = integrator.steps().to_vec();
    let mut integrator = Integrator::new(mechanism, settings, first, end_time)?;
    to.clone_from(first);
    let mut group: Vec<[State; 2]> = Vec::new();
    for [begin, end] in steps {
        // A step begins behind the corner or jump at the end of the last one.
        for part in 0..=PARTS {
            let t = if part < PARTS { begin + (end - begin) * part as f64 / PARTS as f64 } else { end }.min(end_time);
            if t > to.t {
                std::mem::swap(&mut from, &mut to);
                integrator.advance(mechanism, &from, t, &mut to)?;
                group.push([from.clone(), to.clone()]);
            }
            if part % GROUP == 0 {
                sums.add(&group);
                group.clear();
            }
        }
    }
    Ok(sums.means(end_time - first.t))
}

/// The integrals so far.
struct Sums<'m> {
    mechanism: &'m dyn Mechanism,
    /// Completes states inside pieces.
    solver: Solver,
    nodes: [(f64, f64); NODES],
    /// The polynomial through the nodes of a group.
    group: Group,
    sums: Vec<Sum>,
    /// The pieces that may still be halved: outputs that are rounding errors need ever more.
    left: u32,
}

/// The integral of an output so far, its error, and the largest size of the output.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    integral: f64,
    error: f64,
    size: f64,
}

impl<'m> Sums<'m> {
    fn new(mechanism: &'m dyn Mechanism) -> Self {
        let count = mechanism.description().outputs.len();
        let nodes = gauss_legendre::<NODES>();
        Self {
            mechanism,
            solver: Solver::new(mechanism),
            group: Group::new(&nodes),
            nodes,
            sums: vec![Sum::default(); count],
            left: MOST_PIECES,
        }
    }

    fn means(&self, time: f64) -> Vec<(f64, f64)> {
        let mean = |sum: &Sum| (sum.integral / time, sum.error / time + f64::EPSILON * sum.size);
        self.sums.iter().map(mean).collect()
    }

    /// Adds the motion over neighbouring parts of a step.
    fn add(&mut self, parts: &[[State; 2]]) {
        if parts.len() == GROUP && self.add_smooth(parts) {
            return;
        }
        for [from, to] in parts {
            self.add_part([from, to]);
        }
    }

    /// Adds the motion over as many parts as a group has, if outputs are smooth there: their integral by one polynomial
    /// through all nodes is that by Gauss's formula in each part.
    fn add_smooth(&mut self, parts: &[[State; 2]]) -> bool {
        let count = self.sums.len();
        let length = parts[GROUP - 1][1].t - parts[0][0].t;
        let (mut by_parts, mut by_group) = (vec![0.0; count], vec![0.0; count]);
        let mut outputs = vec![0.0; count];
        let mut at_ends = vec![[0.0; GROUP + 1]; count];
        let Group { weights, ends } = self.group.clone();
        for (part, [from, to]) in parts.iter().enumerate() {
            for (place, (x, weight)) in self.nodes.into_iter().enumerate() {
                let node = NODES * part + place;
                let group_weight = weights[node];
                self.outputs([from, to], from.t + x * (to.t - from.t), &mut outputs);
                for (i, output) in outputs.iter().enumerate() {
                    by_parts[i] += weight * (to.t - from.t) * output;
                    by_group[i] += group_weight * length * output;
                    at_ends[i].iter_mut().zip(&ends).for_each(|(at, weights)| *at += weights[node] * output);
                }
            }
        }
        // A jump or a corner where the formulae agree by chance shows at the ends of parts.
        let mut missed = vec![0.0_f64; count];
        for (end, state) in parts.iter().map(|[from, _]| from).chain([&parts[GROUP - 1][1]]).enumerate() {
            let State { t, q, qd, qdd, multipliers, .. } = state;
            self.mechanism.outputs(*t, q, qd, qdd, multipliers, &mut outputs);
            for (i, output) in outputs.iter().enumerate() {
                missed[i] = missed[i].max((at_ends[i][end] - output).abs());
            }
        }
        if (0..count).any(|i| missed[i] > CORNER * self.sums[i].size) {
            return false;
        }
        let change = |i: usize| (by_parts[i] - by_group[i]).abs().max(BLIND * missed[i] * length);
        let is_smooth = |i: usize| (by_parts[i] - by_group[i]).abs() <= RESOLVED * self.sums[i].size * length;
        if !(0..count).all(is_smooth) {
            return false;
        }
        for (i, sum) in self.sums.iter_mut().enumerate() {
            sum.error += change(i);
            sum.integral += by_parts[i];
        }
        true
    }

    /// Adds the motion between two states of a step.
    fn add_part(&mut self, ends: [&State; 2]) {
        let (from, to) = (ends[0].t, ends[1].t);
        // The pieces that wait, each with its integral and the number of its halvings.
        let mut waiting = vec![(from, to, self.piece(ends, from, to), 0)];
        while let Some((a, b, whole, halvings)) = waiting.pop() {
            let middle = 0.5 * (a + b);
            let halves = [self.piece(ends, a, middle), self.piece(ends, middle, b)];
            let change = |i: usize| (halves[0][i] + halves[1][i] - whole[i]).abs();
            // Halving does not help what is not a number.
            let is_resolved = |i: usize| !(change(i) > RESOLVED * self.sums[i].size * (to - from));
            if halvings < MOST_HALVINGS && self.left > 0 && !(0..whole.len()).all(is_resolved) {
                self.left -= 1;
                let [first, second] = halves;
                waiting.extend([(middle, b, second, halvings + 1), (a, middle, first, halvings + 1)]);
                continue;
            }
            let errors: Vec<f64> =
                (0..whole.len()).map(|i| if is_resolved(i) { change(i) / 16.0 } else { change(i) }).collect();
            for (i, sum) in self.sums.iter_mut().enumerate() {
                // Halves have a 64th of the error, where the output is smooth.
                sum.error += errors[i];
                sum.integral += halves[0][i] + halves[1][i];
            }
        }
    }

    /// The integrals of all outputs over a piece between two states.
    fn piece(&mut self, ends: [&State; 2], a: f64, b: f64) -> Vec<f64> {
        let mut integrals = vec![0.0; self.sums.len()];
        let mut outputs = integrals.clone();
        for (x, weight) in self.nodes {
            self.outputs(ends, a + x * (b - a), &mut outputs);
            for (integral, output) in integrals.iter_mut().zip(&outputs) {
                *integral += weight * (b - a) * output;
            }
        }
        integrals
    }

    /// The outputs at a time between two states.
    fn outputs(&mut self, [from, to]: [&State; 2], t: f64, outputs: &mut [f64]) {
        let mut at = quintic(from, to, t);
        match self.solver.complete(self.mechanism, &mut at) {
            Ok(()) => {
                let State { t, q, qd, qdd, multipliers, .. } = &at;
                self.mechanism.outputs(*t, q, qd, qdd, multipliers, outputs);
            }
            // The mean is not known.
            Err(_) => outputs.fill(f64::NAN),
        }
        for (sum, output) in self.sums.iter_mut().zip(&*outputs) {
            sum.size = sum.size.max(output.abs());
        }
    }
}

/// The polynomial through the nodes of a group of parts of equal length.
#[derive(Clone)]
struct Group {
    /// The weights of the nodes in its mean.
    weights: Vec<f64>,
    /// The weights of the nodes in its values at the ends of parts.
    ends: Vec<Vec<f64>>,
}

impl Group {
    fn new(nodes: &[(f64, f64); NODES]) -> Self {
        const COUNT: usize = NODES * GROUP;
        let places = (0..GROUP).flat_map(|part| nodes.iter().map(move |(x, _)| (part as f64 + x) / GROUP as f64));
        let places: Vec<f64> = places.collect();
        let values = DMatrix::from_fn(COUNT, COUNT, |degree, node| legendre(degree, 2.0 * places[node] - 1.0));
        let factors = values.lu();
        let solve = |right: DVector<f64>| {
            factors.solve(&right).map_or_else(|| vec![f64::NAN; COUNT], |weights| weights.as_slice().to_vec())
        };
        // The means of Legendre polynomials are zero, but for the first.
        let mean = DVector::from_fn(COUNT, |degree, _| f64::from(u8::from(degree == 0)));
        let end =
            |end: usize| DVector::from_fn(COUNT, |degree, _| legendre(degree, 2.0 * end as f64 / GROUP as f64 - 1.0));
        Self { weights: solve(mean), ends: (0..=GROUP).map(|place| solve(end(place))).collect() }
    }
}

/// A Legendre polynomial.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut before, mut value) = (0.0, 1.0);
    for k in 0..degree {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0));
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polynomial_of_a_group_is_exact_for_its_degree() {
        let nodes = gauss_legendre::<NODES>();
        let group = Group::new(&nodes);
        let places: Vec<f64> =
            (0..GROUP).flat_map(|part| nodes.iter().map(move |(x, _)| (part as f64 + x) / GROUP as f64)).collect();
        for degree in 0..12 {
            let sum = |weights: &[f64]| -> f64 { weights.iter().zip(&places).map(|(w, x)| w * x.powi(degree)).sum() };
            assert!((sum(&group.weights) - 1.0 / f64::from(degree + 1)).abs() < 1e-13, "{degree}");
            for (place, weights) in group.ends.iter().enumerate() {
                let expected = (place as f64 / GROUP as f64).powi(degree);
                assert!((sum(weights) - expected).abs() < 1e-11, "{degree} {place}: {}", sum(weights) - expected);
            }
        }
    }
}
