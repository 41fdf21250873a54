//! Pages of `qrm live` in a browser.

use std::time::{Duration, Instant};

use crate::common::chromium::Chromium;
use crate::common::live::Live;

/// Whether the page shows a motion.
const READY: &str = "document.querySelector('[data-ready]') !== null";

/// A block on a spring, with a mistake and with a spring without a place.
const BLOCK: &str = r#"
name = "block"
coordinates = [{ name = "x", unit = "m" }]
[parameters]
c = { value = 4, unit = "N/m" }
[points]
P = ['x', '0']
[bodies]
block = { mass = 1, com = "P" }
[loads]
spring = { force = ['-c*y', '0'], on = "block" }
[initial]
given = { x = 'sqrt(c - 5)', x_dot = 0 }
[run]
step = 1e-3
end_time = 1
"#;

/// A scene file with its page.
struct Desk {
    live: Live,
    browser: Chromium,
}

impl Desk {
    fn new(scene: &str) -> Self {
        let mut desk = Self::open(Live::of_scene(scene));
        desk.browser.wait_for(READY);
        desk
    }

    fn open(live: Live) -> Self {
        let mut browser = Chromium::new(1400, 900);
        browser.open(&live.address);
        Self { live, browser }
    }

    /// The text of a part of the page; empty if it is hidden.
    fn said(&mut self, part: &str) -> String {
        let said = self.browser.value(&format!(
            "(() => {{ const part = document.querySelector('.qrm-{part}'); return part.hidden ? '' : part.textContent; \
             }})()"
        ));
        said.as_str().expect("a text").to_owned()
    }

    /// The run that is shown.
    fn run(&mut self) -> String {
        let run = self.browser.value("document.querySelector('.qrm-animation').dataset.run");
        run.as_str().expect("a run").to_owned()
    }

    /// Waits until the page has settled on another run than that; gives it.
    fn next_run(&mut self, before: &str) -> String {
        self.browser.wait_for(&format!(
            "(() => {{ const root = document.querySelector('.qrm-animation'); return root.dataset.run !== \
             {before:?} && !root.hasAttribute('data-draft'); }})()"
        ));
        self.run()
    }

    /// Types a value of a parameter.
    fn set(&mut self, name: &str, value: f64) {
        self.browser.value(&format!(
            "(() => {{ const field = document.querySelector('[name={name}]'); field.value = {value}; \
             field.dispatchEvent(new Event('change')); }})()"
        ));
    }
}

#[test]
#[ignore = "full tier: browser"]
fn a_saved_scene_moves_anew_where_it_was() {
    let mut desk = Desk::new("quick-return");
    let first = desk.run();
    desk.browser.value("location.hash = '#t=0.5'");
    desk.browser.wait_for("document.querySelector('.qrm-animation').dataset.time === '0.5'");
    desk.set("J2", 90.0);
    let second = desk.next_run(&first);
    // A value, and a formula; the slider stays where it is.
    desk.live.edit("value = 0.6,", "value = 0.61,");
    let third = desk.next_run(&second);
    desk.live.edit("'C.y - yC'", "'C.y - yC + 0.001'");
    let fourth = desk.next_run(&third);
    assert_eq!(desk.browser.value("document.querySelector('.qrm-animation').dataset.time"), "0.5");
    assert_eq!(desk.said("command"), "qrm run mine.toml --set J2=90");
    // A mistake is shown beside the last motion.
    desk.live.edit("'C.y - yC + 0.001'", "'C.y - yD'");
    desk.browser.wait_for("!document.querySelector('.qrm-mistake').hidden");
    let mistake = desk.said("mistake");
    assert!(mistake.contains("mine.toml:") && mistake.contains("^^"), "{mistake}");
    assert_eq!(desk.run(), fourth);
    if let Some(folder) = std::env::var_os("QRM_SCREENSHOTS") {
        let picture = std::path::PathBuf::from(folder).join("live-mistake.png");
        std::fs::write(picture, desk.browser.screenshot()).expect("written");
    }
    desk.live.edit("'C.y - yD'", "'C.y - yC'");
    let fifth = desk.next_run(&fourth);
    assert_eq!((desk.said("mistake"), desk.said("problem"), desk.said("news")), Default::default());
    // The scene has a value of its own now.
    desk.live.edit("value = 100.0,", "value = 95.0,");
    desk.next_run(&fifth);
    assert_eq!(desk.said("command"), "qrm run mine.toml");
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn a_scene_that_is_wrong_at_first_is_shown_once_it_is_right() {
    let mut desk = Desk::open(Live::of_text(BLOCK));
    desk.browser.wait_for("document.querySelector('.qrm-mistake')?.hidden === false");
    assert!(desk.said("mistake").contains("unknown name `y`"));
    desk.live.edit("-c*y", "-c*x");
    // The root has no value.
    desk.browser.wait_for("!document.querySelector('.qrm-mistake').textContent.includes('unknown name')");
    let mistake = desk.said("mistake");
    assert!(mistake.contains("sqrt(c - 5)"), "{mistake}");
    desk.live.edit("sqrt(c - 5)", "sqrt(c - 3)");
    desk.browser.wait_for(READY);
    assert_eq!((desk.said("mistake"), desk.said("problem")), Default::default());
    // The block is dragged to the left.
    let at = desk.browser.middle("[data-name=P] rect");
    desk.browser.drag(at, [at[0] - 50.0, at[1] + 20.0]);
    desk.browser.wait_for("document.querySelector('.qrm-command').textContent.includes('--start x=')");
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn changed_values_are_written_to_the_file() {
    let mut desk = Desk::new("quick-return");
    let first = desk.run();
    desk.set("O2A", 0.25);
    desk.set("phi2", 0.5);
    let second = desk.next_run(&first);
    desk.browser.value("document.querySelector('.qrm-write').click()");
    desk.browser.wait_for("document.querySelector('.qrm-command').textContent === 'qrm run mine.toml'");
    desk.browser.wait_for("!document.querySelector('.qrm-animation').hasAttribute('data-draft')");
    let text = desk.live.text();
    assert!(text.contains("O2A  = { value = 0.25,   unit") && text.contains("phi2 = 0.5,"), "{text}");
    assert_eq!(desk.run(), second);
}

#[test]
#[ignore = "full tier: browser"]
fn a_value_that_changes_after_writing_stays() {
    let mut desk = Desk::new("quick-return");
    let first = desk.run();
    desk.set("O2A", 0.25);
    desk.next_run(&first);
    desk.browser.value(
        "(() => { document.querySelector('.qrm-write').click(); const field = document.querySelector('[name=O2A]'); \
         field.value = 0.26; field.dispatchEvent(new Event('change')); })()",
    );
    desk.browser.wait_for("document.querySelector('.qrm-news').textContent === 'written to mine.toml'");
    while !desk.live.text().contains("value = 0.25,") {}
    // The next save shows that the one before has arrived.
    let before = desk.run();
    desk.live.edit("'C.y - yC'", "'C.y - yC + 0.001'");
    desk.next_run(&before);
    assert_eq!(desk.said("command"), "qrm run mine.toml --set O2A=0.26");
}

#[test]
#[ignore = "full tier: browser"]
fn a_save_ends_a_drag() {
    let mut desk = Desk::new("quick-return");
    let first = desk.run();
    // The crank lies to the right of its pivot.
    desk.browser.value("location.hash = '#t=0'");
    desk.browser.wait_for("document.querySelector('.qrm-animation').dataset.time === '0'");
    let [x, y] = desk.browser.middle("[data-name=crank] .qrm-bar");
    desk.browser.mouse("mousePressed", [x, y]);
    desk.browser.mouse("mouseMoved", [x - 10.0, y - 40.0]);
    let held = desk.next_run(&first);
    assert!(desk.said("command").contains("--start phi2="));
    desk.live.edit("'C.y - yC'", "'C.y - yC + 0.001'");
    let second = desk.next_run(&held);
    for to in 1..5 {
        desk.browser.mouse("mouseMoved", [x - 10.0 + 5.0 * f64::from(to), y - 40.0]);
    }
    desk.browser.mouse("mouseReleased", [x, y]);
    assert_eq!((desk.run(), desk.said("problem")), (second, String::new()));
    // The next drag works.
    let [x, y] = desk.browser.middle("[data-name=crank] .qrm-bar");
    desk.browser.drag([x, y], [x + 20.0, y]);
    desk.browser.wait_for("!document.querySelector('.qrm-animation').hasAttribute('data-draft')");
    assert_eq!(desk.said("problem"), "");
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn a_saved_value_has_the_branch_of_its_own_file() {
    let mut desk = Desk::new("four-bar");
    let first = desk.run();
    // The other branch than that of the file before: a derivation is not needed, but a start is.
    desk.live.edit("l4  = { value = 0.34,", "l4  = { value = 0.068,");
    let shown: serde_json::Value = serde_json::from_str(&desk.next_run(&first)).expect("JSON");
    let out = desk.live.folder().join("out");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_qrm"));
    command.args(["run", "mine.toml", "--no-figures", "--out"]).arg(&out).current_dir(desk.live.folder());
    let output = command.env("QRM_CACHE", desk.live.folder().join("cache")).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary = std::fs::read_to_string(out.join("summary.json")).expect("a summary");
    let summary: serde_json::Value = serde_json::from_str(&summary).expect("JSON");
    for (i, name) in ["q1", "q2", "q3"].into_iter().enumerate() {
        let [own, expected] = [&shown["q"][i], &summary["end_state"][name]].map(|x| x.as_f64().expect("a number"));
        assert!((own - expected).abs() < 1e-11 * expected.abs().max(1.0), "{name}: {own} instead of {expected}");
    }
}

#[test]
#[ignore = "full tier: browser"]
fn no_save_is_lost_and_memory_stays() {
    // For longer than the test, with a save a second.
    let long: Option<f64> = std::env::var("QRM_SOAK").ok().and_then(|text| text.parse().ok());
    let (seconds, period) = long.map_or((5.0, 0.0), |seconds| (seconds, 1.0));
    let mut desk = Desk::new("quick-return");
    let mut run = desk.run();
    let begun = Instant::now();
    let (mut number, mut first) = (0, None);
    while begun.elapsed().as_secs_f64() < seconds {
        number += 1;
        let next = f64::from(number) * period;
        std::thread::sleep(Duration::try_from_secs_f64(next - begun.elapsed().as_secs_f64()).unwrap_or_default());
        let [before, after] = [number - 1, number].map(|number| format!("'C.y - yC + 0.0000{number:04}'"));
        desk.live.edit(if number == 1 { "'C.y - yC'" } else { &before }, &after);
        run = desk.next_run(&run);
        let status = std::fs::read_to_string(format!("/proc/{}/status", desk.live.id())).unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix(" kB"));
        let resident: f64 = resident.and_then(|kilobytes| kilobytes.parse().ok()).unwrap_or(0.0);
        let used = desk.browser.call("Runtime.getHeapUsage", serde_json::json!({}));
        let used = used["usedSize"].as_f64().unwrap_or(0.0) + used["backingStorageSize"].as_f64().unwrap_or(0.0);
        // The first ones fill caches.
        let (own, page) = *first.get_or_insert((resident, used));
        if number == 5 {
            first = Some((resident, used));
        } else if number > 5 && number % 100 == 0 {
            println!(
                "{number} saves: command {resident} kB, of {own}; page {:.0} kB, of {:.0}",
                used / 1e3,
                page / 1e3
            );
            assert!(resident < own + 30_000.0 && used < page + 60e6);
        }
    }
    assert!(number > 3, "{number}");
}
