//! Problems that others published, against their values and against some of higher precision.

use crate::common;
use crate::common::{Table, run};

/// Decimal digits to which every one of some values is right.
fn digits(end: &serde_json::Value, known: &[(&str, f64)]) -> f64 {
    let off = |(name, value): &(&str, f64)| (end[name].as_f64().expect("a number") / value - 1.0).abs();
    -known.iter().map(off).fold(1e-17, f64::max).log10()
}

/// Test Set for IVP Solvers, andrews, t = 0.03: PSIDE with a tolerance of 1e-14.
const PUBLISHED: [(&str, f64); 7] = [
    ("beta", 15.810_771_196_299_04),
    ("Theta", -15.756_371_059_842_98),
    ("gamma", 0.040_822_240_130_731_01),
    ("Phi", -0.534_730_116_322_694_8),
    ("delta", 0.524_409_965_880_530_4),
    ("Omega", 0.534_730_116_322_694_8),
    ("eps", 1.048_080_741_042_263),
];
const PUBLISHED_RATES: [(&str, f64); 7] = [
    ("beta_dot", 1_139.920_302_151_208),
    ("Theta_dot", -1_424.379_294_994_111),
    ("gamma_dot", 11.032_912_219_371_34),
    ("Phi_dot", 19.293_374_644_213_85),
    ("delta_dot", 0.573_569_928_479_080_8),
    ("Omega_dot", -19.293_374_644_213_85),
    ("eps_dot", 0.323_179_165_802_695_5),
];
/// The end values of the problem andrews by extrapolation of order 20 with 128 bits.
const OWN: [(&str, f64); 7] = [
    ("beta", 15.810_771_195_153_707),
    ("Theta", -15.756_371_058_411_839),
    ("gamma", 0.040_822_240_119_645_8),
    ("Phi", -0.534_730_116_342_079_6),
    ("delta", 0.524_409_965_879_954_1),
    ("Omega", 0.534_730_116_342_079_6),
    ("eps", 1.048_080_741_041_938),
];

#[test]
fn andrews_squeezer_is_that_of_the_test_set() {
    let tight = run(&["andrews", "--method", "dop853", "--tolerance", "1e-12", "--step", "0.03", "--no-figures"]);
    assert_eq!(tight.status(), 0, "{}", tight.stderr());
    let end = &tight.summary()["end_state"];
    assert!(digits(end, &PUBLISHED) > 9.5 && digits(end, &PUBLISHED_RATES) > 7.0);
    assert!(digits(end, &OWN) > 11.0, "{}", digits(end, &OWN));
}

#[test]
fn andrews_squeezer_takes_few_evaluations() {
    let run = run(&["andrews", "--method", "dop853", "--tolerance", "7e-8", "--step", "0.03", "--no-error-estimate"]);
    let summary = run.summary();
    let evaluations = summary["evaluations"].as_u64().expect("a number");
    assert!(digits(&summary["end_state"], &OWN) > 7.9 && evaluations <= 1000, "{evaluations} evaluations");
}

#[test]
fn a_pendulum_without_an_angle_swings_for_long() {
    // x = sin, y = -cos of 2 asin(sqrt(1/2) sn(K - sqrt(g) t)).
    let arguments = ["pendulum", "--method", "dop853", "--tolerance", "1e-13", "--step", "0.5", "--end-time", "2000"];
    let run = run(&[&arguments[..], &["--no-figures"]].concat());
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let end = &run.summary()["end_state"];
    for (name, exact) in [("x", -0.814_603_068_589_032_2), ("y", -0.580_018_827_836_935_5)] {
        let off = (end[name].as_f64().expect("a number") - exact).abs();
        assert!(off < 1e-6, "{name} is off by {off:e}");
    }
}

#[test]
fn coupled_four_bars_keep_parallel() {
    let run = run(&["n-four-bar-2", "--end-time", "20", "--no-figures"]);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let table = run.trajectory();
    let last = table.last();
    for (name, exact) in
        [("B0x", 0.839_746_574_306_843_5), ("B0y", 0.542_978_536_352_884_7), ("B0x_dot", 1.838_222_644_196_742_7)]
    {
        let off = (table.number(last, name) - exact).abs();
        assert!(off < 1e-9, "{name} is off by {off:e}");
    }
}

/// 81 coordinates, 80 constraints.
#[test]
#[ignore = "full tier: large"]
fn forty_coupled_four_bars_keep_parallel() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut build = std::process::Command::new(env!("CARGO"));
    build.current_dir(env!("CARGO_MANIFEST_DIR")).env("QRM_SCENES", "n-four-bar-40");
    build.args(["run", "--release", "--", "run", "n-four-bar-40", "--no-figures", "--out"]);
    let output = build.arg(folder.path()).output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = Table::read(&folder.path().join("trajectory.csv"));
    let last = table.last();
    for (name, exact) in [("B0x", 0.410_901_153_762_945_2), ("B0y", 0.911_679_900_971_980_7)] {
        let off = (table.number(last, name) - exact).abs();
        assert!(table.number(last, "t") == 20.0 && off < 1e-9, "{name} is off by {off:e}");
    }
}

/// SUNDIALS, idaSlCrank: the slider-crank of Haug, integrated by IDA with a tolerance of 1e-6, as printed.
#[test]
fn the_slider_crank_is_that_of_sundials() {
    let arguments = ["slider-crank", "--method", "dop853", "--tolerance", "1e-13", "--no-figures"];
    let run = run(&arguments);
    assert_eq!(run.status(), 0, "{}", run.stderr());
    let (table, printed) = (run.trajectory(), Table::reference("sundials-slider-crank.csv"));
    for row in 0..printed.rows.len() {
        let t = printed.number(row, "t");
        let own = (0..table.rows.len()).find(|&row| table.number(row, "t") >= t - 1e-9).expect("a row at this time");
        for name in ["q", "x", "p"] {
            let (text, value) = (printed.text(row, name), table.number(own, name));
            let exponent: i32 = text.split_once('e').expect("an exponent").1.parse().expect("a number");
            // Half a unit of the last digit, and what IDA is off by.
            let allowed = 0.5 * 10f64.powi(exponent - 4) + 1e-5;
            let off = (value - printed.number(row, name)).abs();
            assert!(off <= allowed, "{name} is {value} instead of {text} at t = {t}");
        }
    }
    // Integrated with 120 bits.
    let own = [("q", 1.275_675_848_650_239_3), ("x", 1.023_578_558_979_839_4), ("p", -0.498_813_049_182_498_7)];
    let end = run.summary();
    assert!(digits(&end["end_state"], &own) > 11.0, "{}", digits(&end["end_state"], &own));
    // The integral of the kinetic energy, by Simpson's rule; 3.33662 as printed.
    let kinetic = |row: usize| {
        let square = |name: &str| table.number(row, name).powi(2);
        (square("q_dot") + square("x_dot") + 2.0 * square("p_dot")) / 2.0
    };
    let last = table.last();
    let weight = |row: usize| if row == 0 || row == last { 1.0 } else { 2.0 + 2.0 * (row % 2) as f64 };
    let sum: f64 = (0..=last).map(|row| weight(row) * kinetic(row)).sum();
    let integral = sum * table.number(last, "t") / last as f64 / 3.0;
    assert!((integral - 3.336_606_799_482_784_6).abs() < 1e-9, "{integral}");
}

/// SymPy, test_four_bar_linkage_with_manual_constraints: mass matrix and forcing of Kane's equations, whose solution
/// are the accelerations.
#[test]
fn the_four_bar_starts_like_that_of_sympy() {
    let mass = [
        [34.527_098_152_565_06, 7.003_948_798_374_735, -4.939_690_970_641_498],
        [-2.203_792_703_880_936e-14, 0.207_170_247_995_707_7, 0.284_291_757_303_371_1],
        [-0.130_000_000_000_012_3, -0.008_836_934_896_046_506, 0.186_489_133_006_084_7],
    ];
    let forcing = nalgebra::Vector3::new(-0.031_211_821_321_648, -0.000_660_226_081_81, 0.001_813_559_741_243);
    let published = nalgebra::Matrix3::from_fn(|i, j| mass[i][j]).lu().solve(&forcing).expect("regular");
    let run = run(&["four-bar", "--end-time", "0.01", "--no-figures"]);
    let table = run.trajectory();
    let stated = [
        ("q2", 0.665_547_037_507_758_8),
        ("q3", 2.527_408_138_024_188),
        ("q2_dot", -0.179_637_339_388_520_67),
        ("q3_dot", 0.130_906_054_060_161_2),
    ];
    for (name, value) in stated {
        assert!((table.number(0, name) - value).abs() < 5e-13, "{name}: {} instead of {value}", table.number(0, name));
    }
    for (name, value) in ["q1_ddot", "q2_ddot", "q3_ddot"].into_iter().zip(published.iter()) {
        let off = (table.number(0, name) / value - 1.0).abs();
        assert!(off < 5e-12, "{name} is off by {off:e}");
    }
}

/// The force of the ground on the last rod, by the law of Newton and Euler for the rods one after another: the moment
/// of all that is beyond a joint vanishes there.
#[test]
fn the_four_bar_is_held_by_what_its_rods_need() {
    use num_dual::{Dual2_64, DualNum};
    let run = run(&["four-bar", "--no-figures", "--step", "1e-3", "--end-time", "5"]);
    let table = run.trajectory();
    for row in (0..=table.last()).step_by(500) {
        let of = |name: &str| table.number(row, name);
        let q = |i: usize| Dual2_64::new(of(&format!("q{i}")), of(&format!("q{i}_dot")), of(&format!("q{i}_ddot")));
        let angles = [q(1), q(1) + q(2), q(1) + q(2) + q(3)];
        let lengths = [0.24, 0.21, 0.34];
        let zero = Dual2_64::from(0.0);
        let mut joints = vec![[zero + 0.065, zero]];
        for (angle, length) in angles.iter().zip(lengths) {
            let [x, y] = joints[joints.len() - 1];
            joints.push([x + angle.cos() * length, y + angle.sin() * length]);
        }
        let end = joints[3].map(|c| c.re);
        for first in 0..3 {
            let pivot = joints[first].map(|c| c.re);
            // Force at the end against the change of angular momentum of what lies between.
            let force = (end[0] - pivot[0]) * of("Dy") - (end[1] - pivot[1]) * of("Dx");
            let needed: f64 = (first..3)
                .map(|rod| {
                    let (mass, length) = (997.0 * lengths[rod], lengths[rod]);
                    let [x, y] = [0, 1].map(|axis| (joints[rod][axis] + joints[rod + 1][axis]) / 2.0);
                    let moment = (x.re - pivot[0]) * y.v2 - (y.re - pivot[1]) * x.v2;
                    mass * (moment + length * length / 12.0 * angles[rod].v2)
                })
                .sum();
            assert!((force - needed).abs() < 1e-8 * (1.0 + needed.abs()), "row {row}, joint {first}: {force} {needed}");
        }
    }
}

#[test]
fn a_thrown_stick_flies_along_a_parabola() {
    let run = run(&["thrown-stick", "--method", "dop853", "--tolerance", "1e-12", "--no-figures"]);
    let end = &run.summary()["end_state"];
    let (x, y, a) = (6.6 - 0.6 * 20.0_f64.cos(), 22.0 - 19.62 - 0.6 * 20.0_f64.sin(), 20.0);
    for (name, exact) in [("x", x), ("y", y), ("a", a), ("a_dot", 10.0)] {
        let off = (end[name].as_f64().expect("a number") - exact).abs();
        assert!(off < 1e-10, "{name} is off by {off:e}");
    }
}

/// Claims that hold for a chaotic motion: its first seconds, its energy, and that the rest is refused.
#[test]
fn a_double_pendulum_is_known_for_a_while() {
    let end = |tolerance: &str, until: &str| {
        let arguments = ["double-pendulum", "--method", "dop853", "--tolerance", tolerance, "--end-time", until];
        run(&[&arguments[..], &["--no-figures"]].concat())
    };
    let at = |run: &common::Run, name: &str| run.summary()["end_state"][name].as_f64().expect("a number");
    let (coarse, fine) = (end("1e-11", "8"), end("1e-13", "8"));
    assert_eq!((coarse.status(), fine.status()), (0, 0), "{}{}", coarse.stderr(), fine.stderr());
    assert!((at(&coarse, "b") - at(&fine, "b")).abs() < 1e-6);
    let late = end("1e-12", "60");
    assert!(late.status() == 1 && late.stderr().contains("chaotic motions"), "{}", late.stderr());
    assert!(late.summary()["energy_drift"].as_f64().expect("a number") < 1e-8);
}
