//! STUN at a meeting place (RFC 8489): whoever asks is told the address that he is seen at, if that makes nothing larger.
//!
//! A binding response has 32 bytes (IPv4) or 44 (IPv6) and a bare request 20. Anybody can write another's address on a request, so a request is
//! answered only if it is at least as long as its answer; a client pads it, for example with SOFTWARE.

use std::net::{IpAddr, SocketAddr};

const COOKIE: [u8; 4] = [0x21, 0x12, 0xA4, 0x42];
const HEADER: usize = 20;
const REQUEST: [u8; 2] = [0, 1];
const RESPONSE: [u8; 2] = [1, 1];
const XOR_MAPPED_ADDRESS: [u8; 2] = [0, 0x20];

/// Whether a datagram is a message of STUN: its cookie and its length are right.
pub fn is_message(datagram: &[u8]) -> bool {
    let length = datagram.get(2..4).map(|length| usize::from(u16::from_be_bytes([length[0], length[1]])));
    datagram.get(4..8) == Some(&COOKIE[..])
        && length == datagram.len().checked_sub(HEADER)
        && datagram.len().is_multiple_of(4)
}

/// The 96 bits by which a response belongs to a request.
pub fn transaction(message: &[u8]) -> Option<[u8; 12]> {
    message.get(8..HEADER)?.first_chunk().copied()
}

/// Whether a message is a successful response.
pub fn is_response(message: &[u8]) -> bool {
    message.starts_with(&RESPONSE)
}

/// The answer to a binding request from there, if it is one and long enough.
pub fn answer(from: SocketAddr, datagram: &[u8]) -> Option<Vec<u8>> {
    let asks = is_message(datagram) && datagram.starts_with(&REQUEST);
    let transaction = transaction(datagram).filter(|_| asks)?;
    let (family, ip) = match from.ip() {
        IpAddr::V4(ip) => (1, ip.octets().to_vec()),
        IpAddr::V6(ip) => (2, ip.octets().to_vec()),
    };
    let veil = || COOKIE.into_iter().chain(transaction);
    let port = from.port().to_be_bytes();
    let veiled = |bytes: &[u8]| bytes.iter().zip(veil()).map(|(byte, veil)| byte ^ veil).collect::<Vec<u8>>();
    let value = [&[0, family][..], &veiled(&port), &veiled(&ip)].concat();
    let sized = |length: usize| (length as u16).to_be_bytes();
    let (whole, own) = (sized(value.len() + 4), sized(value.len()));
    let answer = [&RESPONSE[..], &whole, &COOKIE, &transaction, &XOR_MAPPED_ADDRESS, &own, &value].concat();
    (answer.len() <= datagram.len()).then_some(answer)
}
