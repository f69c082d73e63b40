//! For every scene that `build()` accepts and whatever comes in, `tick` returns finite forces within the limits.
//!
//! Settings are drawn over their whole ranges, ends included; sensors and packets are any bit pattern: NaN, infinities,
//! subnormals, huge numbers, encoder counts that jump.

use cohold_core::device::encoder::Counts;
use cohold_core::device::kinematics::{AnyKinematics, AnySpatial, Joints, Kinematics};
use cohold_core::device::motor::COGGING_SHARE;
use cohold_core::device::probe::{Probe, Request, Shape};
use cohold_core::device::stage::{Flow, Measured};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::names::{FixtureName, RenderingName};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::{Allowed, Choice, MOST_OWN_KEYS, Settings, Value};
use std::{array::from_fn, f64::consts::TAU};

use proptest::prelude::*;

use crate::{AnyLaw, SCHEMA};

/// A number of any kind: three in four what a device could say, the others any bits.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        15 => -0.5..0.5_f64,
        1 => any::<u64>().prop_map(f64::from_bits),
        1 => Just(f64::NAN),
        1 => Just(f64::INFINITY),
        1 => Just(-1e38),
        1 => Just(5e-324),
    ]
}

/// One tick's worth of the outside world.
#[derive(Clone, Debug)]
struct Outside {
    numbers: [f64; 7],
    counts: [u16; 3],
    live_ticks: u32,
    read_counts: bool,
    overrun: bool,
    packet: bool,
    /// Shape of a probe that is asked for, if any.
    probe: Option<usize>,
    stage: Option<Measured>,
}

/// Nothing, little, or any bits.
fn stage() -> impl Strategy<Value = Option<Measured>> {
    let flow =
        |most: i16| prop::array::uniform3(-most..=most).prop_map(|[mean, last, voltage]| Flow { mean, last, voltage });
    // Of 6000 counts cool, of any any code.
    let measured = |(motors, supply_mv, supply_counts): ([Flow; AXES], u16, u16)| {
        Some(Measured { motors, supply_mv, supply_counts, thermistor: (supply_counts % 6000 % 64) as u8 })
    };
    prop_oneof![
        2 => Just(None),
        5 => (prop::array::uniform2(flow(300)), 20_000..25_000_u16, Just(6000)).prop_map(measured),
        1 => (prop::array::uniform2(flow(i16::MAX)), any::<u16>(), any::<u16>()).prop_map(measured),
        1 => (Just([Flow { mean: i16::MIN, last: i16::MIN, voltage: i16::MIN }; AXES]), any::<u16>(), 0..2_u16)
            .prop_map(measured),
    ]
}

fn outside() -> impl Strategy<Value = Outside> {
    let probe = prop::option::weighted(0.1, 0..Shape::ALL.len());
    let flags = (any::<bool>(), 0..50_u8, any::<bool>());
    (prop::array::uniform7(any_number()), any::<([u16; 3], u32)>(), flags, probe, stage()).prop_map(
        |(numbers, (counts, live_ticks), (read_counts, overrun, packet), probe, stage)| Outside {
            numbers,
            counts,
            live_ticks,
            read_counts,
            overrun: overrun == 0,
            packet,
            probe,
            stage,
        },
    )
}

/// Settings with every key drawn from its range by one number in 0..=1; 0 and 1 are the ends.
fn settings(draws: &[f64]) -> Settings {
    let mut settings = Settings::default();
    for (key, &draw) in SCHEMA.keys().zip(draws) {
        // Of laws' own keys, which come last, those of the law that was drawn: there is no room for all. Of a list that is
        // longer than the room, one in turn keeps its default.
        let of_a_law = SCHEMA.laws().iter().any(|law| law.keys.contains(&key));
        let own = SCHEMA.law(&settings).map_or(&[][..], |law| law.keys);
        let left = (own.len() as f64 * draws[0]) as usize % own.len().max(1);
        let is_left = |nth| nth == left && own.len() > MOST_OWN_KEYS;
        if of_a_law && own.iter().position(|own| *own == key).is_none_or(is_left) {
            continue;
        }
        let value = match key.allowed {
            // Half the draws over the magnitudes, half over the values.
            Allowed::Number { min, max } if min > 0.0 && draw < 0.5 => {
                Value::Number(min * (max / min).powf(2.0 * draw))
            }
            Allowed::Number { min, max } => Value::Number((min + (max - min) * draw * draw).clamp(min, max)),
            Allowed::Whole { min, max } => Value::Number((f64::from(min) + f64::from(max - min) * draw * draw).round()),
            Allowed::Flag => Value::Flag(draw > 0.5),
            Allowed::Names(names) => Value::Text(pick(names, draw)),
            Allowed::Laws(kinds) => Value::Text(pick(kinds, draw).name),
            Allowed::Only(_) => continue,
        };
        SCHEMA.set(&mut settings, key.name, value).unwrap_or_else(|error| panic!("{}: {error:?}", key.name));
    }
    // Half of all pairs would be out of order, and refused.
    let safety = &mut settings.safety;
    safety.disengage_s = safety.disengage_s.max(safety.fade_s + 1e-5);
    settings.motor.max_supply_v = settings.motor.max_supply_v.max(settings.motor.min_supply_v);
    settings.axis.shared = settings.axis.shared.min(settings.axis.count);
    if settings.axis.shared > 1 {
        settings.contact.one_sided = false;
        settings.contact.rendering = RenderingName::Continuous;
        settings.contact.gap_m = 0.0;
    }
    let law = SCHEMA.law(&settings).expect("a law");
    if !law.scatters {
        (settings.coordination.ledger, settings.coordination.drift_correction) = (false, false);
    }
    let needs_ports = law.own_time || law.budgets().next().is_some();
    if needs_ports && !settings.object.integrator.solves() {
        settings.object.integrator = IntegratorName::Midpoint;
    }
    if settings.object.integrator.solves() {
        settings.coordination.decode = Decode::Implicit;
        settings.object.force_delay_ticks = 0.0;
        SCHEMA.set(&mut settings, "four_channel.at_device", Value::Flag(false)).expect("a flag");
    } else {
        settings.fixture.kind = FixtureName::None;
    }
    if settings.axis.shared == 1 {
        (settings.fixture.direction_rad, settings.fixture.drag_n_s_per_m) = (0.0, 0.0);
    }
    if settings.axis.shared < 3 {
        settings.fixture.elevation_rad = 0.0;
    }
    if settings.axis.shared == 1 || settings.fixture.kind == FixtureName::Guide {
        settings.fixture.friction = 0.0;
    }
    // Cogging has a place with an index only, on one axis, in whole parts of a turn.
    let most = COGGING_SHARE * settings.safety.max_force_n / Joints::of(&settings).usual_per_m;
    let is_known = settings.encoder.index && settings.axis.count == 1;
    let motor = &mut settings.motor;
    motor.cogging_n_or_n_m = if is_known { motor.cogging_n_or_n_m.min(most) } else { 0.0 };
    motor.cogging_period_m_or_rad = TAU / (TAU / motor.cogging_period_m_or_rad).round().clamp(1.0, 6e4);
    settings
}

fn pick<T: Copy>(all: &[T], draw: f64) -> T {
    all[((draw * all.len() as f64) as usize).min(all.len() - 1)]
}

/// The peer that has the axes of the scene.
fn check<S: Scalar>(settings: &Settings, course: &[Outside]) -> Result<(), TestCaseError> {
    match (settings.axis.shared, settings.axis.count) {
        (1, 3) => check_axes::<S, 1, 3, AnySpatial<S>>(settings, course),
        (2, 3) => check_axes::<S, 2, 3, AnySpatial<S>>(settings, course),
        (_, 3) => check_axes::<S, 3, 3, AnySpatial<S>>(settings, course),
        (2, _) => check_axes::<S, 2, 2, AnyKinematics<S>>(settings, course),
        _ => check_axes::<S, 1, 2, AnyKinematics<S>>(settings, course),
    }
}

fn check_axes<S: Scalar, const SHARED: usize, const N: usize, K: Kinematics<S, N>>(
    settings: &Settings,
    course: &[Outside],
) -> Result<(), TestCaseError> {
    let Ok(mut peer) = Peer::<S, AnyLaw<S>, SHARED, N, K>::build(settings, [Motion::REST; N]) else { return Ok(()) };
    peer.command(Command::Arm);
    let (safety, mut before) = (&settings.safety, [0.0; N]);
    let step = safety.max_slew_n_per_s * settings.timing.control_period_s;
    for now in course {
        let [a, b, c, d, e, f, g] = now.numbers.map(S::from_f64);
        if let Some(shape) = now.probe {
            let (limits, period_s) = (&settings.probe, settings.timing.control_period_s);
            let request = Request {
                joint: settings.axis.count,
                shape: Shape::ALL[shape],
                duty: -limits.max_duty.min(settings.motor.max_duty),
                duration_s: limits.max_s,
                frequency_hz: 0.1 / period_s,
            };
            if let Ok(probe) = Probe::build(settings, &request) {
                peer.command(Command::Disarm);
                peer.probe(probe);
            }
        }
        match now.live_ticks % 16 {
            0 => peer.command(Command::Clutch),
            1 => peer.command(Command::Release),
            _ => {}
        }
        if now.packet {
            let [.., energy_j, wave_integral] = now.numbers.map(S::Counter::from_f64);
            let packet = Packet {
                motion: Motion { position: e, velocity: f },
                wave: g,
                energy_j,
                wave_integral,
                live_ticks: now.live_ticks,
            };
            // Another wave along every axis.
            let mut packets = [packet; SHARED];
            for (packet, wave) in packets.iter_mut().zip([g, a, b]) {
                packet.wave = wave;
            }
            peer.hear(&packets);
        }
        if peer.packet_due() {
            let sent = peer.exchange();
            let finite = sent.is_none_or(|sent| sent.iter().all(|packet| packet.is_finite()));
            prop_assert!(finite, "sent {sent:?}");
        }
        let reading = if now.read_counts {
            Reading::Counts(from_fn(|joint| Counts(now.counts[joint])))
        } else {
            let axes = [(a, b), (c, d), (e, f)].map(|(position, velocity)| Motion { position, velocity });
            Reading::Exact(from_fn(|axis| axes[axis]))
        };
        let stage = now.stage.map(|stage| Measured {
            motors: from_fn(|motor| stage.motors[motor % stage.motors.len()]),
            supply_mv: stage.supply_mv,
            supply_counts: stage.supply_counts,
            thermistor: stage.thermistor,
        });
        let actuators = peer.tick(&Sensors { reading, overrun: now.overrun, stage, marks: None });
        // Limits are the device's, forces the world's.
        let forces = actuators.forces.map(|force| force.to_f64() / settings.scale.force);
        let most = safety.max_force_n * (1.0 + 1e-6);
        for (force, before) in forces.into_iter().zip(before) {
            prop_assert!(force.is_finite() && force.abs() <= most, "force {force}");
            // Toward zero it goes at once, away from it slowly.
            let slow = (before.min(0.0)..=before.max(0.0)).contains(&force) || {
                let from = if force > 0.0 { before.max(0.0) } else { before.min(0.0) };
                (force - from).abs() <= step + 1e-6 * most
            };
            prop_assert!(slow, "from {before} to {force}");
        }
        before = forces;
        if peer.mode() == Mode::Armed {
            // What is reported of the tick is as finite as what it did.
            for (seen, ledger) in peer.observed().into_iter().zip(peer.ledger()) {
                let motions = [seen.device, seen.object, seen.desired];
                let numbers = [seen.contact_force, seen.coordination_force, ledger.received_j(), ledger.sent_j()];
                let finite = motions.iter().all(|motion| motion.is_finite()) && numbers.iter().all(|n| n.is_finite());
                prop_assert!(finite, "{seen:?} {ledger:?}");
            }
        }
        let on = actuators.enable || actuators.forces.iter().any(|f| f.to_f64() != 0.0);
        let on_when = [Mode::Armed, Mode::Probing];
        prop_assert!(!on || on_when.contains(&peer.mode()), "forces while {:?}", peer.mode());
        if peer.mode() == Mode::Probing {
            let most = (settings.probe.max_duty.min(settings.motor.max_duty) * 32767.0) as i16;
            let within = actuators.duties.iter().all(|duty| duty.0.saturating_abs() <= most);
            prop_assert!(within && actuators.forces.iter().all(|f| f.to_f64() == 0.0), "{actuators:?}");
        } else if peer.mode() == Mode::Disarmed {
            peer.command(Command::Arm);
        }
        if matches!(peer.mode(), Mode::Faulted(_)) {
            // Keep going as an operator would: everything must hold after any fault.
            peer.command(Command::Clear);
            peer.command(Command::Arm);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn forces_stay_finite_and_within_limits(
        draws in prop::collection::vec(0.0..=1.0_f64, SCHEMA.keys().count()),
        course in prop::collection::vec(outside(), 1..120),
    ) {
        let settings = settings(&draws);
        check::<f32>(&settings, &course)?;
        check::<f64>(&settings, &course)?;
        check::<Fixed>(&settings, &course)?;
    }
}

/// The draws above would prove nothing if `build()` refused them all.
#[test]
fn most_drawn_settings_are_accepted() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let strategy = prop::collection::vec(0.0..=1.0_f64, SCHEMA.keys().count());
    let accepted = (0..1000)
        .filter(|_| {
            let draws = strategy.new_tree(&mut runner).expect("a vector of numbers").current();
            settings(&draws).check_with::<AnyLaw<f64>>().is_ok()
        })
        .count();
    assert!(accepted > 150, "only {accepted} of 1000 random settings build");
}
