//! Ticks of a whole peer, replayed: no plant, no network, no sine while counting.
//!
//! Two peers are driven along smooth paths and talk with one packet of delay; what peer 1 is given is recorded, after as
//! many ticks that are not. A tick is what a board's interrupt does: [`peer::tick`], and before every 8th of them
//! [`peer::exchange`], so that an eighth of an exchange is in the mean.

use alloc::boxed::Box;
use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::TAU;
use core::hint::black_box;
use core::marker::PhantomData;

use haptic_core::axis::encoder::Counts;
use haptic_core::axis::kinematics::{KinematicsName, direct};
use haptic_core::axis::velocity::{VelocityName, measured};
use haptic_core::axis::{AXES, Reading};
use haptic_core::couple::{Packet, wave};
use haptic_core::motion::Motion;
use haptic_core::object::forward_euler;
use haptic_core::peer::{self, Actuators, Sensors, State};
use haptic_core::render::{Contact, Side};
use haptic_core::safety::{Command, Mode};
use haptic_core::scalar::Scalar;
use haptic_core::scene::{Models, Scene};
use haptic_core::settings::Settings;

use super::{Case, Meter, scenes};

/// Ticks of a replay: whole packets, and one whole period of the paths.
const TICKS: usize = 800;

/// The models of an image that names them: [`scenes::NAMED`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Named<S>(PhantomData<S>);

impl<S: Scalar> Models for Named<S> {
    type Scalar = S;
    type Velocity = measured::Measured;
    type Kinematics = direct::Direct;
    type Contact = Contact<S>;
    type Integrator = forward_euler::ForwardEuler<S>;
    type Law = wave::PassiveWave<S>;
}

/// The ticks of a scene.
pub fn case<M: Models, R: Meter>(scene: &scenes::Scene) -> Case {
    let settings = scene.settings();
    let replay = move || {
        let (scene, mut state, inputs) = record::<M>(&settings);
        let mut body = |input: &Input<M::Scalar>| step(&scene, &mut state, input);
        for input in &inputs {
            black_box(R::call(&mut body, input));
        }
        // A peer that faulted would be counted doing nothing.
        assert_eq!(state.mode(), Mode::Armed, "a scene must run without a fault");
    };
    Case { name: format!("tick/{}", scene.name), calls: TICKS, replay: Box::new(replay) }
}

/// What a peer is given in one tick.
#[derive(Clone, Copy, Debug)]
struct Input<S> {
    sensors: Sensors<S>,
    packet: Option<Packet<S>>,
}

/// Peer 1, its state in the middle of the run, and what it is given from there on.
fn record<M: Models>(settings: &Settings) -> (Scene<M>, State<M>, Vec<Input<M::Scalar>>) {
    let mut peers = [Side::Left, Side::Right].map(|side| {
        let mut settings = *settings;
        settings.contact.side = side;
        let scene = Scene::<M>::build(&settings).expect("the scenes of the cases are valid");
        let mut state = State::new(&scene, [Motion::REST; AXES]);
        state.command(&scene, Command::Arm);
        (scene, state)
    });
    let mut on_the_way = [None, None];
    let (mut start, mut inputs) = (peers[0].1, Vec::with_capacity(TICKS));
    for tick in 0..2 * TICKS {
        if tick == TICKS {
            start = peers[0].1;
        }
        let (due, arrived) = (peers[0].1.packet_due(), on_the_way);
        for (index, (scene, state)) in peers.iter_mut().enumerate() {
            if due {
                on_the_way[1 - index] = Some(peer::outgoing(scene, state));
            }
            let input = Input { sensors: sensors(settings, tick, index), packet: arrived[index] };
            step(scene, state, &input);
            if index == 0 && tick >= TICKS {
                inputs.push(input);
            }
        }
    }
    let [(scene, _), _] = peers;
    (scene, start, inputs)
}

/// One tick of a peer, and the exchange before it when one is due.
#[inline(always)]
fn step<M: Models>(scene: &Scene<M>, state: &mut State<M>, input: &Input<M::Scalar>) -> Actuators<M::Scalar> {
    if state.packet_due() {
        black_box(peer::exchange(scene, state, input.packet));
    }
    peer::tick(scene, state, &input.sensors)
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
