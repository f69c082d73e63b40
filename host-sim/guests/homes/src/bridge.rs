//! The bridge: what passes between a board and the carrier of the PC beside it. The board sees one partner, the PC; nothing changes on it.
//!
//! It opens nothing: a sealed datagram goes on as it came, byte for byte, one for one. So whoever is here can drop and delay, and the two ends judge all else themselves.
//!
//! **From the board** goes what comes from its one address, port included, is of the sealed wire by its first byte, and is no longer than the wire's longest.
//! **To the board** goes the same of what the carrier has, while the board has said something itself within `CONSENT`: a wrong address is not written to.
//! **Either way** passes what a seat of a meeting place passes on ([`RATE`](crate::place::RATE)). What does not pass is counted by why.

use std::net::SocketAddr;
use std::time::Instant;

use cohold_protocol::wire::MAX_DATAGRAM;
use serde::Serialize;

use crate::allowance::{Allowance, BURST, passes};
use crate::frame::Frame;
use crate::ice::CONSENT;

/// What a bridge has done so far, datagrams each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Of the board's, handed to the carrier.
    pub from_board: u64,
    /// Of the far end's, handed to the board.
    pub to_board: u64,
    /// From another address than the board's.
    pub strangers: u64,
    /// Of another kind than the sealed wire.
    pub other_kinds: u64,
    /// Longer than the wire's longest.
    pub too_long: u64,
    /// More than may pass in that time.
    pub over_rate: u64,
    /// For a board that says nothing.
    pub unasked: u64,
    /// How often the board was there after it was not.
    pub arrivals: u64,
}

/// Between a board and a carrier.
#[derive(Debug)]
pub struct Bridge {
    board: SocketAddr,
    /// When the board said something last.
    spoke: Option<Instant>,
    there: bool,
    /// From the board, and to it.
    allowances: [Allowance; 2],
    /// What it has done.
    pub counts: Counts,
}

impl Bridge {
    /// To the board at this address.
    pub fn new(board: SocketAddr, now: Instant) -> Self {
        let (allowances, counts) = ([Allowance::new(BURST, now); 2], Counts::default());
        Self { board, spoke: None, there: false, allowances, counts }
    }

    /// The board's address.
    pub fn board(&self) -> SocketAddr {
        self.board
    }

    /// Takes a datagram from the board's network; whether it is for the far end.
    pub fn hear_board(&mut self, now: Instant, from: SocketAddr, datagram: &[u8]) -> bool {
        if from != self.board {
            self.counts.strangers += 1;
            return false;
        }
        let passes = self.passes(now, 0, datagram);
        if passes {
            self.spoke = Some(now);
            self.counts.from_board += 1;
        }
        passes
    }

    /// Takes what the carrier has for the link; whether it goes to the board.
    pub fn hear_far(&mut self, now: Instant, datagram: &[u8]) -> bool {
        if !self.is_there(now) {
            self.counts.unasked += 1;
            return false;
        }
        let passes = self.passes(now, 1, datagram);
        self.counts.to_board += u64::from(passes);
        passes
    }

    fn passes(&mut self, now: Instant, way: usize, datagram: &[u8]) -> bool {
        let stopped = match () {
            () if Frame::of(datagram) != Frame::Sealed => &mut self.counts.other_kinds,
            () if datagram.len() > MAX_DATAGRAM => &mut self.counts.too_long,
            () if !passes(&mut self.allowances[way], now, datagram.len()) => &mut self.counts.over_rate,
            () => return true,
        };
        *stopped += 1;
        false
    }

    /// Whether the board has said something of late.
    pub fn is_there(&self, now: Instant) -> bool {
        self.spoke.is_some_and(|at| now.saturating_duration_since(at) < CONSENT)
    }

    /// Whether the board is there, where that has changed since the last look.
    pub fn look(&mut self, now: Instant) -> Option<bool> {
        let there = self.is_there(now);
        let changed = std::mem::replace(&mut self.there, there) != there;
        self.counts.arrivals += u64::from(changed && there);
        changed.then_some(there)
    }
}
