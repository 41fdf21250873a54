//! Any command line, an argument a line: an exit status that fits, no panic, no number in a file that is none, and no
//! run that is accepted and not as accurate as it claims.

#![no_main]

use std::path::Path;

use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};
use qrm_cli::execute;

/// Scenes with parameters of theirs.
const SCENES: [(&str, &str); 3] = [
    ("quick-return", "O2A O4B BC O4O2 O4G4 BG5 yC m3 m4 m5 m6 J2 J4 J5 F6 w0"),
    ("quick-return-loaded", "O2A O4B BC O4O2 O4G4 BG5 yC m3 m4 m5 m6 J2 J3 J4 J5 F6 w0 T2 g k cd x6_0 k cd k cd J2"),
    ("n-four-bar-2", "l m J g v0"),
];
const METHODS: [&str; 6] = ["rk4", "dopri5", "dop853", "gauss", "auto", "rodas"];

fuzz_target!(|text: &str| {
    let arguments: Vec<&str> = text.lines().collect();
    if !is_short(&arguments) {
        return;
    }
    let out = std::env::temp_dir().join(format!("qrm-fuzz-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&out);
    let folder = out.display().to_string();
    let status = run(&arguments, &folder);
    assert!(status <= 2, "status {status}");
    let rows = std::fs::read_to_string(out.join("trajectory.csv")).unwrap_or_default();
    let numbers = rows.split_once('\n').map_or("", |(_, rows)| rows);
    assert!(!numbers.contains("NaN") && !numbers.contains("inf"), "a row is not finite");
    if status == 0 && arguments.first() == Some(&"run") {
        check(&arguments, &out);
    }
});

fn run(arguments: &[&str], folder: &str) -> u8 {
    let line = [&["qrm"], arguments, &["--out", folder]].concat();
    execute(qrm_model::MODELS, line.into_iter().map(Into::into))
}

/// Whether a run takes no more than some ten thousand steps, and nothing is written elsewhere.
fn is_short(arguments: &[&str]) -> bool {
    let after = |option: &str| {
        let place = arguments.iter().position(|a| *a == option)?;
        arguments.get(place + 1)?.trim().parse::<f64>().ok()
    };
    let (step, end) = (after("--step").unwrap_or(1e-3), after("--end-time").unwrap_or(10.0));
    let is_given_once = |option: &str| arguments.iter().filter(|a| a.contains(option)).count() <= 1;
    let is_run = arguments
        .first()
        .is_some_and(|a| ["run", "stability", "check", "explain", "code", "derive", "list"].contains(a));
    is_run
        && step > 0.0
        && end / step <= 1e4
        && ["--step", "--end-time", "--tolerance", "--until"].iter().all(|option| is_given_once(option))
        && !arguments.iter().any(|a| a.contains("--out") || a.contains("--closure"))
}

/// Compares the end of an accepted run with that of one with a tight tolerance, if that can be relied on.
fn check(arguments: &[&str], out: &Path) {
    let summary = |out: &Path| -> Option<serde_json::Value> {
        serde_json::from_str(&std::fs::read_to_string(out.join("summary.json")).ok()?).ok()
    };
    let Some(got) = summary(out) else { panic!("no summary") };
    let end = got["end_time"].as_f64().expect("a time");
    if !(end > 0.0) || got["projection"] == "none" {
        return;
    }
    let mut again = vec!["run", got["scene"].as_str().expect("a name")];
    let set = arguments.windows(2).filter(|pair| pair[0] == "--set").flatten();
    let (end_text, step_text) = (format!("{end:?}"), format!("{:?}", 0.1 * end));
    again.extend(set.copied());
    again.extend([
        "--method",
        "auto",
        "--tolerance",
        "1e-10",
        "--no-figures",
        "--end-time",
        &end_text,
        "--step",
        &step_text,
    ]);
    let other = out.join("again");
    if run(&again, &other.display().to_string()) != 0 {
        return;
    }
    let Some(exact) = summary(&other) else { return };
    let accumulation = (10.0 * got["steps"].as_f64().expect("a number")).max(1e4);
    let claimed = got["tolerance"].as_f64().map_or(1e-3, |tolerance| (tolerance * accumulation).min(1e-3));
    // A reference that is not certain itself tells nothing.
    if !exact["estimated_error"].as_f64().is_some_and(|error| error < 0.1 * claimed) {
        return;
    }
    let coordinates = exact["end_state"]
        .as_object()
        .expect(
            "a \
        state",
        )
        .iter()
        .filter(|(name, _)| !name.ends_with("_dot"));
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    // Errors are claimed in the unit of the coordinates, or relative to the largest of them.
    let largest = coordinates.clone().map(|(_, value)| number(value).abs()).fold(1.0, f64::max);
    for (name, value) in coordinates {
        let (value, got) = (number(value), number(&got["end_state"][name]));
        assert!(
            (got - value).abs() <= 3.0 * claimed * largest,
            "{name} is {got} instead of {value}: \
            {}",
            arguments.join(" ")
        );
    }
}

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    let mut random = fastrand::Rng::with_seed(u64::from(seed));
    if random.u8(..) < 60 {
        return fuzzer_mutate(data, size, max_size);
    }
    let text = line(&mut random);
    let length = text.len().min(max_size);
    data[..length].copy_from_slice(&text.as_bytes()[..length]);
    length
});

/// A command line that is likely to run, with parameters from 1e-12 to 1e12.
fn line(random: &mut fastrand::Rng) -> String {
    let pick = |random: &mut fastrand::Rng, from: &[&'static str]| from[random.usize(..from.len())];
    let power = |random: &mut fastrand::Rng, low: f64, high: f64| 10.0_f64.powf(low + (high - low) * random.f64());
    let command = match random.u8(..30) {
        0 => "stability",
        1 => "check",
        _ => "run",
    };
    let (scene, parameters) = SCENES[random.usize(..SCENES.len())];
    let parameters: Vec<&str> = parameters.split(' ').collect();
    let mut words = vec![command.to_owned(), scene.to_owned()];
    for _ in 0..random.usize(0..4) {
        let value = match random.u8(..4) {
            0 => 0.0,
            1 => power(random, -12.0, 12.0),
            2 => -power(random, -12.0, 12.0),
            _ => power(random, -2.0, 3.0),
        };
        words.extend(["--set".to_owned(), format!("{}={value:e}", parameters[random.usize(..parameters.len())])]);
    }
    let step = power(random, -3.5, 0.0);
    if random.bool() {
        words.extend(["--step".to_owned(), format!("{step:e}")]);
    }
    if random.bool() {
        words.extend(["--end-time".to_owned(), format!("{:e}", step * power(random, 0.0, 3.5))]);
    }
    if command == "run" {
        let method = pick(random, &METHODS);
        words.extend(["--no-figures".to_owned(), "--method".to_owned(), method.to_owned()]);
        if method != "rk4" {
            words.extend(["--tolerance".to_owned(), format!("{:e}", power(random, -12.0, -3.0))]);
        }
    }
    if command == "stability" {
        words.push("--no-extremes".to_owned());
    }
    words.join("\n")
}
