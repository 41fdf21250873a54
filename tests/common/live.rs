//! `qrm live` as a process, and its answers.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// The longest wait for news.
const LONGEST: Duration = Duration::from_secs(600);

/// `qrm live` with a scene file in a folder of its own.
pub(crate) struct Live {
    folder: Arc<TempDir>,
    process: Child,
    /// The address of the page.
    pub(crate) address: String,
    /// The versions of the last news and of the last scene.
    known: (u64, u64),
}

impl Live {
    /// The command with a copy of a scene of the program.
    pub(crate) fn of_scene(scene: &str) -> Self {
        Self::of_text(&copy_of(scene))
    }

    /// The command with this scene.
    pub(crate) fn of_text(text: &str) -> Self {
        let folder = folder_with(text);
        let command = command(folder.path(), &["--no-open", "mine.toml"]);
        Self::started(folder, command)
    }

    /// The command with a copy of a scene of the program and with this PATH. It opens a browser.
    pub(crate) fn with_browser(scene: &str, path: &str) -> Self {
        let folder = folder_with(&copy_of(scene));
        let mut command = command(folder.path(), &["mine.toml"]);
        command.env("PATH", path);
        Self::started(folder, command)
    }

    /// The command with a scene of the program and with at most this number of descriptors.
    #[cfg(unix)]
    pub(crate) fn with_descriptors(count: u32) -> Self {
        let folder = folder_with(&copy_of("pendulum"));
        let command = command(folder.path(), &["--no-open", "mine.toml"]);
        let mut limited = Command::new("sh");
        limited.args(["-c", &format!("ulimit -n {count} && exec \"$0\" \"$@\"")]);
        limited.arg(command.get_program()).args(command.get_args()).current_dir(folder.path());
        limited.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
        Self::started(folder, limited)
    }

    /// Another command with the same file.
    pub(crate) fn second(&self) -> Self {
        Self::started(Arc::clone(&self.folder), command(self.folder.path(), &["--no-open", "mine.toml"]))
    }

    fn started(folder: Arc<TempDir>, mut command: Command) -> Self {
        let mut process = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let mut line = String::new();
        let mut said = BufReader::new(process.stdout.take().expect("a pipe"));
        said.read_line(&mut line).expect("it says where the page is");
        let address = line.split_whitespace().find(|word| word.starts_with("http://")).expect("an address").to_owned();
        Self { folder, process, address, known: (0, 0) }
    }

    /// The scene file.
    pub(crate) fn file(&self) -> PathBuf {
        self.folder.path().join("mine.toml")
    }

    /// The text of the scene file.
    pub(crate) fn text(&self) -> String {
        fs::read_to_string(self.file()).expect("the scene")
    }

    /// Saves another text.
    pub(crate) fn save(&self, text: impl AsRef<[u8]>) {
        fs::write(self.file(), text).expect("written");
    }

    /// Replaces a part of the scene file.
    pub(crate) fn edit(&self, from: &str, to: &str) {
        let text = self.text();
        assert!(text.contains(from), "`{from}` is not in the scene");
        self.save(text.replacen(from, to, 1));
    }

    /// The next news. As a page does, it asks again when there is nothing to show for as long as an answer may take:
    /// the engine may be at work for another program.
    pub(crate) fn next(&mut self) -> Value {
        let (version, scene) = self.known;
        let asked = Instant::now();
        let body = loop {
            match self.get(&format!("news?version={version}&scene={scene}"), &[]) {
                (200, body) => break body,
                (status, _) => assert_eq!(status, 204, "news of version {version}"),
            }
            assert!(asked.elapsed() < LONGEST, "nothing is shown after {LONGEST:?}");
        };
        let news: Value = serde_json::from_str(&body).expect("JSON");
        self.known = (news["version"].as_u64().expect("a version"), news["scene_version"].as_u64().expect("one"));
        news
    }

    /// Waits for a scene.
    pub(crate) fn next_scene(&mut self) -> Value {
        loop {
            let next = self.next();
            if next.get("scene").is_some() {
                return next;
            }
        }
    }

    /// Waits for a mistake whose report contains this; the report. A file that is half written has other mistakes.
    pub(crate) fn wait_for_problem(&mut self, part: &str) -> String {
        loop {
            let next = self.next();
            if let Some(problem) = next["problem"].as_str().filter(|problem| problem.contains(part)) {
                return problem.to_owned();
            }
        }
    }

    /// The status and the body of an answer.
    pub(crate) fn get(&self, path: &str, headers: &[&str]) -> (u16, String) {
        self.answer("GET", &format!("{}{path}", self.path()), headers, "")
    }

    /// Sends values.
    pub(crate) fn post_values(&self, values: &str) -> (u16, String) {
        self.answer("POST", &format!("{}values", self.path()), &[], values)
    }

    pub(crate) fn answer(&self, method: &str, path: &str, headers: &[&str], body: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(self.host()).expect("it listens");
        let own = format!("Host: {}", self.host());
        let host = if headers.iter().any(|header| header.starts_with("Host:")) { "X-Host: 0" } else { &own };
        let (headers, length) = (headers.join("\r\n"), body.len());
        let separator = if headers.is_empty() { "" } else { "\r\n" };
        let request = format!(
            "{method} {path} HTTP/1.1\r\n{host}\r\nConnection: close\r\nContent-Length: {length}\r\n\
             {headers}{separator}\r\n{body}"
        );
        stream.write_all(request.as_bytes()).expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("received");
        let (head, body) = answer.split_once("\r\n\r\n").expect("a head and a body");
        (head[9..12].parse().expect("a status"), body.to_owned())
    }

    fn host(&self) -> &str {
        self.address["http://".len()..].split('/').next().expect("a host")
    }

    fn path(&self) -> &str {
        &self.address["http://".len() + self.host().len()..]
    }

    /// The identifier of the process.
    pub(crate) fn id(&self) -> u32 {
        self.process.id()
    }

    /// Ends the command without asking it.
    pub(crate) fn kill(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }

    /// The message of a command with these arguments, which fails.
    pub(crate) fn refused(&self, arguments: &[&str]) -> String {
        let output = command(self.folder.path(), &[&["--no-open"], arguments].concat()).output().expect("it starts");
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    }

    /// The port of the page.
    pub(crate) fn port(&self) -> &str {
        self.host().split(':').nth(1).expect("a port")
    }

    /// The folder of the scene.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }
}

/// The text of a scene of the program under another name.
fn copy_of(scene: &str) -> String {
    let text = fs::read_to_string(format!("{}/scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR"))).expect("a scene");
    text.replacen(&format!("\"{scene}\""), "\"mine\"", 1)
}

fn folder_with(text: &str) -> Arc<TempDir> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    fs::write(folder.path().join("mine.toml"), text).expect("written");
    Arc::new(folder)
}

fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_qrm"));
    command.arg("live").args(arguments).current_dir(folder).env("QRM_CACHE", folder.join("cache"));
    command
}

impl Drop for Live {
    fn drop(&mut self) {
        self.kill();
    }
}
