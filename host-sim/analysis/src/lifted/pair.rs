//! What two peers and the network between them fall apart into: sum and difference, or the pair as it is.

use std::borrow::Cow;

use cohold_sim::scene::Scene;

use super::Lifted;
use super::closing::{End, close};
use super::delay::delays_ticks;
use super::driven::Response;
use crate::error::Error;

/// Whether the two peers, their devices and both directions of the network are the same.
pub fn is_symmetric(linear: &Scene) -> bool {
    let [to_first, to_second] = delays_ticks(linear);
    same_arms(linear) && to_first == to_second
}

/// Whether both ends of the law are the same: of one that compensates what it reflects only the end on the left does.
pub(crate) fn same_ends(linear: &Scene) -> bool {
    linear.law().ends_alike
}

/// Whether both users' arms, devices, contacts, fixtures and ends of the law are the same: all in which the two peers of a linear scene can differ.
pub(crate) fn same_arms(linear: &Scene) -> bool {
    let (devices, peers) = (linear.devices(), linear.peers());
    let end = |end: usize| {
        let (user, contact) = (&linear.users[end].settings.user, &peers[end].contact);
        let arm = (user.arm_stiffness_n_per_m, user.arm_damping_n_s_per_m, user.arm_mass_kg);
        (arm, devices[end], contact.stiffness_n_per_m, contact.damping_n_s_per_m, peers[end].fixture)
    };
    end(0) == end(1) && same_ends(linear)
}

/// Whether nobody can hold anything, for want of stiffness and damping of contact.
pub(crate) fn hands_are_off(linear: &Scene) -> bool {
    linear.peers().iter().all(|peer| peer.contact.stiffness_n_per_m == 0.0 && peer.contact.damping_n_s_per_m == 0.0)
}

/// The linear scene of a peer with its hand on or let go ([`Scene::hands_off`]): a device that holds nothing, and the arm at
/// it, are no part of it.
pub(crate) fn seat(linear: &Scene, released: bool) -> Cow<'_, Scene> {
    if released || hands_are_off(linear) { Cow::Owned(linear.hands_off()) } else { Cow::Borrowed(linear) }
}

/// Two peers' answers, each to a packet that it hears so far into a packet period as its delay says, and the whole packet periods
/// that packets are on their way to each of them.
pub(crate) struct Joined<'a> {
    answers: [&'a Response; 2],
    delays_packets: [usize; 2],
    /// Taken apart into sum and difference: one answer for both, and the same delay both ways.
    pub symmetric: bool,
}

impl<'a> Joined<'a> {
    pub(crate) fn new(answers: [&'a Response; 2], delays_packets: [usize; 2]) -> Self {
        let symmetric = std::ptr::eq(answers[0], answers[1]) && delays_packets[0] == delays_packets[1];
        Self { answers, delays_packets, symmetric }
    }

    /// The lifted matrices it falls apart into, by sign: sum and difference, or the pair as it is.
    pub(crate) fn signs(&self) -> &'static [f64] {
        if self.symmetric { &[1.0, -1.0] } else { &[1.0] }
    }

    /// Axes along which the object is shared.
    pub(crate) fn axes(&self) -> usize {
        self.answers[0].translations.len()
    }

    /// Where the position of the object along every axis is in such a matrix: peer 1's, and where there are two, peer 2's.
    pub(crate) fn objects(&self) -> Vec<usize> {
        let [first, second] = self.answers;
        let of = |answer: &Response, from: usize| {
            answer.translations.iter().map(move |along| from + along.object).collect::<Vec<_>>()
        };
        let others = if self.symmetric { Vec::new() } else { of(second, first.states()) };
        [of(first, 0), others].concat()
    }

    /// Writes the matrix of one sign into `whole`.
    pub(crate) fn write(&self, sign: f64, whole: &mut Lifted) {
        let end =
            |at: usize, hears| End { response: self.answers[at], hears, sign, delay_packets: self.delays_packets[at] };
        if self.symmetric {
            close(&[end(0, 0)], whole);
        } else {
            close(&[end(0, 1), end(1, 0)], whole);
        }
    }
}

/// The lifted matrix of the whole pair, nothing left out and not taken apart, in the order peer 1, peer 2, packets on
/// their way to peer 1, to peer 2; local order as in `lifted::driven`.
///
/// # Errors
/// A scene that cannot be built.
pub fn pair_matrix(linear: &Scene) -> Result<Lifted, Error> {
    seated_matrix([linear, linear])
}

/// [`pair_matrix`] with a scene for each peer ([`seat`]).
pub(crate) fn seated_matrix(seats: [&Scene; 2]) -> Result<Lifted, Error> {
    let (delays, ticks_per_packet) = (delays_ticks(seats[0]), seats[0].peer.timing.ticks_per_packet as usize);
    let mut answers = <[Response; 2]>::default();
    for (at, answer) in answers.iter_mut().enumerate() {
        answer.measure(seats[at], at, delays[at] % ticks_per_packet)?;
    }
    let mut whole = Lifted::default();
    Joined::new(answers.each_ref(), delays.map(|ticks| ticks / ticks_per_packet)).write(1.0, &mut whole);
    Ok(whole)
}
