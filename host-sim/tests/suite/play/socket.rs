//! A window without a browser: what a page says over its socket.

use std::net::TcpStream;
use std::time::Duration;

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
        let place = [along, 0.0, 0.0].map(f32::to_le_bytes).concat();
        let question = [&u32::MAX.to_le_bytes()[..], &place, &0_u32.to_le_bytes()].concat();
        self.0.send(Message::Binary(question.into())).expect("it hears");
        while !self.0.read().expect("it answers").is_binary() {}
    }
}
