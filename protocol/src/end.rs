//! One end of a line (feature `peer`): the order in which it takes what comes over its link, the same on a board and on a PC.
//!
//! Notices come first. The flow in a datagram may be the first of another life of the other peer, and nothing from before goes with it.

use crate::error::Refusal;
use crate::link::{Link, Notice};
use crate::peer::flow_in;
use crate::wire::{Flows, Message, Telemetry};

/// One end of the line between two peers that share the object along `AXES` axes.
pub trait End<const AXES: usize> {
    /// Its link to the other end.
    fn link(&mut self) -> &mut Link;

    /// Takes a notice of the link, at `now_us`, µs. After [`Notice::Disengaged`] nothing counts that came before.
    fn notice(&mut self, now_us: u64, notice: Notice);

    /// Keeps a flow for the next exchange. It came at tick `tick` and was sealed at `sealed_us`, µs of this end's clock.
    ///
    /// # Errors
    /// [`Refusal::Impossible`]: a number in it that cannot be. The other end is disengaged.
    fn keep(&mut self, tick: u32, sealed_us: u64, flow: Flows<AXES>) -> Result<(), Refusal>;

    /// Takes telemetry of the other end.
    fn telemetry(&mut self, _said: Telemetry) {}

    /// Takes a datagram that came at `now_us` (µs) and at tick `tick`, opened in place. Gives the flow in it, if there is one.
    ///
    /// # Errors
    /// The datagram was refused, and why.
    fn receive(&mut self, now_us: u64, tick: u32, datagram: &mut [u8]) -> Result<Option<Flows<AXES>>, Refusal> {
        let taken = self.link().receive(now_us, datagram);
        self.heed(now_us);
        let taken = taken?;
        if let Some(Message::Telemetry(said)) = taken {
            self.telemetry(said);
        }
        let flow = taken.as_ref().and_then(flow_in);
        if let Some(flow) = flow {
            let sealed_us = self.sealed_us(now_us);
            self.keep(tick, sealed_us, flow)?;
        }
        Ok(flow)
    }

    /// Takes all notices of the link, at `now_us`, µs.
    fn heed(&mut self, now_us: u64) {
        while let Some(notice) = self.link().take_notice() {
            self.notice(now_us, notice);
        }
    }

    /// When the newest datagram was sealed, µs of this end's clock: by the common clock, or, before that is known, half of its age ago.
    fn sealed_us(&mut self, now_us: u64) -> u64 {
        let link = self.link();
        let offset_us = link.clock().offset_us(now_us);
        let sealed_us = offset_us.and_then(|offset_us| link.sealed_us().checked_add_signed(offset_us.saturating_neg()));
        let ago_us = u64::from(link.delay_us().unwrap_or_default());
        sealed_us.unwrap_or(now_us.saturating_sub(ago_us)).min(now_us)
    }
}
