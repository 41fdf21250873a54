//! Vectors of doubles, one in each lane of a register, as numbers of generated functions.

use core::ops::{Add, Div, Mul, Neg, Sub};

use crate::scalar::Scalar;
use pulp::Simd;

/// A vector of doubles. Its values exist only in `StepsBy` (`lane_steps`), `Steps` (`gauss`) and their kernels. The
/// constructors of these take a token of `S`, or are called where one exists: wherever there is such a value, the
/// processor has the instructions of `S`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes<S: Token>(S::Register);

/// A token proves that the processor has its instructions.
pub(crate) trait Token: Simd {
    /// The register type of the processor: with `f64s`, the compiler splits the vector in places and loads it piece by
    /// piece.
    type Register: bytemuck::Pod + core::fmt::Debug + Send + Sync;

    /// Returns the token again, where `try_new` has already returned one.
    fn again() -> Self;
}

#[cfg(target_arch = "x86_64")]
macro_rules! token {
    ($name:ty, $register:ty) => {
        impl Token for $name {
            type Register = $register;

            // An operator has no argument for a token, and querying the processor each time doubles the time of a step.
            #[allow(unsafe_code)]
            #[inline(always)]
            fn again() -> Self {
                // SAFETY: only operations on `Lanes` call this. These exist only where `try_new` has returned the
                // token: see `Lanes`.
                unsafe { Self::new_unchecked() }
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
token!(pulp::x86::V3, core::arch::x86_64::__m256d);
#[cfg(target_arch = "x86_64")]
token!(pulp::x86::V4, core::arch::x86_64::__m512d);

impl<S: Token> Lanes<S> {
    /// The number of lanes.
    pub(crate) const COUNT: usize = S::F64_LANES;

    /// The value of each lane.
    #[inline(always)]
    pub(crate) fn from_fn(mut value: impl FnMut(usize) -> f64) -> Self {
        let mut lanes = Self::zero();
        for i in 0..Self::COUNT {
            lanes.set(i, value(i));
        }
        lanes
    }

    /// Loads the first numbers of a slice, one for each lane.
    #[inline(always)]
    pub(crate) fn load(numbers: &[f64]) -> Self {
        Self(bytemuck::pod_read_unaligned(bytemuck::cast_slice(&numbers[..Self::COUNT])))
    }

    /// The value of a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        bytemuck::cast_slice(core::slice::from_ref(&self.0))[lane]
    }

    /// Sets the value of a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: f64) {
        bytemuck::cast_slice_mut(core::slice::from_mut(&mut self.0))[lane] = value;
    }

    #[inline(always)]
    fn new(vector: S::f64s) -> Self {
        Self(bytemuck::must_cast(vector))
    }

    #[inline(always)]
    fn vector(self) -> S::f64s {
        bytemuck::must_cast(self.0)
    }

    /// Another number, but not a number in lanes where this one is not.
    #[inline(always)]
    fn unless_nan(self, other: Self) -> Self {
        let simd = S::again();
        let is_number = simd.equal_f64s(self.vector(), self.vector());
        Self::new(simd.select_f64s(is_number, other.vector(), self.vector()))
    }

    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        Self::from_fn(|i| f(self.get(i)))
    }
}

macro_rules! operators {
    ($($operator:ident $name:ident $simd:ident),*) => {
        $(impl<S: Token> $operator for Lanes<S> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self::new(S::again().$simd(self.vector(), other.vector()))
            }
        })*
    };
}

operators!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s, Div div div_f64s);

impl<S: Token> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(S::again().neg_f64s(self.vector()))
    }
}

macro_rules! one_by_one {
    ($($name:ident),*) => {
        $(fn $name(self) -> Self { self.each(f64::$name) })*
    };
}

impl<S: Token> Scalar for Lanes<S> {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        Self::new(S::again().splat_f64s(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::new(S::again().sqrt_f64s(self.vector()))
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        crate::sine::sin_cos(self)
    }
    fn powf(self, exponent: f64) -> Self {
        self.each(|value| value.powf(exponent))
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self.choose(0.0, self, self / self.abs())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // The nearest integer, or that less one.
        let (simd, shift) = (S::again(), Self::from_f64(6_755_399_441_055_744.0));
        let nearest = self + shift - shift;
        let is_above = simd.less_than_f64s(self.vector(), nearest.vector());
        let below = simd.select_f64s(is_above, (nearest - Self::from_f64(1.0)).vector(), nearest.vector());
        // Larger numbers are integers.
        self.choose(2_251_799_813_685_248.0, Self::new(below), self)
    }
    one_by_one!(asin, acos, atan, exp, ln, sinh, cosh, tanh);
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self::new(S::again().mul_add_e_f64s(self.vector(), a.vector(), b.vector()))
    }
    #[inline(always)]
    fn neg_mul_add(self, a: Self, b: Self) -> Self {
        Self::new(S::again().mul_add_e_f64s((-self).vector(), a.vector(), b.vector()))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // `abs_f64s` is not always inlined, and then lacks the target features of the token.
        let simd = S::again();
        Self::new(simd.and_f64s(self.vector(), simd.splat_f64s(f64::from_bits(i64::MAX as u64))))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.unless_nan(Self::new(S::again().max_f64s(self.vector(), other.vector())))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.unless_nan(Self::new(S::again().min_f64s(self.vector(), other.vector())))
    }
    fn atan2(self, abscissa: Self) -> Self {
        Self::from_fn(|i| self.get(i).atan2(abscissa.get(i)))
    }
    fn hypot(self, other: Self) -> Self {
        Self::from_fn(|i| self.get(i).hypot(other.get(i)))
    }
    fn powi(self, exponent: i32) -> Self {
        self.each(|value| value.powi(exponent))
    }
    fn pow(self, exponent: Self) -> Self {
        Self::from_fn(|i| self.get(i).powf(exponent.get(i)))
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.get(0)
    }
    #[inline(always)]
    fn is_negative(self) -> bool {
        let simd = S::again();
        let below = simd.less_than_f64s(self.vector(), simd.splat_f64s(0.0));
        simd.first_true_m64s(simd.not_m64s(below)) == Self::COUNT
    }
    #[inline(always)]
    fn is_within(self, bound: f64) -> bool {
        let simd = S::again();
        let inside = simd.less_than_or_equal_f64s(self.abs().vector(), simd.splat_f64s(bound));
        simd.first_true_m64s(simd.not_m64s(inside)) == Self::COUNT
    }
    #[inline(always)]
    fn choose(self, bound: f64, inside: Self, outside: Self) -> Self {
        let simd = S::again();
        let mask = simd.less_than_or_equal_f64s(self.abs().vector(), simd.splat_f64s(bound));
        Self::new(simd.select_f64s(mask, inside.vector(), outside.vector()))
    }
    #[inline(always)]
    fn quarter_turns(self, sin: Self, cos: Self) -> (Self, Self) {
        let simd = S::again();
        let n = simd.transmute_u64s_f64s(self.vector());
        let is_odd = has_bit::<S>(n, 1);
        let swapped = (
            simd.select_f64s(is_odd, cos.vector(), sin.vector()),
            simd.select_f64s(is_odd, sin.vector(), cos.vector()),
        );
        let next = simd.add_u64s(n, simd.splat_u64s(1));
        (
            Self::new(signed::<S>(has_bit::<S>(n, 2), swapped.0)),
            Self::new(signed::<S>(has_bit::<S>(next, 2), swapped.1)),
        )
    }
    #[cold]
    #[inline(never)]
    fn sin_cos_far(self) -> (Self, Self) {
        let (mut sin, mut cos) = (self, self);
        for i in 0..Self::COUNT {
            let far = self.get(i).sin_cos_far();
            sin.set(i, far.0);
            cos.set(i, far.1);
        }
        (sin, cos)
    }
    #[inline(always)]
    fn vectorized<T>(f: impl FnOnce() -> T) -> T {
        S::again().vectorize(f)
    }
    #[cold]
    #[inline(never)]
    fn sin_cos_apart(self) -> (Self, Self) {
        // A function that is not inlined has the target features only if it declares them.
        S::again().vectorize(
            #[inline(always)]
            || crate::sine::sin_cos(self),
        )
    }
}

#[inline(always)]
fn has_bit<S: Token>(n: S::u64s, bit: u64) -> S::m64s {
    let simd = S::again();
    let bit = simd.splat_u64s(bit);
    simd.equal_u64s(simd.and_u64s(n, bit), bit)
}

#[inline(always)]
fn signed<S: Token>(is_negative: S::m64s, value: S::f64s) -> S::f64s {
    S::again().select_f64s(is_negative, S::again().neg_f64s(value), value)
}
