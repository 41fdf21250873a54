//! Double-double numbers: arithmetic against integers, functions against values to 200 digits.

use num_bigint::BigInt;
use num_traits::Signed;
use qrm_core::{DoubleDouble, Scalar};

/// Largest relative error.
const TOLERANCE: f64 = 1e-31;
/// The number of fractional bits of fixed-point numbers.
const BITS: u64 = 400;

/// A double in fixed point, exactly.
fn fixed_double(x: f64) -> BigInt {
    let bits = x.abs().to_bits();
    let (exponent, digits) = ((bits >> 52) as i64, bits & ((1 << 52) - 1));
    if exponent == 0 {
        return BigInt::ZERO;
    }
    let value = BigInt::from(digits | (1 << 52)) << (BITS as i64 + exponent - 1075) as u64;
    if x < 0.0 { -value } else { value }
}

fn fixed(x: DoubleDouble) -> BigInt {
    fixed_double(x.hi()) + fixed_double(x.lo())
}

/// Whether two fixed-point numbers differ by less than the fraction `tolerance` of the second.
fn is_near(x: &BigInt, y: &BigInt, tolerance: f64) -> bool {
    let inverse = BigInt::from((1.0 / tolerance) as u128);
    (x - y).abs() * inverse <= y.abs()
}

/// Numbers with random digits in both parts.
fn random(random: &mut fastrand::Rng) -> DoubleDouble {
    let mut digits = || 2.0 * random.f64() - 1.0;
    let (high, low) = (digits(), digits());
    let high = high * f64::from(1 << (30.0 * digits().abs()) as u32);
    DoubleDouble::sum(high, high * low * f64::EPSILON / 2.0)
}

#[test]
fn arithmetic_is_right_to_31_digits() {
    let mut rng = fastrand::Rng::with_seed(3);
    for _ in 0..20_000 {
        let (x, mut y) = (random(&mut rng), random(&mut rng));
        if rng.bool() {
            // Nearly equal numbers, whose leading digits cancel.
            y = -x + random(&mut rng) * DoubleDouble::from(1e-25);
        }
        let (a, b) = (fixed(x), fixed(y));
        assert!(is_near(&fixed(x + y), &(&a + &b), TOLERANCE), "{x:?} + {y:?}");
        assert!(is_near(&fixed(x - y), &(&a - &b), TOLERANCE), "{x:?} - {y:?}");
        assert!(is_near(&fixed(x * y), &((&a * &b) >> BITS), TOLERANCE), "{x:?} * {y:?}");
        assert!(is_near(&fixed(x / y), &((&a << BITS) / &b), TOLERANCE), "{x:?} / {y:?}");
        let root = (a.abs() << BITS).sqrt();
        assert!(is_near(&fixed(x.abs().sqrt()), &root, TOLERANCE), "sqrt({x:?})");
    }
}

/// The numbers that follow the name of a function in a line.
fn numbers(line: &str) -> Vec<DoubleDouble> {
    let parts: Vec<f64> = line.split(' ').skip(1).map(|part| part.parse().expect("a double")).collect();
    parts.chunks(2).map(|pair| DoubleDouble::sum(pair[0], pair[1])).collect()
}

/// Arguments and values to 200 digits by mpmath, rounded to pairs of doubles.
const VALUES: &str = include_str!("double_double.txt");

#[test]
fn functions_are_right_to_31_digits() {
    for line in VALUES.lines() {
        let numbers = numbers(line);
        let (x, y, expected) = (numbers[0], numbers[1], numbers[numbers.len() - 1]);
        let got = match line.split(' ').next().unwrap_or_default() {
            "sin" => x.sin(),
            "cos" => x.cos(),
            "tan" => x.tan(),
            "asin" => x.asin(),
            "acos" => x.acos(),
            "atan" => x.atan(),
            "exp" => x.exp(),
            "ln" => x.ln(),
            "sinh" => x.sinh(),
            "cosh" => x.cosh(),
            "tanh" => x.tanh(),
            "sqrt" => x.sqrt(),
            "atan2" => x.atan2(y),
            "hypot" => x.hypot(y),
            "pow" => x.pow(y),
            other => panic!("no function `{other}`"),
        };
        let error = (got - expected).abs().hi();
        assert!(error <= TOLERANCE * expected.abs().hi(), "{line}: {got:?}, {:e}", error / expected.abs().hi());
    }
}

#[test]
fn special_values_are_those_of_doubles() {
    type Function = fn(DoubleDouble) -> DoubleDouble;
    type OfDouble = fn(f64) -> f64;
    let functions: [(Function, OfDouble); 10] = [
        (Scalar::sqrt, f64::sqrt),
        (Scalar::exp, f64::exp),
        (Scalar::ln, f64::ln),
        (Scalar::sinh, f64::sinh),
        (Scalar::cosh, f64::cosh),
        (Scalar::tanh, f64::tanh),
        (Scalar::atan, f64::atan),
        (Scalar::recip, f64::recip),
        (Scalar::abs, f64::abs),
        (|x| x.powf(0.5), |x| x.powf(0.5)),
    ];
    for x in [0.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, 800.0, -800.0, 1e300] {
        for (i, (function, of_double)) in functions.into_iter().enumerate() {
            let (got, expected) = (function(x.into()).hi(), of_double(x));
            let is_same = got == expected || got.is_nan() && expected.is_nan();
            assert!(
                is_same || (got / expected - 1.0).abs() < 1e-14,
                "function {i} of {x}: {got} instead of {expected}"
            );
        }
    }
    let [zero, one] = [0.0, 1.0].map(DoubleDouble::from);
    assert_eq!((one / zero).hi(), f64::INFINITY);
    assert_eq!(DoubleDouble::from(f64::MAX) * 2.0.into(), f64::INFINITY.into());
    assert_eq!((zero.sign(), (-one).sign(), one.sign()), (zero, -one, one));
    assert_eq!((one.max(zero), one.min(zero)), (one, zero));
    assert!(DoubleDouble::from(1e16).sin().hi().is_nan());
}

#[test]
fn a_double_stands_for_a_simple_fraction() {
    for (p, q) in
        [(1, 10), (-1, 3), (22, 7), (12_345, 100_000), (0, 1), (-4, 1), (9_999_988, 9_999_989), (1, 3_000_000)]
    {
        let (p, q) = (f64::from(p), f64::from(q));
        let meant = DoubleDouble::from(p) / DoubleDouble::from(q);
        assert_eq!(DoubleDouble::fraction(p / q), Some(meant), "{p} / {q}");
    }
    for other in [std::f64::consts::PI, 1e300, f64::INFINITY, f64::NAN, 0.1 + f64::EPSILON] {
        assert_eq!(DoubleDouble::fraction(other), None, "{other}");
        assert_eq!(DoubleDouble::from_number(other).hi().to_bits(), other.to_bits());
    }
}
