//! Sine and cosine together, in line and without branches for all but very large angles.
//!
//! The angle is reduced to an eighth of a turn by a quarter turn in three parts (Cody, Waite 1980); the polynomials of
//! fdlibm's kernels then give sine and cosine. Errors stay below 0.8 units in the last place.

// The published constants have a few more digits than a double holds.
#![allow(clippy::excessive_precision)]

use core::f64::consts::FRAC_2_PI;

use crate::scalar::Scalar;

/// The largest angle whose number of quarter turns has 20 bits: its products with the first two parts are exact.
const FAR: f64 = 1e6;
/// A quarter turn: 33 bits, the next 33, and the rest.
const QUARTER: [f64; 3] =
    [1.570_796_326_734_125_614_17, 6.077_100_506_303_965_976_60e-11, 2.022_266_248_795_950_631_54e-21];
/// Adding this to a number below 2^51 leaves its nearest integer in the last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// (sin x - x) / x^3 as a polynomial of x^2.
const SINE: [f64; 6] = [
    -1.666_666_666_666_663_243_48e-1,
    8.333_333_333_322_489_461_24e-3,
    -1.984_126_982_985_794_931_34e-4,
    2.755_731_370_707_006_767_89e-6,
    -2.505_076_025_340_686_341_95e-8,
    1.589_690_995_211_550_102_21e-10,
];
/// (cos x - 1 + x^2 / 2) / x^4 as a polynomial of x^2.
const COSINE: [f64; 6] = [
    4.166_666_666_666_660_190_37e-2,
    -1.388_888_888_887_410_957_49e-3,
    2.480_158_728_947_672_941_78e-5,
    -2.755_731_435_139_066_330_35e-7,
    2.087_572_321_298_174_827_90e-9,
    -1.135_964_755_778_819_482_65e-11,
];

/// Sine and cosine.
#[inline(always)]
pub fn sin_cos<R: Scalar>(x: R) -> (R, R) {
    let (sine, cosine) = near(x);
    if x.is_within(FAR) {
        return (sine, cosine);
    }
    // The result of a lane must not depend on whether other lanes are far.
    let (far_sine, far_cosine) = x.sin_cos_far();
    (x.choose(FAR, sine, far_sine), x.choose(FAR, cosine, far_cosine))
}

#[inline(always)]
fn near<R: Scalar>(x: R) -> (R, R) {
    let number = R::from_f64;
    let shifted = x * number(FRAC_2_PI) + number(WHOLE);
    let n = shifted - number(WHOLE);
    // All three products but the last are exact; the first difference is exact too.
    let rest = x - n * number(QUARTER[0]);
    let part = n * number(QUARTER[1]);
    let high = rest - part;
    let tail = ((rest - high) - part) - n * number(QUARTER[2]);
    let y = high + tail;
    let tail = (high - y) + tail;

    let z = y * y;
    let (z2, cube) = (z * z, z * y);
    let [s1, s2, s3, s4, s5, s6] = SINE;
    let low = z.mul_add(z.mul_add(number(s4), number(s3)), number(s2));
    let series = (z * z2).mul_add(z.mul_add(number(s6), number(s5)), low);
    let sine = y - ((z * (number(0.5) * tail - cube * series) - tail) - cube * number(s1));
    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let low = z * z.mul_add(z.mul_add(number(c3), number(c2)), number(c1));
    let series = (z2 * z2).mul_add(z.mul_add(z.mul_add(number(c6), number(c5)), number(c4)), low);
    let half = number(0.5) * z;
    let most = number(1.0) - half;
    let cosine = most + (((number(1.0) - most) - half) + (z * series - y * tail));
    shifted.quarter_turns(sine, cosine)
}

/// `sin(x + d)` and `cos(x + d)` from those of `x`, for turns `d` up to an eighth of a revolution.
#[cfg(feature = "simd")]
#[inline(always)]
pub(crate) fn rotated<R: Scalar>(sin: R, cos: R, d: R) -> (R, R) {
    let number = R::from_f64;
    let z = d * d;
    let (z2, cube) = (z * z, z * d);
    let pair = |[a, b]: [f64; 2]| z.mul_add(number(b), number(a));
    let [s1, s2, s3, s4, s5, s6] = SINE;
    let series = (z2 * z2).mul_add(pair([s5, s6]), z2.mul_add(pair([s3, s4]), pair([s1, s2])));
    let sin_d = cube.mul_add(series, d);
    let [c1, c2, c3, c4, c5, c6] = COSINE;
    let series = (z2 * z2).mul_add(pair([c5, c6]), z2.mul_add(pair([c3, c4]), pair([c1, c2])));
    let cos_d_less_one = z2.mul_add(series, z * number(-0.5));
    (sin + cos.mul_add(sin_d, sin * cos_d_less_one), cos + sin.neg_mul_add(sin_d, cos * cos_d_less_one))
}
