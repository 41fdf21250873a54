//! Statistics of samples.

/// The statistics of the samples of a quantity.
#[derive(Clone, Debug, Default)]
pub(super) struct Statistics {
    /// The number of samples.
    pub(super) count: usize,
    pub(super) mean: f64,
    pub(super) deviation: f64,
    /// Smallest value, quantiles of 0.135 %, 50 % and 99.865 %, and largest value.
    pub(super) quantiles: [f64; 5],
    /// The square of the correlation with each parameter: its share in the variance, if the quantity is linear.
    pub(super) correlations: Vec<f64>,
}

/// The probabilities of a normal distribution below -3, 0 and 3 standard deviations.
const PROBABILITIES: [f64; 3] = [0.001_349_898, 0.5, 0.998_650_102];

impl Statistics {
    /// Computes statistics of the finite values; `inputs` holds the values of each parameter in the same samples.
    pub(super) fn new(values: &[f64], inputs: &[Vec<f64>]) -> Self {
        let known: Vec<usize> = (0..values.len()).filter(|&i| values[i].is_finite()).collect();
        if known.is_empty() {
            let correlations = vec![0.0; inputs.len()];
            return Self { correlations, quantiles: [f64::NAN; 5], mean: f64::NAN, ..Self::default() };
        }
        let centred = |of: &[f64]| -> (f64, Vec<f64>) {
            let first = of[known[0]];
            // Differences from the first value lose fewer digits.
            let mean = first + known.iter().map(|&i| of[i] - first).sum::<f64>() / known.len() as f64;
            (mean, known.iter().map(|&i| of[i] - mean).collect())
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let (mean, own) = centred(values);
        let square = dot(&own, &own);
        let correlation = |input: &Vec<f64>| {
            let (_, input) = centred(input);
            let size = dot(&input, &input) * square;
            if size > 0.0 { dot(&own, &input).powi(2) / size } else { 0.0 }
        };
        let mut sorted: Vec<f64> = known.iter().map(|&i| values[i]).collect();
        sorted.sort_by(f64::total_cmp);
        let [low, middle, high] = PROBABILITIES.map(|probability| quantile(&sorted, probability));
        Self {
            count: known.len(),
            mean,
            deviation: (square / (known.len().max(2) - 1) as f64).sqrt(),
            quantiles: [sorted[0], low, middle, high, sorted[sorted.len() - 1]],
            correlations: inputs.iter().map(correlation).collect(),
        }
    }
}

/// The quantile of sorted values, interpolated between two of them.
fn quantile(sorted: &[f64], probability: f64) -> f64 {
    let place = probability * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - place.floor()) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statistics_of_a_plane() {
        // z = 3 x + 4 y on a grid: x and y are independent, with equal variances.
        let grid: Vec<[f64; 2]> = (0..20).flat_map(|i| (0..20).map(move |j| [f64::from(i), f64::from(j)])).collect();
        let inputs = [0, 1].map(|k| grid.iter().map(|point| point[k]).collect::<Vec<f64>>());
        let mut values: Vec<f64> = grid.iter().map(|[x, y]| 3.0 * x + 4.0 * y).collect();
        let exact = Statistics::new(&values, &inputs);
        assert!((exact.mean - 66.5).abs() < 1e-12);
        // The variance of 0 to 19 is 33.25.
        assert!((exact.deviation.powi(2) * 399.0 / 400.0 - 25.0 * 33.25).abs() < 1e-9, "{exact:?}");
        assert!((exact.correlations[0] - 0.36).abs() < 1e-12 && (exact.correlations[1] - 0.64).abs() < 1e-12);
        assert_eq!([exact.quantiles[0], exact.quantiles[2], exact.quantiles[4]], [0.0, 66.5, 133.0]);
        values[7] = f64::NAN;
        assert_eq!(Statistics::new(&values, &inputs).count, 399);
    }

    #[test]
    fn samples_that_all_fail_have_none() {
        let none = Statistics::new(&[f64::NAN; 3], &[vec![1.0, 2.0, 3.0]]);
        assert!(none.count == 0 && none.mean.is_nan());
    }
}
