//! Functions of double-double numbers. They use series after a reduction of the argument; inverse functions take one
//! step of Newton's method from the double-precision value.

use super::DoubleDouble;
use crate::{Scalar, math};

/// Adding this to a number below 2^51 leaves its nearest integer in the last bits.
const WHOLE: f64 = 6_755_399_441_055_744.0;
/// The largest angle whose number of quarter turns is an exact double.
const FAR: f64 = 1e15;
/// A quarter turn, in four parts.
const QUARTER: [f64; 4] =
    [core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33, 5.562_271_104_316_826e-50];
/// The logarithm of 2, in three parts.
const LN_2: [f64; 3] = [core::f64::consts::LN_2, 2.319_046_813_846_299_6e-17, 5.707_708_438_416_212e-34];
/// The number of times that the argument of the exponential series is halved.
const HALVINGS: i32 = 4;

/// `1/k!` from `k = 2` on.
const INVERSE_FACTORIALS: [(f64, f64); 28] = [
    (0.5, 0.0),
    (0.166_666_666_666_666_66, 9.251_858_538_542_97e-18),
    (0.041_666_666_666_666_664, 2.312_964_634_635_742_7e-18),
    (0.008_333_333_333_333_333, 1.156_482_317_317_871_4e-19),
    (0.001_388_888_888_888_889, -5.300_543_954_373_577e-20),
    (0.000_198_412_698_412_698_4, 1.720_955_829_342_070_5e-22),
    (2.480_158_730_158_73e-05, 2.151_194_786_677_588_2e-23),
    (2.755_731_922_398_589_3e-06, -1.858_393_274_046_472e-22),
    (2.755_731_922_398_589e-07, 2.376_771_462_225_029_7e-23),
    (2.505_210_838_544_172e-08, -1.448_814_070_935_912e-24),
    (2.087_675_698_786_81e-09, -1.207_345_059_113_26e-25),
    (1.605_904_383_682_161_3e-10, 1.258_529_458_875_209_8e-26),
    (1.147_074_559_772_972_5e-11, 2.065_551_275_283_074_5e-28),
    (7.647_163_731_819_816e-13, 7.038_728_777_334_53e-30),
    (4.779_477_332_387_385e-14, 4.399_205_485_834_081e-31),
    (2.811_457_254_345_520_6e-15, 1.650_884_273_086_143_3e-31),
    (1.561_920_696_858_622_5e-16, 1.191_067_966_027_375_4e-32),
    (8.220_635_246_624_33e-18, 2.214_189_411_960_426_5e-34),
    (4.110_317_623_312_165e-19, 1.441_297_337_865_952_7e-36),
    (1.957_294_106_339_126_3e-20, -1.364_350_383_008_790_8e-36),
    (8.896_791_392_450_574e-22, -7.911_402_614_872_376e-38),
    (3.868_170_170_630_684e-23, -8.843_177_655_482_344e-40),
    (1.611_737_571_096_118_4e-24, -3.684_657_356_450_976_6e-41),
    (6.446_950_284_384_474e-26, -1.933_040_423_370_346_5e-42),
    (2.479_596_263_224_797_6e-27, -1.295_373_096_476_522_9e-43),
    (9.183_689_863_795_546e-29, 1.430_315_039_678_732_2e-45),
    (3.279_889_237_069_838e-30, 1.511_754_274_402_987_9e-46),
    (1.130_996_288_644_771_6e-31, 1.049_801_541_295_950_6e-47),
];

/// `1/k!`
fn inverse_factorial(k: usize) -> DoubleDouble {
    let (hi, lo) = INVERSE_FACTORIALS[k - 2];
    DoubleDouble { hi, lo }
}

/// The nearest whole number, if it is below 2^51.
fn nearest(x: f64) -> f64 {
    (x + WHOLE) - WHOLE
}

impl DoubleDouble {
    /// Subtracts a multiple of a constant that is given in several parts.
    fn without(self, times: f64, parts: &[f64]) -> Self {
        parts.iter().fold(self, |rest, part| rest - Self::product(times, *part))
    }

    pub(super) fn square_root(self) -> Self {
        let root = math::sqrt(self.hi);
        if root == 0.0 || !root.is_finite() {
            return root.into();
        }
        let rest = self - Self::product(root, root);
        Self::ordered_sum(root, rest.hi / (2.0 * root))
    }

    /// Sine and cosine of angles up to 1e15.
    pub(super) fn sine_and_cosine(self) -> (Self, Self) {
        if !(self.hi.abs() <= FAR) {
            return (f64::NAN.into(), f64::NAN.into());
        }
        let turns = nearest(self.hi * core::f64::consts::FRAC_2_PI);
        let angle = self.without(turns, &QUARTER);
        let square = -(angle * angle);
        // The terms of degree 29 and 28 suffice for angles up to an eighth of a turn.
        let (mut sine, mut cosine) = (inverse_factorial(29), inverse_factorial(28));
        for k in (1..14).rev() {
            sine = sine * square + inverse_factorial(2 * k + 1);
            cosine = cosine * square + inverse_factorial(2 * k);
        }
        Self::from(turns + WHOLE).quarter_turns(angle * square * sine + angle, cosine * square + Self::ONE)
    }

    /// `e^x - 1` of a number below a half.
    fn small_exponential_less_one(self) -> Self {
        let x = self.scaled(1.0 / f64::from(1 << HALVINGS));
        let mut series = inverse_factorial(18);
        for k in (2..18).rev() {
            series = series * x + inverse_factorial(k);
        }
        let mut value = series * x * x + x;
        for _ in 0..HALVINGS {
            value = value.scaled(2.0) + value * value;
        }
        value
    }

    pub(super) fn exponential(self) -> Self {
        if !(self.hi.abs() < 700.0) {
            return math::exp(self.hi).into();
        }
        let twos = nearest(self.hi * core::f64::consts::LOG2_E);
        let power = self.without(twos, &LN_2).small_exponential_less_one() + Self::ONE;
        #[expect(clippy::cast_possible_truncation, reason = "whole and small")]
        power.scaled(math::powi(2.0, twos as i32))
    }

    pub(super) fn logarithm(self) -> Self {
        if !(self.hi > 0.0 && self.is_finite()) {
            return math::ln(self.hi).into();
        }
        let ratio = (self - Self::ONE) / (self + Self::ONE);
        if ratio.hi.abs() < 0.05 {
            // Twice the inverse hyperbolic tangent of the ratio.
            let square = ratio * ratio;
            let mut series = Self::ONE / 29.0.into();
            for k in (0..14).rev() {
                series = series * square + Self::ONE / f64::from(2 * k + 1).into();
            }
            return (series * ratio).scaled(2.0);
        }
        let guess = Self::from(math::ln(self.hi));
        // In two halves, because the second part of a very small exponential would lose digits.
        let half = guess.scaled(-0.5).exponential();
        let quotient = self * half * half;
        guess + ((quotient - Self::ONE) / (quotient + Self::ONE)).scaled(2.0)
    }

    pub(super) fn hyperbolic_sine(self) -> Self {
        if self.hi.abs() < 0.5 {
            let less_one = self.small_exponential_less_one();
            return (less_one + less_one / (less_one + Self::ONE)).scaled(0.5);
        }
        let power = self.exponential();
        (power - power.recip()).scaled(0.5)
    }

    pub(super) fn hyperbolic_tangent(self) -> Self {
        // sinh over cosh would overflow.
        let twice = self.abs().scaled(-2.0);
        let less_one =
            if twice.hi > -0.5 { twice.small_exponential_less_one() } else { twice.exponential() - Self::ONE };
        let size = -less_one / (less_one + 2.0.into());
        if self.is_negative() { -size } else { size }
    }

    /// The angle of the vector with ordinate `self` and this abscissa.
    pub(super) fn angle_from(self, abscissa: Self) -> Self {
        let guess = math::atan2(self.hi, abscissa.hi);
        if !(self.is_finite() && abscissa.is_finite()) || self.hi == 0.0 && abscissa.hi == 0.0 {
            return guess.into();
        }
        let (sine, cosine) = Self::from(guess).sine_and_cosine();
        Self::from(guess) + (self * cosine - abscissa * sine) / (abscissa * cosine + self * sine)
    }

    /// An integer power, by repeated squaring.
    pub(super) fn whole_power(self, exponent: i32) -> Self {
        let (mut power, mut square, mut rest) = (Self::ONE, self, exponent.unsigned_abs());
        while rest > 0 {
            if rest & 1 == 1 {
                power = power * square;
            }
            square = square * square;
            rest >>= 1;
        }
        if exponent < 0 { power.recip() } else { power }
    }

    pub(super) fn power(self, exponent: Self) -> Self {
        let whole = exponent.hi;
        if exponent.lo == 0.0 && nearest(whole) == whole && whole.abs() <= 1024.0 {
            #[expect(clippy::cast_possible_truncation, reason = "whole and small")]
            return self.whole_power(whole as i32);
        }
        if self.hi > 0.0 && self.is_finite() && exponent.is_finite() {
            return (self.logarithm() * exponent).exponential();
        }
        math::powf(self.hi, exponent.hi).into()
    }
}
