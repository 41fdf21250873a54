//! The pages of a scene, for browsers on this machine only.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::json;

use super::edit::{self, length_parameters};
use super::editor::Editor;
use super::feed::Feed;
use super::http::{Answer, Connection, Request, Timeouts};
use super::write_back::with_values;
use crate::error::Error;

/// The longest time that a request for news waits.
const POLL_TIMEOUT: Duration = Duration::from_secs(20);
/// The interval between two checks whether the page of such a request still waits.
const CHECK_INTERVAL: Duration = Duration::from_millis(500);
/// The largest number of connections at a time. Further clients wait in the queue of the system.
const MAX_CONNECTIONS: usize = 64;
/// The interval between two attempts to accept a connection while there are too many.
const RETRY_INTERVAL: Duration = Duration::from_millis(10);
/// The longest durations of the parts of a connection.
const TIMEOUTS: Timeouts =
    Timeouts { request: Duration::from_secs(5), answer: Duration::from_secs(30), close: Duration::from_secs(1) };
/// The page runs only its own scripts, and connects to this server only.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src data: blob:; frame-ancestors 'none'; base-uri 'none'; \
                      form-action 'none'";

/// The headers of each answer.
const HEADERS: [(&str, &str); 4] = [
    ("Content-Security-Policy", POLICY),
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
];

/// Serves a page on the loopback interface, to clients that know its address.
pub(crate) struct Server {
    listener: TcpListener,
    timeouts: Timeouts,
    port: u16,
    token: String,
    /// The path that is passed to the browser and works once, since other users of this machine can see command lines.
    launch_path: Mutex<Option<String>>,
    page: String,
    feed: Arc<Feed>,
    /// Changes the file, by one request at a time.
    editor: Mutex<Option<Editor>>,
}

impl Server {
    /// Creates a server at the given port, or at any free one.
    pub(crate) fn new(port: Option<u16>, page: String, feed: Arc<Feed>, file: Option<PathBuf>) -> Result<Self, Error> {
        let cannot_bind = |reason: String| {
            let asked = port.map_or_else(|| "a port".to_owned(), |port| format!("port {port}"));
            Error::usage(format!("{asked} of the loopback interface cannot be taken: {reason}"))
                .help("choose another one by --port, or leave it to the system")
        };
        let listener =
            TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0))).map_err(|e| cannot_bind(e.to_string()))?;
        let port = listener.local_addr().map_err(|e| cannot_bind(e.to_string()))?.port();
        let (token, launch_path, timeouts) = (random_name()?, Mutex::new(None), TIMEOUTS);
        Ok(Self { listener, timeouts, port, token, launch_path, page, feed, editor: Mutex::new(file.map(Editor::new)) })
    }

    /// The address of the page, which cannot be guessed.
    pub(crate) fn address(&self) -> String {
        format!("http://{}:{}/{}/", Ipv4Addr::LOCALHOST, self.port, self.token)
    }

    /// An address that leads to the page once.
    pub(crate) fn launch_address(&self) -> Result<String, Error> {
        let path = format!("/{}", random_name()?);
        let address = format!("http://{}:{}{path}", Ipv4Addr::LOCALHOST, self.port);
        *lock(&self.launch_path) = Some(path);
        Ok(address)
    }

    /// Answers requests until the program ends.
    pub(crate) fn serve(self) {
        let server = Arc::new(self);
        loop {
            // Each connection holds a reference. Accepting fails if the system has no more descriptors.
            let has_room = Arc::strong_count(&server) <= MAX_CONNECTIONS;
            let Some((stream, _)) = has_room.then(|| server.listener.accept().ok()).flatten() else {
                thread::sleep(RETRY_INTERVAL);
                continue;
            };
            let own = Arc::clone(&server);
            // Pages wait for news. If no thread is available, the connection is closed, and its page asks again.
            let _ = thread::Builder::new().spawn(move || own.answer(stream));
        }
    }

    fn answer(&self, stream: TcpStream) {
        let mut connection = Connection::new(stream, self.timeouts);
        let answer = connection.request().and_then(|request| self.answer_to(&request, &mut connection));
        connection.send(&answer.unwrap_or_else(|refusal| refusal), &HEADERS);
    }

    fn answer_to(&self, request: &Request, connection: &mut Connection) -> Result<Answer, Answer> {
        self.check_origin(request)?;
        if lock(&self.launch_path).take_if(|path| *path == request.target).is_some() {
            let location = Some(format!("/{}/", self.token));
            return Ok(Answer { location, ..Answer::text(303, "the page is elsewhere") });
        }
        let path = request.target.strip_prefix('/').and_then(|path| path.strip_prefix(self.token.as_str()));
        let (path, query) = path.map_or(("", ""), |path| path.split_once('?').unwrap_or((path, "")));
        match (request.method.as_str(), path) {
            ("GET", "/") => Ok(Answer::new(200, "text/html; charset=utf-8", self.page.clone())),
            ("GET", "/news") => Ok(self.news(query, connection)),
            ("POST", "/values") => connection.body(request).map(|body| self.write(body)),
            ("POST", "/edit") => connection.body(request).map(|body| self.edit(&body)),
            ("POST", "/tools") => connection.body(request).map(|_| {
                self.feed.begin_editing();
                Answer::text(200, "")
            }),
            ("POST", "/undo") => {
                connection.body(request).map(|_| self.change(|editor| editor.undo().map(|()| String::new())))
            }
            ("POST", "/redo") => {
                connection.body(request).map(|_| self.change(|editor| editor.redo().map(|()| String::new())))
            }
            _ => Err(Answer::text(404, "there is nothing here")),
        }
    }

    /// Refuses a request that does not come from a page of this server: names of other sites may resolve to this
    /// machine.
    fn check_origin(&self, request: &Request) -> Result<(), Answer> {
        let port = if self.port == 80 { String::new() } else { format!(":{}", self.port) };
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}{port}"));
        let is_own = |host: &str| hosts.iter().any(|own| own == host);
        let Some(host) = request.value("Host")? else {
            return Err(Answer::text(400, "the request has no header `Host`"));
        };
        let origin = request.value("Origin")?;
        if is_own(host) && origin.is_none_or(|origin| origin.strip_prefix("http://").is_some_and(is_own)) {
            return Ok(());
        }
        Err(Answer::text(403, "this address belongs to the pages of `qrm live` alone"))
    }

    /// The content that is newer than the versions of the page; empty after a while, or if the page has closed the
    /// connection.
    fn news(&self, query: &str, connection: &Connection) -> Answer {
        let known = |name: &str| {
            let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
            pairs.filter(|(own, _)| *own == name).find_map(|(_, value)| value.parse().ok()).unwrap_or(0)
        };
        let begun = Instant::now();
        while begun.elapsed() < POLL_TIMEOUT && !connection.is_closed() {
            if let Some(news) = self.feed.after(known("version"), known("scene"), CHECK_INTERVAL) {
                return Answer::new(200, "application/json", news);
            }
        }
        Answer::new(204, "text/plain", Vec::new())
    }

    /// Writes values to the scene file.
    fn write(&self, body: Vec<u8>) -> Answer {
        let Ok(text) = String::from_utf8(body) else {
            return Answer::text(400, "the values are not UTF-8 text");
        };
        let value = |line: &str| {
            let (name, value) = line.split_once('=')?;
            Some((name.to_owned(), value.parse().ok().filter(|value: &f64| value.is_finite())?))
        };
        let Some(values) = text.lines().map(value).collect::<Option<BTreeMap<_, _>>>() else {
            return Answer::text(400, "a line is no NAME=VALUE with a finite value");
        };
        self.change(|editor| {
            editor.change(None, |text| Ok((with_values(text, &values)?, ())))?;
            Ok(format!("written to {}", editor.path().display()))
        })
    }

    /// Changes the scene as it was drawn with the mouse. Answers the names of the points of a new bar, and the values that are new.
    fn edit(&self, body: &[u8]) -> Answer {
        let request = match serde_json::from_slice::<edit::Request>(body) {
            Ok(request) => request,
            Err(reason) => return Answer::text(400, &format!("this is no change of a scene: {reason}")),
        };
        self.change(|editor| {
            editor.change(request.gesture.as_deref(), |before| {
                let (after, points) = request.apply(before)?;
                let (known, mut values) = (length_parameters::values(before), length_parameters::values(&after));
                values.retain(|name, value| known.get(name) != Some(value));
                Ok((after, json!({ "points": points, "values": values }).to_string()))
            })
        })
    }

    fn change(&self, change: impl FnOnce(&mut Editor) -> Result<String, String>) -> Answer {
        let mut editor = lock(&self.editor);
        let Some(editor) = &mut *editor else {
            return Answer::text(409, "this scene is built in and has no file: `qrm new` writes a copy");
        };
        change(editor).map_or_else(|reason| Answer::text(409, &reason), |text| Answer::text(200, &text))
    }
}

/// A name that cannot be guessed.
fn random_name() -> Result<String, Error> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|e| Error::run(format!("the system has no random numbers: {e}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
