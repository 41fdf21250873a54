//! The coefficients of RODAS.
//!
//! E. Hairer and G. Wanner, Solving Ordinary Differential Equations II, 2nd edition, section IV.10: a linearly implicit
//! method of order 4 with an estimate of order 3, stiffly accurate and L-stable.

use super::implicit::Implicit;
use super::method::Method;

/// The linearly implicit method of order 4.
pub const RODAS: &Method = &Method {
    name: "rodas",
    doc: "Linearly implicit method of order 4 for stiff springs and dampers, steps chosen by --tolerance; most scenes \
          must say `stiff = true`",
    order: 4,
    is_for_stiff: true,
    needs_linearization: true,
    tableau: None,
    formula: Some(|_| Box::new(Implicit)),
};

/// The diagonal coefficient.
pub(crate) const GAMMA: f64 = 0.25;

/// The fraction of the step at which each stage is evaluated.
pub(crate) const NODES: [f64; 6] = [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];

/// The weight of the derivative with respect to time in each stage.
pub(crate) const BY_TIME: [f64; 6] = [0.25, -0.1043, 0.1035, -0.036_200_000_000_000_23, 0.0, 0.0];

/// The weights of earlier increments in the argument of each stage.
#[rustfmt::skip]
pub(crate) const ARGUMENTS: [[f64; 5]; 6] = [
    [0.0; 5],
    [1.544, 0.0, 0.0, 0.0, 0.0],
    [0.946_678_528_081_582_6, 0.255_701_169_898_328_4, 0.0, 0.0, 0.0],
    [3.314_825_187_068_521, 2.896_124_015_972_201, 0.998_641_913_997_781_7, 0.0, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895, 0.0],
    [1.221_224_509_226_641, 6.019_134_481_288_629, 12.537_083_329_320_87, -0.687_886_036_105_895, 1.0],
];

/// The weights of earlier increments in the equations of each stage.
#[rustfmt::skip]
pub(crate) const INCREMENTS: [[f64; 5]; 6] = [
    [0.0; 5],
    [-5.6688, 0.0, 0.0, 0.0, 0.0],
    [-2.430_093_356_833_875, -0.206_359_915_709_191_5, 0.0, 0.0, 0.0],
    [-0.107_352_905_815_137_5, -9.594_562_251_023_355, -20.470_286_148_096_16, 0.0, 0.0],
    [7.496_443_313_967_647, -10.246_804_314_643_52, -33.999_903_528_199_05, 11.708_908_932_061_6, 0.0],
    [8.083_246_795_921_522, -7.981_132_988_064_893, -31.521_594_328_743_71, 16.319_305_431_231_36, -6.058_818_238_834_054],
];
