//! Mechanisms that are drawn in the pages of `qrm live`.

use std::time::{Duration, Instant};

use crate::common::chromium::Chromium;
use crate::common::live::Live;

/// A plane without links.
const BLANK: &str = include_str!("../crates/cli/src/commands/new/blank.toml");
/// A driven four-bar with comments, units and a parameter.
const FOUR_BAR: &str = include_str!("../crates/cli/src/commands/new/four-bar.toml");

/// A scene file with its page, and the clicks that were made.
struct Desk {
    live: Live,
    browser: Chromium,
    clicks: usize,
}

impl Desk {
    fn new(scene: &str) -> Self {
        let live = Live::of_text(scene);
        let mut browser = Chromium::new(1400, 900);
        browser.open(&live.address);
        browser.wait_for("document.querySelector('[data-tool]') !== null");
        Self { live, browser, clicks: 0 }
    }

    fn click(&mut self, at: [f64; 2]) {
        self.clicks += 1;
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            self.browser.mouse(kind, at);
        }
    }

    /// Chooses a tool.
    fn tool(&mut self, name: &str) {
        let at = self.browser.middle(&format!(".qrm-tool-{name}"));
        self.click(at);
        assert_eq!(self.browser.value("document.querySelector('.qrm-animation').dataset.tool"), name);
    }

    /// The line below the tools, if it says why something was refused.
    fn refusal(&mut self) -> String {
        let line = "document.querySelector('.qrm-hint-line[data-refused]')?.textContent ?? ''";
        self.browser.value(line).as_str().unwrap_or_default().to_owned()
    }

    /// Waits until the file contains a text.
    fn wait_for_text(&mut self, text: &str) -> String {
        let begun = Instant::now();
        loop {
            let file = self.live.text();
            if file.contains(text) {
                return file;
            }
            assert!(begun.elapsed() < Duration::from_secs(30), "{text}\n{}\n{file}", self.refusal());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Waits until the lengths of links are parameters.
    fn wait_for_lengths(&mut self) {
        self.browser.wait_for(
            "'qrm_links_rocker_length' in JSON.parse(document.querySelector('.qrm-animation').dataset.run).values",
        );
        self.browser.wait_for(SETTLED);
    }
}

#[test]
#[ignore = "full tier: browser"]
fn a_four_bar_with_a_force_takes_ten_clicks() {
    let mut desk = Desk::new(BLANK);
    let [x, y] = desk.browser.middle(".qrm-canvas");
    let [crank, coupler, rocker] = [[x - 140.0, y + 20.0], [x + 30.0, y - 140.0], [x + 100.0, y + 60.0]];
    // The first bar begins at an empty place, the others at the end of the one before.
    for place in [[x - 180.0, y + 60.0], crank, coupler, rocker] {
        desk.click(place);
    }
    desk.wait_for_text("bar3");
    desk.tool("pin");
    desk.click(rocker);
    desk.tool("drive");
    desk.click([x - 180.0, y + 60.0]);
    desk.wait_for_text("60rpm*t");
    desk.tool("force");
    desk.click(coupler);
    let text = desk.wait_for_text("F_C = { joint = \"C\" }");
    assert_eq!(desk.clicks, 10);
    assert!(text.contains("# rigid bodies; `ground` does not move") && text.contains("60rpm*t"), "{text}");
    assert_eq!(desk.refusal(), "");
    desk.browser.wait_for("document.querySelector('.qrm-arrow[data-name=F_C]') !== null");
    if let Some(folder) = std::env::var_os("QRM_SCREENSHOTS") {
        let picture = std::path::PathBuf::from(folder).join("drawn-four-bar.png");
        std::fs::write(picture, desk.browser.screenshot()).expect("written");
    }
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}

/// The pin of the coupler and the rocker.
const JOINT_C: &str = "[data-name=coupler] circle:nth-of-type(2)";
/// Whether the page has settled on a motion.
const SETTLED: &str = "!document.querySelector('.qrm-animation').hasAttribute('data-draft')";

/// Notes the milliseconds from each movement of the mouse to the motion that follows from it.
const LATENCIES: &str = "window.latencies = []; let moved = 0; \
                         document.addEventListener('pointermove', () => { moved = performance.now(); }, true); \
                         new MutationObserver(() => window.latencies.push(performance.now() - moved)) \
                         .observe(document.querySelector('.qrm-animation'), { attributeFilter: ['data-run'] });";

#[test]
#[ignore = "full tier: browser"]
fn a_joint_is_dragged_and_the_file_follows() {
    let mut desk = Desk::new(FOUR_BAR);
    desk.browser.wait_for("document.querySelector('[data-ready]') !== null");
    desk.tool("move");
    let joint = desk.browser.middle(JOINT_C);
    desk.wait_for_lengths();
    desk.browser.value(LATENCIES);
    desk.browser.mouse("mouseMoved", joint);
    desk.browser.mouse("mousePressed", joint);
    for step in 1..=20 {
        desk.browser.mouse("mouseMoved", [joint[0] + f64::from(step), joint[1] - 2.0 * f64::from(step)]);
        std::thread::sleep(Duration::from_millis(100));
    }
    let end = [joint[0] + 20.0, joint[1] - 40.0];
    desk.browser.mouse("mouseReleased", end);
    desk.browser.wait_for(SETTLED);
    // The joint is where it was let go.
    let now = desk.browser.middle(JOINT_C);
    assert!((now[0] - end[0]).hypot(now[1] - end[1]) < 3.0, "{now:?} {end:?}");
    let latencies = desk.browser.value("JSON.stringify(window.latencies)");
    println!("milliseconds from the mouse to the motion: {latencies}");
    // Three lengths and a place have changed, and nothing else.
    let text = desk.live.text();
    let differing: Vec<&str> = text.lines().zip(FOUR_BAR.lines()).filter(|(a, b)| a != b).map(|(a, _)| a).collect();
    let names: Vec<&str> = differing.iter().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names, ["coupler", "rocker", "C"], "{text}");
    assert_eq!(text.lines().count(), FOUR_BAR.lines().count());
    // All of it is one change.
    desk.browser.value("document.querySelector('.qrm-undo').click()");
    desk.wait_for_text("sides = [0.35, 0.20, 0.22]");
    assert_eq!(desk.live.text(), FOUR_BAR);
    desk.browser.value("document.querySelector('.qrm-redo').click()");
    desk.wait_for_text(differing[0]);
    assert_eq!((desk.live.text(), desk.refusal()), (text, String::new()));
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}

/// A four-bar that nothing drives, from where it was drawn.
const FREE: &str = r#"name = "free"
run = { step = 1e-3, end_time = 1 }
[links]
ground = { points = { A = [0, 0], D = [0.2, 0] } }
bar1 = { bar = ["A", "B"], length = 0.05831, mass = 1, angle = '59.036 deg' }
bar2 = { bar = ["B", "C"], length = 0.1077, mass = 1, angle = '21.801 deg' }
bar3 = { bar = ["C", "D"], length = 0.11402, mass = 1, angle = '-52.125 deg' }
[joints]
A = { revolute = ["bar1", "ground"] }
B = { revolute = ["bar1", "bar2"] }
C = { revolute = ["bar2", "bar3"] }
D = { revolute = ["bar3", "ground"] }
[loads]
weight = { gravity = [0, -9.81] }
"#;

#[test]
#[ignore = "full tier: browser"]
fn other_joints_stay_while_one_is_dragged() {
    let mut desk = Desk::new(FREE);
    desk.browser.wait_for("document.querySelector('[data-ready]') !== null");
    desk.tool("move");
    desk.browser
        .wait_for("'qrm_links_bar1_angle' in JSON.parse(document.querySelector('.qrm-animation').dataset.run).values");
    desk.browser.wait_for(SETTLED);
    let pin = |bar: &str, place: usize| format!("[data-name={bar}] circle:nth-of-type({place})");
    let [b, c] = [pin("bar1", 2), pin("bar2", 2)].map(|pin| desk.browser.middle(&pin));
    let to = [b[0] - 40.0, b[1] - 30.0];
    let drag = |desk: &mut Desk| {
        desk.browser.mouse("mouseMoved", b);
        desk.browser.mouse("mousePressed", b);
        for part in 1..=10 {
            let part = f64::from(part) / 10.0;
            desk.browser.mouse("mouseMoved", [b[0] + part * (to[0] - b[0]), b[1] + part * (to[1] - b[1])]);
            std::thread::sleep(Duration::from_millis(30));
        }
    };
    drag(&mut desk);
    desk.browser.mouse("mouseReleased", to);
    std::thread::sleep(Duration::from_millis(300));
    desk.browser.wait_for(SETTLED);
    for (pin, expected) in [(pin("bar1", 2), to), (pin("bar2", 1), to), (pin("bar2", 2), c), (pin("bar3", 1), c)] {
        let now = desk.browser.middle(&pin);
        assert!((now[0] - expected[0]).hypot(now[1] - expected[1]) < 3.0, "{pin} {now:?} {expected:?}");
    }
    desk.browser.value("document.querySelector('.qrm-undo').click()");
    desk.wait_for_text("length = 0.05831");
    assert_eq!(desk.live.text(), FREE);
    std::thread::sleep(Duration::from_millis(300));
    desk.browser.wait_for(SETTLED);
    // Escape leaves the file as it was.
    drag(&mut desk);
    desk.browser.value("document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape', bubbles: true }))");
    desk.browser.mouse("mouseReleased", to);
    desk.wait_for_text("length = 0.05831");
    std::thread::sleep(Duration::from_millis(300));
    desk.browser.wait_for(SETTLED);
    let now = desk.browser.middle(&pin("bar1", 2));
    assert!((now[0] - b[0]).hypot(now[1] - b[1]) < 3.0, "{now:?} {b:?}");
    assert_eq!((desk.live.text(), desk.refusal()), (FREE.to_owned(), String::new()));
    assert!(desk.browser.complaints.is_empty(), "{:?}", desk.browser.complaints);
}
