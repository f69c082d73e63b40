//! No force steps because a peer lets go: when it has been silent for too long, and when it is known to be gone.

use cohold_core::device::Reading;
use cohold_core::device::kinematics::{AnyKinematics, AnySpatial, Kinematics};
use cohold_core::law::degradation::STEP_N;
use cohold_core::law::{Law, LawInfo};
use cohold_core::names::{Decode, FixtureName, IntegratorName};
use cohold_core::num::Motion;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::{Settings, Value};

use crate::{AnyLaw, SCHEMA};

const PERIOD_S: f64 = 1e-3;
/// Mass of a hand with its device, and its damping.
const HAND_KG: f64 = 0.3;
const HAND_N_S_PER_M: f64 = 10.0;
/// When pushes are at rest, and how long a peer hears nothing from then on, ticks.
const SETTLED: u32 = 3000;
const SILENT: u32 = 1500;

const LAWS: &[LawInfo] = <AnyLaw<f64> as Law<f64>>::LAWS;

/// A law with the gains that it proposes, but the silences of a board as it is delivered.
fn settings(law: &'static LawInfo, axes: u32, ticks_per_packet: u32) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = law.name;
    for gain in law.gains {
        let (key, value) = gain.split_once('=').expect("a key and a value");
        if !["safety.fade_s", "safety.disengage_s", "event.longest_s"].contains(&key) {
            let value = value.parse().map_or(Value::Text(value), Value::Number);
            SCHEMA.set(&mut settings, key, value).unwrap_or_else(|error| panic!("{key}: {error:?}"));
        }
    }
    settings.coordination.decode = Decode::Implicit;
    if settings.object.integrator == IntegratorName::ForwardEuler {
        settings.object.integrator = IntegratorName::SemiImplicit;
    }
    (settings.object.force_delay_ticks, settings.object.damping_n_s_per_m) = (0.0, 2.0);
    (settings.axis.count, settings.axis.shared) = (axes.max(2), axes);
    settings.timing.ticks_per_packet = ticks_per_packet;
    settings
}

/// What came of a peer that let go, the worst of all axes.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// Largest change of the coordination force in a tick from then on, N.
    step_n: f64,
    /// Coordination force when it let go, and at the end, N.
    let_go_n: f64,
    after_n: f64,
    /// What the coordination force did to a copy from then on, J.
    work_j: f64,
    /// Largest change of the force on the hand in a tick, since nothing is heard, N.
    felt_n: f64,
}

/// Two persons who push against each other with a constant force until the first peer hears nothing any more, or `parts`.
fn run<const SHARED: usize, const N: usize, K: Kinematics<f64, N>>(
    settings: &Settings,
    push_n: f64,
    parts: bool,
) -> Found {
    let peer = || Peer::<f64, AnyLaw<f64>, SHARED, N, K>::build(settings, [Motion::REST; N]).expect("good settings");
    let mut peers = [peer(), peer()];
    peers.iter_mut().for_each(|peer| peer.command(Command::Arm));
    let mut hands = [[Motion::<f64>::REST; N]; 2];
    let mut last = peers[0].observed().map(|seen| *seen);
    let (mut work_j, mut felt) = ([0.0; SHARED], [0.0; N]);
    let mut found = Found::default();
    for tick in 0..SETTLED + SILENT {
        if tick == SETTLED && parts {
            peers[0].part();
        }
        if peers[0].packet_due() {
            let said = [0, 1].map(|at| peers[at].speak());
            for (at, packets) in said.into_iter().enumerate() {
                if let Some(packets) = packets.filter(|_| at == 0 || tick < SETTLED) {
                    peers[1 - at].hear(&packets);
                }
            }
            peers.iter_mut().for_each(Peer::listen);
        }
        for (at, peer) in peers.iter_mut().enumerate() {
            let forces = peer.tick(&Sensors::of(Reading::Exact(hands[at]))).forces;
            assert_eq!(peer.mode(), Mode::Armed, "tick {tick}");
            if at == 0 {
                let changes =
                    forces.iter().zip(core::mem::replace(&mut felt, forces)).map(|(now, was)| (now - was).abs());
                found.felt_n = changes.fold(if tick < SETTLED { 0.0 } else { found.felt_n }, f64::max);
            }
            for (axis, hand) in hands[at].iter_mut().enumerate() {
                let share = f64::from(tick.min(1000)) / 1000.0;
                let sign = [1.0, -1.0][at] * [1.0, -0.7, 0.4][axis];
                let push = if axis < SHARED { share * sign * push_n } else { 0.0 };
                let velocity = (hand.velocity + PERIOD_S / HAND_KG * (push + forces[axis]))
                    / (1.0 + PERIOD_S * HAND_N_S_PER_M / HAND_KG);
                *hand = Motion { position: hand.position + PERIOD_S * velocity, velocity };
            }
        }
        let gone = !peers[0].is_engaged();
        let seen = peers[0].observed().map(|seen| *seen);
        if !gone {
            found.let_go_n = seen.iter().map(|seen| seen.coordination_force.abs()).fold(0.0, f64::max);
        }
        for axis in 0..SHARED {
            let (was, now) = (last[axis], seen[axis]);
            let change = (now.coordination_force - was.coordination_force).abs();
            if gone {
                found.step_n = found.step_n.max(change);
                work_j[axis] += was.coordination_force * (now.object.position - was.object.position);
                found.work_j = found.work_j.max(work_j[axis]);
            }
            found.after_n = now.coordination_force;
        }
        last = seen;
    }
    found
}

/// Runs of a law with as many axes as these.
fn worst<const SHARED: usize, const N: usize, K: Kinematics<f64, N>>(
    law: &'static LawInfo,
    change: impl Fn(&mut Settings),
) {
    for (ticks_per_packet, push_n, parts) in
        [(1, 1.0, false), (8, 3.0, false), (2, 5.0, false), (1, 3.0, true), (2, 1.0, true), (8, 5.0, true)]
    {
        let mut settings = settings(law, SHARED as u32, ticks_per_packet);
        settings.axis.count = N as u32;
        change(&mut settings);
        if settings.check_with::<AnyLaw<f64>>().is_err() {
            return;
        }
        let found = run::<SHARED, N, K>(&settings, push_n, parts);
        let told = format!("{}, {SHARED} axes, {push_n} N, {ticks_per_packet}, parts {parts}: {found:?}", law.name);
        // The force of this law jumps where its spring turns round, in the last tick as well.
        let jumps_n = if law.name == "fractal-impedance" { 1.0 } else { 0.0 };
        assert!(found.step_n <= STEP_N.max(jumps_n) + 1e-9 && found.after_n == 0.0, "{told}");
        // This law lets no packet stand: what one has brought is emitted in M ticks, and its end is still then, after any loss.
        let most = if law.name == "wave-integral" { 0.15 } else { 0.02 };
        assert!(found.felt_n <= most, "{told}");
        let stored_j = 0.5 * found.let_go_n * found.let_go_n / settings.coordination.stiffness_n_per_m;
        assert!(found.work_j <= stored_j + 1e-12, "{told}");
    }
}

#[test]
fn no_force_steps_when_a_peer_lets_go() {
    for law in LAWS {
        worst::<1, 2, AnyKinematics<f64>>(law, |_| ());
        worst::<2, 2, AnyKinematics<f64>>(law, |_| ());
        worst::<3, 3, AnySpatial<f64>>(law, |_| ());
    }
}

/// A guide across the axes, so that their laws are solved for together.
#[test]
fn no_force_steps_along_axes_that_are_solved_for_together() {
    for law in LAWS {
        let guide = |settings: &mut Settings| {
            settings.object.integrator = IntegratorName::Midpoint;
            settings.fixture.kind = FixtureName::Guide;
            (settings.fixture.stiffness_n_per_m, settings.fixture.direction_rad) = (100.0, 0.6);
        };
        worst::<2, 2, AnyKinematics<f64>>(law, guide);
        worst::<3, 3, AnySpatial<f64>>(law, guide);
    }
}

/// A wave that is paid for ends with what pays for it, in silence as in any loss: its force goes before the line fades.
#[test]
fn a_paid_wave_takes_its_force_with_it() {
    for law in LAWS.iter().filter(|law| law.scatters) {
        for (ticks_per_packet, push_n) in [(1, 1.0), (8, 3.0), (2, 5.0)] {
            let mut settings = settings(law, 1, ticks_per_packet);
            settings.coordination.ledger = true;
            if settings.check_with::<AnyLaw<f64>>().is_err() {
                continue;
            }
            let found = run::<1, 2, AnyKinematics<f64>>(&settings, push_n, false);
            let told = format!("{}, {push_n} N, {ticks_per_packet}: {found:?}", law.name);
            assert!(found.felt_n <= 0.026 * push_n && found.step_n <= STEP_N + 1e-9 && found.after_n == 0.0, "{told}");
        }
    }
}
