//! Gauss-Legendre quadrature.

/// The nodes between -1 and 1, and the weights, of the rule that is exact for polynomials of degree 5.
pub(crate) const GAUSS_3: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];

/// The number of nodes of the rule that is exact for polynomials of degree 31.
pub(crate) const NODES: usize = 16;

/// Computes nodes between 0 and 1 with their weights, by Newton's method on the Legendre polynomial.
pub(crate) fn gauss_legendre<const N: usize>() -> [(f64, f64); N] {
    let n = N as f64;
    std::array::from_fn(|i| {
        // Nodes come in pairs; the smaller one of a pair is accurate relative to its distance from -1.
        let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 0.0;
        for _ in 0..10 {
            let (mut before, mut now) = (1.0, x);
            for k in 2..=N {
                (before, now) = (now, next_legendre(k, x, [before, now]));
            }
            slope = n * (x * now - before) / (x * x - 1.0);
            x -= now / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// The Legendre polynomial of degree `k` at `x`, from the two of lower degrees.
#[inline]
pub(crate) fn next_legendre(k: usize, x: f64, [before, now]: [f64; 2]) -> f64 {
    let k = k as f64;
    ((2.0 * k - 1.0) * x * now - (k - 1.0) * before) / k
}

#[cfg(test)]
mod tests {
    use super::{NODES, gauss_legendre};

    #[test]
    fn polynomials_are_integrated_exactly() {
        let rule = gauss_legendre::<NODES>();
        for degree in 0..32 {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
            assert!((sum * f64::from(degree + 1) - 1.0).abs() < 4e-15, "{degree}: {sum}");
        }
    }
}
