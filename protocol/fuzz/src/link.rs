//! Any datagrams to a link in a session: none is taken, and the session is as it was.

use cohold_protocol::wire::{Flow, MAX_DATAGRAM, VERSION};

use super::pair;

/// Runs one fuzz input, a series of datagrams, against a link in session.
pub(super) fn run(bytes: &[u8]) {
    let [mut one, mut two] = pair::joined();
    let mut out = [0; MAX_DATAGRAM];
    let mut rest = bytes;
    // Each datagram: how it is dressed, its length, its bytes.
    while let [dress, len, tail @ ..] = rest {
        let (datagram, tail) = tail.split_at(usize::from(*len).min(tail.len()));
        let mut datagram = datagram.to_vec();
        rest = tail;
        match dress % 4 {
            0 => {}
            1 => datagram.splice(..0, [VERSION, 3, 2, 1]).for_each(drop),
            2 => datagram.splice(..0, [VERSION, 1, 2, 1]).for_each(drop),
            _ => {
                // A true datagram with the given bytes laid over it: nothing, or an alteration.
                let len = two.send(5_000, Flow::default(), &mut out).expect("a session");
                let original = out[..len].to_vec();
                let mut altered = original.clone();
                for (byte, with) in altered.iter_mut().zip(&datagram) {
                    *byte ^= with;
                }
                let taken = one.receive(5_000, &mut altered.clone()).is_ok();
                assert_eq!(taken, altered == original);
                continue;
            }
        }
        assert!(one.receive(5_000, &mut datagram).is_err());
    }
    let len = two.send(6_000, Flow::default(), &mut out).expect("a session");
    assert!(matches!(one.receive(6_000, &mut out[..len]), Ok(Some(_))));
}
