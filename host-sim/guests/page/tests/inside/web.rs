use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::mpsc::Receiver;

use super::super::connections::MOST_WITHOUT_KEY;
use super::super::environment::Command;
use super::super::messages::FARTHEST_M;
use super::*;

const UPGRADE: &str =
    "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

fn site() -> &'static Site {
    static SITE: std::sync::OnceLock<Site> = std::sync::OnceLock::new();
    let lan = SocketAddrV4::new(Ipv4Addr::new(192, 168, 7, 1), 7001);
    SITE.get_or_init(|| Site::new(Doors { here: 7000, lan: Some(lan) }, Value::Null).expect("keys"))
}

/// Where a window with these roles connects.
fn at(roles: &[Role]) -> String {
    format!("/ws/{}", site().keys.ring(roles))
}

fn ask(path: &str, host: &str, more: &str) -> Answer {
    ask_by(Way::Here, path, host, more)
}

fn ask_by(way: Way, path: &str, host: &str, more: &str) -> Answer {
    site().answer(way, format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{more}\r\n").as_bytes())
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
    let window = |hand, operates| Answer::Window(Rights { hand, operates }, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=".into());
    assert_eq!(ask(&at(&[Role::Hand1]), "127.0.0.1:7000", &ours), window(Some(0), false));
    assert_eq!(ask(&at(&[Role::Operator]), "127.0.0.1:7000", &ours), window(None, true));
    assert_eq!(ask(&at(&[Role::Watch]), "127.0.0.1:7000", &ours), window(None, false));
    let elsewhere = from("http://localhost:7000");
    assert_eq!(ask(&at(&[Role::Hand2, Role::Operator]), "localhost:7000", &elsewhere), window(Some(1), true));
    for name in ["/", "/page.js", "/environments.js", "/page.css"] {
        assert!(matches!(ask(name, "localhost:7000", ""), Answer::File(..)), "{name}");
    }
}

/// From the local network hands and onlookers come in, and nobody who operates, whatever else is on the ring; and the page's host and origin
/// are exactly what the request came to.
#[test]
fn the_network_opens_hands_and_watching_at_its_own_address_only() {
    const LAN: &str = "192.168.7.1:7001";
    let ours = from(&format!("http://{LAN}"));
    for (role, hand) in [(Role::Hand1, Some(0)), (Role::Hand2, Some(1)), (Role::Watch, None)] {
        let rights = Rights { hand, operates: false };
        let answer = ask_by(Way::Lan, &at(&[role]), LAN, &ours);
        assert!(matches!(&answer, Answer::Window(opened, _) if *opened == rights), "{answer:?}");
        refused(ask_by(Way::Lan, &at(&[role, Role::Operator]), LAN, &ours), "403");
    }
    refused(ask_by(Way::Lan, &at(&[Role::Operator]), LAN, &ours), "403");
    assert!(matches!(ask_by(Way::Lan, "/", LAN, ""), Answer::File(..)));
    for host in [
        "127.0.0.1:7000",
        "localhost:7000",
        "localhost:7001",
        "192.168.7.1",
        "192.168.7.1:7000",
        "rebound.example:7001",
    ] {
        refused(ask_by(Way::Lan, "/", host, ""), "421");
        refused(ask_by(Way::Lan, &at(&[Role::Hand2]), host, &from(&format!("http://{host}"))), "421");
    }
    refused(ask(&at(&[Role::Hand2]), LAN, &ours), "421");
    for origin in ["http://127.0.0.1:7000", "http://rebound.example:7001", "https://192.168.7.1:7001", "null"] {
        refused(ask_by(Way::Lan, &at(&[Role::Hand2]), LAN, &from(origin)), "403");
    }
}

#[test]
fn another_host_is_misdirected() {
    for host in ["rebound.example:7000", "127.0.0.1", "127.0.0.1:7001", "127.0.0.1:7000\r\nHost: rebound.example", ""] {
        refused(ask("/", host, ""), "421");
    }
    refused(site().answer(Way::Here, b"GET / HTTP/1.1\r\n\r\n"), "421");
}

#[test]
fn another_origin_or_key_is_forbidden() {
    for origin in
        ["http://evil.example", "null", "https://127.0.0.1:7000", "http://127.0.0.1:7001", "http://localhost:7000"]
    {
        refused(ask(&at(&[Role::Hand2]), "127.0.0.1:7000", &from(origin)), "403");
    }
    refused(ask(&at(&[Role::Hand2]), "127.0.0.1:7000", UPGRADE), "403");
    let ours = from("http://127.0.0.1:7000");
    let watch = at(&[Role::Watch]);
    for other in ["hand1", "hand2", "operator"] {
        refused(ask(&watch.replace("watch", other), "127.0.0.1:7000", &ours), "403");
    }
    for ring in ["", "watch", "watch-", "operator-00ff", "hand1-00ff+"] {
        refused(ask(&format!("/ws/{ring}"), "127.0.0.1:7000", &ours), "403");
    }
    for changed in [format!("{watch}0"), watch[..watch.len() - 1].to_owned(), format!("{watch}+")] {
        refused(ask(&changed, "127.0.0.1:7000", &ours), "403");
    }
}

#[test]
fn other_names_and_methods_are_refused() {
    for name in ["/../Cargo.toml", "/index.html", "/ws", "/page.js?x", "//"] {
        refused(ask(name, "127.0.0.1:7000", ""), "404");
    }
    for method in ["POST", "HEAD", "OPTIONS", "CONNECT"] {
        let request = format!("{method} / HTTP/1.1\r\nHost: 127.0.0.1:7000\r\n\r\n");
        refused(site().answer(Way::Here, request.as_bytes()), "405");
    }
    refused(ask(&at(&[Role::Hand1]), "127.0.0.1:7000", "Origin: http://127.0.0.1:7000\r\n"), "426");
    refused(site().answer(Way::Here, b"\x16\x03\x01\r\n\r\n"), "400");
}

/// A page as it is served, over a real socket.
struct Served {
    site: Site,
    mailbox: Arc<Mailbox>,
    port: u16,
    /// What is asked of the judge.
    asked: Receiver<Ask>,
}

fn served() -> Served {
    // On a test's machine the local network is this machine, too.
    let (doors, listeners) = Doors::open(0, Some(Ipv4Addr::LOCALHOST)).expect("two ports");
    let port = doors.here;
    let scene = Scene::new(cohold_sim::Laws::built_in());
    let mailbox = Arc::new(Mailbox::new(Model::Absent));
    let mut site = Site::new(doors, hello(Kinds::default(), &scene, None, false)).expect("a site");
    site.offer(Role::Hand2).expect("a code").expect("a way in");
    let (asks, asked) = std::sync::mpsc::sync_channel(16);
    site.serve(listeners, &mailbox, asks).expect("a thread");
    Served { site, mailbox, port, asked }
}

impl Served {
    fn open(&self, roles: &[Role]) -> WebSocket<TcpStream> {
        self.open_by(Way::Here, roles).expect("it is let in")
    }

    fn open_by(&self, way: Way, roles: &[Role]) -> Result<WebSocket<TcpStream>, cohold_cli::Failure> {
        let stream = crate::measure::connect(&self.site.address_by(way, roles).expect("a way in"))?;
        Ok(WebSocket::from_raw_socket(stream, Side::Client, None))
    }
}

/// A question that says where the hand is wanted, along, m.
fn holds_at(along: f32) -> Message {
    let words = [along, 0.0, 0.0].map(f32::to_le_bytes);
    Message::Binary([&[0; 4], &words.concat()[..], &0_u32.to_le_bytes()].concat().into())
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
    let Served { port, .. } = served();
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
    let [(_, _, html), ..] = FILES else { panic!("there is a page") };
    for inline in ["<style", " style=", " onclick", "javascript:", "http://", "https://"] {
        assert!(!html.contains(inline), "{inline}");
    }
}

/// Who says too much before it has said what it wants is cut off.
#[test]
fn sizes_are_limited() {
    let Served { port, .. } = served();
    let long = format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nX: {}\r\n\r\n", "x".repeat(2 * LONGEST_HEAD));
    assert!(!get(port, &long).starts_with("HTTP/1.1 200"));
}

/// However many say nothing, whoever asks is answered, and with a key gets a window; those who say nothing are bounded.
#[test]
fn silent_connections_lock_nobody_out() {
    let served = served();
    let port = served.port;
    let mut idle = Vec::new();
    // The operator's window was here before them, and is not turned out.
    let mut first = served.open(&[Role::Operator]);
    for _ in 0..5 {
        idle.extend((0..40).map(|_| TcpStream::connect(("127.0.0.1", port)).expect("it listens")));
        let page = get(port, &format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n"));
        assert!(page.starts_with("HTTP/1.1 200"), "{} are silent: {page:?}", idle.len());
        // Those who have watched longest in silence go for the newest.
        for _ in 0..10 {
            idle.push(served.open(&[Role::Watch]).get_ref().try_clone().expect("a socket"));
        }
        served.open(&[Role::Hand1]);
    }
    first.send(Message::text("stop")).expect("it hears");
    while served.mailbox.lock().next_command() != Some(Command::Stop) {
        std::thread::sleep(Duration::from_millis(1));
    }
    // What is kept of them is bounded: all but the last are closed.
    idle.truncate(200 - MOST_WITHOUT_KEY);
    for mut stream in idle {
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
        let mut greeting = Vec::new();
        stream.read_to_end(&mut greeting).expect("it is closed");
    }
}

/// What a visitor's phone can do, at the level of its socket: hold its hand, and stop; and who only watches there, nothing. Every other order
/// is refused by the program, and the operator's address opens no window there at all.
#[test]
fn a_phone_on_the_network_holds_one_hand_and_an_onlooker_nothing() {
    let served = served();
    for roles in [&[Role::Operator][..], &[Role::Hand2, Role::Operator], &[Role::Watch, Role::Operator]] {
        assert!(served.open_by(Way::Lan, roles).is_err(), "{roles:?}");
    }
    let lines = [
        "cut",
        "join",
        "start",
        "partner absent",
        "set network.loss=0.9",
        "show squash",
        "scene default",
        "board 1 arm",
    ];
    for (role, also) in [(Role::Hand2, &[][..]), (Role::Watch, &["stop"])] {
        let mut window = served.open_by(Way::Lan, &[role]).expect("it is let in");
        for line in lines.iter().chain(also) {
            window.send(Message::text(*line)).expect("it hears");
            window.send(holds_at(0.03)).expect("it hears");
            let said = std::iter::from_fn(|| window.read().ok()).take(20);
            let refused =
                said.filter_map(|said| said.to_text().ok().map(|text| text.contains("refused"))).any(|refused| refused);
            assert!(refused, "{role:?} {line}");
        }
        let mut contents = served.mailbox.lock();
        // The partner of the start is what lay there before.
        while let Some(command) = contents.next_command() {
            assert_eq!(command, Command::Partner(Model::Absent), "{role:?}");
        }
        assert!(served.asked.try_recv().is_err() && !contents.operator_asked, "{role:?}");
        assert_eq!(contents.holder[0], None, "the other hand is not his");
        assert_eq!(contents.holder[1].is_some(), role == Role::Hand2);
    }
    let mut hand = served.open_by(Way::Lan, &[Role::Hand2]).expect("it is let in");
    hand.send(Message::text("stop")).expect("it hears");
    while served.mailbox.lock().next_command() != Some(Command::Stop) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A phone that turns its screen off, or loses the network, says nothing more: its hand has let go a quarter of a second later. What it says
/// when it is there again holds again, over the same line or over a new one, though the old one was never closed.
#[test]
fn a_phone_that_falls_silent_lets_go_and_comes_back() {
    let served = served();
    let at = |along: Option<f32>| {
        let start = Instant::now();
        while served.mailbox.lock().pointed[1].map(|pointed| pointed.at) != Some(along.map(|along| [along, 0.0, 0.0])) {
            assert!(start.elapsed() < Duration::from_secs(20), "{:?}", served.mailbox.lock().pointed);
            std::thread::sleep(Duration::from_millis(1));
        }
        start.elapsed()
    };
    let mut phone = served.open_by(Way::Lan, &[Role::Hand2]).expect("it is let in");
    for along in [0.05, 0.06] {
        phone.send(holds_at(along)).expect("it hears");
        at(Some(along));
        let silent = at(None);
        assert!(silent > SILENCE / 2 && silent < SILENCE + Duration::from_millis(500), "{silent:?}");
    }
    let mut again = served.open_by(Way::Lan, &[Role::Hand2]).expect("it is let in");
    again.send(holds_at(0.07)).expect("it hears");
    at(Some(0.07));
    let left = std::iter::from_fn(|| Some(phone.read())).take(20).find_map(|said| match said {
        Ok(Message::Close(why)) => Some(why.map(|why| u16::from(why.code))),
        Err(_) => Some(None),
        Ok(_) => None,
    });
    assert_eq!(left, Some(Some(TAKEN)), "the line before is told why it is closed");
    served.mailbox.lock().over = true;
    let _ = again.send(holds_at(0.07));
    let over = std::iter::from_fn(|| again.read().ok()).find_map(|said| match said {
        Message::Close(why) => why.map(|why| u16::from(why.code)),
        _ => None,
    });
    assert_eq!(over, Some(OVER));
}

/// Who asks for everything again and again is sent no sample twice.
#[test]
fn a_question_brings_about_no_more_than_what_came_since() {
    let served = served();
    let mut contents = served.mailbox.lock();
    (0..500).for_each(|_| contents.put([0.5; super::super::environment::MOST]));
    drop(contents);
    let mut window = served.open_by(Way::Lan, &[Role::Watch]).expect("it is let in");
    let mut lengths = Vec::new();
    while lengths.len() < 5 {
        window.send(Message::Binary(vec![0xff; 20].into())).expect("it hears");
        if let Message::Binary(bytes) =
            std::iter::from_fn(|| window.read().ok()).find(Message::is_binary).expect("an answer")
        {
            lengths.push(bytes.len());
        }
    }
    assert!(lengths[0] > 500 * 4 && lengths[1..].iter().all(|length| *length == HEADER), "{lengths:?}");
}

/// However quickly an onlooker orders, the control loop and others' windows find the mailbox free: it is heard 250 times a second.
#[test]
fn who_orders_without_end_is_heard_every_4_ms() {
    let served = served();
    let mut window = served.open_by(Way::Lan, &[Role::Watch]).expect("it is let in");
    let start = Instant::now();
    (0..50).for_each(|_| window.send(Message::text("cut")).expect("it hears"));
    (0..50).for_each(|_| window.send(Message::Ping(Vec::new().into())).expect("it hears"));
    window.send(Message::Binary(vec![0xff; 20].into())).expect("it hears");
    assert!(std::iter::from_fn(|| window.read().ok()).any(|said| said.is_binary()));
    assert!(start.elapsed() >= 100 * SOONEST, "{:?}", start.elapsed());
}

/// The operator's windows are told the address of the hand on the network, with its code; nobody else is told any key.
#[test]
fn only_the_operator_is_told_the_address_on_the_network() {
    let served = served();
    let (address, key) =
        (served.site.address_by(Way::Lan, &[Role::Hand2]).expect("a way in"), served.site.keys.ring(&[Role::Hand2]));
    for (way, roles) in [
        (Way::Here, &[Role::Operator][..]),
        (Way::Here, &[Role::Hand1]),
        (Way::Lan, &[Role::Watch]),
        (Way::Lan, &[Role::Hand1]),
    ] {
        let mut window = served.open_by(way, roles).expect("it is let in");
        window.send(Message::Binary(vec![0xff; 20].into())).expect("it hears");
        let said: Vec<String> = std::iter::from_fn(|| window.read().ok())
            .take_while(|said| !said.is_binary())
            .filter_map(|said| Some(said.to_text().ok()?.to_owned()))
            .collect();
        let tells = said.iter().find(|text| text.contains(&key));
        assert_eq!(tells.is_some(), roles == [Role::Operator], "{roles:?}");
        if let Some(text) = tells {
            let join: Value = serde_json::from_str(text).expect("a message");
            assert_eq!((join["join"]["address"].as_str(), join["join"]["hand"].as_u64()), (Some(&*address), Some(2)));
            assert!(join["join"]["path"].as_str().is_some_and(|path| path.starts_with("M4 4h7v1h-7z")), "{text}");
        }
    }
}

/// What each role's window says acts only where its key opens that; everything else is refused, and named.
#[test]
fn orders_are_checked_by_the_window_that_gives_them() {
    let served = served();
    for line in
        ["start", "cut", "join", "partner carries-on", "board 1 arm", "board 2 check 1", "set a=1", "anyway set a=1"]
    {
        for roles in [&[Role::Watch][..], &[Role::Hand1], &[Role::Hand2]] {
            let mut window = served.open(roles);
            while served.mailbox.lock().next_command().is_some() {}
            window.send(Message::text(line)).expect("it hears");
            window.send(Message::Binary(vec![0xff; 20].into())).expect("it hears");
            let refused = std::iter::from_fn(|| window.read().ok())
                .find_map(|said| said.to_text().ok().filter(|text| text.contains("refused")).map(str::to_owned));
            assert_eq!(
                refused.as_deref(),
                Some(r#"{"refused":"only the operator's address may order that"}"#),
                "{line}"
            );
            assert_eq!(served.mailbox.lock().next_command(), None, "{roles:?} {line}");
            assert!(!served.mailbox.lock().operator_asked, "{roles:?}");
            assert!(served.asked.try_recv().is_err(), "{roles:?} {line}");
        }
    }
    // Nobody points a hand but who holds it.
    let mut watching = served.open(&[Role::Watch]);
    watching.send(Message::Binary(vec![0; 20].into())).expect("it hears");
    while !matches!(watching.read(), Ok(Message::Binary(_))) {}
    assert_eq!(served.mailbox.lock().holder, [None; 2]);
    // The operator's acts.
    let mut operator = served.open(&[Role::Operator]);
    operator.send(Message::text("cut")).expect("it hears");
    while served.mailbox.lock().next_command() != Some(Command::Cut(true)) {
        std::thread::sleep(Duration::from_millis(1));
    }
    operator.send(Message::text("set a=1")).expect("it hears");
    assert_eq!(served.asked.recv_timeout(Duration::from_secs(20)).expect("an order").line, "set a=1");
    operator.send(Message::Binary(vec![0; 20].into())).expect("it hears");
    while !served.mailbox.lock().operator_asked {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A second window takes the hand of the first, and a window that is closed leaves it to the partner.
#[test]
fn a_hand_is_held_by_the_newest_window() {
    let served = served();
    let (mailbox, open) = (&served.mailbox, || served.open(&[Role::Hand2]));
    let holder = |wanted: Option<u64>| {
        while mailbox.lock().holder[1] != wanted {
            std::thread::sleep(Duration::from_millis(5));
        }
    };
    let mut first = open();
    holder(Some(1));
    let mut second = open();
    holder(Some(2));
    let _ = first.send(Message::Binary(vec![0; 20].into()));
    let closed =
        std::iter::from_fn(|| Some(first.read())).take(10).any(|read| matches!(read, Ok(Message::Close(_)) | Err(_)));
    assert!(closed);
    // Where it wants its hand, and what is no place.
    let point = |at: f32| {
        [&[0; 4], &at.to_le_bytes()[..], &0.01_f32.to_le_bytes(), &0.02_f32.to_le_bytes(), &7_u32.to_le_bytes()]
            .concat()
    };
    for (said, heard) in [(0.05, Some(0.05)), (9.0, Some(FARTHEST_M)), (f32::NAN, None), (f32::INFINITY, None)] {
        second.send(Message::Binary(point(said).into())).expect("it hears");
        let wanted = Some(Pointed { at: heard.map(|along| [along, 0.01, 0.02]), restarts: 7 });
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
