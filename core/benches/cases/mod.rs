//! The ticks that are measured: one short recording per scene, the same for every number type and every tool.
//!
//! Two peers are driven along smooth paths and talk to each other with one packet of delay. What peer 1 is given in the
//! measured ticks is recorded, with its state before them, so that a measurement replays the peer alone: no plant, no
//! network, no sine. Shared by `core/benches/instructions.rs` (exact counts) and `host-sim/benches/ticks.rs` (time).

use haptic_core::axis::encoder::Counts;
use haptic_core::axis::kinematics::KinematicsName;
use haptic_core::axis::velocity::VelocityName;
use haptic_core::axis::{AXES, Reading, kinematics, velocity};
use haptic_core::couple::wave::Decode;
use haptic_core::couple::{LawName, Packet, wave};
use haptic_core::motion::Motion;
use haptic_core::object::forward_euler;
use haptic_core::peer::{self, Actuators, Sensors, State};
use haptic_core::render::{Contact, Side};
use haptic_core::safety::{Command, Mode};
use haptic_core::scalar::{Fixed, Scalar};
use haptic_core::scene::{Any, Models, Scene};
use haptic_core::settings::Settings;

/// Ticks measured, after as many that are not: whole packets, and one whole period of the paths.
pub(crate) const TICKS: usize = 800;

/// Whatever measures the cases.
pub(crate) trait Measure {
    /// Measures the scene that `settings` describe, called `scene`, computing in `M::Scalar`.
    fn case<M: Models>(&mut self, scene: &'static str, settings: &Settings);
}

/// Every scene in every number type.
pub(crate) fn measure_all(measure: &mut impl Measure) {
    for (scene, change) in SCENES {
        let mut settings = Settings::default();
        change(&mut settings);
        measure.case::<Any<f32>>(scene, &settings);
        measure.case::<Any<f64>>(scene, &settings);
        measure.case::<Any<Fixed>>(scene, &settings);
    }
    let settings = Settings::default();
    measure.case::<Named<f32>>(NAMED, &settings);
    measure.case::<Named<f64>>(NAMED, &settings);
    measure.case::<Named<Fixed>>(NAMED, &settings);
}

/// A change to the default settings.
type Change = fn(&mut Settings);

/// What each scene changes of the default settings, which are the paper's: passive wave, delayed decode. Stiffnesses are
/// the largest the paper found at a round trip of 16 ms.
const SCENES: &[(&str, Change)] = &[
    ("no-coordination", |settings| settings.coordination.comm = LawName::Free),
    ("power", |settings| {
        settings.coordination.comm = LawName::Power;
        settings.coordination.stiffness_n_per_m = 310.0;
    }),
    ("wave", |settings| {
        settings.coordination.comm = LawName::Wave;
        settings.coordination.stiffness_n_per_m = 1590.0;
    }),
    ("passive-wave", |_| {}),
    ("passive-wave-implicit", |settings| settings.coordination.decode = Decode::Implicit),
    ("passive-mean-implicit", |settings| {
        settings.coordination.comm = LawName::PassiveMean;
        settings.coordination.decode = Decode::Implicit;
    }),
    ("passive-mean-implicit-ledger-drift", |settings| {
        settings.coordination.comm = LawName::PassiveMean;
        settings.coordination.decode = Decode::Implicit;
        settings.coordination.ledger = true;
        settings.coordination.drift_correction = true;
    }),
    ("one-sided-gap", |settings| {
        settings.contact.one_sided = true;
        settings.contact.gap_m = 0.002;
    }),
    ("encoder-adaptive-two-axes", |settings| {
        settings.axis.count = 2;
        settings.axis.velocity = VelocityName::Adaptive;
    }),
    ("five-bar-adaptive-two-axes", |settings| {
        settings.axis.count = 2;
        settings.axis.velocity = VelocityName::Adaptive;
        settings.kinematics.model = KinematicsName::FiveBar;
    }),
];

/// The passive wave again, in an image that names its models and so carries no others.
const NAMED: &str = "passive-wave-named-models";

/// The models of [`NAMED`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Named<S>(core::marker::PhantomData<S>);

impl<S: Scalar> Models for Named<S> {
    type Scalar = S;
    type Velocity = velocity::measured::Measured;
    type Kinematics = kinematics::direct::Direct;
    type Contact = Contact<S>;
    type Integrator = forward_euler::ForwardEuler<S>;
    type Law = wave::PassiveWave<S>;
}

/// What a peer is given in one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Input<S> {
    sensors: Sensors<S>,
    packet: Option<Packet<S>>,
}

/// A peer about to be measured, and what it will be given.
pub(crate) struct Recording<M: Models> {
    scene: Scene<M>,
    state: State<M>,
    inputs: Vec<Input<M::Scalar>>,
}

impl<M: Models> Recording<M> {
    /// Runs the scene and records its second half.
    pub(crate) fn new(settings: &Settings) -> Self {
        let mut peers = [Side::Left, Side::Right].map(|side| {
            let mut settings = *settings;
            settings.contact.side = side;
            let scene = Scene::<M>::build(&settings).expect("the scenes of the benches are valid");
            let mut state = State::new(&scene, [Motion::REST; AXES]);
            state.command(&scene, Command::Arm);
            (scene, state)
        });
        let mut on_the_way = [None, None];
        let mut inputs = Vec::new();
        let mut start = peers[0].1;
        for tick in 0..2 * TICKS {
            if tick == TICKS {
                start = peers[0].1;
            }
            let due = peers[0].1.packet_due();
            let arrived = on_the_way;
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
        for (_, state) in &peers {
            // A peer that faulted would be measured doing nothing.
            assert_eq!(state.mode(), Mode::Armed, "a scene of the benches must run without a fault: {settings:?}");
        }
        let [(scene, _), _] = peers;
        Self { scene, state: start, inputs }
    }

    /// Replays the recording: [`TICKS`] calls of [`measured_tick`].
    pub(crate) fn replay(&self) -> State<M> {
        let mut state = self.state;
        for input in &self.inputs {
            core::hint::black_box(measured_tick(&self.scene, &mut state, input));
        }
        state
    }
}

/// [`step`] as a function that tools can find by its name, called by nothing but [`Recording::replay`].
#[inline(never)]
fn measured_tick<M: Models>(scene: &Scene<M>, state: &mut State<M>, input: &Input<M::Scalar>) -> Actuators<M::Scalar> {
    step(scene, state, input)
}

/// One tick of a peer, and before every 8th its exchange: what a board does in its interrupt.
#[inline(always)]
fn step<M: Models>(scene: &Scene<M>, state: &mut State<M>, input: &Input<M::Scalar>) -> Actuators<M::Scalar> {
    if state.packet_due() {
        core::hint::black_box(peer::exchange(scene, state, input.packet));
    }
    peer::tick(scene, state, &input.sensors)
}

/// Where the device of peer `index` is: 5 mm up and down once in [`TICKS`], the second peer a little behind.
fn sensors<S: Scalar>(settings: &Settings, tick: usize, index: usize) -> Sensors<S> {
    let angular = core::f64::consts::TAU / (TICKS as f64 * settings.timing.control_period_s);
    let time_s = tick as f64 * settings.timing.control_period_s;
    let (sine, cosine) = (angular * time_s - 0.3 * index as f64).sin_cos();
    let (amplitude, side_amplitude) = (0.005, 0.001);
    let axis = |amplitude: f64| Motion {
        position: S::from_f64(amplitude * sine),
        velocity: S::from_f64(amplitude * angular * cosine),
    };
    // Encoders where the velocity is estimated; a joint of the five-bar turns by 50 mrad.
    let counts = |at: f64| Counts((at * sine).floor() as i64 as u16);
    let reading = match (settings.axis.velocity, settings.kinematics.model) {
        (VelocityName::Measured, _) => Reading::Exact([axis(amplitude), axis(side_amplitude)]),
        (_, KinematicsName::Direct) => {
            Reading::Counts([amplitude, side_amplitude].map(|at| counts(at * settings.encoder.counts_per_m)))
        }
        _ => Reading::Counts(
            [0.05, 0.03].map(|at| counts(at * settings.encoder.counts_per_rev / core::f64::consts::TAU)),
        ),
    };
    Sensors { reading, overrun: false }
}
