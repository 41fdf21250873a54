//! Positions from which equilibria are sought.

use std::f64::consts::{PI, TAU};

use qrm_core::Mechanism;

use super::closed;
use super::search::Search;
use crate::analysis::modes::NoModes;
use crate::position::LoopSolver;

/// The number of positions of a mechanism with one degree of freedom, and of others.
const ONE: u32 = 24;
const MANY: u32 = 64;
/// With more degrees of freedom, so few positions say nothing about all equilibria.
pub(super) const MOST_FREEDOM: usize = 8;

/// Closed positions whose given coordinates are spread evenly, as far as the mechanism moves there; none with
/// more than eight degrees of freedom.
///
/// # Errors
/// The start is singular, or gives more or fewer coordinates than degrees of freedom.
pub(super) fn positions(mechanism: &dyn Mechanism, search: &Search) -> Result<Vec<Vec<f64>>, NoModes> {
    let from = &search.from;
    let singular = || NoModes::Singular { q: from.clone() };
    let given: Vec<usize> = (0..from.len()).filter(|&i| search.preferred[i]).collect();
    let drive = LoopSolver::new(mechanism, search.preferred.clone()).ok_or_else(singular)?;
    let start = closed(mechanism, search.preferred.clone(), from.clone()).ok_or_else(singular)?;
    let length = drive.size(&start);
    let count = match given.len() {
        1 => ONE,
        2..=MOST_FREEDOM => MANY,
        _ => 0,
    };
    let position = |k: u32| {
        let mut to = from.clone();
        for (&i, fraction) in given.iter().zip(fractions(given.len(), k)) {
            to[i] += if drive.is_angle(i) { TAU * fraction - PI } else { length * (2.0 * fraction - 1.0) };
        }
        match drive.move_to(&start, &to) {
            Ok(position) => position.q,
            Err(limit) => limit.position.q,
        }
    };
    Ok((1..=count).map(position).collect())
}

/// The point with this number of a sequence that fills the unit cube evenly: multiples of the powers of `1/x`, where
/// `x^(d + 1) = x + 1`.
fn fractions(dimensions: usize, k: u32) -> Vec<f64> {
    let exponent = 1.0 / (dimensions as f64 + 1.0);
    let root = (0..60).fold(1.5_f64, |root, _| (1.0 + root).powf(exponent));
    (1..=dimensions as i32).map(|power| (0.5 + f64::from(k) * root.powi(-power)).fract()).collect()
}

#[cfg(test)]
mod tests {
    use super::fractions;

    #[test]
    fn points_fill_the_line_and_the_square_evenly() {
        // The golden ratio, and the real root of x^3 = x + 1.
        assert!((fractions(1, 1)[0] - 0.118_033_988_749_895).abs() < 1e-14);
        assert!((fractions(2, 1)[0] - 0.254_877_666_246_692_8).abs() < 1e-14);
        let mut cells: Vec<u32> = (1..=24).map(|k| (fractions(1, k)[0] * 12.0) as u32).collect();
        cells.sort_unstable();
        cells.dedup();
        assert_eq!(cells.len(), 12);
    }
}
