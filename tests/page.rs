//! Pages of `qrm page` in a browser, against the command.

use serde_json::Value;

use crate::common;
use crate::common::chromium::Chromium;
use crate::common::{near, qrm};

/// `qrm page SCENE` in a browser, once its first motion is there.
fn opened(scene: &str, address: &str, browser: &mut Chromium) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("page.html");
    let written = qrm(&["page", scene, "--out"]).arg(&file).output().expect("the command starts");
    assert!(written.status.success(), "{}", String::from_utf8_lossy(&written.stderr));
    let bytes = std::fs::metadata(&file).expect("the page").len();
    assert!(bytes <= 300_000, "{scene}: {bytes} bytes");
    browser.open(&format!("file://{}{address}", file.display()));
    browser.wait_for("document.querySelector('[data-ready]') !== null");
    folder
}

/// The run that the page shows.
fn shown(browser: &mut Chromium) -> Value {
    let run = browser.value("document.querySelector('.qrm-animation').dataset.run");
    let problem = browser.value("document.querySelector('.qrm-problem').textContent");
    serde_json::from_str(run.as_str().unwrap_or_else(|| panic!("{problem}, {:?}", browser.complaints))).expect("JSON")
}

/// Compares the run that a page shows with one of the command.
#[track_caller]
fn same(browser: &mut Chromium, arguments: &[&str]) {
    let summary = common::run(&[arguments, &["--no-figures"]].concat()).summary();
    let shown = shown(browser);
    let end = summary["end_state"].as_object().expect("a table");
    for (i, coordinate) in common::model(arguments[0]).description.coordinates.iter().enumerate() {
        for (name, own) in
            [(coordinate.name.to_owned(), &shown["q"]), (format!("{}_dot", coordinate.name), &shown["qd"])]
        {
            let (value, own) = (end[&name].as_f64().expect("a number"), own[i].as_f64().expect("a number"));
            near(&name, own, value, 1e-12 * value.abs().max(1.0));
        }
    }
    assert_eq!(shown["steps"], summary["steps"]);
    let [estimated, own] = [&summary, &shown].map(|run| run["estimated_error"].as_f64().expect("an estimate"));
    // Rounding errors differ without fused products.
    near("estimated error", own, estimated, 1e-3 * estimated + 1e-13);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn a_page_computes_what_the_command_computes() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("andrews", "", &mut browser);
    same(&mut browser, &["andrews"]);
    let _folder = opened("quick-return", "#J2=90", &mut browser);
    same(&mut browser, &["quick-return", "--set", "J2=90"]);
    browser.value("document.querySelector('.qrm-reset').click()");
    same(&mut browser, &["quick-return"]);
    // The first slider is dragged by the mouse.
    let from = browser.middle(".qrm-parameter input[type=range]");
    browser.drag(from, [from[0] + 15.0, from[1]]);
    browser.wait_for("!document.querySelector('.qrm-animation').hasAttribute('data-draft')");
    let value = browser.value("document.querySelector('.qrm-parameter input[type=number]').value");
    let value = value.as_str().expect("a number");
    assert_ne!(value, "0.2");
    same(&mut browser, &["quick-return", "--set", "J2=100", "--set", &format!("O2A={value}")]);
    let said = browser.value("document.querySelector('.qrm-command').textContent");
    assert_eq!(said, format!("qrm run quick-return --set O2A={value}"));
}

/// Between the frames of a long motion nothing is interpolated: numbers are those of the command, and a rod keeps its
/// length.
#[test]
#[ignore = "full tier: browser"]
fn what_is_shown_at_a_time_is_what_the_command_computes() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("pendulum", "#t=37", &mut browser);
    let run = common::run(&["pendulum", "--no-figures"]);
    let text = std::fs::read_to_string(run.path("trajectory.csv")).expect("the trajectory");
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    let at = |t: f64, name: &str| -> f64 {
        let column = rows[0].iter().position(|own| *own == name).expect("a column");
        let time = |row: &&Vec<&str>| (row[0].parse::<f64>().expect("a time") - t).abs() < 1e-9;
        rows[1..].iter().find(time).expect("a row")[column].parse().expect("a number")
    };
    let shown = |browser: &mut Chromium, name: &str| -> (f64, f64) {
        let text = browser.value(&format!(
            "[...document.querySelectorAll('.qrm-key')].find((key) => key.children[1].textContent === \
             '{name}')             .querySelector('output').textContent"
        ));
        let text = text.as_str().expect("a text").replace('\u{2212}', "-");
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        (text.parse().expect("a number"), 0.51 * 10.0_f64.powi(-(decimals as i32)))
    };
    let length = |browser: &mut Chromium| -> f64 {
        let script = "(() => { const [a, b] = [...document.querySelectorAll('.qrm-link .qrm-pin')].map((pin) \
                      =>                       { const { e, f } = pin.getCTM(); return [e, f]; }); return \
                      Math.hypot(a[0] - b[0], a[1] - b[1]); })()";
        browser.value(script).as_f64().expect("a length")
    };
    let first = length(&mut browser);
    for t in [37.0, 37.25, 99.999] {
        browser.value(&format!("location.hash = 't={t}'"));
        browser.wait_for(&format!("document.querySelector('.qrm-animation').dataset.time === '{t}'"));
        for name in ["x_dot", "y_dot", "S"] {
            let (value, half_digit) = shown(&mut browser, name);
            near(name, value, at(t, name), half_digit);
        }
        let now = length(&mut browser);
        assert!((now - first).abs() < 1e-3 * first, "{t}: {now} px instead of {first} px");
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// The middle of a body on the screen.
fn body(browser: &mut Chromium, name: &str) -> [f64; 2] {
    browser.middle(&format!("[data-name={name}] .qrm-bar"))
}

#[test]
#[ignore = "full tier: browser"]
fn a_motion_starts_where_a_body_was_let_go() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("quick-return", "#t=0", &mut browser);
    // The crank lies to the right of its pivot, and is turned upward.
    let at = body(&mut browser, "crank");
    browser.drag(at, [at[0] - 20.0, at[1] - 60.0]);
    let is_settled = "!document.querySelector('.qrm-animation').matches('[data-draft], [data-dragged]')";
    browser.wait_for(is_settled);
    let said = browser.value("document.querySelector('.qrm-command').textContent");
    let value =
        said.as_str().and_then(|said| said.strip_prefix("qrm run quick-return --start phi2=")).map(str::to_owned);
    let value = value.unwrap_or_else(|| panic!("{said}"));
    let angle: f64 = value.parse().expect("a number");
    assert!((0.5..1.6).contains(&angle), "{angle}");
    same(&mut browser, &["quick-return", "--start", &format!("phi2={value}")]);
    // The ram turns the crank as well; where it cannot come it comes as near as it can.
    browser.value("document.querySelector('.qrm-reset').click()");
    let at = browser.middle("[data-name=ram] rect");
    browser.drag(at, [at[0] + 400.0, at[1] + 100.0]);
    browser.wait_for(is_settled);
    let said = browser.value("document.querySelector('.qrm-command').textContent");
    let value = said.as_str().expect("a text").rsplit('=').next().expect("a value").to_owned();
    same(&mut browser, &["quick-return", "--start", &format!("phi2={value}")]);
    assert_eq!(browser.value("document.querySelector('.qrm-problem').hidden"), true);
    // What a drive moves is shown at the time at which it is nearest.
    let _folder = opened("quick-return-driven", "#t=0", &mut browser);
    let at = body(&mut browser, "crank");
    browser.drag(at, [at[0] - 20.0, at[1] - 60.0]);
    let time = browser.value("Number(document.querySelector('.qrm-animation').dataset.time)");
    assert!(time.as_f64().is_some_and(|time| time > 0.01), "{time}");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn values_that_follow_are_shown() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("double-pendulum", "#a0=1", &mut browser);
    let shown = "document.querySelector('[name=a]').value + ' ' + document.querySelector('[name=b]').value";
    assert_eq!(browser.value(shown), "1 1");
    same(&mut browser, &["double-pendulum", "--set", "a0=1"]);
    // An arrow key moves the slider that has the focus, not the time.
    browser.value("document.querySelector('.qrm-parameter input[type=range]').focus()");
    for kind in ["keyDown", "keyUp"] {
        let key = serde_json::json!({ "type": kind, "key": "ArrowRight", "windowsVirtualKeyCode": 39 });
        browser.call("Input.dispatchKeyEvent", key);
    }
    browser.wait_for("document.querySelector('.qrm-command').textContent.includes('--set l=1.')");
    browser.value(
        "(() => { const field = document.querySelector('[name=l]'); field.value = 1; field.dispatchEvent(new \
                   Event('change')); })()",
    );
    let type_b = "(() => { const field = document.querySelector('[name=b]'); field.value = 1.5; \
                  field.dispatchEvent(new Event('change')); })()";
    browser.value(type_b);
    browser.wait_for("!document.querySelector('.qrm-animation').hasAttribute('data-draft')");
    same(&mut browser, &["double-pendulum", "--set", "a0=1", "--start", "b=1.5"]);
    assert_eq!(browser.value(shown), "1 1.5");
}

#[test]
#[ignore = "full tier: browser"]
fn pictures_are_saved_as_svg() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("quick-return", "#t=0.4", &mut browser);
    browser.value("URL.createObjectURL = (blob) => { window.saved = blob.text(); return '#t=0.4'; }; 0");
    for (name, shown) in [("drawing", ["quick-return", "cutting"]), ("curves", ["angular speeds", "reaction forces"])] {
        browser.value(&format!("document.querySelector('.qrm-save-{name}').click()"));
        let text = browser.value("window.saved").as_str().expect("a file").to_owned();
        let document = roxmltree::Document::parse(&text).expect("XML");
        let words: String = document.descendants().filter_map(|node| node.text()).collect();
        assert!(shown.iter().all(|word| words.contains(word)), "{words}");
        assert!(document.descendants().all(|node| node.attribute("class").is_none()));
        if let Some(folder) = std::env::var_os("QRM_SCREENSHOTS").map(std::path::PathBuf::from) {
            std::fs::write(folder.join(format!("{name}.svg")), text).expect("written");
        }
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
#[ignore = "full tier: browser"]
fn the_last_motion_stays_where_there_is_none() {
    let mut browser = Chromium::new(1400, 900);
    let _folder = opened("quick-return", "", &mut browser);
    let before = shown(&mut browser);
    // A rod so short that the loops cannot be closed.
    browser.value(
        "(() => { const number = document.querySelectorAll('.qrm-parameter input[type=number]')[2]; number.value = \
         0.1; number.dispatchEvent(new Event('change')); })()",
    );
    browser.wait_for("!document.querySelector('.qrm-problem').hidden");
    let said = browser.value("document.querySelector('.qrm-problem').textContent");
    assert!(said.as_str().expect("a text").contains("cannot be assembled"), "{said}");
    assert_eq!(shown(&mut browser), before);
    // The command refuses this one too.
    browser.value("location.hash = 'm6=-1'");
    browser.wait_for("document.querySelector('.qrm-problem').textContent.includes('negative mass: -1')");
    assert_eq!(shown(&mut browser), before);
    browser.value("location.hash = 'J2=90'");
    browser.wait_for("document.querySelector('.qrm-command').textContent.includes('--set J2=90')");
    browser.wait_for("document.querySelector('.qrm-problem').hidden");
    assert_ne!(shown(&mut browser), before);
}

#[test]
#[ignore = "full tier: browser"]
fn pages_look_the_same_on_every_screen() {
    let folder = std::env::var_os("QRM_SCREENSHOTS").map(std::path::PathBuf::from);
    for (width, height) in [(1400, 900), (390, 844)] {
        for scheme in ["light", "dark"] {
            let mut browser = Chromium::new(width, height);
            browser.prefer(scheme);
            let _page = opened("quick-return", "#t=0.4", &mut browser);
            let is_wide = browser.value("document.documentElement.scrollWidth > innerWidth");
            assert_eq!(is_wide, false, "nothing lies beside a screen of {width} pixels");
            if let Some(folder) = &folder {
                std::fs::write(folder.join(format!("{width}-{scheme}.png")), browser.screenshot()).expect("written");
            }
        }
    }
}
