//! Packets on their way between two peers.

use std::collections::VecDeque;

/// A line that delivers every packet a fixed number of packet periods after it was sent.
#[derive(Clone, Debug)]
pub struct DelayLine<P> {
    in_flight: VecDeque<P>,
    delay_packets: usize,
}

impl<P> DelayLine<P> {
    /// An empty line.
    pub fn new(delay_packets: u32) -> Self {
        Self { in_flight: VecDeque::with_capacity(delay_packets as usize + 1), delay_packets: delay_packets as usize }
    }

    /// Takes the packet of this period and gives the one that arrives in it.
    pub fn pass(&mut self, packet: P) -> Option<P> {
        self.in_flight.push_back(packet);
        if self.in_flight.len() > self.delay_packets { self.in_flight.pop_front() } else { None }
    }
}
