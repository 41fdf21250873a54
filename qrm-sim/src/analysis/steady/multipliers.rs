//! Floquet multipliers: the factors by which small deviations grow in a period.

use nalgebra::{Complex, DMatrix};

use super::error::NoSteadyMotion;
use super::return_map::{Found, ReturnMap};
use crate::analysis::sensitivity::EndByStart;
use crate::analysis::spectrum::eigenvalues;

/// The rounding error of the derivatives of a period, relative to their size.
const ROUNDING: f64 = 1e-13;

/// A Floquet multiplier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiplier {
    /// The value.
    pub value: Complex<f64>,
    /// The estimated error of its size.
    pub error: f64,
}

/// The multipliers of a motion, the largest first, with their differences from those by steps half as long.
///
/// # Errors
/// The eigenvalues cannot be computed.
pub(super) fn multipliers(map: &ReturnMap, found: &Found, accurate: &Found) -> Result<Vec<Multiplier>, NoSteadyMotion> {
    let own = values(map, &found.at)?;
    let mut others = values(map, &accurate.at)?;
    // Small multipliers of a large matrix have its rounding errors.
    let floor = ROUNDING * map.jacobian(&found.at).norm().max(1.0);
    let mut all: Vec<Multiplier> = own
        .into_iter()
        .map(|value| {
            let nearest =
                (0..others.len()).min_by(|&a, &b| (others[a] - value).norm().total_cmp(&(others[b] - value).norm()));
            let difference = nearest.map_or(f64::INFINITY, |place| (others.swap_remove(place) - value).norm());
            Multiplier { value, error: difference.max(floor) }
        })
        .collect();
    all.sort_by(|a, b| b.value.norm().total_cmp(&a.value.norm()).then(b.value.im.total_cmp(&a.value.im)));
    Ok(all)
}

/// The eigenvalues of the return map: over the period, or to the same phase where the period is free.
fn values(map: &ReturnMap, at: &EndByStart) -> Result<Vec<Complex<f64>>, NoSteadyMotion> {
    let jacobian = map.jacobian(at);
    let matrix = match map.phase() {
        None => jacobian,
        Some(phase) => {
            let rates = map.rates(at);
            let kept: Vec<usize> = (0..map.unknowns()).filter(|&i| i != phase).collect();
            // A deviation of the phase at the end is made up for by the time `-d/rate`.
            DMatrix::from_fn(kept.len(), kept.len(), |row, column| {
                let (row, column) = (kept[row], kept[column]);
                jacobian[(row, column)] - rates[row] * jacobian[(phase, column)] / rates[phase]
            })
        }
    };
    if matrix.is_empty() {
        return Ok(Vec::new());
    }
    eigenvalues(matrix).ok_or(NoSteadyMotion::NoEigenvalues)
}
