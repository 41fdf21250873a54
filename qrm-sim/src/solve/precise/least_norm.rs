//! Multipliers of redundant constraints.

use qrm_core::Scalar;

use super::Number;
use super::elimination::Elimination;

/// The multipliers of all constraints that have the smallest norm and exert the same force as given multipliers of
/// independent constraints; `None` if those constraints are dependent.
///
/// With the rows `C` of the Jacobian, `n` entries each, and the rows `D` of the independent constraints, the
/// multipliers are `C D' z`, where `(D C')(C D') z = D D' multipliers`.
pub(super) fn least_norm(
    jacobian: &[Number],
    n: usize,
    independent: &[usize],
    multipliers: &[Number],
) -> Option<Vec<Number>> {
    if independent.is_empty() {
        return Some(vec![Number::zero(); jacobian.len() / n]);
    }
    let row = |k: usize| &jacobian[k * n..][..n];
    // The rows of `C D'`.
    let products: Vec<Vec<Number>> = jacobian
        .chunks_exact(n)
        .map(|constraint| independent.iter().map(|&k| dot(constraint, row(k))).collect())
        .collect();
    let mut system = Elimination::zero(independent.len());
    for (i, entries) in system.entries_mut().chunks_exact_mut(independent.len()).enumerate() {
        for (j, entry) in entries.iter_mut().enumerate() {
            *entry = products.iter().fold(Number::zero(), |sum, products| sum + products[i] * products[j]);
        }
    }
    let right: Vec<Number> = independent.iter().map(|&k| dot(&products[k], multipliers)).collect();
    let mut z = right.clone();
    system.factor().then(|| system.solve(&right, &mut z))?;
    Some(products.iter().map(|products| dot(products, &z)).collect())
}

fn dot(a: &[Number], b: &[Number]) -> Number {
    a.iter().zip(b).fold(Number::zero(), |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows `r`, `2 r` and `s` with `D = (r, s)`: a force `5 r` is shared as 1 to 2 by the first two.
    #[test]
    fn a_force_is_shared_by_constraints_that_repeat_each_other() {
        let jacobian = [1.0, 2.0, 2.0, 4.0, 0.0, 3.0].map(Number::from);
        let shared = least_norm(&jacobian, 2, &[0, 2], &[5.0, 7.0].map(Number::from)).expect("independent rows");
        for (shared, exact) in shared.into_iter().zip([1.0, 2.0, 7.0]) {
            assert!((shared - exact.into()).to_f64().abs() < 1e-28, "{shared:?}");
        }
        assert!(least_norm(&jacobian, 2, &[0, 1], &[5.0, 7.0].map(Number::from)).is_none());
    }
}
