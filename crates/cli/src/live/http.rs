//! Requests of HTTP/1, of limited size and duration, and their answers. A connection takes one request.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use httparse::{EMPTY_HEADER, Status};

/// The largest size of a request line with its headers, in bytes.
pub(super) const MAX_HEAD: usize = 1 << 14;
/// The largest number of headers.
pub(super) const MAX_HEADERS: usize = 64;
/// The largest size of a body, in bytes.
pub(super) const MAX_BODY: usize = 1 << 16;

/// The longest durations of the parts of a connection.
#[derive(Clone, Copy)]
pub(super) struct Timeouts {
    /// The arrival of the request.
    pub(super) request: Duration,
    /// The departure of the answer.
    pub(super) answer: Duration,
    /// The wait for the client to close the connection.
    pub(super) close: Duration,
}

/// A request without its body.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) method: String,
    /// The path with the query.
    pub(super) target: String,
    headers: Vec<(String, String)>,
}

impl Request {
    /// Parses a request and returns it with its length in bytes; `None` if it is incomplete.
    fn parse(bytes: &[u8]) -> Result<Option<(Self, usize)>, Answer> {
        let mut headers = [EMPTY_HEADER; MAX_HEADERS];
        let mut head = httparse::Request::new(&mut headers);
        let length = match head.parse(bytes) {
            Ok(Status::Complete(length)) => length,
            Ok(Status::Partial) => return Ok(None),
            Err(httparse::Error::TooManyHeaders) => {
                return Err(Answer::text(431, &format!("the request has more than {MAX_HEADERS} headers")));
            }
            Err(e) => return Err(Answer::text(400, &format!("this is not a request of HTTP/1: {e}"))),
        };
        let text = |text: Option<&str>| text.unwrap_or_default().to_owned();
        let owned =
            |header: &httparse::Header| (header.name.to_owned(), String::from_utf8_lossy(header.value).into_owned());
        let (method, target) = (text(head.method), text(head.path));
        Ok(Some((Self { method, target, headers: head.headers.iter().map(owned).collect() }, length)))
    }

    /// The value of a header. A header that is sent twice is refused, since programs differ in which of them they use.
    pub(super) fn value(&self, name: &str) -> Result<Option<&str>, Answer> {
        let mut values = self.headers.iter().filter(|(own, _)| own.eq_ignore_ascii_case(name));
        match (values.next(), values.next()) {
            (_, Some(_)) => Err(Answer::text(400, &format!("the request has more than one header `{name}`: send one"))),
            (value, None) => Ok(value.map(|(_, value)| value.as_str())),
        }
    }

    /// The size of the body in bytes.
    fn body_length(&self) -> Result<usize, Answer> {
        let length = self.value("Content-Length")?;
        let (None, Some(length)) = (self.value("Transfer-Encoding")?, length) else {
            return Err(Answer::text(
                411,
                "the size of the body is unknown: send it in `Content-Length`, not in chunks",
            ));
        };
        if length.is_empty() || !length.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(Answer::text(400, "the value of `Content-Length` is not a number of bytes"));
        }
        length.parse().ok().filter(|length| *length <= MAX_BODY).ok_or_else(|| {
            Answer::text(413, &format!("the values take more than {MAX_BODY} bytes: send fewer of them at once"))
        })
    }
}

/// An answer to a request.
#[derive(Debug)]
pub(super) struct Answer {
    pub(super) status: u16,
    pub(super) kind: &'static str,
    pub(super) body: Vec<u8>,
    /// The address of a redirection.
    pub(super) location: Option<String>,
}

impl Answer {
    pub(super) fn new(status: u16, kind: &'static str, body: impl Into<Vec<u8>>) -> Self {
        Self { status, kind, body: body.into(), location: None }
    }

    pub(super) fn text(status: u16, text: &str) -> Self {
        Self::new(status, "text/plain; charset=utf-8", text)
    }
}

/// A stream that fails when its time has passed, however slowly the other end reads or writes.
struct TimedStream {
    stream: TcpStream,
    end: Instant,
}

impl TimedStream {
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.end.saturating_duration_since(Instant::now());
        // A timeout of zero is invalid.
        if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for TimedStream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(buffer)
    }
}

impl Write for TimedStream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// A connection to a client.
pub(super) struct Connection {
    stream: TimedStream,
    timeouts: Timeouts,
    /// The bytes that were received and not used yet.
    received: Vec<u8>,
    /// Whether the request asks for an answer without its body.
    is_head: bool,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, timeouts: Timeouts) -> Self {
        // Otherwise the end of an answer is delayed by 40 ms. A system that lacks this option only answers later.
        let _ = stream.set_nodelay(true);
        let stream = TimedStream { stream, end: Instant::now() + timeouts.request };
        Self { stream, timeouts, received: Vec::new(), is_head: false }
    }

    /// Reads the request, without its body.
    pub(super) fn request(&mut self) -> Result<Request, Answer> {
        loop {
            if let Some((request, length)) = Request::parse(&self.received)? {
                self.received.drain(..length);
                self.is_head = request.method == "HEAD";
                return Ok(request);
            }
            if self.received.len() == MAX_HEAD {
                return Err(Answer::text(
                    431,
                    &format!("the request line and the headers take more than {MAX_HEAD} bytes"),
                ));
            }
            self.receive(MAX_HEAD)?;
        }
    }

    /// Reads the body of the request.
    pub(super) fn body(&mut self, request: &Request) -> Result<Vec<u8>, Answer> {
        let length = request.body_length()?;
        if request.value("Expect")?.is_some_and(|value| value.eq_ignore_ascii_case("100-continue")) {
            // Some clients send the body only now. A failure is found by the next read.
            let _ = self.stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n");
        }
        while self.received.len() < length {
            self.receive(length)?;
        }
        self.received.truncate(length);
        Ok(std::mem::take(&mut self.received))
    }

    /// Whether the client has closed the connection.
    pub(super) fn is_closed(&self) -> bool {
        let stream = &self.stream.stream;
        let peeked = stream.set_nonblocking(true).and_then(|()| stream.peek(&mut [0]));
        let is_waiting = peeked.map_or_else(|e| e.kind() == ErrorKind::WouldBlock, |length| length > 0);
        !is_waiting || stream.set_nonblocking(false).is_err()
    }

    /// Receives some bytes, until there are at most `total`.
    fn receive(&mut self, total: usize) -> Result<(), Answer> {
        let mut buffer = [0; 4096];
        let room = buffer.len().min(total - self.received.len());
        match self.stream.read(&mut buffer[..room]) {
            Ok(0) => Err(Answer::text(400, "the request is incomplete")),
            Ok(length) => {
                self.received.extend_from_slice(&buffer[..length]);
                Ok(())
            }
            Err(e) if e.kind() == ErrorKind::Interrupted => Ok(()),
            Err(_) => Err(Answer::text(408, "the request did not arrive in time")),
        }
    }

    /// Sends the answer with these further headers, and closes the connection.
    pub(super) fn send(mut self, answer: &Answer, headers: &[(&str, &str)]) {
        let length = answer.body.len().to_string();
        let own = [("Content-Type", answer.kind), ("Content-Length", &length), ("Connection", "close")];
        let location = answer.location.as_deref().map(|to| ("Location", to));
        let headers = own.iter().chain(headers).copied().chain(location);
        let headers: String = headers.map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        let head = format!("HTTP/1.1 {} \r\n{headers}\r\n", answer.status);
        self.stream.end = Instant::now() + self.timeouts.answer;
        let body = if self.is_head { &[][..] } else { &answer.body };
        let sent = self.stream.write_all(head.as_bytes()).and_then(|()| self.stream.write_all(body));
        if sent.and_then(|()| self.stream.stream.shutdown(Shutdown::Write)).is_ok() {
            // If bytes are unread when a connection is closed, the system discards what the client has not received.
            self.stream.end = Instant::now() + self.timeouts.close;
            let _ = io::copy(&mut self.stream, &mut io::sink());
        }
    }
}
