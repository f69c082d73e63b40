//! Any bytes as a message, a greeting and a sealed datagram: no panic, and what is read has one encoding only.

use cohold_protocol::wire::{Greeting, Header, MAX_MESSAGE, Message};

/// Runs one fuzz input through the message, greeting and datagram parsers.
pub(super) fn run(bytes: &[u8]) {
    if let Ok(message) = Message::parse(bytes) {
        let mut out = [0; MAX_MESSAGE];
        let len = message.emit(&mut out).expect("what was read can be written");
        assert_eq!(&out[..len], bytes);
    }
    if let Ok((greeting, body, _)) = Greeting::parse(bytes) {
        let mut out = [0; Greeting::LEN];
        assert_eq!(greeting.emit(&mut out), Ok(Greeting::LEN));
        assert_eq!(out, body);
    }
    if let Ok((header, head, sealed)) = Header::parse(&mut bytes.to_vec()) {
        let mut out = [0; Header::LEN];
        assert_eq!(header.emit(&mut out), Ok(Header::LEN));
        assert_eq!(&out, head);
        assert_eq!(sealed.len(), bytes.len() - Header::LEN);
    }
}
