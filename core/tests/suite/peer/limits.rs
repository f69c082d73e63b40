//! What limits do is passive: whatever cuts the force of a contact, the hand's work is never less than what device and copy have of it.

use cohold_core::contact::{RenderingName, Side};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::AnyLaw;
use cohold_core::names::{Decode, FixtureName};
use cohold_core::num::Motion;
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

use crate::contact::setup::Random;

const PERIOD_S: f64 = 1e-3;

/// A board's limits as it is delivered, and a contact within what its sampling allows beside a device of 1 N·s/m: K_LC·T_c ≤ 4·√(B_LC·b).
fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "none";
    settings.coordination.decode = Decode::Implicit;
    (settings.object.integrator, settings.object.force_delay_ticks) = (IntegratorName::Midpoint, 0.0);
    (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (3.0, 60.0);
    settings.safety.saturated_ticks = 10_000;
    settings.safety.workspace_m = 1000.0;
    settings
}

/// A mass with damping, m·v̇ + b·v = F, exactly, on both axes of a device.
struct Device {
    mass_kg: f64,
    damping: f64,
    axes: [Motion<f64>; AXES],
    /// What its hand has done, J.
    work_j: f64,
}

impl Device {
    fn fly(&mut self, forces: [f64; AXES], pushes: [f64; AXES]) {
        let gone = -(-PERIOD_S * self.damping / self.mass_kg).exp_m1();
        let lasting_s = self.mass_kg / self.damping;
        for (axis, (force, push)) in self.axes.iter_mut().zip(forces.into_iter().zip(pushes)) {
            let end = (force + push) / self.damping;
            let moved = end * PERIOD_S + (axis.velocity - end) * lasting_s * gone;
            axis.velocity += (end - axis.velocity) * gone;
            axis.position += moved;
            self.work_j += push * moved;
        }
    }

    fn energy_j(&self) -> f64 {
        self.axes.iter().map(|axis| 0.5 * self.mass_kg * axis.velocity.powi(2)).sum()
    }
}

/// What one run came to.
#[derive(Debug, Default)]
struct Found {
    /// The least, at the end of any tick, of the hand's work less the energy of device and copy, J.
    least_j: f64,
    /// Of all that the hand did, one way or the other.
    most_j: f64,
    limited: u32,
    braked: u32,
    /// Runs that ended because limiting failed.
    ended: u32,
}

/// A hand that pushes the device about at random, for so many ticks.
fn shaken(settings: &Settings, random: &mut Random, ticks: u32) -> Found {
    let mut peer = Peer::<f64, AnyLaw<f64>>::new(settings, [Motion::REST; AXES]).expect("good settings");
    peer.command(Command::Arm);
    let mut device = Device { mass_kg: 0.1, damping: 1.0, axes: [Motion::REST; AXES], work_j: 0.0 };
    let mut found = Found::default();
    let (mut pushes, mut last) = ([0.0; AXES], 0.0_f64);
    let strength = random.scale(0.2, 8.0);
    for _ in 0..ticks {
        if random.unit() < 0.02 {
            pushes = [strength * random.between(-1.0, 1.0), 0.5 * strength * random.between(-1.0, 1.0)];
        }
        let forces = peer.tick(&Sensors::of(Reading::Exact(device.axes))).forces;
        if peer.mode() == Mode::Faulted(Fault::Overspeed) {
            found.ended += 1;
            break;
        }
        assert_eq!(peer.mode(), Mode::Armed);
        let seen = *peer.observed()[0];
        // What the device feels is what the copy gets, in every tick in which it does not brake.
        let (braked, velocity) = (forces[0] + seen.contact_force, seen.device.velocity);
        let brakes = velocity.abs() > settings.safety.max_speed_m_per_s;
        assert!(if brakes { braked * velocity <= 1e-12 } else { braked.abs() < 1e-12 }, "{braked} N at {velocity} m/s");
        found.braked += u32::from(brakes);
        found.limited += u32::from(forces[0].abs() > last.abs() + 0.0599 || forces[0].abs() > 2.999);
        last = forces[0];
        let copy_j = 0.5 * settings.object.mass_kg * seen.object.velocity.powi(2);
        found.least_j = found.least_j.min(device.work_j - device.energy_j() - copy_j);
        found.most_j = found.most_j.max(device.work_j.abs());
        device.fly(forces, if settings.axis.count == 1 { [pushes[0], 0.0] } else { pushes });
    }
    found
}

/// Two-sided, with play, one-sided and with impacts; with a guide or a wall at the copy; beside an axis that is held.
#[test]
fn no_contact_that_is_cut_gives_more_than_it_was_given() {
    let found = every_contact(Random(21), |_, _| ());
    assert!(found.limited > 20_000 && found.braked == 0, "{found:?}");
}

/// Hands that move faster than devices may, and press harder than they may for long: both are limited, a device that brakes only takes, and
/// where that does not help it ends.
#[test]
fn no_device_that_brakes_or_tires_gives_more_than_it_was_given() {
    let found = every_contact(Random(22), |settings, random| {
        settings.safety.max_speed_m_per_s = random.scale(0.3, 3.0);
        settings.safety.max_rms_force_n = random.scale(0.3, 3.0);
        settings.safety.max_rms_power_w = random.scale(0.3, 3.0);
        settings.safety.rms_s = random.scale(0.2, 1.0);
    });
    assert!(found.limited > 20_000 && found.braked > 20_000 && (10..500).contains(&found.ended), "{found:?}");
}

/// Runs of 1,000 contacts, with settings changed like this.
fn every_contact(mut random: Random, change: impl Fn(&mut Settings, &mut Random)) -> Found {
    let mut all = Found::default();
    for run in 0..1000 {
        let mut settings = settings();
        settings.object.mass_kg = random.scale(0.05, 1.0);
        settings.contact.stiffness_n_per_m = random.scale(100.0, 2500.0);
        settings.safety.max_force_n = random.scale(0.5, 6.0);
        settings.safety.max_slew_n_per_s = random.scale(10.0, 1000.0);
        match run % 5 {
            1 => settings.contact.gap_m = 0.002,
            2 => settings.contact.one_sided = true,
            3 => {
                settings.contact.one_sided = true;
                settings.contact.rendering = RenderingName::Impulsive;
                settings.contact.restitution = random.unit();
            }
            4 => {
                settings.fixture.kind = [FixtureName::Guide, FixtureName::ForbiddenAbove][run % 2];
                settings.fixture.stiffness_n_per_m = random.scale(100.0, 1e4);
                settings.fixture.position_m = 0.0;
            }
            _ => {}
        }
        settings.axis.count = 1 + (run % 2) as u32;
        settings.contact.side = if random.unit() < 0.5 { Side::Left } else { Side::Right };
        change(&mut settings, &mut random);
        let found = shaken(&settings, &mut random, 2000);
        all.limited += found.limited;
        all.braked += found.braked;
        all.ended += found.ended;
        assert!(found.least_j > -1e-4 * found.most_j.max(1e-3), "run {run}: {found:?}, {:?}", settings.contact);
    }
    all
}

/// A hand that sweeps to and fro by 0.15 m in 0.4 s, with an arm of 300 N/m and 10 N·s/m that follows a movement of least jerk: how fast the
/// device went, m/s, and the most with which it braked, N.
fn sweep(max_speed_m_per_s: f64) -> (f64, f64) {
    let mut settings = settings();
    settings.safety.max_speed_m_per_s = max_speed_m_per_s;
    let mut peer = Peer::<f64, AnyLaw<f64>>::new(&settings, [Motion::REST; AXES]).expect("good settings");
    peer.command(Command::Arm);
    let mut device = Device { mass_kg: 0.1, damping: 1.0, axes: [Motion::REST; AXES], work_j: 0.0 };
    let (mut fastest, mut braked) = (0.0_f64, 0.0_f64);
    for sweep in 0..6 {
        for tick in 0..800 {
            let s = (f64::from(tick) / 400.0).min(1.0);
            let [way, rate] = [s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * (s * (1.0 - s)).powi(2) / 0.4]
                .map(|part| 0.15 * part);
            let (goal, rate) = if sweep % 2 == 0 { (way, rate) } else { (0.15 - way, -rate) };
            let forces = peer.tick(&Sensors::of(Reading::Exact(device.axes))).forces;
            assert_eq!(peer.mode(), Mode::Armed, "sweep {sweep}, tick {tick}: {:?}", device.axes[0]);
            let at = device.axes[0];
            fastest = fastest.max(at.velocity.abs());
            braked = braked.max((forces[0] + peer.observed()[0].contact_force).abs());
            device.fly(forces, [300.0 * (goal - at.position) + 10.0 * (rate - at.velocity), 0.0]);
        }
        let goal = if sweep % 2 == 0 { 0.15 } else { 0.0 };
        assert!((device.axes[0].position - goal).abs() < 0.01, "{:?}", device.axes[0]);
    }
    (fastest, braked)
}

/// Beside a device that is limited to 3 N and 0.5 m/s, as at a PC and on a board: it brakes, the hand comes to where it wanted, and nothing ends.
#[test]
fn a_hand_that_sweeps_goes_on() {
    let (free, none) = sweep(10.0);
    let (braked, most) = sweep(0.5);
    assert!(free > 0.7 && none < 1e-9 && braked < free && (1.0..3.0).contains(&most), "{free}, {braked} m/s, {most} N");
}
