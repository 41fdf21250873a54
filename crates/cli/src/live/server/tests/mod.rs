//! Requests of any size, form and speed.

use std::io::{Read, Write};

use super::*;
use crate::live::http::{MAX_BODY, MAX_HEAD, MAX_HEADERS};

/// Long enough for a request on a busy machine.
const REQUEST: Duration = Duration::from_secs(2);
/// The longest duration of a request in tests that wait for its end.
const SHORT: Duration = Duration::from_millis(300);
/// The duration after which a test fails rather than waits.
const LONG: Duration = Duration::from_secs(60);

/// A server that runs until the tests end.
struct Served {
    port: u16,
    token: String,
    feed: Arc<Feed>,
}

impl Served {
    /// A server with this longest duration of a request, and of the wait for the end of its connection.
    fn new(request: Duration) -> Self {
        let feed = Arc::new(Feed::default());
        let mut server = Server::new(None, "the page".to_owned(), Arc::clone(&feed), None).expect("a port");
        server.timeouts = Timeouts { request, close: request, ..TIMEOUTS };
        let (port, token) = (server.port, server.token.clone());
        thread::spawn(move || server.serve());
        Self { port, token, feed }
    }

    fn connection(&self) -> TcpStream {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).expect("a connection");
        stream.set_read_timeout(Some(LONG)).expect("a timeout");
        stream
    }

    fn sent(&self, bytes: impl AsRef<[u8]>) -> TcpStream {
        let mut stream = self.connection();
        stream.write_all(bytes.as_ref()).expect("sent");
        stream
    }

    /// A request of the page with these further headers.
    fn request(&self, method: &str, path: &str, headers: &str) -> String {
        format!("{method} /{}/{path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n{headers}\r\n", self.token, self.port)
    }

    /// The status and the body of an answer. The connection is closed after it.
    fn answer(&self, bytes: impl AsRef<[u8]>) -> (u16, String) {
        answer_of(self.sent(bytes))
    }

    /// The status of an answer to a request for the page with these further headers.
    fn status(&self, headers: &str) -> u16 {
        self.answer(self.request("GET", "", headers)).0
    }
}

fn answer_of(mut stream: TcpStream) -> (u16, String) {
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer and the end of the connection");
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head and a body");
    assert!(head.contains("\r\nConnection: close\r\n"), "{head}");
    let length = head.split("\r\nContent-Length: ").nth(1).and_then(|rest| rest.split("\r\n").next());
    let length: usize = length.expect("a length").parse().expect("a number");
    assert!(body.is_empty() || length == body.len(), "{head}");
    (head[9..12].parse().expect("a status"), body.to_owned())
}

#[test]
fn announced_bodies_are_not_waited_for() {
    let served = Served::new(LONG);
    let open: Vec<TcpStream> = (0..40)
        .map(|number| {
            let path = ["", "values"][number % 2];
            let stream = served.sent(served.request("POST", path, "Content-Length: 17000000\r\n"));
            assert_eq!(answer_of(stream.try_clone().expect("a copy")).0, [404, 413][number % 2]);
            stream
        })
        .collect();
    assert_eq!(served.status(""), 200);
    // A client that goes on sending can do so until it has seen the answer.
    for mut stream in open {
        stream.write_all(b"a").and_then(|()| stream.write_all(b"a")).expect("sent");
    }
    // The right to use the page is looked at first.
    let foreign = "POST / HTTP/1.1\r\nHost: evil.example\r\nContent-Length: 99999999999999999999999\r\n\r\n";
    assert_eq!(served.answer(foreign).0, 403);
}

#[test]
fn bodies_have_a_largest_size() {
    let served = Served::new(REQUEST);
    let posted = |length: usize| {
        let head = served.request("POST", "values", &format!("Content-Length: {length}\r\n"));
        served.answer(head + &"\n".repeat(length))
    };
    // Lines without values are read and refused.
    assert_eq!(posted(MAX_BODY), (400, "a line is no NAME=VALUE with a finite value".to_owned()));
    let large = (413, "the values take more than 65536 bytes: send fewer of them at once".to_owned());
    assert_eq!(posted(MAX_BODY + 1), large);
    assert_eq!(posted(0).0, 409);
    for (headers, status) in [
        ("", 411),
        ("Transfer-Encoding: chunked\r\n", 411),
        ("Transfer-Encoding: chunked\r\nContent-Length: 3\r\n", 411),
        ("Content-Length: 3\r\nContent-Length: 3\r\n", 400),
        ("Content-Length: +3\r\n", 400),
        ("Content-Length: -3\r\n", 400),
        ("Content-Length:\r\n", 400),
        ("Content-Length: 3x\r\n", 400),
        ("Content-Length: 99999999999999999999999\r\n", 413),
    ] {
        let request = served.request("POST", "values", headers) + "3\r\na=1\r\n0\r\n\r\n";
        assert_eq!(served.answer(request).0, status, "{headers}");
    }
    // Values that are not text.
    let request = served.request("POST", "values", "Content-Length: 2\r\n");
    assert_eq!(served.answer([request.as_bytes(), &[0xff, 0xfe]].concat()).0, 400);
}

#[test]
fn a_client_may_ask_before_it_sends_a_body() {
    let served = Served::new(REQUEST);
    let expect = |length: usize| format!("Content-Length: {length}\r\nExpect: 100-continue\r\n");
    let mut stream = served.sent(served.request("POST", "values", &expect(3)));
    let mut interim = [0; 25];
    stream.read_exact(&mut interim).expect("an interim answer");
    assert_eq!(&interim, b"HTTP/1.1 100 Continue\r\n\r\n");
    stream.write_all(b"a=1").expect("sent");
    assert_eq!(answer_of(stream).0, 409);
    assert_eq!(served.answer(served.request("POST", "values", &expect(MAX_BODY + 1))).0, 413);
    assert_eq!(served.status(&expect(3)), 200);
}

#[test]
fn heads_have_a_largest_size() {
    let served = Served::new(REQUEST);
    let padding = |length: usize| format!("X-Padding: {}\r\n", "a".repeat(length));
    let room = MAX_HEAD - served.request("GET", "", &padding(0)).len();
    assert_eq!(served.status(&padding(room)), 200);
    assert_eq!(served.status(&padding(room + 1)), 431);
    let headers = |count: usize| (0..count).map(|number| format!("X-{number}: 0\r\n")).collect::<String>();
    assert_eq!(served.status(&headers(MAX_HEADERS - 1)), 200);
    assert_eq!(served.status(&headers(MAX_HEADERS)), 431);
    assert_eq!(served.answer(format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(1 << 20))).0, 431);
    assert_eq!(served.answer("\r\n".repeat(MAX_HEAD)).0, 431);
    // Headers without end: the client is cut off while it sends.
    let served = Served::new(SHORT);
    for part in ["X-Padding: 0\r\n".to_owned(), "a".repeat(1000)] {
        let mut stream = served.sent(&served.request("GET", "", "")[..60]);
        let begun = Instant::now();
        while stream.write_all(part.as_bytes()).is_ok() {
            assert!(begun.elapsed() < LONG, "the server reads headers without end");
        }
    }
}

#[test]
fn host_and_origin_are_sent_once() {
    let served = Served::new(REQUEST);
    let (host, other) = (format!("127.0.0.1:{}", served.port), "evil.example");
    let origin = format!("http://{host}");
    for headers in [format!("Host: {host}\r\n"), format!("Host: {other}\r\n"), format!("hOST: {other}\r\n")] {
        assert_eq!(served.status(&headers), 400, "{headers}");
    }
    assert_eq!(served.status(&format!("Origin: {origin}\r\n")), 200);
    for second in [&*origin, "http://evil.example", "null"] {
        let headers = format!("Origin: {origin}\r\norigin: {second}\r\n");
        assert_eq!(served.status(&headers), 400, "{headers}");
    }
    for origin in ["null", "http://evil.example", &host, &format!("https://{host}"), &format!("{origin}, {origin}")] {
        assert_eq!(served.status(&format!("Origin: {origin}\r\n")), 403, "{origin}");
    }
    let path = format!("/{}/", served.token);
    for (request, status) in [
        (format!("GET {path} HTTP/1.1\r\n\r\n"), 400),
        (format!("GET {path} HTTP/1.0\r\n\r\n"), 400),
        (format!("GET {path} HTTP/1.0\r\nHost: {host}\r\n\r\n"), 200),
        (format!("GET {path} HTTP/1.1\r\nHost: {other}\r\n\r\n"), 403),
        (format!("GET {path} HTTP/1.1\r\nHost:\r\n\r\n"), 403),
        (format!("GET {path} HTTP/1.1\r\nHost : {host}\r\n\r\n"), 400),
        (format!("GET {path} HTTP/1.1\r\nX: 0\r\n Host: {host}\r\n\r\n"), 400),
    ] {
        assert_eq!(served.answer(&request).0, status, "{request}");
    }
}

#[test]
fn other_methods_and_other_bytes_are_refused() {
    let served = Served::new(REQUEST);
    for (method, path) in [("PUT", ""), ("POST", ""), ("GET", "values"), ("DELETE", "values"), ("OPTIONS", "news")] {
        let headers = "Content-Length: 3\r\n";
        assert_eq!(served.answer(served.request(method, path, headers) + "a=1").0, 404, "{method} {path}");
    }
    // The answer has no body, though its length is said.
    assert_eq!(served.answer(served.request("HEAD", "", "")), (404, String::new()));
    let noise: Vec<u8> = (0..100_000_u32).map(|i| i.wrapping_mul(2_654_435_761).to_be_bytes()[0]).collect();
    // The beginning of a connection by TLS, and texts of no protocol or another one.
    let tls: &[u8] = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03";
    for bytes in [&noise, tls, b"\0\0\0\0", b"hello\r\n\r\n", b"GET / HTTP/2.0\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\n"] {
        assert_eq!(served.answer(bytes).0, 400, "{:?}", &bytes[..4]);
    }
}

#[test]
fn a_connection_takes_one_request() {
    let served = Served::new(REQUEST);
    let request = served.request("GET", "", "Connection: keep-alive\r\n");
    assert_eq!(served.answer(request.repeat(100)), (200, "the page".to_owned()));
    let post = served.request("POST", "values", "Content-Length: 3\r\n") + "a=1";
    assert_eq!(served.answer(post + &request).0, 409);
    // A client that has sent a part of a request and no more.
    let stream = served.sent(&request[..request.len() - 1]);
    stream.shutdown(std::net::Shutdown::Write).expect("shut down");
    assert_eq!(answer_of(stream).0, 400);
}

#[test]
fn slow_clients_are_cut_off() {
    let served = Served::new(SHORT);
    let begun = Instant::now();
    assert_eq!(served.answer("").0, 408);
    assert_eq!(served.answer("GET /").0, 408);
    assert_eq!(served.answer(served.request("POST", "values", "Content-Length: 3\r\n") + "a").0, 408);
    assert!(begun.elapsed() >= 3 * SHORT);
    // Bytes that arrive in time do not extend the time of their request.
    let begun = Instant::now();
    let mut stream = served.sent("GET /");
    stream.set_read_timeout(Some(SHORT / 10)).expect("a timeout");
    let mut start = [0; 12];
    while stream.read_exact(&mut start).is_err() {
        assert!(begun.elapsed() < 20 * SHORT, "the client is never cut off");
        stream.write_all(b"a").expect("sent");
    }
    assert_eq!(&start, b"HTTP/1.1 408");
}

#[test]
fn connections_have_a_largest_number() {
    let served = Served::new(SHORT);
    let begun = Instant::now();
    let idle: Vec<TcpStream> = (0..2 * MAX_CONNECTIONS).map(|_| served.connection()).collect();
    // It waits until others are cut off.
    assert_eq!(served.status(""), 200);
    assert!(begun.elapsed() >= 2 * SHORT, "all connections were accepted");
    drop(idle);
}

#[test]
fn clients_that_do_not_receive_are_cut_off() {
    let feed = Arc::new(Feed::default());
    // More than the buffers of the system take.
    let mut server = Server::new(None, "a".repeat(1 << 26), feed, None).expect("a port");
    server.timeouts = Timeouts { request: REQUEST, answer: SHORT, close: SHORT };
    let (port, token) = (server.port, server.token.clone());
    let server = Arc::new(server);
    let request = format!("GET /{token}/ HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n");
    let mut client = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("a connection");
    client.write_all(request.as_bytes()).expect("sent");
    let begun = Instant::now();
    server.answer(server.listener.accept().expect("a connection").0);
    assert!(begun.elapsed() >= SHORT && begun.elapsed() < LONG, "{:?}", begun.elapsed());
}

#[test]
fn news_arrive_while_a_request_waits() {
    let served = Served::new(SHORT);
    let waiting = served.sent(served.request("GET", "news?version=0&scene=0", ""));
    thread::sleep(2 * SHORT);
    served.feed.show_scene("the scene".to_owned(), None);
    let (status, body) = answer_of(waiting);
    assert!(status == 200 && body.contains("the scene"), "{status} {body}");
}

#[test]
fn abandoned_requests_for_news_end() {
    let served = Served::new(REQUEST);
    let request = served.request("GET", "news?version=0&scene=0", "");
    let begun = Instant::now();
    for _ in 0..2 * MAX_CONNECTIONS {
        drop(served.sent(&request));
    }
    assert_eq!(served.status(""), 200);
    assert!(begun.elapsed() < POLL_TIMEOUT / 2, "{:?}", begun.elapsed());
}
