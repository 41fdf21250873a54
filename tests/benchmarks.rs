//! Problems that others published, against their values and against some of higher precision.

mod common;

use common::{Table, run};

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
/// The same by extrapolation of order 20 with 128 bits.
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
#[ignore = "it needs a build of its own"]
fn forty_coupled_four_bars_keep_parallel() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut build = std::process::Command::new(env!("CARGO"));
    build.current_dir(env!("CARGO_MANIFEST_DIR")).env("QRM_SCENES", "n-four-bar-40");
    build.args([
        "run",
        "--release",
        "--target-dir",
        "target/large",
        "--",
        "run",
        "n-four-bar-40",
        "--no-figures",
        "--out",
    ]);
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
