//! A recording of a peer: two peers are driven along smooth paths and talk with one packet of delay; what peer 1 is given
//! is recorded, after as many ticks that are not. So a replay is the peer alone: no plant, no network, no sine.
//!
//! Leans on `haptic_core`, `libm` and `alloc` alone: the same text is counted on a PC (`benches/instructions.rs`,
//! `host-sim/benches/choices.rs`), timed there (`host-sim/benches/ticks.rs`) and counted on the board's processor
//! (`tests/count`).

extern crate alloc;

use alloc::vec::Vec;
use core::f64::consts::TAU;
use core::hint::black_box;

use haptic_core::contact::Side;
use haptic_core::device::encoder::Counts;
use haptic_core::device::kinematics::KinematicsName;
use haptic_core::device::velocity::VelocityName;
use haptic_core::device::{AXES, Reading};
use haptic_core::law::{Law, Packet};
use haptic_core::num::{Motion, Scalar};
use haptic_core::peer::{Actuators, Peer, Sensors};
use haptic_core::safety::{Command, Mode};
use haptic_core::settings::Settings;

/// Ticks of a replay: whole packets, and one whole period of the paths.
pub const TICKS: usize = 800;

/// What a peer is given in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Input<S> {
    sensors: Sensors<S>,
    packet: Option<Packet<S>>,
}

/// Peer 1 in the middle of the run, and what it is given from there on.
pub struct Recording<S: Scalar, L: Law<S>> {
    peer: Peer<S, L>,
    inputs: Vec<Input<S>>,
}

impl<S: Scalar, L: Law<S>> Recording<S, L> {
    /// Runs the scene and records its second half.
    pub fn new(settings: &Settings) -> Self {
        let mut peers = [Side::Left, Side::Right].map(|side| {
            let mut settings = *settings;
            settings.contact.side = side;
            let mut peer =
                Peer::<S, L>::new(&settings, [Motion::REST; AXES]).expect("a scene that is measured is valid");
            peer.command(Command::Arm);
            peer
        });
        let mut on_the_way = [None, None];
        let (mut start, mut inputs) = (peers[0], Vec::with_capacity(TICKS));
        for tick in 0..2 * TICKS {
            if tick == TICKS {
                start = peers[0];
            }
            let (due, arrived) = (peers[0].packet_due(), on_the_way);
            for (index, peer) in peers.iter_mut().enumerate() {
                if due {
                    on_the_way[1 - index] = Some(peer.outgoing());
                }
                let input = Input { sensors: sensors(settings, tick, index), packet: arrived[index] };
                step(peer, &input);
                if index == 0 && tick >= TICKS {
                    inputs.push(input);
                }
            }
        }
        for peer in &peers {
            // A peer that faulted would be measured doing nothing.
            assert_eq!(peer.mode(), Mode::Armed, "a scene that is measured must run without a fault: {settings:?}");
        }
        Self { peer: start, inputs }
    }

    /// Replays it: [`TICKS`] calls of `tick`, which is [`step`] in whatever measures it.
    pub fn replay(&self, mut tick: impl FnMut(&mut Peer<S, L>, &Input<S>) -> Actuators<S>) {
        let mut peer = self.peer;
        for input in &self.inputs {
            black_box(tick(&mut peer, input));
        }
        black_box(peer);
    }
}

/// One tick of a peer, and the exchange before it when one is due: what a board does in its interrupt, so that an eighth of
/// an exchange is in the mean.
#[inline(always)]
pub fn step<S: Scalar, L: Law<S>>(peer: &mut Peer<S, L>, input: &Input<S>) -> Actuators<S> {
    if peer.packet_due() {
        black_box(peer.exchange(input.packet));
    }
    peer.tick(&input.sensors)
}

/// Where the device of peer `index` is: 5 mm up and down once in [`TICKS`], the second peer a little behind.
fn sensors<S: Scalar>(settings: &Settings, tick: usize, index: usize) -> Sensors<S> {
    let angular = TAU / (TICKS as f64 * settings.timing.control_period_s);
    let time_s = tick as f64 * settings.timing.control_period_s;
    let (sine, cosine) = libm::sincos(angular * time_s - 0.3 * index as f64);
    let axis = |amplitude: f64| Motion {
        position: S::from_f64(amplitude * sine),
        velocity: S::from_f64(amplitude * angular * cosine),
    };
    let counts = |amplitude: f64| Counts(libm::floor(amplitude * sine) as i64 as u16);
    // Encoders where the velocity is estimated; a joint that turns does so by 50 and 30 mrad.
    let reading = match (settings.axis.velocity, settings.kinematics.model) {
        (VelocityName::Measured, _) => Reading::Exact([0.005, 0.001].map(axis)),
        (_, KinematicsName::Direct) => {
            Reading::Counts([0.005, 0.001].map(|amplitude| counts(amplitude * settings.encoder.counts_per_m)))
        }
        _ => Reading::Counts([0.05, 0.03].map(|amplitude| counts(amplitude * settings.encoder.counts_per_rev / TAU))),
    };
    Sensors { reading, overrun: false }
}
