//! Roam: which servers a client needs where it is, and when it moves from one to the next.
//!
//! A client is at home at one server. As soon as it comes within the margin of another region it opens a link there too and
//! downloads what is around it; it moves once it is in that region and the download is complete, and lets the old server go
//! when it leaves that one's margin. So at any time it holds what is around it, and what lies on the border it holds twice
//! under the same id.

use heapless::Vec;

use crate::records::{MAX_REGIONS, Region};

/// Where a client is at home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Roam {
    home: u8,
    moves: u32,
}

impl Roam {
    /// At home at the server with this number.
    pub fn new(home: u8) -> Self {
        Self { home, moves: 0 }
    }

    /// The server that the client is at home at.
    pub fn home(&self) -> u8 {
        self.home
    }

    /// How often it has moved.
    pub fn moves(&self) -> u32 {
        self.moves
    }

    /// The servers that a client at `position` (m) needs: its home, and every one within whose margin it is.
    pub fn needs<'a>(
        &self,
        regions: impl IntoIterator<Item = &'a Region>,
        margin_m: f32,
        position: [f32; 2],
    ) -> Vec<u8, MAX_REGIONS> {
        let mut needed = Vec::new();
        // There is room for a server for each region but home, which is one of them or the only one.
        let _ = needed.push(self.home);
        for region in regions {
            let near = region.with_margin(margin_m).within(position, 0.0);
            if near && !needed.contains(&region.server) {
                let _ = needed.push(region.server);
            }
        }
        needed
    }

    /// Moves home to the server of the region at `position` (m) if that one is `ready`: its download is complete.
    /// Gives the server that was left.
    pub fn update<'a>(
        &mut self,
        regions: impl IntoIterator<Item = &'a Region>,
        position: [f32; 2],
        ready: impl FnOnce(u8) -> bool,
    ) -> Option<u8> {
        let mut here = regions.into_iter().filter(|region| region.holds(position)).map(|region| region.server);
        let server = here.next().filter(|server| *server != self.home)?;
        if !ready(server) {
            return None;
        }
        self.moves = self.moves.saturating_add(1);
        Some(core::mem::replace(&mut self.home, server))
    }
}
