//! The far end of USART3: the PC behind the ST-LINK, as two queues of bytes.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// What the PC has to say, and what it has heard.
#[derive(Debug, Default)]
pub(super) struct Console {
    pub(super) said: VecDeque<u8>,
    pub(super) heard: Vec<u8>,
}

impl Store for Console {}

impl Peer for Console {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        self.heard.push(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.said.pop_front().map(u16::from)
    }
}
