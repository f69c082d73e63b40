//! Two links that can be made to do anything, shared by the targets `link` and `session`.

use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::wire::{MAX_DATAGRAM, PeerId};

/// One end of a pair: peer 1 or peer 2, in its n-th life.
pub(super) fn link(local: u8, life: u8) -> Link {
    let mut entropy = [local; Key::LEN];
    entropy[0] = life;
    let ends = Ends { local: PeerId(local), remote: PeerId(3 - local) };
    let config =
        Config { key: Key::new([7; Key::LEN]), ends, packet_period_us: 8_000, parameters: Parameters::new(), entropy };
    Link::new(config).expect("a sound configuration")
}

/// A pair that has joined.
pub(super) fn joined() -> [Link; 2] {
    let mut links = [link(1, 1), link(2, 1)];
    let mut out = [0; MAX_DATAGRAM];
    for now in [0, 1_000, 2_000, 3_000, 4_000] {
        for from in [0, 1] {
            while let Some(len) = links[from].poll(now, &mut out) {
                let _ = links[1 - from].receive(now, &mut out[..len]);
            }
        }
    }
    links
}
