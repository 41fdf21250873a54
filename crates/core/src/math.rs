//! Functions of doubles from the standard library, or from the crate `libm` where there is none.

macro_rules! functions {
    ($($name:ident($x:ident $(, $y:ident)*) = $libm:ident;)*) => {
        $(
            #[inline(always)]
            pub(crate) fn $name($x: f64 $(, $y: f64)*) -> f64 {
                #[cfg(feature = "std")]
                return f64::$name($x $(, $y)*);
                #[cfg(not(feature = "std"))]
                return libm::$libm($x $(, $y)*);
            }
        )*
    };
}

functions! {
    floor(x) = floor;
    sqrt(x) = sqrt;
    tan(x) = tan;
    asin(x) = asin;
    acos(x) = acos;
    atan(x) = atan;
    exp(x) = exp;
    ln(x) = log;
    sinh(x) = sinh;
    cosh(x) = cosh;
    tanh(x) = tanh;
    powf(x, y) = pow;
    atan2(x, y) = atan2;
    hypot(x, y) = hypot;
    mul_add(x, y, z) = fma;
}

#[inline(always)]
pub(crate) fn recip(x: f64) -> f64 {
    1.0 / x
}

#[cfg(feature = "std")]
#[inline(always)]
pub(crate) fn powi(x: f64, exponent: i32) -> f64 {
    f64::powi(x, exponent)
}

/// An integer power, by repeated squaring.
#[cfg(not(feature = "std"))]
pub(crate) fn powi(x: f64, exponent: i32) -> f64 {
    let (mut power, mut square, mut rest) = (1.0, x, exponent.unsigned_abs());
    while rest > 0 {
        if rest & 1 == 1 {
            power *= square;
        }
        square *= square;
        rest >>= 1;
    }
    if exponent < 0 { 1.0 / power } else { power }
}
