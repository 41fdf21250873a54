//! Floquet multipliers: the factors by which small deviations grow in a period.

use nalgebra::{Complex, DMatrix};

use super::error::NoSteadyMotion;
use super::newton::Found;
use super::return_map::ReturnMap;
use crate::analysis::sensitivity::EndByStart;
use crate::analysis::spectrum::eigenvalues;

/// The rounding error of the derivatives of a period, relative to their size.
const ROUNDING: f64 = 1e-13;
/// The ratio of a true error to a stated one that is allowed for.
const MARGIN: f64 = 3.0;

/// A Floquet multiplier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Multiplier {
    /// The value.
    pub value: Complex<f64>,
    /// The estimated error of its size.
    pub error: f64,
}

/// The stability of a periodic motion: the fate of small deviations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionStability {
    /// There are none: the drives leave no degree of freedom.
    NoDeviation,
    /// All become smaller.
    Attracting,
    /// One grows.
    Repelling,
    /// The largest multiplier is one within its error.
    Undecided,
    /// None grows, and the motion is one of many at other speeds or amplitudes.
    OneOfMany,
}

impl MotionStability {
    /// The stability by the multipliers, the largest first; `is_singular` says whether other motions are near.
    pub(super) fn new(multipliers: &[Multiplier], is_singular: bool) -> Self {
        if multipliers.is_empty() {
            return Self::NoDeviation;
        }
        // A shift of speed or amplitude neither grows nor decays.
        let is_one = |m: &Multiplier| (m.value - 1.0).norm() <= (MARGIN * m.error).max(MARGIN * ROUNDING.sqrt());
        let grows = |m: &Multiplier| m.value.norm() - MARGIN * m.error > 1.0;
        let decays = |m: &Multiplier| m.value.norm() + MARGIN * m.error < 1.0;
        if is_singular && multipliers.iter().any(is_one) {
            let other = multipliers.iter().filter(|m| !is_one(m)).any(grows);
            return if other { Self::Repelling } else { Self::OneOfMany };
        }
        if multipliers.iter().all(decays) {
            Self::Attracting
        } else if multipliers.iter().any(grows) {
            Self::Repelling
        } else {
            Self::Undecided
        }
    }
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
    let all = own.iter().enumerate().map(|(i, value)| {
        let nearest =
            (0..others.len()).min_by(|&a, &b| (others[a] - value).norm().total_cmp(&(others[b] - value).norm()));
        let difference = nearest.map_or(f64::INFINITY, |place| (others.swap_remove(place) - value).norm());
        // Rounding errors separate equal multipliers by about the square root of their size.
        let near = own.iter().enumerate().filter(|(other, _)| *other != i).map(|(_, other)| (other - value).norm());
        let apart = near.filter(|distance| *distance <= MARGIN * floor.sqrt()).fold(0.0, f64::max);
        Multiplier { value: *value, error: difference.max(floor).max(apart) }
    });
    let mut all: Vec<Multiplier> = all.collect();
    all.sort_by(|a, b| b.value.norm().total_cmp(&a.value.norm()).then(b.value.im.total_cmp(&a.value.im)));
    Ok(all)
}

/// The eigenvalues of the return map: over the period, or to the same phase where the period is free.
pub(super) fn values(map: &ReturnMap, at: &EndByStart) -> Result<Vec<Complex<f64>>, NoSteadyMotion> {
    let jacobian = map.jacobian(at);
    let matrix = match map.phase() {
        None => jacobian,
        Some(phase) => {
            let rates = map.rates(at);
            let kept: Vec<usize> = (0..map.places().len()).filter(|&i| i != phase).collect();
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
