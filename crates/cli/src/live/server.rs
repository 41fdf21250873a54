//! The pages of a scene, for browsers on this machine only.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use socket2::SockRef;
use tiny_http::{Header, Method, Request, Response};

use super::feed::Feed;
use super::write_back::write_back;
use crate::error::Error;

/// The longest time that a request for news waits.
const POLL_TIMEOUT: Duration = Duration::from_secs(20);
/// The largest accepted body, in bytes.
const MAX_BYTES: u64 = 1 << 16;
/// The announced body size, in bytes, above which a request is not answered.
const MAX_BODY: u64 = 1 << 24;
/// The page runs only its own scripts, and connects to this server only.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src data: blob:; frame-ancestors 'none'; base-uri 'none'; \
                      form-action 'none'";

/// Serves a page on the loopback interface, to clients that know its address.
pub(crate) struct Server {
    http: tiny_http::Server,
    port: u16,
    token: String,
    /// The path that is passed to the browser and works once, since other users of this machine can see command lines.
    launch_path: Mutex<Option<String>>,
    page: String,
    feed: Arc<Feed>,
    /// The file for values, written by one request at a time.
    file: Mutex<Option<PathBuf>>,
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
        // Connections inherit this option. Without it the end of an answer is delayed by 40 ms.
        let _ = SockRef::from(&listener).set_tcp_nodelay(true);
        let http = tiny_http::Server::from_listener(listener, None).map_err(|e| cannot_bind(e.to_string()))?;
        let (token, launch_path) = (random_name()?, Mutex::new(None));
        Ok(Self { http, port, token, launch_path, page, feed, file: Mutex::new(file) })
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

    /// Answers requests until the listener fails.
    pub(crate) fn serve(self) {
        let server = Arc::new(self);
        for request in server.http.incoming_requests() {
            let own = Arc::clone(&server);
            // Pages wait for news. If no thread is available, the request is dropped, and its page asks again.
            let _ = thread::Builder::new().spawn(move || own.answer(request));
        }
    }

    fn answer(&self, mut request: Request) {
        if request.body_length().is_some_and(|length| length as u64 > MAX_BODY) {
            // Answering would first read the whole body into memory. No page sends such a request.
            std::mem::forget(request);
            return;
        }
        let answer = self.answer_to(&mut request);
        let mut response = Response::from_data(answer.body).with_status_code(answer.status);
        let headers = [
            ("Content-Type", answer.kind),
            ("Content-Security-Policy", POLICY),
            ("Cache-Control", "no-store"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ];
        for (name, value) in headers.into_iter().chain(answer.location.as_deref().map(|to| ("Location", to))) {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        // The browser may have closed the connection.
        let _ = request.respond(response);
    }

    fn answer_to(&self, request: &mut Request) -> Answer {
        if !self.is_same_origin(request) {
            return Answer::text(403, "this address belongs to the pages of `qrm live` alone");
        }
        if lock(&self.launch_path).take_if(|path| path == request.url()).is_some() {
            let location = Some(format!("/{}/", self.token));
            return Answer { location, ..Answer::text(303, "the page is elsewhere") };
        }
        let path = request.url().strip_prefix('/').and_then(|path| path.strip_prefix(self.token.as_str()));
        let Some(path) = path.map(str::to_owned) else { return Answer::not_found() };
        let (path, query) = path.split_once('?').unwrap_or((&path, ""));
        match (request.method(), path) {
            (Method::Get, "/") => Answer::new(200, "text/html; charset=utf-8", self.page.clone()),
            (Method::Get, "/news") => self.news(query),
            (Method::Post, "/values") => self.write(request),
            _ => Answer::not_found(),
        }
    }

    /// Whether a request comes from a page of this server: names of other sites may resolve to this machine.
    fn is_same_origin(&self, request: &Request) -> bool {
        let value = |name: &'static str| {
            let header = request.headers().iter().find(|header| header.field.equiv(name));
            header.map(|header| header.value.as_str().to_owned())
        };
        let port = if self.port == 80 { String::new() } else { format!(":{}", self.port) };
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}{port}"));
        value("Host").is_some_and(|host| hosts.contains(&host))
            && value("Origin").is_none_or(|origin| hosts.iter().any(|host| origin == format!("http://{host}")))
    }

    /// The content that is newer than the versions of the page.
    fn news(&self, query: &str) -> Answer {
        let known = |name: &str| {
            let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
            pairs.filter(|(own, _)| *own == name).find_map(|(_, value)| value.parse().ok()).unwrap_or(0)
        };
        match self.feed.after(known("version"), known("scene"), POLL_TIMEOUT) {
            Some(news) => Answer::new(200, "application/json", news),
            None => Answer::new(204, "text/plain", Vec::new()),
        }
    }

    /// Writes values to the scene file.
    fn write(&self, request: &mut Request) -> Answer {
        let mut text = String::new();
        if request.as_reader().take(MAX_BYTES + 1).read_to_string(&mut text).is_err() {
            return Answer::text(400, "the values did not arrive");
        }
        if text.len() as u64 > MAX_BYTES {
            return Answer::text(413, "these are too many values");
        }
        let value = |line: &str| {
            let (name, value) = line.split_once('=')?;
            Some((name.to_owned(), value.parse().ok().filter(|value: &f64| value.is_finite())?))
        };
        let Some(values) = text.lines().map(value).collect::<Option<BTreeMap<_, _>>>() else {
            return Answer::text(400, "a line is no NAME=VALUE with a finite value");
        };
        let file = lock(&self.file);
        let Some(file) = &*file else {
            return Answer::text(409, "this scene is built in and has no file: `qrm new` writes a copy");
        };
        match write_back(file, &values) {
            Ok(()) => Answer::text(200, &format!("written to {}", file.display())),
            Err(reason) => Answer::text(409, &reason),
        }
    }
}

struct Answer {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
    /// The address of a redirection.
    location: Option<String>,
}

impl Answer {
    fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status, kind, body: body.into(), location: None }
    }

    fn text(status: u16, text: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", text)
    }

    fn not_found() -> Self {
        Self::text(404, "there is nothing here")
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
