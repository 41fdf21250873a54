//! The pages that the command writes, opened in a browser.

mod common;

use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;

use common::{Table, near, qrm};

/// Opens a page in Chromium, which must have nothing to complain of, and returns the document as it is then.
fn opened(folder: &Path, address: &str) -> String {
    let chromium = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
    let output = Command::new(&chromium)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,900"])
        .args(["--virtual-time-budget=3000", "--dump-dom", "--enable-logging=stderr"])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}/{address}", folder.display()))
        .output()
        .unwrap_or_else(|error| panic!("`{chromium}` cannot be run ({error}): set CHROMIUM"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let complaints: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The text between two others.
#[track_caller]
fn between<'t>(text: &'t str, before: &str, after: &str) -> &'t str {
    let rest = text.split_once(before).unwrap_or_else(|| panic!("`{before}` is missing")).1;
    rest.split_once(after).unwrap_or_else(|| panic!("`{after}` is missing")).0
}

/// The direction of a drawn bar, counter-clockwise.
fn direction(document: &str, bar: &str) -> f64 {
    let bar = document.split_once(&format!("data-name=\"{bar}\"")).expect("the bar is drawn").1;
    let bar = bar.split_once("class=\"qrm-bar\"").expect("a line").1;
    let points = between(bar, "points=\"", "\"");
    let numbers: Vec<f64> = points.split([' ', ',']).map(|number| number.parse().expect("a number")).collect();
    // Downward on the screen is negative in the mechanism.
    (numbers[1] - numbers[3]).atan2(numbers[2] - numbers[0])
}

#[test]
#[ignore = "needs Chromium"]
fn the_animation_shows_the_exact_position() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let written = qrm(&["animate", "--no-gif", "--out"]).arg(folder.path()).output().expect("the command starts");
    assert!(written.status.success());
    let exact = Table::reference("quick-return-states.csv");
    for t in [0.1, 0.5, 1.0] {
        let row = (0..exact.rows.len()).find(|&row| (exact.number(row, "t") - t).abs() < 1e-12).expect("a state");
        let document = opened(folder.path(), &format!("animation.html#t={t}"));
        near("time shown", between(&document, "data-time=\"", "\"").parse().expect("a number"), t, 1e-9);
        for (bar, angle) in [("crank", "phi2"), ("rocker", "phi4")] {
            let off = direction(&document, bar) - exact.number(row, angle);
            // The hundredth of a pixel that coordinates are rounded to.
            near(&format!("{bar} at t = {t}"), off - TAU * (off / TAU).round(), 0.0, 1e-3);
        }
    }
}

#[test]
#[ignore = "needs Chromium"]
fn the_report_opens_without_complaint() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let written = qrm(&["report", "--out"]).arg(folder.path()).output().expect("the command starts");
    assert!(written.status.success());
    let document = opened(folder.path(), "report.html");
    assert!(document.contains("data-name=\"crank\""), "the animation is drawn");
    assert!(document.contains("<math"), "formulae are there");
}

/// `qrm page SCENE`, opened with a script that acts on it once it is ready; the run that the page shows then.
fn page_run(scene: &str, address: &str, script: &str) -> serde_json::Value {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("page.html");
    let written = qrm(&["page", scene, "--out"]).arg(&file).output().expect("the command starts");
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let page = std::fs::read_to_string(&file).expect("the page");
    assert!(page.len() <= 300_000, "{scene}: {} bytes", page.len());
    assert!(!page.contains("http://") || page.matches("http://").count() == page.matches("http://www.w3.org/").count());
    let acting = format!(
        "<script>const wait = setInterval(() => {{ if (!document.querySelector('[data-ready]')) return; \
         clearInterval(wait); {script} }}, 5);</script></body>"
    );
    std::fs::write(&file, page.replace("</body>", &acting)).expect("written");
    let document = opened(folder.path(), &format!("page.html{address}"));
    let run = between(&document, "data-run=\"", "\"").replace("&quot;", "\"");
    serde_json::from_str(&run).expect("JSON")
}

/// The end state and the estimated error of `qrm run SCENE`, as a page tells them.
fn command_run(arguments: &[&str]) -> (Vec<f64>, f64) {
    let run = common::run(arguments);
    let summary = run.summary();
    let end = summary["end_state"].as_object().expect("a table");
    let state = end.iter().filter(|(name, _)| !name.starts_with("lambda")).map(|(_, value)| value.as_f64());
    let state = state.map(|value| value.expect("a number")).collect();
    (state, summary["estimated_error"].as_f64().expect("an estimate"))
}

#[test]
#[ignore = "needs Chromium"]
fn a_page_computes_what_the_command_computes() {
    let moved = "const slider = document.querySelector('.qrm-parameter input[type=range]'); slider.value = 0.25; \
                 slider.dispatchEvent(new Event('input'));";
    let cases: [(&str, &str, &str, &[&str]); 4] = [
        ("quick-return", "", "", &["quick-return"]),
        ("quick-return", "#J2=90", "", &["quick-return", "--set", "J2=90"]),
        ("quick-return", "", moved, &["quick-return", "--set", "O2A=0.25"]),
        ("andrews", "", "", &["andrews"]),
    ];
    for (scene, address, script, arguments) in cases {
        let shown = page_run(scene, address, script);
        let (state, error) = command_run(&[arguments, &["--no-figures"]].concat());
        let numbers = |key: &str| -> Vec<f64> {
            shown[key].as_array().expect("a list").iter().map(|value| value.as_f64().expect("a number")).collect()
        };
        let shown_state = [numbers("q"), numbers("qd")].concat();
        for value in &shown_state {
            let nearest = state.iter().map(|own| (own - value).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 1e-12 * value.abs().max(1.0), "{scene}{address}: {value} is {nearest:e} off");
        }
        near("estimated error", shown["estimated_error"].as_f64().expect("an estimate"), error, 1e-2 * error + 1e-14);
    }
}

#[test]
#[ignore = "needs Chromium"]
fn a_page_keeps_the_last_motion_where_there_is_none() {
    // A rod so short that the loops cannot be closed.
    const TOO_SHORT: &str = "const number = document.querySelectorAll('.qrm-parameter input[type=number]')[2]; \
                             number.value = 0.1; number.dispatchEvent(new Event('change'));";
    let shown = page_run("quick-return", "", TOO_SHORT);
    assert_eq!(shown["steps"], 1756);
}
