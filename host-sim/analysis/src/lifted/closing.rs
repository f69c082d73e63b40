//! Joins the answers of peers through the network's queues into one matrix.
//!
//! The state is the peers' local states, one after the other, and then for every peer the packets on their way to it,
//! youngest first. At the start of a period each peer sends, the queues move up by one, and the oldest packet is heard; with
//! no delay the packet sent is heard at once. With A the peer's own answer, B what it makes of a packet and C what it
//! sends, two peers without delay are `[[A₁, B₁·C₂], [B₂·C₁, A₂]]`.

use super::Lifted;
use super::driven::{Response, Translation};
use crate::matrix::{add_block, apply, reset};

/// A peer, and whose packets it hears.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End<'a> {
    /// The matrices that answer a packet.
    pub response: &'a Response,
    /// Place of the sender in the list of ends.
    pub hears: usize,
    /// +1, or −1 where the difference of two like peers is followed.
    pub sign: f64,
    /// Packet periods that a packet is on its way to this peer.
    pub delay_packets: usize,
}

/// Where everything begins in the joint state.
struct Layout {
    local: Vec<usize>,
    queue: Vec<usize>,
    size: usize,
}

impl Layout {
    fn of(ends: &[End<'_>]) -> Self {
        let mut size = 0;
        let mut take = |count: usize| {
            size += count;
            size - count
        };
        let local = ends.iter().map(|end| take(end.response.states())).collect();
        let queue = ends.iter().map(|end| take(end.delay_packets * end.response.packet())).collect();
        Self { local, queue, size }
    }
}

/// Writes the lifted matrix of the ends, and its rest modes, into `lifted`.
pub(crate) fn close(ends: &[End<'_>], lifted: &mut Lifted) {
    let layout = Layout::of(ends);
    let matrix = &mut lifted.matrix;
    reset(matrix, layout.size, layout.size);
    for (at, end) in ends.iter().enumerate() {
        let (own, packet) = (end.response, end.response.packet());
        let sender = ends[end.hears].response;
        let (to, from, queue) = (layout.local[at], layout.local[end.hears], layout.queue[at]);
        add_block(matrix, to, to, &own.own, 1.0);
        if end.delay_packets == 0 {
            add_block(matrix, to, from, &(&own.heard * &sender.sent), end.sign);
            continue;
        }
        let oldest = queue + (end.delay_packets - 1) * packet;
        add_block(matrix, to, oldest, &own.heard, 1.0);
        add_block(matrix, queue, from, &sender.sent, end.sign);
        for moved in queue..oldest {
            matrix[(moved + packet, moved)] = 1.0;
        }
    }
    rest_modes(ends, &layout, lifted);
}

/// Each peer's own translation along an axis, where it stays and nobody minds; else that of all of them together.
fn rest_modes(ends: &[End<'_>], layout: &Layout, lifted: &mut Lifted) {
    lifted.rest_modes.clear();
    for axis in 0..ends[0].response.translations.len() {
        rest_modes_along(axis, ends, layout, lifted);
    }
}

fn rest_modes_along(axis: usize, ends: &[End<'_>], layout: &Layout, lifted: &mut Lifted) {
    let known = lifted.rest_modes.len();
    for at in 0..ends.len() {
        let Translation { sent, stays, .. } = &ends[at].response.translations[axis];
        let hears_itself = ends[at].hears == at && sent.iter().any(|number| *number != 0.0);
        let stays = match (hears_itself, ends[at].sign > 0.0) {
            (false, _) => stays[0],
            (true, true) => stays[1],
            (true, false) => stays[2],
        };
        let unheard = ends
            .iter()
            .enumerate()
            .filter(|(other, end)| *other != at && end.hears == at)
            .all(|(_, end)| apply(&end.response.heard, sent).iter().all(|number| *number == 0.0));
        if stays && unheard {
            let mut mode = vec![0.0; layout.size];
            translate(axis, ends, layout, at, &mut mode);
            lifted.rest_modes.push(mode);
        }
    }
    let together = ends.iter().all(|end| end.sign > 0.0 && end.response.translations[axis].stays[1]);
    if lifted.rest_modes.len() == known && together && ends.len() > 1 {
        let mut mode = vec![0.0; layout.size];
        (0..ends.len()).for_each(|at| translate(axis, ends, layout, at, &mut mode));
        lifted.rest_modes.push(mode);
    }
}

/// Adds the translation of one peer along an axis, and of what it has sent, to `mode`.
fn translate(axis: usize, ends: &[End<'_>], layout: &Layout, at: usize, mode: &mut [f64]) {
    let response = ends[at].response;
    let translation = &response.translations[axis];
    mode[layout.local[at]..][..response.states()].copy_from_slice(&translation.local);
    for (to, end) in ends.iter().enumerate().filter(|(_, end)| end.hears == at) {
        let packet = response.packet();
        for slot in 0..end.delay_packets {
            let queue = &mut mode[layout.queue[to] + slot * packet..][..packet];
            for (number, sent) in queue.iter_mut().zip(&translation.sent) {
                *number = end.sign * sent;
            }
        }
    }
}
