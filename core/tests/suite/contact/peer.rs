//! Impulsive contact in a whole peer: crossings at every speed, the pulse, the limits above it and the account.

use cohold_core::contact::{RenderingName, Side};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::AnyLaw;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::Settings;

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.contact.rendering = RenderingName::Impulsive;
    settings.contact.one_sided = true;
    settings.contact.gap_m = 0.01;
    settings.coordination.comm = "none";
    settings.object.integrator = IntegratorName::SemiImplicit;
    settings.safety.max_speed_m_per_s = 100.0;
    settings
}

/// A device (kg) that obeys the motor, sampled exactly.
struct Rig<S: Scalar> {
    peer: Peer<S, AnyLaw<S>>,
    device: Motion<f64>,
    mass_kg: f64,
    /// The largest force commanded, N.
    peak_n: f64,
}

impl<S: Scalar> Rig<S> {
    fn new(settings: &Settings, velocity: f64) -> Self {
        let mut peer = Peer::new(settings, [Motion::REST; AXES]).expect("good settings");
        peer.command(Command::Arm);
        Self { peer, device: Motion { position: 0.0, velocity }, mass_kg: settings.contact.device_mass_kg, peak_n: 0.0 }
    }

    fn tick(&mut self) {
        let mut axes = [Motion::REST; AXES];
        axes[0] = Motion { position: S::from_f64(self.device.position), velocity: S::from_f64(self.device.velocity) };
        let force = self.peer.tick(&Sensors::of(Reading::Exact(axes)));
        let force = force.forces[0].to_f64();
        self.peak_n = self.peak_n.max(force.abs());
        let change = 1e-3 / self.mass_kg * force;
        self.device.position += 1e-3 * (self.device.velocity + 0.5 * change);
        self.device.velocity += change;
        assert_eq!(self.peer.mode(), Mode::Armed);
    }

    fn object(&self) -> Motion<f64> {
        let seen = self.peer.observed()[0].object;
        Motion { position: seen.position.to_f64(), velocity: seen.velocity.to_f64() }
    }
}

/// At every speed that the guard lets pass, from both sides: one impact, the velocity of the closed form, on the path that
/// starts where device and surface met. Light enough for one pulse at 99 m/s.
fn every_speed<S: Scalar>(within: f64) {
    for side in [Side::Left, Side::Right] {
        let sign = if side == Side::Left { 1.0 } else { -1.0 };
        for tenth in 1..=990 {
            let speed = 0.1 * f64::from(tenth);
            let mut settings = settings();
            settings.contact.side = side;
            (settings.object.mass_kg, settings.contact.device_mass_kg) = (3e-3, 1e-3);
            (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (200.0, 1e6);
            let mut rig = Rig::<S>::new(&settings, sign * speed);
            // The motor is off: the device flies on, the object flies ahead of it.
            rig.mass_kg = 1e12;
            let ticks = (0.01 / speed / 1e-3).ceil() as u32 + 2;
            for _ in 0..ticks {
                rig.tick();
            }
            assert_eq!(rig.peer.impacts()[0].count, 1, "at {speed} m/s in {}", S::NAME);
            // m 1 g on 3 g at rest: half the speed. It was hit at 10 mm.
            let object = rig.object();
            assert!((object.velocity - sign * 0.5 * speed).abs() < within * speed, "{object:?} at {speed}");
            let since_s = f64::from(ticks - 1) * 1e-3 - 0.01 / speed;
            let expected = sign * (0.01 + 0.5 * speed * since_s);
            assert!(
                (object.position - expected).abs() < within * speed,
                "{object:?}, not {expected}, at {speed} in {}",
                S::NAME
            );
        }
    }
}

#[test]
fn none_is_missed_at_any_speed_and_the_time_of_impact_is_right() {
    every_speed::<f64>(1e-9);
    every_speed::<f32>(1e-4);
    every_speed::<Fixed>(1e-5);
}

/// Within the limits the hand feels all of ΔQ: momentum of device and object together stays.
#[test]
fn a_pulse_within_the_limits_gives_the_device_its_impulse() {
    for restitution in [1.0, 0.5, 0.0] {
        let mut settings = settings();
        settings.contact.restitution = restitution;
        let (speed, mass) = (0.1, 0.1);
        let mut rig = Rig::<f64>::new(&settings, speed);
        while rig.peer.impacts()[0].count == 0 {
            rig.tick();
        }
        rig.tick();
        let impacts = rig.peer.impacts()[0];
        let exchanged = (1.0 + restitution) * 0.1 * 0.3 / 0.4 * speed;
        assert_eq!(impacts.count, 1);
        assert!((impacts.wanted_n_s - exchanged).abs() < 1e-12);
        assert!((impacts.delivered_n_s - exchanged).abs() < 1e-12);
        assert!((impacts.lost_j - 0.5 * 0.075 * (1.0 - restitution * restitution) * speed * speed).abs() < 1e-12);
        assert!((rig.peak_n - exchanged / 1e-3).abs() < 1e-9, "ΔQ/T is {} N", rig.peak_n);
        assert!((rig.device.velocity - (speed - exchanged / mass)).abs() < 1e-12);
        assert!((mass * rig.device.velocity + 0.3 * rig.object().velocity - mass * speed).abs() < 1e-12);
    }
}

/// Above the limits the force stands at them, and the object takes no more than that: the rest comes in the next ticks.
#[test]
fn what_the_limits_cut_is_carried_over() {
    let mut settings = settings();
    settings.safety.max_force_n = 5.0;
    let mut rig = Rig::<f64>::new(&settings, 1.0);
    while rig.peer.impacts()[0].count == 0 {
        rig.tick();
    }
    for ticks in 1..=29 {
        let impacts = rig.peer.impacts()[0];
        assert!((impacts.wanted_n_s - 0.15).abs() < 1e-12, "{impacts:?}");
        assert!((impacts.delivered_n_s - 5e-3 * f64::from(ticks)).abs() < 1e-12, "{impacts:?}");
        assert!((rig.object().velocity - impacts.delivered_n_s / 0.3).abs() < 1e-12, "{impacts:?}");
        rig.tick();
    }
    assert!(rig.peak_n <= 5.0);
}

/// A wall of an object, too heavy to move: one impact turns the device back, in as many pulses as the limits need.
#[test]
fn a_heavy_object_turns_the_device_back() {
    for (max_force_n, max_slew_n_per_s) in [(200.0, 1e6), (40.0, 2e4), (40.0, 2e3)] {
        let mut settings = settings();
        settings.object.mass_kg = 1000.0;
        settings.safety.max_force_n = max_force_n;
        settings.safety.max_slew_n_per_s = max_slew_n_per_s;
        let mut rig = Rig::<f64>::new(&settings, 0.9);
        let mut deepest = 0.0_f64;
        for _ in 0..50 {
            rig.tick();
            deepest = deepest.max(rig.device.position - rig.object().position);
        }
        let account = rig.peer.impacts()[0];
        assert_eq!(account.count, 1);
        assert!((account.delivered_n_s - 0.1 * (0.9 - rig.device.velocity)).abs() < 1e-9, "{account:?}");
        assert!((rig.device.velocity + 0.9).abs() < 1e-3 && deepest < 0.01, "{:?} {deepest}", rig.device);
    }
}

#[test]
fn an_impact_has_a_side() {
    let mut settings = settings();
    settings.contact.one_sided = false;
    let refused = settings.check().unwrap_err().to_string();
    assert!(refused.contains("contact.rendering = \"impulsive\"") && refused.contains("one_sided"), "{refused}");
}
