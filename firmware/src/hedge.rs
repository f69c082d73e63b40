//! Hedge: random bytes that do not repeat themselves though the source of noise does.
//!
//! What the links draw their ephemerals and challenges from is a hash, under a secret of the board's ([`crate::keys::Keys::seed`]),
//! of the noise and of all that is different from draw to draw: which board, which start, which draw of that start, and when. So
//! a source that gives the same at every start gives other bytes all the same, which who does not hold both of its keys cannot
//! foresee. One that works is as good as without this.

use cohold_protocol::key::Key;

/// What random bytes are made from.
#[derive(Clone, Copy, Debug)]
pub struct Sources {
    /// What the source of noise gave.
    pub noise: [u8; 32],
    /// The board's number; with the keys it tells boards apart.
    pub board: u8,
    /// Number of the start ([`crate::boots`]).
    pub boot: u32,
    /// Number of the draw in this start.
    pub draw: u32,
    /// Since the start, µs.
    pub uptime_us: u64,
}

impl Sources {
    /// 32 bytes for a link's configuration.
    pub fn mixed(&self, seed: &Key) -> [u8; Key::LEN] {
        let [boot, draw] = [self.boot, self.draw].map(u32::to_le_bytes);
        let parts = [&self.noise[..], &[self.board], &boot, &draw, &self.uptime_us.to_le_bytes()];
        seed.hedged(&parts)
    }
}
