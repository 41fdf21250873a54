//! `qrm live` as a process.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// A command that serves a page.
pub(crate) struct Live {
    process: Child,
    /// Where the page is.
    pub(crate) address: String,
}

impl Live {
    /// `qrm live` with a scene, in a folder that has the cache too.
    pub(crate) fn new(folder: &Path, scene: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_qrm"))
            .args(["live", scene, "--no-open"])
            .current_dir(folder)
            .env("QRM_CACHE", folder.join("cache"))
            .stdout(Stdio::piped())
            .spawn()
            .expect("the command starts");
        let mut line = String::new();
        let mut said = BufReader::new(process.stdout.take().expect("a pipe"));
        said.read_line(&mut line).expect("it says where the page is");
        let address = line.split([' ', ',']).find(|word| word.starts_with("http://")).expect("an address").to_owned();
        Self { process, address }
    }

    /// The identity of the process.
    pub(crate) fn id(&self) -> u32 {
        self.process.id()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
