//! `qrm modes` and `qrm linearize` against closed forms, 40 digits and runs.

use std::f64::consts::TAU;

use serde_json::Value;

use crate::common::{error, number, within, writing, written};

/// The contents of `modes.json`.
fn modes(arguments: &[&str]) -> Value {
    written(&[&["modes", "--no-figures"], arguments].concat(), "modes.json")
}

/// Compares derivatives to this part of their values.
fn derivatives(mode: &Value, expected: &[(&str, f64)], part: f64) {
    for (name, expected) in expected {
        let found = number(&mode["by"][name]);
        assert!((found - expected).abs() <= part * expected.abs(), "{name}: {found} instead of {expected}");
    }
}

/// `w^2 = (2 -+ sqrt 2) g/l`, with the lower mass `+-sqrt 2` as far as the upper one.
#[test]
fn a_double_pendulum_has_the_frequencies_of_its_closed_form() {
    let found = modes(&["double-pendulum", "--at", "a=10deg,b=3deg"]);
    assert_eq!(found["equilibrium"]["stability"], "stable");
    for (mode, sign) in [(0, -1.0), (1, 1.0)] {
        let rate = ((2.0 + sign * 2.0_f64.sqrt()) * 9.81).sqrt();
        let mode = &found["modes"][mode];
        within(&mode["rate"], &mode["rate_error"], rate, 1e-14 * rate);
        within(&mode["frequency"], &mode["frequency_error"], rate / TAU, 1e-14 * rate);
        assert!((number(&mode["shape"]["a"]) + sign * 0.5_f64.sqrt()).abs() < 1e-14, "{mode}");
        assert!((number(&mode["shape"]["b"]) - 1.0).abs() < 1e-15, "{mode}");
        derivatives(mode, &[("g", 0.5 * rate / 9.81), ("l", -0.5 * rate)], 1e-13);
        assert!(number(&mode["by"]["m"]).abs() < 1e-13 * rate, "{mode}");
    }
    // All four positions in which the rods hang or stand.
    assert_eq!(found["others"].as_array().expect("others").len(), 3);
    let standing = &found["others"].as_array().expect("others")[2];
    let growth = ((2.0 + 2.0_f64.sqrt()) * 9.81).sqrt();
    assert_eq!(standing["stability"], "unstable");
    assert!((number(&standing["growth"]) - growth).abs() < 1e-13 * growth, "{standing}");
}

#[test]
fn a_mode_is_drawn_and_is_a_row_of_a_table() {
    let run = writing(&["modes", "double-pendulum", "--at", "a=10deg,b=3deg"]);
    assert!(run.output.status.success(), "{}", run.stderr());
    let text = run.stdout();
    assert!(text.contains("stable: deviations oscillate") && text.contains("mode-2.gif"), "{text}");
    for name in ["mode-1.gif", "mode-2.gif"] {
        assert!(std::fs::read(run.path(name)).is_ok_and(|bytes| bytes.starts_with(b"GIF89a")), "{name}");
    }
    assert!(!run.path("mode-3.gif").exists());
    let table = crate::common::Table::read(&run.path("modes.csv"));
    let header =
        "mode kind frequency frequency_error rate rate_error square square_error shape_a shape_b by_l by_m by_g by_a0";
    assert_eq!(table.columns.join(" "), header);
    assert_eq!(table.rows.len(), 2);
}

/// Equilibrium, frequency and derivatives come from the reduced potential and mass of the loop with 50 digits.
#[test]
#[ignore = "full tier: engine"]
fn a_four_bar_with_springs_to_forty_digits() {
    let found = modes(&["tests/modes/four-bar-springs.toml"]);
    let at = &found["equilibrium"];
    let place = [("a", 1.058_464_928_424_014), ("b", 0.400_531_533_206_956_2), ("c", 1.535_284_947_922_927_4)];
    for (name, expected) in place {
        within(&at["coordinates"][name], &at["errors"][name], expected, 1e-14);
    }
    let mode = &found["modes"][0];
    within(&mode["rate"], &mode["rate_error"], 19.800_911_804_521_634, 1e-12);
    let by = [
        ("d", 19.675_006_423_482_14),
        ("l1", -115.539_786_070_033_81),
        ("l2", -23.034_378_608_490_613),
        ("l3", 18.048_384_010_780_968),
        ("m1", -1.268_572_591_090_179),
        ("m2", -3.137_994_011_321_55),
        ("m3", -0.557_538_219_875_334_7),
        ("J1", -109.440_430_126_115_22),
        ("J2", -5.542_257_226_622_744),
        ("J3", -16.263_042_324_658_306),
        ("g", -0.081_629_871_705_397_56),
        ("k1", 0.286_972_214_360_137_9),
        ("k3", -0.028_423_235_182_191_086),
        ("a0", -5.365_020_092_797_844),
        ("c0", -4.791_585_532_966_689),
        ("T", -0.134_125_502_319_946_09),
    ];
    derivatives(mode, &by, 1e-11);
    assert_eq!(mode["by"]["e"], 0.0);
    let value = &found["eigenvalues"][0];
    within(&value["re"], &value["error"], -0.492_796_770_730_867_9, 1e-12);
    within(&value["im"], &value["error"], 19.794_778_595_205_39, 1e-12);
    assert_eq!(at["stability"], "asymptotically_stable");
}

/// `m x'' + c x' + k x = F`
#[test]
#[ignore = "full tier: engine"]
fn a_damped_oscillator_has_the_eigenvalues_of_its_closed_form() {
    let scene = "tests/modes/oscillator.toml";
    let found = modes(&[scene]);
    within(&found["equilibrium"]["coordinates"]["x"], &found["equilibrium"]["errors"]["x"], 0.2, 1e-15);
    let mode = &found["modes"][0];
    within(&mode["rate"], &mode["rate_error"], 5.0, 1e-14);
    derivatives(mode, &[("k", 0.05), ("m", -1.25)], 1e-14);
    let value = &found["eigenvalues"][0];
    within(&value["re"], &value["error"], -0.75, 1e-13);
    within(&value["im"], &value["error"], (25.0_f64 - 0.75 * 0.75).sqrt(), 1e-13);
    assert!(
        (number(&value["damping_ratio"]) - 0.15).abs() < 1e-14 && (number(&value["time"]) - 4.0 / 3.0).abs() < 1e-13
    );
    // From elsewhere to zero.
    let relaxed = modes(&[scene, "--set", "F=1e-300", "--at", "x=0.3"]);
    within(&relaxed["equilibrium"]["coordinates"]["x"], &relaxed["equilibrium"]["errors"]["x"], 0.0, 1e-15);
    // Critical damping: both eigenvalues are -5, and have half of the digits.
    let critical = modes(&[scene, "--set", "c=20"]);
    for value in critical["eigenvalues"].as_array().expect("eigenvalues") {
        within(&value["re"], &value["error"], -5.0, 1e-6);
        within(&value["im"], &value["error"], 0.0, 1e-6);
    }
    // Strong damping: a fast and a slow decay.
    let strong = modes(&[scene, "--set", "c=2000"]);
    let root = (500.0_f64 * 500.0 - 25.0).sqrt();
    within(&strong["eigenvalues"][0]["re"], &strong["eigenvalues"][0]["error"], -25.0 / (500.0 + root), 1e-14);
    within(&strong["eigenvalues"][1]["re"], &strong["eigenvalues"][1]["error"], -500.0 - root, 1e-10);
}

/// `n` equal masses at equal distances hang like a heavy chain: the squares of frequencies are the roots of Laguerre's
/// polynomial `L_n`, in parts of `g/l`.
#[test]
#[ignore = "full tier: engine"]
fn a_chain_of_masses_has_the_roots_of_laguerres_polynomial() {
    let count = 16;
    let (folder, scene) = chain(count);
    let found = modes(&[&scene]);
    drop(folder);
    for mode in found["modes"].as_array().expect("modes") {
        let [rate, error] = ["rate", "rate_error"].map(|name| number(&mode[name]));
        let mut x = rate * rate * 0.5 / 9.81;
        for _ in 0..3 {
            x -= laguerre(count, x);
        }
        let expected = (x * 9.81 / 0.5).sqrt();
        // The root of the polynomial has twelve digits too.
        assert!((rate - expected).abs() <= 3.0 * error + 1e-13 * rate && error < 1e-12 * rate, "{rate} {expected}");
    }
}

/// The quotient of Laguerre's polynomial and its derivative.
fn laguerre(n: u32, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, 1.0 - x);
    for k in 1..n {
        let k = f64::from(k);
        (before, now) = (now, ((2.0 * k + 1.0 - x) * now - k * before) / (k + 1.0));
    }
    now * x / (f64::from(n) * (now - before))
}

/// A scene file of point masses on rods, one below the other.
fn chain(count: u32) -> (tempfile::TempDir, String) {
    let list = |part: &dyn Fn(u32) -> String, between: &str| (0..count).map(part).collect::<Vec<_>>().join(between);
    let coordinates = list(&|i| format!("{{ name = \"a{i}\", unit = \"rad\" }}"), ", ");
    let point = |i: u32| {
        let above = if i == 0 { "O".to_owned() } else { format!("P{}", i - 1) };
        format!("P{i} = [\"{above}.x + l*sin(a{i})\", \"{above}.y - l*cos(a{i})\"]")
    };
    let text = format!(
        "name = \"hanging\"\ncoordinates = [{coordinates}]\n[parameters]\nl = {{ value = 0.5, unit = \"m\" }}\n\
         m = {{ value = 2.0, unit = \"kg\" }}\ng = {{ value = 9.81, unit = \"m/s^2\" }}\n[points]\nO = [\"0\", \"0\"]\n{}\n\
         [bodies]\n{}\n[loads]\nweight = {{ gravity = [\"0\", \"-g\"] }}\n[initial]\ngiven = {{ {} }}\n[run]\n\
         step = 1e-3\nend_time = 1\n",
        list(&point, "\n"),
        list(&|i| format!("b{i} = {{ mass = \"m\", com = \"P{i}\" }}"), "\n"),
        list(&|i| format!("a{i} = 0.1, a{i}_dot = 0"), ", "),
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("hanging.toml");
    std::fs::write(&path, text).expect("written");
    let path = path.display().to_string();
    (folder, path)
}

/// Ziegler's column: `2 x^2 + (2 P - 7) x + 1 = 0` for the squares of frequencies.
#[test]
#[ignore = "full tier: engine"]
fn a_force_that_follows_makes_a_column_flutter() {
    let scene = "tests/modes/ziegler.toml";
    let below = modes(&[scene]);
    for (place, sign) in [(0, -1.0), (1, 1.0)] {
        let mode = &below["modes"][place];
        within(&mode["square"], &mode["square_error"], (5.0 + sign * 17.0_f64.sqrt()) / 4.0, 1e-13);
        // The derivative of the quadratic equation.
        let x = number(&mode["square"]);
        let by = -x / (4.0 * x - 5.0) / number(&mode["rate"]);
        derivatives(mode, &[("P", by)], 1e-12);
    }
    assert_eq!(below["equilibrium"]["stability"], "undecided");
    let above = modes(&[scene, "--set", "P=2.5"]);
    assert_eq!(above["equilibrium"]["stability"], "unstable");
    assert_eq!(above["modes"].as_array().map(Vec::len), Some(0));
    let square = [&above["complex_squares"][0][0], &above["complex_squares"][0][1]].map(number);
    assert!((square[0] - 0.5).abs() < 1e-14 && (square[1] - 0.5).abs() < 1e-14, "{square:?}");
    // The square root of -(1 + i)/2.
    let value = &above["eigenvalues"][0];
    let growth = ((0.5_f64.sqrt() - 0.5) / 2.0).sqrt();
    within(&value["re"], &value["error"], growth, 1e-14);
    within(&value["im"], &value["error"], 0.25 / growth, 1e-14);
}

/// Derivatives against central differences of frequencies about the moved equilibrium.
#[test]
fn derivatives_agree_with_differences_of_frequencies() {
    let scene = ["slider-crank", "--no-others", "--at", "q=10deg"];
    let found = modes(&scene);
    let mode = &found["modes"][0];
    for (name, value) in [("k", 0.5), ("m2", 1.0)] {
        let rate = |value: f64| {
            let set = format!("{name}={value}");
            number(&modes(&[&scene[..], &["--set", &set]].concat())["modes"][0]["rate"])
        };
        let h = 1e-3;
        let slope = |h: f64| (rate(value + h) - rate(value - h)) / (2.0 * h);
        let expected = (4.0 * slope(h) - slope(2.0 * h)) / 3.0;
        let own = {
            let set = format!("{name}={value}");
            number(&modes(&[&scene[..], &["--set", &set]].concat())["modes"][0]["by"][name])
        };
        assert!((own - expected).abs() < 1e-10, "{name}: {own} {expected}");
    }
    assert_eq!(mode["kind"], "oscillation");
}

#[test]
fn a_mechanism_without_loads_rests_everywhere() {
    let found = modes(&["four-bar"]);
    assert_eq!((&found["equilibrium"]["stability"], &found["modes"][0]["kind"]), (&"free".into(), &"free".into()));
    assert_eq!((number(&found["modes"][0]["rate"]), &found["modes"][0]["by"]), (0.0, &Value::Null));
    assert_eq!(found["others"].as_array().map(Vec::len), Some(0));
}

/// Two states, and the response to a step of 1e-6 that a run has: six digits.
#[test]
#[ignore = "full tier: engine"]
fn a_linear_model_of_a_four_bar_follows_a_run() {
    let scene = "tests/modes/four-bar-springs.toml";
    let outputs = ["c", "a_dot", "c_ddot", "Rx"];
    let named: Vec<&str> = outputs.iter().flat_map(|name| ["--output", name]).collect();
    let model = written(&[&["linearize", scene, "--input", "T"], &named[..]].concat(), "linear.json");
    let states: Vec<&Value> = model["states"].as_array().expect("states").iter().map(|state| &state["name"]).collect();
    assert_eq!(states, ["a", "a_dot"]);
    let entry = |matrix: &str, row: usize, column: usize| number(&model[matrix][row][column]);
    // -k/m and -d/m of the reduced equation with 50 digits: twice the real part, and the square of the frequency.
    let expected = [-392.076_108_290_444_3, -0.985_593_541_461_735_8];
    for (column, expected) in expected.into_iter().enumerate() {
        within(&model["A"][1][column], &model["errors"]["A"][1][column], expected, 1e-12 * expected.abs());
    }
    let start = format!("a={:?}", number(&model["equilibrium"]["a"]));
    let step = 1e-6;
    let run = |torque: f64| {
        let set = format!("T={torque:?}");
        let how = ["--method", "dop853", "--tolerance", "1e-15", "--step", "0.01", "--end-time", "0.5"];
        let run = crate::common::run(&[&[scene, "--start", &start, "--set", &set], &how[..]].concat());
        run.trajectory()
    };
    let [before, after] = [run(0.5), run(0.5 + step)];
    let [before, after] = [before, after].map(|table| {
        outputs.map(|name| {
            let column = table.columns.iter().position(|column| column == name).expect("a column");
            table.rows.iter().map(|row| row[column].parse::<f64>().expect("a number")).collect::<Vec<_>>()
        })
    });
    let [a, b] = [[entry("A", 1, 0), entry("A", 1, 1)], [entry("B", 1, 0), 0.0]];
    let mut x = [0.0, 0.0];
    let mut largest = [0.0_f64; 4];
    let mut worst = [0.0_f64; 4];
    for row in 0..=50 {
        for (place, (largest, worst)) in largest.iter_mut().zip(&mut worst).enumerate() {
            let linear = entry("C", place, 0) * x[0] + entry("C", place, 1) * x[1] + entry("D", place, 0);
            let nonlinear = (after[place][row] - before[place][row]) / step;
            *largest = largest.max(linear.abs());
            *worst = worst.max((linear - nonlinear).abs());
        }
        // RK4 of the linear equation to the next row.
        for _ in 0..100 {
            let h = 1e-4;
            let f = |x: [f64; 2]| [x[1], a[0] * x[0] + a[1] * x[1] + b[0]];
            let along = |k: [f64; 2], h: f64| [x[0] + h * k[0], x[1] + h * k[1]];
            let k1 = f(x);
            let k2 = f(along(k1, 0.5 * h));
            let k3 = f(along(k2, 0.5 * h));
            let k4 = f(along(k3, h));
            x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
        }
    }
    for (place, name) in outputs.iter().enumerate() {
        assert!(worst[place] < 1e-6 * largest[place], "{name}: {:e} of {:e}", worst[place], largest[place]);
    }
}

/// `X/F = 1/(k - m w^2 + i c w)`, in 1000 frequencies.
#[test]
#[ignore = "full tier: engine"]
fn a_frequency_response_is_that_of_its_closed_form() {
    let arguments = ["linearize", "tests/modes/oscillator.toml", "--input", "F", "--output", "x", "--output", "grip"];
    let run = writing(&arguments);
    assert!(run.output.status.success(), "{}", run.stderr());
    let table = crate::common::Table::read(&run.path("frequency_response.csv"));
    assert_eq!(table.rows.len(), 1000);
    let column = |name: &str| table.columns.iter().position(|column| column == name).expect("a column");
    let places = ["rate", "x/F_re", "x/F_im", "x/F_gain", "x/F_phase_deg", "grip/F_re", "grip/F_im"].map(column);
    for row in &table.rows {
        let [w, re, im, gain, phase, grip_re, grip_im] =
            places.map(|column| row[column].parse::<f64>().expect("a number"));
        let (real, imaginary) = (50.0 - 2.0 * w * w, 3.0 * w);
        let size = real * real + imaginary * imaginary;
        let near = |found: f64, expected: f64, size: f64| assert!((found - expected).abs() < 1e-13 * size, "{row:?}");
        near(re, real / size, size.sqrt().recip());
        near(im, -imaginary / size, size.sqrt().recip());
        near(gain, size.sqrt().recip(), size.sqrt().recip());
        near(phase, (-imaginary).atan2(real).to_degrees(), 360.0);
        near(grip_re, (50.0 * real + imaginary * imaginary) / size, 50.0 / size.sqrt() + 1.0);
        near(grip_im, (imaginary * real - 50.0 * imaginary) / size, 50.0 / size.sqrt() + 1.0);
    }
    assert!(run.path("frequency_response.svg").exists());
    let script = std::process::Command::new("octave-cli")
        .args(["--quiet", "--norc", "--eval", "linear; printf('%.17g ', A, B, C, D)"])
        .current_dir(run.path(""))
        .output()
        .expect("octave-cli");
    let printed = String::from_utf8_lossy(&script.stdout);
    let numbers: Vec<f64> = printed.split_whitespace().map(|number| number.parse().expect("a number")).collect();
    // Column by column.
    let expected = [0.0, -25.0, 1.0, -1.5, 0.0, 0.5, 1.0, 50.0, 0.0, 3.0, 0.0, 0.0];
    assert_eq!(numbers.len(), expected.len(), "{printed}{}", String::from_utf8_lossy(&script.stderr));
    assert!(numbers.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12), "{printed}");
}

/// The start of the toggle clamp leads to a position where the force is smallest. Near one it is an error, with the
/// force there.
#[test]
#[ignore = "full tier: engine"]
fn what_is_near_is_found_or_said() {
    let scene = "scenes/linkages/toggle-clamp.toml";
    let found = modes(&[scene]);
    assert_eq!(
        (&found["is_from_start"], &found["equilibrium"]["stability"]),
        (&false.into(), &"asymptotically_stable".into())
    );
    let model = written(&["linearize", scene, "--input", "F", "--output", "clamping"], "linear.json");
    assert_eq!(model["equilibrium"], found["equilibrium"]["coordinates"]);
    let error = error(&["modes", scene, "--at", "phi_link=80deg"]);
    assert!(error.contains("no equilibrium was found. Nearest is phi_link ="), "{error}");
    assert!(error.contains("on `phi_link` is not balanced"), "{error}");
    let repeated = self::error(&["modes", "tests/functions/redundant.toml"]);
    assert!(repeated.contains("C_q has rank 1 with 3 constraints"), "{repeated}");
}

#[test]
fn where_there_are_no_modes_it_is_said() {
    for (arguments, words) in [
        (&["modes", "quick-return-driven"][..], "the mechanism has no degree of freedom"),
        (
            &["modes", "thrown-stick"],
            "no equilibrium was found. Nearest is x = 0.0000000 m, y = 0.0000000 m, a = 0.0000 deg, where a force of 7.8480e0 N on `y`",
        ),
        (&["modes", "slider-crank", "--set", "a=1", "--at", "q=90deg"], "the position is singular"),
        (&["modes", "slider-crank", "--set", "J1=0", "--set", "J2=0", "--set", "m2=0"], "has no inertia at q = "),
        (&["modes", "shaper"], "no equilibrium was found. Nearest is phi2 ="),
        (&["modes", "pendulum", "--at", "z=1"], "`--at z=1`: scene `pendulum` has no coordinate `z`"),
        (&["modes", "four-bar", "--at", "q2=1"], "scene `four-bar` does not give `q2` at its start"),
        (&["modes", "four-bar", "--at", "q1"], "`--at q1`: `q1` has no `=`"),
        (&["modes", "four-bar", "--at", "q1=1,q1=2"], "`--at q1` is given twice"),
        (&["modes", "four-bar", "--set", "l9=1"], "has no parameter `l9`"),
        (&["linearize", "slider-crank", "--input", "m2", "--output", "x"], "`m2` changes the masses"),
        (&["linearize", "slider-crank", "--input", "L1", "--output", "x"], "has no parameter `L1`"),
        (&["linearize", "slider-crank", "--input", "F", "--output", "xx"], "has no coordinate or output `xx`"),
        (&["linearize", "slider-crank", "--input", "a", "--output", "x"], "`a` changes the constraints"),
        (&["linearize", "slider-crank", "--output", "x"], "--input"),
    ] {
        let error = error(arguments);
        assert!(error.contains(words), "{arguments:?}: {error}");
    }
}
