//! The ticks that are measured: one short [`Recording`] per scene, the same for every number type and every tool.
//!
//! Two peers are driven along smooth paths and talk with one packet of delay; what peer 1 is given is recorded, after as
//! many ticks that are not. So a replay is the peer alone: no plant, no network, no sine. The same text is counted on a PC
//! (`benches/instructions.rs`, `host-sim/benches/choices.rs`), timed there (`host-sim/benches/ticks.rs`) and counted on
//! the board's processor (`tests/count`).

use alloc::vec::Vec;
use core::f64::consts::TAU;
use core::hint::black_box;

use cohold_core::contact::Side;
use cohold_core::device::encoder::Counts;
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::velocity::VelocityName;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::wave::{Decode, PassiveWave};
use cohold_core::law::{AnyLaw, Law, Packet};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::Settings;

/// Whatever measures the cases.
pub trait Measure {
    /// Measures the scene that `settings` describe, called `scene`, computing in `S`.
    fn case<S: Scalar, L: Law<S>>(&mut self, scene: &'static str, settings: &Settings);
}

/// Every scene in every number type.
pub fn measure_all(measure: &mut impl Measure) {
    for (scene, change) in SCENES {
        let mut settings = Settings::default();
        change(&mut settings);
        measure.case::<f32, AnyLaw<f32>>(scene, &settings);
        measure.case::<f64, AnyLaw<f64>>(scene, &settings);
        measure.case::<Fixed, AnyLaw<Fixed>>(scene, &settings);
    }
    let settings = Settings::default();
    measure.case::<f32, PassiveWave<f32>>(NAMED, &settings);
    measure.case::<f64, PassiveWave<f64>>(NAMED, &settings);
    measure.case::<Fixed, PassiveWave<Fixed>>(NAMED, &settings);
}

type Change = fn(&mut Settings);

/// What each scene changes of the default settings, which are the paper's: passive wave, delayed decode. Stiffnesses are
/// the largest the paper found at a round trip of 16 ms.
const SCENES: &[(&str, Change)] = &[
    ("no-coordination", |settings| settings.coordination.comm = "none"),
    ("power", |settings| {
        (settings.coordination.comm, settings.coordination.stiffness_n_per_m) = ("power", 310.0);
    }),
    ("wave", |settings| {
        (settings.coordination.comm, settings.coordination.stiffness_n_per_m) = ("wave", 1590.0);
    }),
    ("passive-wave", |_| {}),
    ("passive-wave-implicit", |settings| settings.coordination.decode = Decode::Implicit),
    ("passive-mean-implicit", passive_mean),
    ("passive-mean-implicit-ledger-drift", |settings| {
        passive_mean(settings);
        settings.coordination.ledger = true;
        settings.coordination.drift_correction = true;
    }),
    ("one-sided-gap", |settings| {
        (settings.contact.one_sided, settings.contact.gap_m) = (true, 0.002);
    }),
    ("encoder-adaptive-two-axes", two_axes),
    ("five-bar-adaptive-two-axes", |settings| {
        two_axes(settings);
        settings.kinematics.model = KinematicsName::FiveBar;
    }),
];

fn passive_mean(settings: &mut Settings) {
    (settings.coordination.comm, settings.coordination.decode) = ("passive-mean", Decode::Implicit);
}

fn two_axes(settings: &mut Settings) {
    (settings.axis.count, settings.axis.velocity) = (2, VelocityName::Adaptive);
}

/// The passive wave again, in an image that names its law and carries no other.
const NAMED: &str = "passive-wave-named-law";

/// [`step`] as a function that tools can find by its name, called by nothing but what measures.
#[inline(never)]
pub fn measured_tick<S: Scalar, L: Law<S>>(peer: &mut Peer<S, L>, input: &Input<S>) -> Actuators<S> {
    step(peer, input)
}

/// Ticks of a replay: whole packets, and one whole period of the paths.
pub const TICKS: usize = 800;

/// What a peer is given in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Input<S: Scalar> {
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
                    on_the_way[1 - index] = Some(peer.outgoing()[0]);
                }
                let input = Input { sensors: sensors(settings, tick, index), packet: arrived[index].filter(|_| due) };
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

/// One tick of a peer, and what is heard and exchanged before it when that is due: what a board does in its interrupt, so that an eighth of
/// an exchange is in the mean.
#[inline(always)]
pub fn step<S: Scalar, L: Law<S>>(peer: &mut Peer<S, L>, input: &Input<S>) -> Actuators<S> {
    if let Some(packet) = input.packet {
        peer.hear(&[packet]);
    }
    if peer.packet_due() {
        black_box(peer.exchange());
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
    Sensors::of(reading)
}
