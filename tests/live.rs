//! `qrm live` in a browser.

#![cfg(feature = "generate")]

#[path = "common/chromium.rs"]
mod chromium;
#[path = "common/live.rs"]
mod live;

use std::fs;
use std::path::PathBuf;

use chromium::Chromium;
use live::Live;
use tempfile::TempDir;

/// A scene of its own, served and opened.
struct Desk {
    folder: TempDir,
    live: Live,
    browser: Chromium,
}

impl Desk {
    fn new(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let text = fs::read_to_string(format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR"))).expect("a scene");
        fs::write(folder.path().join("mine.toml"), text.replacen(&format!("\"{scene}\""), "\"mine\"", 1)).expect("written");
        let live = Live::new(folder.path(), "mine.toml");
        let mut browser = Chromium::new(1400, 900);
        browser.open(&live.address);
        browser.wait_for("document.querySelector('[data-ready]') !== null");
        Self { folder, live, browser }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("mine.toml")
    }

    /// Replaces a part of the scene file.
    fn edit(&self, from: &str, to: &str) {
        let text = fs::read_to_string(self.file()).expect("the scene");
        assert!(text.contains(from), "`{from}` is not in the scene");
        fs::write(self.file(), text.replacen(from, to, 1)).expect("written");
    }

    /// What a part of the page says; empty if it is hidden.
    fn said(&mut self, part: &str) -> String {
        let text = format!("(() => {{ const part = document.querySelector('.qrm-{part}'); return part.hidden ? '' : part.textContent; }})()");
        self.browser.value(&text).as_str().expect("a text").to_owned()
    }

    /// Waits until the settled run of the page is another one than that; gives it.
    fn next_run(&mut self, before: &str) -> String {
        let is_next = format!(
            "(() => {{ const root = document.querySelector('.qrm-animation'); return root.dataset.run !== \
             {before:?} && !root.hasAttribute('data-draft'); }})()"
        );
        self.browser.wait_for(&is_next);
        self.run()
    }

    fn run(&mut self) -> String {
        let run = self.browser.value("document.querySelector('.qrm-animation').dataset.run");
        run.as_str().expect("a run").to_owned()
    }
}

#[test]
#[ignore = "needs Chromium"]
fn a_saved_scene_moves_anew() {
    let mut desk = Desk::new("quick-return");
    let first = desk.run();
    desk.edit("value = 0.6,", "value = 0.61,");
    let second = desk.next_run(&first);
    println!("{second}");
    assert_eq!((desk.said("problem"), desk.said("mistake"), desk.said("news")), Default::default());
}
