//! A window without a browser: what a page says over its socket.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// A window, by the address that its browser would have been given.
pub(super) struct Socket(WebSocket<TcpStream>);

impl Socket {
    /// None where it is refused.
    pub(super) fn open(address: &str) -> Option<Self> {
        let (host, ring) = address.strip_prefix("http://")?.split_once("/#")?;
        let stream = TcpStream::connect(host).expect("it listens");
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
        let mut request = format!("ws://{host}/ws/{ring}").into_client_request().expect("a request");
        request.headers_mut().insert("Origin", format!("http://{host}").parse().expect("an origin"));
        Some(Self(tungstenite::client(request, stream).ok()?.0))
    }

    /// The next text that it is told of this kind.
    pub(super) fn told(&mut self, kind: &str) -> serde_json::Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("it answers") {
                let mut said: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                if !said[kind].is_null() {
                    return said[kind].take();
                }
            }
        }
    }

    pub(super) fn say(&mut self, line: &str) {
        self.0.send(Message::text(line)).expect("it hears");
    }

    /// Says where the hand is wanted, m along the first axis, and waits for the answer.
    pub(super) fn points(&mut self, along: f32) {
        self.asks(u32::MAX, [along, 0.0, 0.0]).expect("it answers");
    }

    /// Asks as a window does, and waits a frame. How the motors of both boards are shown: 0 off, 1 on, 2 not known, 3 on without an operator; and the
    /// newest that it is told of the boards meanwhile.
    pub(super) fn looks(&mut self) -> ([u8; 2], Option<serde_json::Value>) {
        self.question(u32::MAX, [f32::NAN; 3]).expect("it hears");
        let mut boards = None;
        let answer = loop {
            match self.0.read().expect("it answers") {
                Message::Binary(answer) => break answer,
                Message::Text(text) => {
                    let mut said: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                    boards = Some(said["boards"].take()).filter(serde_json::Value::is_array).or(boards);
                }
                _ => {}
            }
        };
        std::thread::sleep(Duration::from_micros(16_667));
        ([answer[12], answer[13]], boards)
    }

    /// Asks for what came since, 60 times a second as a window that looks on does, until the program ends.
    pub(super) fn looks_on(mut self) {
        let (mut next, mut seen) = (u32::MAX, 0);
        while let Ok(answer) = self.asks(next, [f32::NAN; 3]) {
            let asked = Instant::now();
            let first = u32::from_le_bytes(answer[..4].try_into().expect("four bytes"));
            seen += 1;
            std::thread::sleep(Duration::from_micros(16_667));
            // A tick is a millisecond.
            next = first.wrapping_add(asked.elapsed().as_millis() as u32);
        }
        assert!(seen > 100, "it looked on {seen} times");
    }

    fn question(&mut self, next: u32, hand: [f32; 3]) -> Result<(), tungstenite::Error> {
        let question = [&next.to_le_bytes()[..], &hand.map(f32::to_le_bytes).concat(), &0_u32.to_le_bytes()].concat();
        self.0.send(Message::Binary(question.into()))
    }

    fn asks(&mut self, next: u32, hand: [f32; 3]) -> Result<Vec<u8>, tungstenite::Error> {
        self.question(next, hand)?;
        loop {
            if let Message::Binary(answer) = self.0.read()? {
                return Ok(answer.to_vec());
            }
        }
    }
}
