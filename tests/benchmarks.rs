//! Problems that others published, against their values and against some of higher precision.

mod common;

use common::run;

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
