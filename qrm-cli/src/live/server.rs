//! The pages of a scene, for browsers on this machine alone.

use std::io::Read;
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use socket2::SockRef;
use tiny_http::{Header, Method, Request, Response};

use super::feed::Feed;
use super::values;
use crate::error::Error;

/// How long a page waits for news before it asks again.
const PATIENCE: Duration = Duration::from_secs(20);
/// Most bytes that a page sends.
const MAX_BYTES: u64 = 1 << 16;
/// A page is what it is sent, and talks to nobody else.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; \
                      connect-src 'self'; img-src data: blob:; frame-ancestors 'none'; base-uri 'none'; \
                      form-action 'none'";

/// Serves a page on the loopback interface, to whoever knows its address.
pub(crate) struct Server {
    http: tiny_http::Server,
    port: u16,
    token: String,
    page: String,
    feed: Arc<Feed>,
    /// The file that values are written to.
    file: Option<PathBuf>,
}

impl Server {
    /// Takes a port: that one, or any that is free.
    pub(crate) fn new(port: Option<u16>, page: String, feed: Arc<Feed>, file: Option<PathBuf>) -> Result<Self, Error> {
        let taken = |reason: String| {
            let asked = port.map_or_else(|| "a port".to_owned(), |port| format!("port {port}"));
            Error::usage(format!("{asked} of the loopback interface cannot be taken: {reason}"))
                .help("choose another one by --port, or leave it to the system")
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port.unwrap_or(0))).map_err(|e| taken(e.to_string()))?;
        let port = listener.local_addr().map_err(|e| taken(e.to_string()))?.port();
        // Connections take this over. Otherwise the end of an answer waits for 40 ms to be sent.
        let _ = SockRef::from(&listener).set_tcp_nodelay(true);
        let http = tiny_http::Server::from_listener(listener, None).map_err(|e| taken(e.to_string()))?;
        let mut token = [0; 16];
        getrandom::fill(&mut token).map_err(|e| Error::run(format!("the system has no random numbers: {e}")))?;
        let token = token.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Self { http, port, token, page, feed, file })
    }

    /// The address of the page. Nobody can guess it.
    pub(crate) fn address(&self) -> String {
        format!("http://{}:{}/{}/", Ipv4Addr::LOCALHOST, self.port, self.token)
    }

    /// Answers requests for as long as the program runs.
    pub(crate) fn serve(self) {
        let server = Arc::new(self);
        for request in server.http.incoming_requests() {
            let own = Arc::clone(&server);
            // Pages wait for news.
            std::thread::spawn(move || own.answer(request));
        }
    }

    fn answer(&self, mut request: Request) {
        let answer = self.answer_to(&mut request);
        let mut response = Response::from_data(answer.body).with_status_code(answer.status);
        for (name, value) in [
            ("Content-Type", answer.kind),
            ("Content-Security-Policy", POLICY),
            ("Cache-Control", "no-store"),
            ("Referrer-Policy", "no-referrer"),
            ("X-Content-Type-Options", "nosniff"),
        ] {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        // The browser may have gone away.
        let _ = request.respond(response);
    }

    fn answer_to(&self, request: &mut Request) -> Answer {
        if !self.is_own(request) {
            return Answer::text(403, "this page is for the browser that `qrm live` opened");
        }
        let path = request.url().strip_prefix('/').and_then(|path| path.strip_prefix(self.token.as_str()));
        let Some(path) = path.map(str::to_owned) else { return Answer::nothing() };
        let (path, query) = path.split_once('?').unwrap_or((&path, ""));
        match (request.method(), path) {
            (Method::Get, "/") => {
                Answer { status: 200, kind: "text/html; charset=utf-8", body: self.page.clone().into() }
            }
            (Method::Get, "/news") => self.news(query),
            (Method::Post, "/values") => self.write(request),
            _ => Answer::nothing(),
        }
    }

    /// Whether a request comes from a page of this server: other pages could ask under another name for this machine.
    fn is_own(&self, request: &Request) -> bool {
        let value = |name: &'static str| {
            let header = request.headers().iter().find(|header| header.field.equiv(name));
            header.map(|header| header.value.as_str().to_owned())
        };
        let hosts = ["127.0.0.1", "localhost"].map(|host| format!("{host}:{}", self.port));
        value("Host").is_some_and(|host| hosts.contains(&host))
            && value("Origin").is_none_or(|origin| hosts.iter().any(|host| origin == format!("http://{host}")))
    }

    /// What the page does not know yet.
    fn news(&self, query: &str) -> Answer {
        let known = |name: &str| {
            let pairs = query.split('&').filter_map(|pair| pair.split_once('='));
            pairs.filter(|(own, _)| *own == name).find_map(|(_, value)| value.parse().ok()).unwrap_or(0)
        };
        match self.feed.after(known("version"), known("scene"), PATIENCE) {
            Some(news) => Answer { status: 200, kind: "application/json", body: news.into() },
            None => Answer { status: 204, kind: "text/plain", body: Vec::new() },
        }
    }

    /// Writes values to the scene file.
    fn write(&self, request: &mut Request) -> Answer {
        let Some(file) = &self.file else {
            return Answer::text(409, "this scene is built in and has no file: `qrm new` writes a copy");
        };
        let mut text = String::new();
        if request.as_reader().take(MAX_BYTES).read_to_string(&mut text).is_err() {
            return Answer::text(400, "the values did not arrive");
        }
        let value = |line: &str| {
            let (name, value) = line.split_once('=')?;
            Some((name.to_owned(), value.parse().ok().filter(|value: &f64| value.is_finite())?))
        };
        let Some(values) = text.lines().map(value).collect::<Option<Vec<_>>>() else {
            return Answer::text(400, "these are no values");
        };
        match values::write(file, &values) {
            Ok(()) => Answer::text(200, &format!("written to {}", file.display())),
            Err(reason) => Answer::text(409, &reason),
        }
    }
}

struct Answer {
    status: u16,
    kind: &'static str,
    body: Vec<u8>,
}

impl Answer {
    fn text(status: u16, text: &str) -> Self {
        Self { status, kind: "text/plain; charset=utf-8", body: text.into() }
    }

    fn nothing() -> Self {
        Self::text(404, "there is nothing here")
    }
}
