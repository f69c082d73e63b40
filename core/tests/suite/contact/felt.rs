//! What the object takes is what the device gives: impacts and rest in a whole peer, beside a device that is nothing but a
//! mass under the forces that were commanded, which act up to a tick late.

use cohold_core::contact::{RenderingName, Side};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::AnyLaw;
use cohold_core::names::Decode;
use cohold_core::num::Motion;
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

use super::setup::Random;

const PERIOD_S: f64 = 1e-3;

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.contact.rendering = RenderingName::Impulsive;
    settings.contact.one_sided = true;
    settings.coordination.comm = "none";
    settings.object.force_delay_ticks = 0.0;
    // Nobody holds what flies on after an impact.
    settings.safety.workspace_m = 1000.0;
    midpoint(settings)
}

fn midpoint(mut settings: Settings) -> Settings {
    settings.object.integrator = IntegratorName::Midpoint;
    settings.coordination.decode = Decode::Implicit;
    settings
}

fn staged(mut settings: Settings) -> Settings {
    settings.object.integrator = IntegratorName::SemiImplicit;
    settings
}

/// A device, a mass and nothing else.
struct Device {
    mass_kg: f64,
    motion: Motion<f64>,
    /// How late a force acts, ticks.
    delay: f64,
    /// The force that was commanded last, N.
    force: f64,
    /// A hand that pushes, N.
    push: f64,
}

impl Device {
    /// Under a steady force for a part of a tick, exactly.
    fn fly(&mut self, force: f64, seconds: f64) {
        let change = seconds / self.mass_kg * (force + self.push);
        self.motion.position += seconds * (self.motion.velocity + 0.5 * change);
        self.motion.velocity += change;
    }

    fn tick(&mut self, peer: &mut Peer<f64, AnyLaw<f64>>) {
        let mut axes = [Motion::REST; AXES];
        axes[0] = self.motion;
        let force = peer.tick(&Sensors::of(Reading::Exact(axes))).forces[0];
        assert_eq!(peer.mode(), Mode::Armed);
        if self.delay > 0.0 {
            self.fly(self.force, self.delay * PERIOD_S);
        }
        self.fly(force, (1.0 - self.delay) * PERIOD_S);
        self.force = force;
    }

    /// Momentum with what is under way, N·s.
    fn momentum(&self) -> f64 {
        self.mass_kg * self.motion.velocity + self.delay * PERIOD_S * self.force
    }

    fn energy(&self) -> f64 {
        0.5 * self.mass_kg * self.motion.velocity.powi(2)
    }
}

/// A peer and a device at rest, just clear of the object.
fn meet(settings: &Settings, mass_kg: f64, delay: f64) -> (Peer<f64, AnyLaw<f64>>, Device) {
    let peer = Peer::new(settings, [Motion::REST; AXES]).expect("good settings");
    (peer, Device { mass_kg, motion: Motion::REST, delay, force: 0.0, push: 0.0 })
}

/// One impact at this speed, begun anew: the object at rest again, just clear of the device. Relative errors of momentum (worst
/// of all ticks) and of energy less what restitution takes, and by how much of itself energy ever grew.
fn strike(peer: &mut Peer<f64, AnyLaw<f64>>, device: &mut Device, object_kg: f64, velocity: f64) -> [f64; 3] {
    peer.command(Command::Disarm);
    peer.command(Command::Arm);
    (device.motion.velocity, device.force) = (velocity, 0.0);
    let (momentum, energy) = (device.momentum(), device.energy());
    let (mut wrong, mut most) = (0.0_f64, 0.0_f64);
    let mut began = false;
    loop {
        device.tick(peer);
        let object = peer.observed()[0].object.velocity;
        wrong = wrong.max((device.momentum() + object_kg * object - momentum).abs());
        // Where what is under way has acted, so that energy means something.
        let arrived = 0.5 * device.momentum().powi(2) / device.mass_kg + 0.5 * object_kg * object * object;
        most = most.max(arrived / energy - 1.0);
        if began && device.force == 0.0 {
            let lost = peer.impacts()[0].lost_j;
            assert_eq!(peer.impacts()[0].count, 1);
            return [wrong / momentum.abs(), ((arrived + lost) / energy - 1.0).abs(), most];
        }
        began |= device.force != 0.0;
    }
}

fn worst(worst: &mut [f64; 3], of: [f64; 3]) {
    worst.iter_mut().zip(of).for_each(|(worst, of)| *worst = worst.max(of));
}

/// The default limits of force, masses and contact; 0.02 to 5 m/s, any delay of the motor, both ways to move the object.
#[test]
fn a_million_impacts_under_the_default_limits_conserve_momentum_and_energy() {
    let (mut random, mut all) = (Random(11), [0.0; 3]);
    for run in 0..1000 {
        let mut settings = if run % 2 == 0 { settings() } else { staged(settings()) };
        settings.contact.side = if run % 4 < 2 { Side::Left } else { Side::Right };
        let sign = if run % 4 < 2 { 1.0 } else { -1.0 };
        let (mut peer, mut device) = meet(&settings, 0.1, if run % 8 == 0 { 1.0 } else { random.unit() });
        for _ in 0..1000 {
            let of = strike(&mut peer, &mut device, 0.3, sign * random.scale(0.02, 5.0));
            worst(&mut all, of);
        }
    }
    assert!(all.iter().all(|worst| *worst < 1e-12), "{all:?}");
}

/// Any masses, speeds, restitution, limits and delays.
#[test]
fn random_impacts_conserve_or_lose() {
    let (mut random, mut all) = (Random(12), [0.0; 3]);
    for run in 0..20_000 {
        let mut settings = if run % 2 == 0 { settings() } else { staged(settings()) };
        settings.contact.device_mass_kg = random.scale(0.02, 2.0);
        settings.contact.restitution = random.unit();
        settings.object.mass_kg = random.scale(0.02, 2.0);
        settings.safety.max_force_n = random.scale(2.0, 200.0);
        settings.safety.max_slew_n_per_s = random.scale(1e3, 1e6);
        settings.safety.saturated_ticks = 10_000;
        let (mut peer, mut device) = meet(&settings, settings.contact.device_mass_kg, random.unit());
        let of = strike(&mut peer, &mut device, settings.object.mass_kg, random.scale(0.01, 5.0));
        worst(&mut all, of);
        // Thought lighter than it is, a device keeps some of its speed: momentum stays, energy is not made.
        let (mut peer, mut device) = meet(&settings, random.scale(1.0, 10.0) * device.mass_kg, random.unit());
        let [momentum, _, most] = strike(&mut peer, &mut device, settings.object.mass_kg, random.scale(0.01, 5.0));
        worst(&mut all, [momentum, 0.0, most]);
    }
    assert!(all.iter().all(|worst| *worst < 1e-12), "{all:?}");
}

/// 1 m/s under the default limits: the object took 0.15 N·s and the device 0.02, and momentum was 2.55 times what it had been.
#[test]
fn an_impact_beyond_the_limits_makes_no_momentum() {
    for settings in [settings(), staged(settings())] {
        let (mut peer, mut device) = meet(&settings, 0.1, 1.0);
        let [momentum, energy, most] = strike(&mut peer, &mut device, 0.3, 1.0);
        assert!(momentum < 1e-14 && energy < 1e-13 && most < 1e-13, "{momentum} {energy} {most}");
        assert!((peer.observed()[0].object.velocity - 0.5).abs() < 1e-14);
        assert!((device.momentum() + 0.05).abs() < 1e-15);
    }
}

/// Why whoever knows the device refuses a `contact.device_mass_kg` above its mass: of an elastic impact with 0.3 kg it makes energy,
/// 9.8 times as much where 0.1 kg are taken for 0.4, though never momentum.
#[test]
fn a_device_taken_for_heavier_makes_energy_and_for_lighter_none() {
    for taken_for in [0.05, 0.099, 0.1, 0.101, 0.4] {
        let mut settings = settings();
        settings.contact.device_mass_kg = taken_for;
        (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (200.0, 1e6);
        let (mut peer, mut device) = meet(&settings, 0.1, 1.0);
        let [momentum, _, most] = strike(&mut peer, &mut device, 0.3, 0.5);
        let [reduced, taken] = [0.1, taken_for].map(|mass| 1.0 / (1.0 / mass + 1.0 / 0.3));
        let made = 0.75 * ((2.0 * taken / reduced - 1.0_f64).powi(2) - 1.0);
        assert!(momentum < 1e-14, "{taken_for}: {momentum}");
        assert!((most - made.max(0.0)).abs() < 1e-12, "{taken_for}: {most}, not {made}");
        assert!(taken_for != 0.4 || (most + 1.0 - 9.8).abs() < 0.05, "{most}");
    }
}

/// The limits let the force up by 20 N a tick, to 40 N, and down at once: 150 mN·s take five ticks, the last one what is left.
#[test]
fn an_impulse_takes_as_long_as_its_force_needs_to_rise() {
    let (mut peer, mut device) = meet(&settings(), 0.1, 0.0);
    peer.command(Command::Arm);
    device.motion.velocity = 1.0;
    let mut forces = Vec::new();
    while forces.last().is_none_or(|force| *force != 0.0) || forces.len() < 3 {
        device.tick(&mut peer);
        forces.push(device.force);
    }
    let pulses: Vec<f64> = forces.into_iter().filter(|force| *force != 0.0).collect();
    let wanted = [-20.0, -40.0, -40.0, -40.0, -10.0];
    let right = pulses.iter().zip(wanted).all(|(pulse, wanted)| (pulse - wanted).abs() < 1e-9);
    assert!(right && pulses.len() == wanted.len(), "{pulses:?}");
}

/// A hand that pulls the device away while pulses are still owed: they part as fast as restitution has it, and no faster for it.
#[test]
fn who_is_pulled_away_is_not_pushed() {
    let mut settings = settings();
    settings.safety.max_force_n = 5.0;
    let delivered = |push: f64| {
        let (mut peer, mut device) = meet(&settings, 0.1, 0.0);
        peer.command(Command::Arm);
        device.motion.velocity = 1.0;
        device.tick(&mut peer);
        device.push = push;
        for _ in 0..60 {
            device.tick(&mut peer);
        }
        peer.impacts()[0].delivered_n_s
    };
    assert!((delivered(0.0) - 0.15).abs() < 1e-12);
    // 10 N stop 0.1 kg twice as fast as 5 N do.
    assert!(delivered(-10.0) < 0.08, "{}", delivered(-10.0));
}

/// A steady push against an object that nothing moves sinks in by F/K_LC, whatever the restitution, and stays there.
#[test]
fn a_resting_push_does_not_sink() {
    for restitution in [1.0, 0.8, 0.5, 0.0] {
        for (base, delay) in
            [(settings(), 1.0), (settings(), 0.0), (staged(settings()), 1.0), (staged(settings()), 0.0)]
        {
            for start in [0.0, 0.02, 0.2] {
                let mut settings = base;
                settings.contact.restitution = restitution;
                settings.contact.damping_n_s_per_m = 5.0;
                settings.object.mass_kg = 1000.0;
                let (mut peer, mut device) = meet(&settings, 0.1, delay);
                peer.command(Command::Arm);
                (device.motion.velocity, device.push) = (start, 1.0);
                let mut depths = Vec::new();
                for tick in 0..4000 {
                    device.tick(&mut peer);
                    if tick >= 3000 {
                        depths.push(device.motion.position - peer.observed()[0].object.position);
                    }
                }
                // Without loss a bounce of 0.2 m/s never ends.
                if restitution == 1.0 && start > 0.1 {
                    continue;
                }
                let said = || format!("e {restitution}, {:?}, delay {delay}, {start} m/s", settings.object.integrator);
                assert!(depths.iter().all(|depth| (depth / 1e-3 - 1.0).abs() < 0.01), "{}: {:?}", said(), &depths[..3]);
            }
        }
    }
}

/// Slower than a count of the encoder (5 µm) in a tick nothing strikes: it rests at once.
#[test]
fn what_crawls_does_not_strike() {
    for (speed, impacts) in [(4.9e-3, 0), (5.1e-3, 1)] {
        let (mut peer, mut device) = meet(&settings(), 0.1, 1.0);
        peer.command(Command::Arm);
        device.motion.velocity = speed;
        for _ in 0..200 {
            device.tick(&mut peer);
        }
        assert_eq!(peer.impacts()[0].count, impacts);
        assert!(peer.observed()[0].object.velocity > 0.25 * speed, "{:?}", peer.observed()[0]);
    }
}

/// A plastic impact goes over into the spring: momentum stays, and the spring gives back no more than was lost.
#[test]
fn what_rests_makes_no_energy() {
    let mut random = Random(13);
    for run in 0..5_000 {
        let mut settings = staged(settings());
        settings.contact.restitution = if run % 2 == 0 { 0.0 } else { 0.3 * random.unit() };
        settings.contact.device_mass_kg = random.scale(0.02, 2.0);
        settings.object.mass_kg = random.scale(0.02, 2.0);
        settings.safety.max_force_n = random.scale(5.0, 200.0);
        settings.safety.max_slew_n_per_s = random.scale(1e4, 1e6);
        settings.safety.saturated_ticks = 10_000;
        let (mut peer, mut device) = meet(&settings, settings.contact.device_mass_kg, random.unit());
        peer.command(Command::Arm);
        device.motion.velocity = random.scale(0.01, 3.0);
        let (momentum, energy) = (device.momentum(), device.energy());
        for _ in 0..300 {
            let before = device.momentum();
            device.tick(&mut peer);
            // A force of rest moves the object through the tick that it is given in, an impulse before it.
            let object = settings.object.mass_kg * peer.observed()[0].object.velocity;
            let wrong = [before, device.momentum()].map(|device| (device + object - momentum).abs());
            assert!(wrong[0].min(wrong[1]) < 1e-12 * momentum, "run {run}: {wrong:?}");
            let now = device.energy() + 0.5 * object * object / settings.object.mass_kg;
            assert!(device.force != 0.0 || now <= energy * (1.0 + 1e-12), "run {run}: {now} of {energy}");
        }
    }
}

/// So far from its object that no number says the force: it is out of its workspace before there is one.
#[test]
fn a_push_beyond_the_range_of_numbers_is_a_fault() {
    for settings in [settings(), staged(settings())] {
        let mut peer = Peer::<f32, AnyLaw<f32>>::new(&settings, [Motion::at(-1e38); AXES]).expect("good settings");
        peer.command(Command::Arm);
        // So slow that it rests at once.
        let axes = [Motion { position: 0.0, velocity: 1e-3 }; AXES];
        let forces = peer.tick(&Sensors::of(Reading::Exact(axes))).forces;
        assert_eq!((peer.mode(), forces[0]), (Mode::Faulted(Fault::OutOfWorkspace), 0.0));
    }
}
