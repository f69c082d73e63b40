//! What is wrong is found: ticks with a fault put into them, and a law that leaves its number type.

use cohold_core::law::power::Power;
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet};
use cohold_core::num::{Configured, Motion, Scalar};
use cohold_core::object::{Port, Solve};
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::settings::{Refused, Settings};
use cohold_proof::prove::{Broken, Tick};
use cohold_proof::{Number, prove};

type Held = Power<Number>;

fn found(tick: Tick<Held>) -> Broken {
    let [law] = Held::LAWS else { unreachable!() };
    prove::<Held>(law, tick).broken.expect("a fault was put into it").1
}

/// The tick with something done to its first force.
fn first(
    peer: &mut Peer<Number, Held>,
    sensors: &Sensors<Number>,
    change: impl Fn(Number) -> Number,
) -> Actuators<Number> {
    let mut actuators = peer.tick(sensors);
    if actuators.enable {
        actuators.forces[0] = change(actuators.forces[0]);
    }
    actuators
}

#[test]
fn a_force_past_its_limit() {
    // By one part in a million, which no run would meet.
    let broken = found(|peer, sensors| first(peer, sensors, |force| force * Number::from_f64(1.000_001)));
    assert!(matches!(broken, Broken::Force(range) if !range.nan && range.hi > 40.0), "{broken:?}");
}

#[test]
fn a_force_that_is_no_number() {
    let broken = found(|peer, sensors| {
        let wanted = peer.observed()[0].contact_force;
        first(peer, sensors, |force| force + Number::ZERO * wanted)
    });
    assert!(matches!(broken, Broken::Force(range) if range.nan), "{broken:?}");
}

#[test]
fn a_force_without_its_slew_limit() {
    let broken = found(|peer, sensors| {
        let mut actuators = peer.tick(sensors);
        if actuators.enable {
            // Half as much again as the copy gets, which is within what it may grow by.
            actuators.forces[0] =
                (Number::from_f64(-1.5) * peer.observed()[0].contact_force).limit(Number::from_f64(40.0));
        }
        actuators
    });
    assert!(matches!(broken, Broken::Slew(change) if change.hi > 20.1), "{broken:?}");
}

#[test]
fn a_force_after_a_fault() {
    let broken = found(|peer, sensors| {
        let mut actuators = peer.tick(sensors);
        if !actuators.enable {
            actuators.forces[0] = Number::from_f64(1e-3);
        }
        actuators
    });
    assert_eq!(broken, Broken::Off);
}

/// Sums up what it hears in f64, where no range follows.
#[derive(Clone, Copy, Debug)]
struct Outside;

impl Configured for Outside {}

impl<S: Scalar> Law<S> for Outside {
    const LAWS: &'static [LawInfo] = &[LawInfo { name: "outside", ..LawInfo::MOTION }];
    type State = Motion<S>;

    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
    fn start(&self, local: Motion<S>) -> Motion<S> {
        local
    }
    fn receive(&self, state: &mut Motion<S>, packet: Packet<S>) {
        *state = Motion::at(S::from_f64(0.5 * packet.motion.position.to_f64()));
    }
    fn couple(&self, state: &mut Motion<S>, _: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        solve.velocity(Port::default());
        Coupled { desired: *state, ..Coupled::default() }
    }
    fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}

#[test]
fn a_law_that_leaves_its_number_type() {
    let [law] = <Outside as Law<Number>>::LAWS else { unreachable!() };
    let broken = prove::<Outside>(law, Peer::tick).broken.expect("it does").1;
    assert_eq!(broken, Broken::Escaped);
}
