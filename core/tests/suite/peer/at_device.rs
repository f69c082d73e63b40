//! Four channels at the device, without a spring: a device that takes a force and tells where it is, with the limits and the silences of any peer.

use cohold_core::contact::RenderingName;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::degradation::STEP_N;
use cohold_core::law::{AnyLaw, Packet};
use cohold_core::names::Decode;
use cohold_core::num::Motion;
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::schema::Schema;
use cohold_core::settings::{Settings, Value};

/// A packet each tick, no spring; fading from 24 ms to 50 ms of silence.
fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "four-channel";
    (settings.coordination.stiffness_n_per_m, settings.coordination.damping_n_s_per_m) = (0.0, 0.0);
    (settings.timing.ticks_per_packet, settings.safety.disengage_s) = (1, 0.05);
    Schema::BUILT_IN.set(&mut settings, "four_channel.at_device", Value::Flag(true)).expect("its own key");
    settings
}

struct Bench(Peer<f32, AnyLaw<f32>>);

impl Bench {
    fn armed(settings: &Settings) -> Self {
        let mut peer = Peer::new(settings, [Motion::REST; AXES]).expect("a good scene");
        peer.command(Command::Arm);
        Self(peer)
    }

    /// A tick with the device here, which has heard this force: the force along the first axis, and what is said then.
    fn tick(&mut self, force: Option<f32>, device: Motion<f32>) -> (f32, Packet<f32>) {
        if let Some(wave) = force {
            self.0.hear(&[Packet { wave, ..Packet::default() }]);
        }
        self.0.exchange();
        let actuators = self.0.tick(&Sensors::of(Reading::Exact([device, Motion::REST])));
        (actuators.forces[0], self.0.outgoing()[0])
    }
}

/// Wherever the hand goes, and however contact is set: the force is what was heard, and what is said is where the hand is, and what acted.
#[test]
fn it_gives_the_force_it_hears_and_tells_where_it_is() {
    for one_sided in [false, true] {
        let mut settings = settings();
        (settings.contact.one_sided, settings.contact.gap_m) = (one_sided, 0.002);
        settings.contact.rendering = if one_sided { RenderingName::Impulsive } else { RenderingName::Continuous };
        let mut bench = Bench::armed(&settings);
        let mut last = 0.0;
        for tick in 0..2_000_u16 {
            let time = 1e-3 * f32::from(tick);
            let device = Motion { position: 0.02 * (9.0 * time).sin(), velocity: 0.18 * (9.0 * time).cos() };
            let force = 2.0 * (5.0 * time).sin();
            let (given, said) = bench.tick(Some(force), device);
            assert_eq!(given, force, "tick {tick}");
            let told = (said.motion, said.wave, said.wave_integral as f32);
            assert_eq!(told, (device, 0.0, last), "tick {tick}");
            last = given;
        }
        assert_eq!(bench.0.mode(), Mode::Armed);
    }
}

/// Without packets the last force stands for 24 ms and falls by [`STEP_N`] in each tick from then on; what comes then grows from nothing.
#[test]
fn a_force_that_is_not_renewed_fades_and_ends() {
    let mut bench = Bench::armed(&settings());
    for _ in 0..100 {
        bench.tick(Some(1.0), Motion::REST);
    }
    for silent in 1..=200_u16 {
        let (given, said) = bench.tick(None, Motion::REST);
        let wanted = (1.0 - STEP_N as f32 * (f32::from(silent) - 24.0)).clamp(0.0, 1.0);
        assert!((given - wanted).abs() < 1e-6, "{silent} ms: {given} N, not {wanted}");
        assert!(silent <= 80 || said.wave_integral == 0.0, "{silent} ms: {said:?}");
    }
    let mut last = 0.0;
    for tick in 0..26 {
        let (given, _) = bench.tick(Some(1.0), Motion::REST);
        assert!((0.0..=1.0 / 26.0 + 1e-6).contains(&(given - last)), "tick {tick}: {last} N, then {given} N");
        last = given;
    }
    assert_eq!(last, 1.0);
    bench.0.part();
    for tick in 1..=60_u16 {
        let (given, _) = bench.tick(None, Motion::REST);
        let wanted = (1.0 - STEP_N as f32 * f32::from(tick)).max(0.0);
        assert!((given - wanted).abs() < 1e-6, "{tick} ms after the other end has gone: {given} N, not {wanted}");
    }
}

/// The limits of force, slew, speed and workspace are those of any peer, and so are faults.
#[test]
fn limits_and_faults_are_those_of_any_peer() {
    let mut settings = settings();
    (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (3.0, 60.0);
    (settings.safety.max_speed_m_per_s, settings.safety.workspace_m) = (0.5, 0.2);
    let mut bench = Bench::armed(&settings);
    let mut last = 0.0;
    for tick in 0..80 {
        let (given, _) = bench.tick(Some(f32::MAX), Motion::REST);
        assert!(given <= 3.0 && given - last <= 0.06 + 1e-6, "tick {tick}: {last} N, then {given} N");
        last = given;
    }
    assert_eq!(last, 3.0);
    assert_eq!(bench.tick(Some(-1.0), Motion::REST).0, -0.06, "it falls at once, and grows slowly");
    let faults = [
        (Some(f32::NAN), Motion::REST, Fault::NonFiniteInput),
        (Some(1.0), Motion { position: 0.0, velocity: 0.76 }, Fault::Overspeed),
        (Some(1.0), Motion::at(0.3), Fault::OutOfWorkspace),
        (Some(1.0), Motion::at(f32::NAN), Fault::NonFiniteInput),
    ];
    for (force, device, fault) in faults {
        let mut bench = Bench::armed(&settings);
        bench.tick(Some(0.05), Motion::REST);
        assert_eq!(bench.tick(force, device).0, 0.0, "{fault:?}");
        assert_eq!(bench.0.mode(), Mode::Faulted(fault));
    }
}

/// Forces that are solved for with a copy's motion have no meaning where there is no copy.
#[test]
fn an_integrator_that_solves_is_refused() {
    for integrator in [IntegratorName::Midpoint, IntegratorName::BackwardEuler] {
        let mut settings = settings();
        (settings.object.integrator, settings.coordination.decode) = (integrator, Decode::Implicit);
        settings.object.force_delay_ticks = 0.0;
        let refused = settings.check().expect_err("there is no copy").to_string();
        assert!(refused.starts_with("object.integrator = ") && refused.contains("at_device"), "{refused}");
    }
}
