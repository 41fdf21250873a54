//! Monte Carlo samples of mechanisms with tolerances.

use std::collections::BTreeSet;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::motions::Motions;
use super::options::{Distribution, Options};
use super::parameter::TolerancedParameter;
use super::worst_case::Probes;
use crate::error::Error;

/// The results of the samples.
pub(super) struct Samples {
    /// The values of each parameter in all samples.
    pub(super) points: Vec<Vec<f64>>,
    /// The values of each quantity in all samples; not a number where the sample failed.
    pub(super) values: Vec<Vec<f64>>,
    /// The largest difference of each quantity between a motion in lanes and the same motion run separately.
    pub(super) errors: Vec<f64>,
    /// The number of failed samples, and the reason of the first failure.
    pub(super) failed: usize,
    pub(super) reason: Option<String>,
}

impl Samples {
    /// The number of samples, failed ones included.
    pub(super) fn count(&self) -> usize {
        self.values.first().map_or(0, Vec::len)
    }

    /// Runs samples and the probes in lanes, and adds the extreme samples within the tolerances to the probes.
    ///
    /// # Errors
    /// Every sample fails, or the user interrupts.
    pub(super) fn run(
        motions: &mut Motions,
        parameters: &[TolerancedParameter],
        probes: &mut Probes,
        options: &Options,
    ) -> Result<Self, Error> {
        let (first, count) = (probes.count(), options.samples as usize);
        let mut points: Vec<Vec<f64>> = probes.points.clone();
        draw(&mut points, parameters, count, options);
        let mut found = motions.in_lanes(&points, first)?;
        found.failures.retain(|(design, _)| *design >= first);
        if found.failures.len() == count {
            let why = found.failures.first().map_or("", |(_, why)| why);
            return Err(Error::run(format!("every sample fails: {why}")).help("choose smaller tolerances"));
        }
        points.iter_mut().for_each(|points| drop(points.drain(..first)));
        let of_probes: Vec<Vec<f64>> = found.values.iter_mut().map(|values| values.drain(..first).collect()).collect();
        let mut samples = Self {
            points,
            values: found.values,
            errors: vec![0.0; of_probes.len()],
            failed: found.failures.len(),
            reason: found.failures.into_iter().next().map(|(_, why)| why),
        };
        for (quantity, values) in of_probes.iter().enumerate() {
            samples.compare(quantity, values.iter().zip(&probes.values[quantity]));
        }
        let extreme = samples.extremes(parameters, probes);
        let designs: Vec<Vec<f64>> =
            extreme.iter().map(|sample| samples.points.iter().map(|points| points[*sample]).collect()).collect();
        if !designs.is_empty() {
            probes.add(motions, &designs)?;
        }
        for quantity in 0..samples.values.len() {
            let values: Vec<f64> = extreme.iter().map(|sample| samples.values[quantity][*sample]).collect();
            samples.compare(quantity, values.iter().zip(&probes.values[quantity][first..]));
        }
        Ok(samples)
    }

    /// Updates the differences between motions in lanes and separate ones.
    fn compare<'v>(&mut self, quantity: usize, pairs: impl Iterator<Item = (&'v f64, &'v f64)>) {
        let error = &mut self.errors[quantity];
        *error = pairs.map(|(lane, alone)| (lane - alone).abs()).fold(*error, f64::max);
    }

    /// The samples within the tolerances at which some quantity exceeds all probes the most.
    fn extremes(&self, parameters: &[TolerancedParameter], probes: &Probes) -> Vec<usize> {
        let is_within = |sample: &usize| {
            let within = |(parameter, points): (&TolerancedParameter, &Vec<f64>)| {
                (points[*sample] - parameter.value).abs() <= parameter.tolerance
            };
            parameters.iter().zip(&self.points).all(within)
        };
        let within: Vec<usize> = (0..self.count()).filter(is_within).collect();
        let mut extremes = BTreeSet::new();
        for (quantity, values) in self.values.iter().enumerate() {
            let [least, most] = probes.worst_case(quantity).ends;
            let known = || within.iter().copied().filter(|sample| values[*sample].is_finite());
            let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
            extremes.extend(known().min_by(by_value).filter(|sample| values[*sample] < least));
            extremes.extend(known().max_by(by_value).filter(|sample| values[*sample] > most));
        }
        extremes.into_iter().collect()
    }
}

/// Adds random samples of the parameters.
fn draw(points: &mut [Vec<f64>], parameters: &[TolerancedParameter], count: usize, options: &Options) {
    points.iter_mut().for_each(|points| points.reserve(count));
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    for _ in 0..count {
        for (points, TolerancedParameter { value, tolerance, .. }) in points.iter_mut().zip(parameters) {
            points.push(match options.distribution {
                Distribution::Normal => {
                    value + tolerance * options.distribution.deviation() * random.sample::<f64, _>(StandardNormal)
                }
                Distribution::Uniform => value + tolerance * random.random_range(-1.0..=1.0),
            });
        }
    }
}
