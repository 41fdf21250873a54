//! `qrm live` in a browser: from saving a scene to the picture of its motion, by the clock of the machine.
//!
//! `cargo bench --bench live`; needs Chromium, on the path or named by `CHROMIUM`.

#[path = "../tests/common/chromium.rs"]
#[allow(dead_code, reason = "tests use the rest")]
mod chromium;
#[path = "../tests/common/live.rs"]
#[allow(dead_code, reason = "tests use the rest")]
mod live;
#[allow(dead_code, reason = "other benches count instructions")]
mod measure;

use std::time::{SystemTime, UNIX_EPOCH};

use chromium::Chromium;
use live::Live;
use measure::Spread;

/// A parameter and a formula of each scene.
const SCENES: [(&str, &str, &str); 2] =
    [("quick-return", "BC   = { value = 0.6", "'C.y - yC"), ("andrews", "u  = { value = 0.04", "- ss*sin(gamma) - xb")];

/// Promises the time at which the next motion is on the screen, in milliseconds since 1970.
const PROMISE: &str = "{ const root = document.querySelector('.qrm-animation'); const before = root.dataset.run; \
                       window.arrival = new Promise((done) => { const seen = new MutationObserver(() => { \
                       if (root.dataset.run === before) return; seen.disconnect(); requestAnimationFrame(() => \
                       setTimeout(() => done(performance.timeOrigin + performance.now()))); }); \
                       seen.observe(root, { attributes: true }); }); 0 }";

fn main() {
    println!("{:16} {:>28} {:>28}", "from save to motion, ms", "a value", "a formula");
    for (scene, value, formula) in SCENES {
        let live = Live::of_scene(scene);
        let text = live.text();
        let mut browser = Chromium::new(1400, 900);
        browser.open(&live.address);
        browser.wait_for("document.querySelector('[data-ready]') !== null");
        browser.value("document.querySelector('.qrm-play').click()");
        let mut number = 0;
        let mut edited = |place: &str| {
            number += 1;
            let digit = format!("{:04}", 1 + number);
            let changed = if place == formula { format!("{place} + 0.000{digit}") } else { format!("{place}0{digit}") };
            text.replacen(place, &changed, 1)
        };
        let values = measure::in_turn(1, |_| saved(&live, &edited(value), &mut browser));
        let formulae = measure::in_turn(1, |_| saved(&live, &edited(formula), &mut browser));
        println!("{scene:23} {:>28} {:>28}", show(&values), show(&formulae));
    }
}

/// Milliseconds from saving a text to its motion.
fn saved(live: &Live, text: &str, browser: &mut Chromium) -> f64 {
    // The one before is to be settled.
    std::thread::sleep(std::time::Duration::from_millis(500));
    browser.value(PROMISE);
    let begun = SystemTime::now().duration_since(UNIX_EPOCH).expect("a clock").as_secs_f64() * 1e3;
    live.save(text);
    browser.value("window.arrival").as_f64().unwrap_or(f64::NAN) - begun
}

fn show(times: &[Spread]) -> String {
    times.first().map_or_else(String::new, |times| times.show(1))
}
