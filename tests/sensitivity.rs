//! `qrm sensitivity` against published values, closed forms and itself.

use std::collections::HashMap;
use std::path::Path;

use qrm_sim::analysis::{SensitivityError, SensitivityRequest};
use qrm_sim::run::End;

use crate::common::{model, qrm};

/// The value and the derivatives of each quantity, by their names in the table.
type Table = HashMap<(String, String), HashMap<String, f64>>;

fn sensitivity(arguments: &[&str]) -> Table {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_str().expect("a path");
    let output = qrm(&[&["sensitivity"], arguments, &["--out", out]].concat()).output().expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    read(&folder.path().join("sensitivity.csv"))
}

fn read(path: &Path) -> Table {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let header: Vec<String> = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let row = |record: csv::StringRecord| {
        let numbers =
            header.iter().zip(&record).skip(3).map(|(name, text)| (name.clone(), text.parse().expect("a number")));
        ((record[0].to_owned(), record[1].to_owned()), numbers.collect())
    };
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

fn of<'t>(table: &'t Table, what: &str, name: &str) -> &'t HashMap<String, f64> {
    &table[&(what.to_owned(), name.to_owned())]
}

fn close(got: f64, expected: f64, within: f64) {
    assert!((got - expected).abs() <= within, "{got} instead of {expected}: off by {:.1e}", got - expected);
}

/// dG/dk and dG/dc of SUNDIALS' idasSlCrank_FSA_dns, integrated with 120 bits: G is the integral of the kinetic energy
/// over 10 s.
#[test]
fn the_published_sensitivities_of_the_slider_crank() {
    let table = sensitivity(&["slider-crank", "--by", "k", "--by", "c", "--of", "T", "--step", "1e-3"]);
    let integral = of(&table, "integral", "T");
    close(integral["value"], 3.336_606_799_482_784_6, 1e-11);
    close(integral["by_k"], 0.333_448_106_128, 2e-12);
    close(integral["by_c"], -0.363_754_033_971, 2e-12);
    // Eight digits at the scene's own step.
    let table = sensitivity(&["slider-crank", "--by", "k", "--by", "c", "--of", "T"]);
    close(of(&table, "integral", "T")["by_k"], 0.333_448_106_128, 5e-9);
    close(of(&table, "integral", "T")["by_c"], -0.363_754_033_971, 5e-9);
}

/// A quarter of a turn of a crank that nothing moves but its start: phi2 = w0 t, so the time is (pi/2)/w0.
#[test]
fn a_stop_that_moves() {
    let table = sensitivity(&["thrown-stick", "--by", "w", "--until", "a >= 1", "--of", "end"]);
    let end = of(&table, "end", "t");
    close(end["by_w"], -end["value"] / end_value("thrown-stick", "w"), 1e-9);
    close(of(&table, "end", "a")["by_w"], 0.0, 1e-12);
}

fn end_value(scene: &str, parameter: &str) -> f64 {
    let listed = qrm(&["list"]).output().expect("the command starts");
    let text = String::from_utf8_lossy(&listed.stdout).into_owned();
    let block = text.split("\n\n").find(|block| block.starts_with(&format!("{scene}:"))).expect("the scene");
    let line =
        block.lines().find(|line| line.trim_start().starts_with(&format!("{parameter} "))).expect("the parameter");
    line.split_whitespace().nth(1).expect("its value").parse().expect("a number")
}

/// A crank driven at constant speed: its positions do not depend on masses, its torque is linear in them, and all is
/// linear in the end of the turn, 2 pi/w.
#[test]
fn a_driven_crank() {
    let table = sensitivity(&["quick-return-driven", "--by", "m6", "--by", "w", "--of", "x6", "--of", "torque"]);
    for what in ["end", "minimum", "maximum", "integral"] {
        close(of(&table, what, "x6")["by_m6"], 0.0, 1e-12);
    }
    let x6 = of(&table, "integral", "x6");
    let w = end_value("quick-return-driven", "w");
    close(x6["by_w"], -x6["value"] / w, 1e-9);
    let largest = of(&table, "time_of_maximum", "x6");
    close(largest["by_w"], -largest["value"] / w, 1e-6);
    let twice = |m6: &str| {
        of(&sensitivity(&["quick-return-driven", "--by", "m6", "--of", "torque", "--set", m6]), "end", "torque").clone()
    };
    let (light, heavy) = (twice("m6=2"), twice("m6=6"));
    close(light["by_m6"], heavy["by_m6"], 1e-9);
    close(light["by_m6"], (heavy["value"] - light["value"]) / 4.0, 1e-9);
}

/// The pendulum passes positions that its kernel does not suit; its derivatives by length are those of a pendulum of
/// another length at another time: x(t; l, g) = l X(t sqrt(g/l)).
#[test]
fn where_the_kernel_does_not_suit() {
    let table = sensitivity(&["pendulum", "--by", "l", "--by", "g", "--of", "end", "--end-time", "3"]);
    let (l, g) = (end_value("pendulum", "l"), end_value("pendulum", "g"));
    for name in ["x", "y"] {
        let (place, rate) = (of(&table, "end", name), of(&table, "end", &format!("{name}_dot")));
        close(place["by_g"], rate["value"] * 3.0 / (2.0 * g), 1e-7);
        close(place["by_l"], place["value"] / l - rate["value"] * 3.0 / (2.0 * l), 1e-7);
    }
}

/// Two coupled four-bars amount to a pendulum, whose angle is a function of v0^2/(g l) and t sqrt(g/l). They pass a
/// singular position after 1.2 s: steps that do not end beside it pass over it.
#[test]
fn steps_pass_over_singular_positions() {
    let table = sensitivity(&["n-four-bar-2", "--end-time", "2", "--of", "end", "--by", "v0", "--by", "g"]);
    let (v0, g) = (end_value("n-four-bar-2", "v0"), end_value("n-four-bar-2", "g"));
    let (angle, rate) = (of(&table, "end", "a0"), of(&table, "end", "a0_dot"));
    close(angle["by_g"], (2.0 * rate["value"] - v0 * angle["by_v0"]) / (2.0 * g), 1e-9);
}

#[test]
fn what_is_not_there_is_named() {
    let said = |arguments: &[&str]| {
        let output = qrm(&[&["sensitivity"], arguments].concat()).output().expect("the command starts");
        assert!(!output.status.success(), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(said(&["slider-crank", "--by", "kk"]).contains("has no parameter `kk`"));
    assert!(said(&["slider-crank", "--of", "G"]).contains("has no output of this name"));
    assert!(said(&["quick-return", "--set", "BC=0.1"]).contains("cannot be assembled"));
    assert!(said(&["double-pendulum", "--of", "end"]).contains("cannot be relied on"));
}

#[test]
fn many_parameters_give_what_each_gives_by_itself() {
    let model = model("quick-return");
    let by: Vec<&str> = model.description.parameters.iter().map(|parameter| parameter.name).collect();
    assert!(by.len() > 8, "{by:?}");
    let end = || Some(End::Time(0.3));
    let derive = |by: &[&str]| {
        qrm_sim::analysis::sensitivity(
            model,
            &|_| None,
            &SensitivityRequest { by, end: end(), ..SensitivityRequest::default() },
        )
        .expect("smooth")
    };
    let all = derive(&by);
    for (place, name) in by.iter().enumerate() {
        let alone = derive(&[name]);
        for (together, alone) in all.q.iter().chain(&all.qd).zip(alone.q.iter().chain(&alone.qd)) {
            assert_eq!((together.value, together.by[place]), (alone.value, alone.by[0]), "by {name}");
        }
    }
}

#[test]
fn extremes_that_may_be_replaced_are_said_to_be_not_checked() {
    // Without torque each extreme occurs twice in two revolutions.
    let output = qrm(&["sensitivity", "quick-return-loaded", "--by", "T2"]).output().expect("the command starts");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("not checked") && said.contains("time_of_maximum x6_dot"), "{said}");
    assert!(output.status.success());
}

#[test]
fn an_interrupted_motion_says_so() {
    let keep_running = |t: f64, _: f64| t < 0.1;
    for by in [&["k"][..], &[]] {
        let end = Some(End::Time(500.0));
        let request =
            SensitivityRequest { by, end, keep_running: Some(&keep_running), ..SensitivityRequest::default() };
        let found = qrm_sim::analysis::sensitivity(model("slider-crank"), &|_| None, &request);
        assert!(matches!(found, Err(SensitivityError::Interrupted { t }) if t >= 0.1), "{found:?}");
    }
}

/// The Schur complement of the constraints has no digits, although the position is regular: the rocker weighs 15 mg,
/// the crank 12 t. The command compares with difference quotients itself.
#[test]
#[ignore = "full tier: engine"]
fn masses_may_differ_by_many_orders_of_magnitude() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/sensitivity/light-rocker.toml").display().to_string();
    for method in ["dopri5", "dop853", "gauss", "auto"] {
        let table = sensitivity(&[&scene, "--of", "end", "--method", method, "--tolerance", "1e-10"]);
        let crank = of(&table, "end", "phi_crank");
        close(crank["by_p_J_rocker"], 2.144_264e-4, 1e-10);
        close(crank["by_p_m_rocker"], -1.953_694_076e-5, 1e-13);
        close(crank["by_p_J_coupler"], 2.200_054e-4, 1e-10);
    }
}

/// A motion that begins at rest changes its forces less than their rounding errors at first; the derivative of the
/// angle follows from the law of cosines, per mm as the parameter.
#[test]
#[ignore = "full tier: engine"]
fn integrals_of_motions_that_begin_at_rest_are_known() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/crates/cli/src/commands/new/cylinder.toml");
    let table = sensitivity(&[scene, "--by", "closed", "--no-check"]);
    let (first, second, length) = (0.2_f64.hypot(0.6), 0.7_f64.hypot(0.1), 0.9);
    let cosine = (first * first + second * second - length * length) / (2.0 * first * second);
    let exact = 1e-3 * length / (first * second * (1.0 - cosine * cosine).sqrt());
    close(of(&table, "end", "phi_boom")["by_closed"], exact, 1e-11);
    assert!(of(&table, "integral", "F_O_x").values().all(|number| number.is_finite()));
}
