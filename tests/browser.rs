//! The pages that the command writes, opened in a browser.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;

use crate::common::{Table, near, qrm};

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
#[ignore = "full tier: browser"]
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
#[ignore = "full tier: browser"]
fn the_report_opens_without_complaint() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let written = qrm(&["report", "--out"]).arg(folder.path()).output().expect("the command starts");
    assert!(written.status.success());
    let document = opened(folder.path(), "report.html");
    assert!(document.contains("data-name=\"crank\""), "the animation is drawn");
    assert!(document.contains("<math"), "formulae are there");
}
