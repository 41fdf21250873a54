//! A quantity of a motion under tolerances.

use super::nominal::Nominal;
use super::options::Distribution;
use super::parameter::TolerancedParameter;
use super::slope::Slope;
use super::statistics::Statistics;
use super::worst_case::WorstCase;

/// A quantity of a motion, and the effect of tolerances on it.
pub(super) struct Quantity {
    /// The column of a sweep.
    pub(super) name: String,
    pub(super) unit: String,
    pub(super) nominal: Nominal,
    /// The slopes of the quantity for each toleranced parameter.
    pub(super) slopes: Vec<Slope>,
    pub(super) worst: WorstCase,
    pub(super) statistics: Statistics,
    /// The smallest change that is significant.
    pub(super) resolution: f64,
    /// The largest observed error of its values in the samples.
    pub(super) sample_error: f64,
}

impl Quantity {
    /// The standard deviation from the slopes, and the share of each parameter in its square.
    pub(super) fn linear(&self, parameters: &[TolerancedParameter], distribution: Distribution) -> (f64, Vec<f64>) {
        let square = |(slope, parameter): (&Slope, &TolerancedParameter)| {
            (slope.value() * parameter.tolerance * distribution.deviation()).powi(2)
        };
        let squares: Vec<f64> = self.slopes.iter().zip(parameters).map(square).collect();
        let sum: f64 = squares.iter().sum();
        (sum.sqrt(), squares.iter().map(|square| if sum > 0.0 { square / sum } else { 0.0 }).collect())
    }
}
