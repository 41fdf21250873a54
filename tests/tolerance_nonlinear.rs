//! `qrm tolerance` where quantities have no derivative, or turn within the tolerances.

use serde_json::Value;

use crate::common::{near, qrm, run};

/// An oscillator with outputs that are known in closed form.
const OSCILLATOR: &str = r#"
name = "oscillator"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
k = { value = 4 }
p = { value = 0.5 }
r = { value = 0.5 }
[points]
P = ['x', '0']
[bodies]
b = { mass = '1', com = "P" }
[loads]
s = { along = 'x', spring = 'k' }
[initial]
given = { x = 1, x_dot = 0 }
[outputs]
Q = { value = '(p-0.5)^2 + 0*x' }
Q3 = { value = '(p-0.4)^2 + 0*x' }
W = { value = '(p-0.5)*(r-0.5) + 0*x' }
S = { value = 'p^2*(1-r) + 0*x' }
D = { value = 'abs(p-0.5)*(2+x)' }
V = { value = 'x_dot^2' }
L = { value = 'abs(x)' }
T = { value = 'exp(-(t-1)^2*100)+exp(-(t-2)^2*100)+0*x' }
[run]
step = 1e-2
until = 'x_dot >= 1'
max_time = 10
"#;

/// A crank with loads that have corners: its extremes lie where derivatives lose their digits.
const CRANK: &str = r#"
name = "crank"
coordinates = ["phi", { name = "x", unit = "m" }]
[parameters]
L = { value = 1 }
r = { value = 0.3 }
[tables]
motor = { x = [0, 1, 2, 4, 6], y = [3, 5, 4, 1, -2] }
spl = { x = [-0.7, 0, 0.7, 1, 1.3,2], y = [0, 1, -1, 0.5, 0,2], spline="natural" }
[points]
A = ['r*cos(phi)', 'r*sin(phi)']
P = ['x', '0']
[bodies]
c = { angle = 'phi', inertia = '0.5' }
b = { mass = '2', com = "P" }
[constraints]
rod = { residual = '((P.x-A.x)^2+(P.y-A.y)^2-L^2)/2' }
[loads]
t = { torque = 'motor(phi_dot)', on = "c" }
w = { force = ['10*spl(x)', '0'], at = "P" }
st = { along = 'x', potential = '5e3*max(s-1.2,0)^2' }
fr = { along = 'x', friction = '2', slip = '0.01' }
[initial]
given = { phi = 0.3, phi_dot = 2 }
solve = { x = 1.2 }
[outputs]
R = { reaction = "rod", at = "P", along = ['1', '0'] }
a = { second_rate = 'P.x' }
T = { power = "t" }
[run]
step = 2e-2
end_time = 2
stiff = true
"#;

/// The summary of a run of the command on the oscillator, and what it printed.
fn tolerance(arguments: &[&str]) -> (Value, String) {
    tolerance_of(OSCILLATOR, arguments)
}

fn tolerance_of(text: &str, arguments: &[&str]) -> (Value, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, text).expect("a scene");
    let mut command = qrm(&["tolerance"]);
    let output = command.arg(&scene).args(arguments).arg("--out").arg(folder.path()).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read(folder.path().join("tolerance.json")).expect("a summary");
    (serde_json::from_slice(&text).expect("JSON"), String::from_utf8_lossy(&output.stdout).into_owned())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

const BOTH: [&str; 6] = ["--vary", "p=0.5+-0.2", "--vary", "r=+-0.1", "--distribution", "uniform"];

#[test]
#[ignore = "full tier: engine"]
fn worst_cases_are_ranges_of_motions() {
    let (summary, text) = tolerance(&BOTH);
    for (name, least, most, is_monotonic) in [
        ("Q_max", 0.0, 0.04, false),
        ("Q3_max", 0.0, 0.09, false),
        ("W_max", -0.02, 0.02, false),
        ("S_max", 0.09 * 0.4, 0.49 * 0.6, true),
        ("V_max", 4.0, 4.0, true),
    ] {
        let effect = &summary["quantities"][name];
        // Samples come near the smallest value of (p-0.4)^2 between the designs.
        for (end, exact) in [least, most].into_iter().enumerate() {
            near(name, number(&effect["worst_case"][end]), exact, 1e-6);
        }
        assert_eq!(effect["monotonic"], is_monotonic, "{name}");
        let warning = text.lines().skip_while(|line| !line.contains("not monotonic")).collect::<String>();
        assert_eq!(warning.contains(name), !is_monotonic, "{name}: {text}");
        let at = |end: usize, parameter: &str| number(&effect["worst_case_at"][end][parameter]);
        for end in 0..2 {
            let (p, r) = (at(end, "p"), at(end, "r"));
            let value = match name {
                "Q_max" => (p - 0.5).powi(2),
                "Q3_max" => (p - 0.4).powi(2),
                "W_max" => (p - 0.5) * (r - 0.5),
                "S_max" => p * p * (1.0 - r),
                _ => continue,
            };
            near(name, number(&effect["worst_case"][end]), value, 1e-12);
        }
    }
}

#[test]
#[ignore = "full tier: engine"]
fn corners_by_signs_serve_many_parameters() {
    let names: Vec<String> = (0..11).map(|i| format!("p{i}")).collect();
    let parameters: String = names.iter().map(|name| format!("{name} = {{ value = 1 }}\n")).collect();
    let sum = names.iter().enumerate().map(|(i, name)| format!("{}{name}", if i % 2 == 0 { "+" } else { "-" }));
    let sum: String = sum.collect();
    let text = OSCILLATOR.replace("k = { value = 4 }\n", &format!("k = {{ value = 4 }}\n{parameters}"));
    let text = text.replace("Q = {", &format!("A = {{ value = '(0*x{sum})^3' }}\nQ = {{"));
    let vary = names.iter().flat_map(|name| ["--vary".to_owned(), format!("{name}=+-0.1")]);
    let arguments: Vec<String> = vary.chain(["--of", "A_max", "--samples", "100"].map(str::to_owned)).collect();
    let (summary, _) = tolerance_of(&text, &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let worst = &summary["quantities"]["A_max"]["worst_case"];
    near("smallest", number(&worst[0]), (1.0_f64 - 1.1).powi(3), 1e-12);
    near("largest", number(&worst[1]), (1.0_f64 + 1.1).powi(3), 1e-12);
}

#[test]
#[ignore = "full tier: engine"]
fn derivatives_that_do_not_exist_are_not_shown() {
    let (summary, text) = tolerance(&["--vary", "k=+-0.4", "--vary", "p=0.5+-0.2"]);
    // The smallest |x| is zero whatever k is, and steps that miss it have derivatives that mean nothing.
    let effect = &summary["quantities"]["L_min"];
    assert_eq!(effect["linear"]["derivatives"]["k"], Value::Null);
    assert!(number(&effect["linear"]["standard_deviation"]) < 1e-6, "{effect}");
    let warning = "do not confirm the derivatives of";
    assert!(text.contains(warning) && text.contains("L_min by k"), "{text}");
    // Others are confirmed.
    let end_time = &summary["quantities"]["end_time"]["linear"]["derivatives"]["k"];
    assert!(number(end_time) < 0.0);
    let (_, text) = tolerance(&["--vary", "p=0.6+-0.01", "--of", "D_max"]);
    assert!(!text.contains(warning) && !text.contains('~'), "{text}");
    // At a kink differences take the place of the derivative.
    let (summary, text) = tolerance(&["--vary", "p=0.505+-0.05", "--of", "D_max"]);
    let linear = &summary["quantities"]["D_max"]["linear"];
    let slope = 3.0 * (0.055 - 0.045) / 0.1;
    assert!(linear["derivatives"]["p"].is_null() && text.contains("D_max by p") && text.contains("~+-"), "{text}");
    near("deviation", number(&linear["standard_deviation"]), slope * 0.05 / 3.0, 1e-9);
    near("difference", number(&linear["differences"]["p"]), slope, 1e-9);
}

#[test]
#[ignore = "full tier: engine"]
fn derivatives_without_digits_are_not_shown() {
    let (summary, _) = tolerance_of(CRANK, &["--vary", "L=1+-0.0005", "--samples", "100"]);
    // Differences of runs by tight steps.
    for (name, slope) in [("R_min", -562.0_f64), ("T_min", -450.9)] {
        let linear = &summary["quantities"][name]["linear"];
        near(name, number(&linear["differences"]["L"]), slope, 0.01 * slope.abs());
        near(name, number(&linear["standard_deviation"]), slope.abs() * 0.0005 / 3.0, 0.02 * slope.abs() * 0.0005);
        let derivative = &linear["derivatives"]["L"];
        assert!(derivative.is_null() || (number(derivative) - slope).abs() < 0.02 * slope.abs(), "{linear}");
    }
    let end = &summary["quantities"]["R_max"]["linear"];
    near("R_max", number(&end["derivatives"]["L"]), number(&end["differences"]["L"]), 1.0);
}

#[test]
#[ignore = "full tier: engine"]
fn nominal_values_are_those_of_a_run_in_known_digits() {
    let (summary, text) = tolerance(&["--vary", "k=+-0.4", "--samples", "1000"]);
    // The pulse at t = 1 is narrow against a step.
    let pulse = &summary["quantities"]["T_max"];
    near("T_max", number(&pulse["nominal"]), 1.0, 1e-12);
    near("T_max", number(&pulse["worst_case"][0]), 1.0, 1e-12);
    // Lanes find its peak in all samples.
    assert!(number(&pulse["monte_carlo"]["error"]) < 1e-9 && !text.contains("samples with ?"), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("oscillator.toml");
    std::fs::write(&scene, OSCILLATOR).expect("a scene");
    let own = run(&[scene.to_str().expect("a path"), "--method", "dop853", "--no-figures"]).summary();
    for (output, end) in [("V", "min"), ("V", "max"), ("L", "min"), ("Q", "max")] {
        let effect = &summary["quantities"][&format!("{output}_{end}")];
        assert_eq!(effect["nominal"], own["extremes"][output][end], "{output}");
        assert_eq!(effect["error"], own["extremes"][output][format!("{end}_error")], "{output}");
    }
    let end = &summary["quantities"]["end_time"];
    // x = cos(2 t) comes to x' = 1.
    let exact = (std::f64::consts::PI + (0.5_f64).asin()) / 2.0;
    let error = (number(&end["nominal"]) - exact).abs();
    assert!(error <= 3.0 * number(&end["error"]) && number(&end["error"]) < 1e-8, "{end}");
    assert!(text.contains("1.832595") && !text.contains("0.99066"), "{text}");
}
