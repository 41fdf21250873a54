//! Sine and cosine against values to 60 digits, from series in integers.

use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive, Zero};
use qrm_core::{Angles, Fused, Scalar};

/// The number of fractional bits of fixed-point numbers.
const BITS: u64 = 260;

fn one() -> BigInt {
    BigInt::from(1) << BITS
}

/// A double, exactly.
fn fixed(x: f64) -> BigInt {
    let bits = x.abs().to_bits();
    let exponent = (bits >> 52) as i64 - 1075;
    let digits = BigInt::from((bits & ((1 << 52) - 1)) | (1 << 52));
    let shift = BITS as i64 + exponent;
    let value = if shift >= 0 { digits << shift as u64 } else { digits >> (-shift) as u64 };
    if x < 0.0 { -value } else { value }
}

/// A fixed-point number as a double and a second double for the rest.
fn double(x: &BigInt) -> (f64, f64) {
    let high = x.to_f64().unwrap_or(f64::NAN) / 2f64.powi(BITS as i32);
    let rest = (x - fixed(high)).to_f64().unwrap_or(f64::NAN) / 2f64.powi(BITS as i32);
    (high, rest)
}

/// Pi by Machin's formula.
fn pi() -> BigInt {
    let arctan = |over: i64| {
        let (mut power, mut sum, mut k) = (one() / over, BigInt::zero(), 1_i64);
        while !power.is_zero() {
            sum += &power / k;
            power /= -over * over;
            k += 2;
        }
        sum
    };
    4 * (4 * arctan(5) - arctan(239))
}

/// Sine and cosine by their series.
fn series(x: &BigInt) -> (BigInt, BigInt) {
    let (mut sine, mut cosine) = (BigInt::zero(), BigInt::zero());
    let (mut term, mut k) = (one(), 0_i64);
    while !term.is_zero() {
        let sum = if k % 2 == 0 { &mut cosine } else { &mut sine };
        if k % 4 < 2 {
            *sum += &term
        } else {
            *sum -= &term
        };
        k += 1;
        term = ((term * x) >> BITS) / k;
    }
    (sine, cosine)
}

/// Errors of sine and cosine in units in the last place of the exact value.
fn errors(x: f64, (sin, cos): (f64, f64), pi: &BigInt) -> [f64; 2] {
    let turn = 2 * pi;
    let mut rest: BigInt = fixed(x) % &turn;
    if rest.is_negative() {
        rest += turn;
    }
    let (exact_sin, exact_cos) = series(&rest);
    [(sin, exact_sin), (cos, exact_cos)].map(|(got, exact)| {
        let (high, low) = double(&exact);
        let unit = high.abs().max(f64::MIN_POSITIVE);
        let unit = f64::from_bits(unit.to_bits() + 1) - unit;
        ((got - high) - low).abs() / unit
    })
}

fn angles() -> Vec<f64> {
    let mut random = fastrand::Rng::with_seed(7);
    let mut angles = vec![0.0, 1e-30, -1e-9, 1e6, -1e6, 1e9, 3.2e15, -7e22];
    for size in [0.1, 1.0, 10.0, 1e3, 1e5, 1e6] {
        angles.extend((0..200).map(|_| size * (2.0 * random.f64() - 1.0)));
    }
    // Relative errors show where a result is small.
    angles.extend((1..400).map(|n| f64::from(n * n) * std::f64::consts::FRAC_PI_4));
    angles
}

#[test]
fn errors_stay_below_a_unit_in_the_last_place_at_any_angle() {
    let pi = pi();
    let mut worst = 0.0_f64;
    for x in angles() {
        let fused = Fused(x).sin_cos();
        for [sine, cosine] in [
            errors(x, x.sin_cos_of_this_crate(), &pi),
            errors(x, (fused.0.0, fused.1.0), &pi),
            errors(x, x.sin_cos_apart(), &pi),
            errors(x, x.sin_cos_far(), &pi),
        ] {
            assert!(sine < 0.85 && cosine < 0.85, "{x:e}: {sine} and {cosine} units");
            worst = worst.max(sine).max(cosine);
        }
    }
    assert!(worst > 0.5, "the test sees no rounding at all");
}

/// A second name, since `f64` has a method of the same name.
trait Named {
    fn sin_cos_of_this_crate(self) -> (f64, f64);
}

impl Named for f64 {
    fn sin_cos_of_this_crate(self) -> (f64, f64) {
        <f64 as Scalar>::sin_cos(self)
    }
}

#[test]
fn turns_of_any_size_lead_to_the_same_sines() {
    let mut random = fastrand::Rng::with_seed(8);
    let is_angle = [true, false, true];
    for size in [1e-18, 1e-12, 9e-9, 2e-8, 5e-6, 7e-6, 1e-3, 0.0249, 0.0251, 1.0, 100.0] {
        for _ in 0..200 {
            let q: [f64; 3] = std::array::from_fn(|_| 20.0 * (random.f64() - 0.5));
            let dq: [f64; 3] = std::array::from_fn(|_| size * 2.0 * (random.f64() - 0.5));
            let to: [f64; 3] = std::array::from_fn(|i| q[i] + dq[i]);
            // The actual turn, including the rounding of the coordinates.
            let by = std::array::from_fn(|i| to[i] - q[i]);
            let from = Angles::new(&q, is_angle);
            let expected = Angles::new(&to, is_angle);
            for rotated in [
                from.rotated_small(&to, &by, is_angle),
                from.rotated_tiny(&to, &by, is_angle),
                from.rotated_by_correction(&to, &by, is_angle),
            ] {
                for i in [0, 2] {
                    let error = (rotated.sin[i] - expected.sin[i]).abs().max((rotated.cos[i] - expected.cos[i]).abs());
                    assert!(error < 4e-16, "turn by {:e}: {error:e}", by[i]);
                }
                assert_eq!(rotated.sin[1], q[1]);
            }
        }
    }
}
