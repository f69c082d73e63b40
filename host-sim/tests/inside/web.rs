use haptic_sim::Laws;

use super::*;

const UPGRADE: &str =
    "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

fn site() -> Site {
    Site { port: 7000, token: "00ff".into(), hello: Arc::new(Value::Null) }
}

fn ask(path: &str, host: &str, more: &str) -> Answer {
    site().answer(format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n").as_bytes())
}

fn from(origin: &str) -> String {
    format!("Origin: {origin}\r\n{UPGRADE}")
}

#[track_caller]
fn refused(answer: Answer, number: &str) {
    assert!(matches!(&answer, Answer::Refused(status) if status.starts_with(number)), "{answer:?} {number}");
}

/// The key of RFC 6455 §1.3 with the answer that stands there.
#[test]
fn this_page_may_talk() {
    let ours = from("http://127.0.0.1:7000");
    let window = |hand| Answer::Window(hand, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=".into());
    assert_eq!(ask("/ws/1/00ff", "127.0.0.1:7000", &ours), window(Some(0)));
    assert_eq!(ask("/ws/2/00ff", "127.0.0.1:7000", &ours), window(Some(1)));
    assert_eq!(ask("/ws/0/00ff", "127.0.0.1:7000", &ours), window(None));
    assert_eq!(ask("/ws/2/00ff", "localhost:7000", &from("http://localhost:7000")), window(Some(1)));
    for name in ["/", "/page.js", "/environments.js", "/page.css"] {
        assert!(matches!(ask(name, "localhost:7000", ""), Answer::File(..)), "{name}");
    }
}

#[test]
fn another_host_is_misdirected() {
    for host in ["rebound.example:7000", "127.0.0.1", "127.0.0.1:7001", "127.0.0.1:7000\r\nHost: rebound.example", ""] {
        refused(ask("/", host, ""), "421");
    }
    refused(site().answer(b"GET / HTTP/1.1\r\n\r\n"), "421");
}

#[test]
fn another_origin_or_token_is_forbidden() {
    for origin in
        ["http://evil.example", "null", "https://127.0.0.1:7000", "http://127.0.0.1:7001", "http://localhost:7000"]
    {
        refused(ask("/ws/2/00ff", "127.0.0.1:7000", &from(origin)), "403");
    }
    refused(ask("/ws/2/00ff", "127.0.0.1:7000", UPGRADE), "403");
    for token in ["", "00fe", "00f", "00ff0", "00FF"] {
        refused(ask(&format!("/ws/2/{token}"), "127.0.0.1:7000", &from("http://127.0.0.1:7000")), "403");
    }
}

#[test]
fn other_names_and_methods_are_refused() {
    for name in ["/../Cargo.toml", "/index.html", "/ws/3/00ff", "/ws/00ff", "/page.js?x", "//"] {
        refused(ask(name, "127.0.0.1:7000", ""), "404");
    }
    for method in ["POST", "HEAD", "OPTIONS", "CONNECT"] {
        let request = format!("{method} / HTTP/1.1\r\nHost: 127.0.0.1:7000\r\n\r\n");
        refused(site().answer(request.as_bytes()), "405");
    }
    refused(ask("/ws/1/00ff", "127.0.0.1:7000", "Origin: http://127.0.0.1:7000\r\n"), "426");
    refused(site().answer(b"\x16\x03\x01\r\n\r\n"), "400");
}

/// A page as it is served, over a real socket, and what is asked of it.
fn served() -> (Site, Arc<Mailbox>, u16) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = listener.local_addr().expect("an address").port();
    let scene = Scene::new(Laws::built_in());
    let mailbox = Arc::new(Mailbox::new(Model::Absent));
    let site = Site::new(&listener, hello(&scene, None, false)).expect("a site");
    site.serve(listener, &mailbox, std::sync::mpsc::sync_channel(1).0).expect("a thread");
    (site, mailbox, port)
}

fn get(port: u16, request: &str) -> String {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    stream.write_all(request.as_bytes()).expect("it hears");
    let mut text = String::new();
    let _ = stream.read_to_string(&mut text);
    text
}

/// Every answer has the headers that keep other pages out, and the page asks for nothing that they would not let through.
#[test]
fn headers_of_every_answer() {
    let (_, _, port) = served();
    for path in ["/", "/page.js", "/environments.js", "/page.css", "/nothing"] {
        let answer = get(port, &format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
        for header in [
            "Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; ",
            "frame-ancestors 'none'",
            "X-Content-Type-Options: nosniff",
            "Referrer-Policy: no-referrer",
            "Cross-Origin-Resource-Policy: same-origin",
            "Cross-Origin-Opener-Policy: same-origin",
            "Cache-Control: no-store",
        ] {
            assert!(answer.contains(header), "{path}: {header}");
        }
        assert!(!answer.contains("unsafe-inline"));
    }
    let [(_, _, html), ..] = FILES;
    for inline in ["<style", " style=", " onclick", "javascript:", "http://", "https://"] {
        assert!(!html.contains(inline), "{inline}");
    }
}

/// Who says too much before it has said what it wants is cut off, and connections are counted.
#[test]
fn sizes_and_connections_are_limited() {
    let (_, _, port) = served();
    let long = format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nX: {}\r\n\r\n", "x".repeat(2 * LONGEST_HEAD));
    assert!(!get(port, &long).starts_with("HTTP/1.1 200"));
    let idle: Vec<_> = (0..MOST).map(|_| TcpStream::connect(("127.0.0.1", port)).expect("it listens")).collect();
    // Once they are all taken, the next one is closed without a word; who takes them stands back behind everything else.
    let one_more = || get(port, &format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
    let refused = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(10));
        one_more().is_empty()
    });
    assert!(refused);
    drop(idle);
}

/// A second window takes the hand of the first, and a window that is closed leaves it to the partner.
#[test]
fn a_hand_is_held_by_the_newest_window() {
    let (site, mailbox, _) = served();
    let open = || {
        let stream = crate::play::measure::connect(&site.address(2)).expect("it is let in");
        WebSocket::from_raw_socket(stream, Role::Client, None)
    };
    let holder = |wanted: Option<u64>| {
        while mailbox.lock().holder[1] != wanted {
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let mut first = open();
    holder(Some(1));
    let mut second = open();
    holder(Some(2));
    let _ = first.send(Message::Binary(vec![0; 16].into()));
    let closed =
        std::iter::from_fn(|| Some(first.read())).take(10).any(|read| matches!(read, Ok(Message::Close(_)) | Err(_)));
    assert!(closed);
    // Where it wants its hand, and what is no place.
    let point = |at: f32| [&[0; 4], &at.to_le_bytes()[..], &0.01_f32.to_le_bytes(), &7_u32.to_le_bytes()].concat();
    for (said, heard) in [(0.05, Some(0.05)), (9.0, Some(FARTHEST_M)), (f32::NAN, None), (f32::INFINITY, None)] {
        second.send(Message::Binary(point(said).into())).expect("it hears");
        let wanted = Some(Pointed { at: heard.map(|along| [along, 0.01]), restarts: 7 });
        while mailbox.lock().pointed[1] != wanted {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    // Silence lets go, and so does the end.
    while mailbox.lock().pointed[1] != Some(LET_GO) {
        std::thread::sleep(Duration::from_millis(5));
    }
    second.close(None).expect("it closes");
    let _ = second.flush();
    holder(None);
}
