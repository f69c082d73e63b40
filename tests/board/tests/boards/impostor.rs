//! A peer 2 that holds the peers' key, joins as any other, and then says what no link would: by a second implementation of the format.

use board_bench::bench::Bench;
use board_bench::pc::{board_ip, board_mac, peers_key, resolved, udp};

use format::{GREETING, Session, hello};

#[allow(dead_code)] // The protocol's own tests use more of it.
#[path = "../../../../protocol/tests/suite/protocol/format.rs"]
mod format;

/// Its ephemeral secret.
const SECRET: [u8; 32] = [9; 32];
/// Port of the flow, at both ends.
const FLOW: u16 = 7701;
/// Where peer 2 is on the wire.
const PORT: usize = 1;

/// The peer.
#[derive(Default)]
pub struct Impostor {
    /// The board's greeting that the session is made with, and the session.
    joined: Option<(Vec<u8>, Session)>,
    /// The newest time of the board's clock that it has opened, to echo.
    echo_us: u64,
    /// Sealed datagrams that it has sent.
    pub sent: u64,
    /// Hellos that came since it sent the fourth of them: the second, which has a time of the board's to echo, is to end them, but
    /// for what is under way until it arrives.
    pub called: u64,
}

impl Impostor {
    /// Answers what board 1 asks: where it is, and hellos. Those that waited for the first answer may be of another life.
    pub fn tick(&mut self, bench: &mut Bench) {
        let now_ns = bench.now_ns();
        for frame in bench.wire.receive(PORT, now_ns) {
            if let Some(answer) = resolved(&frame, board_mac(2), board_ip(2)) {
                bench.wire.send(PORT, now_ns, &answer);
            }
            let Some(heard) = flow(&frame) else { continue };
            if let Some(([at_us, _], _)) = self.joined.as_ref().and_then(|(_, session)| session.open(heard)) {
                self.echo_us = at_us;
            }
            if heard.len() != GREETING || heard[1] != 1 {
                continue;
            }
            self.called += u64::from(self.sent > 3);
            // The same ephemeral: the same session.
            if self.joined.as_ref().is_none_or(|(joined, _)| joined[48..80] != heard[48..80]) {
                let hello = hello(peers_key().bytes(), heard, SECRET);
                self.joined = Some((heard.to_vec(), Session::of(peers_key().bytes(), heard, &hello, SECRET)));
                say(bench, &hello);
            }
        }
    }

    /// Says any bytes under the session's keys; false while there is no session.
    pub fn seal(&mut self, bench: &mut Bench, message: &[u8]) -> bool {
        let Some((_, session)) = &self.joined else { return false };
        say(bench, &session.seal(2, 1, self.sent, [1 + self.sent, self.echo_us], message));
        self.sent += 1;
        true
    }
}

/// What a frame brings for the flow of peer 2.
fn flow(frame: &[u8]) -> Option<&[u8]> {
    let ours =
        frame.get(..6)? == board_mac(2) && frame.get(12..14)? == [0x08, 0x00] && frame.get(30..34)? == board_ip(2);
    let length = usize::from(u16::from_be_bytes([*frame.get(38)?, *frame.get(39)?]));
    (ours && frame.get(36..38)? == FLOW.to_be_bytes()).then(|| frame.get(42..34 + length))?
}

fn say(bench: &mut Bench, datagram: &[u8]) {
    let end = |number| (board_mac(number), board_ip(number), FLOW);
    let now_ns = bench.now_ns();
    bench.wire.send(PORT, now_ns, &udp(end(2), end(1), datagram));
}
