//! Pages in a browser: from opening to the first picture, and motions a second while a slider moves.
//!
//! `cargo bench --bench page`; needs Chromium, on the path or named by `CHROMIUM`.

#[path = "../tests/common/chromium.rs"]
#[allow(dead_code, reason = "tests use the rest")]
mod chromium;
#[allow(dead_code, reason = "other benches count instructions")]
mod measure;

use std::process::Command;

use chromium::Chromium;
use measure::Spread;

const SCENES: [&str; 2] = ["quick-return", "andrews"];

/// Pictures while a slider moves from one end to the other.
const PICTURES: u32 = 60;

/// Milliseconds until the first picture, by the clock of the page.
const FIRST: &str = "new Promise((done) => { const wait = () => document.querySelector('[data-ready]') ? \
                     requestAnimationFrame(() => done(performance.now())) : setTimeout(wait, 1); wait(); })";

fn main() {
    println!("{:16} {:>28} {:>28}", "", "first picture, ms", "a motion with its picture, ms");
    for scene in SCENES {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("page.html");
        let written = Command::new(env!("CARGO_BIN_EXE_qrm")).args(["page", scene, "--out"]).arg(&file).output();
        assert!(written.is_ok_and(|output| output.status.success()), "no page of {scene}");
        let mut browser = Chromium::new(1400, 900);
        let times = measure::in_turn(1, |_| {
            browser.open(&format!("file://{}", file.display()));
            browser.value(FIRST).as_f64().unwrap_or(f64::NAN)
        });
        let moved = measure::in_turn(1, |_| {
            let moving = format!(
                "new Promise((done) => {{ const slider = document.querySelector('.qrm-parameter input[type=range]'); \
                 const [low, high] = [0.9 * slider.value, 1.1 * slider.value]; let part = 0; \
                 const begun = performance.now(); const next = () => {{ \
                 if (part++ === {PICTURES}) return done((performance.now() - begun) / {PICTURES}); \
                 slider.value = low + (high - low) * part / {PICTURES}; slider.dispatchEvent(new Event('input')); \
                 slider.value = (low + high) / 2; requestAnimationFrame(() => setTimeout(next)); }}; next(); }})"
            );
            browser.value(&moving).as_f64().unwrap_or(f64::NAN)
        });
        println!("{scene:16} {:>28} {:>28}", show(&times), show(&moved));
    }
}

fn show(times: &[Spread]) -> String {
    times.first().map_or_else(String::new, |times| times.show(1))
}
