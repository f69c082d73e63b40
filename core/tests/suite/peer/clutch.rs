//! A device that comes free of the world and takes hold again: no jump, no energy, and the motors go off as ever.

use cohold_core::device::{AXES, Reading};
use cohold_core::names::{Decode, FixtureName};
use cohold_core::num::Motion;
use cohold_core::object::IntegratorName;
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::Settings;

use super::Bench;

/// An object between the device, 1 kN/m, and a spring to zero, 1 kN/m.
fn held() -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "none";
    settings.coordination.decode = Decode::Implicit;
    (settings.object.integrator, settings.object.force_delay_ticks) = (IntegratorName::Midpoint, 0.0);
    settings.fixture.kind = FixtureName::Guide;
    (settings.fixture.stiffness_n_per_m, settings.fixture.damping_n_s_per_m) = (1000.0, 20.0);
    settings.safety.clutch_s = 0.1;
    settings
}

/// Pressed 4 mm into it, slowly, and at rest.
fn pressed(settings: &Settings) -> Bench<f64> {
    let mut bench = Bench::<f64>::armed(settings);
    for tick in 0..4000 {
        bench.at(0.004 * f64::from(tick.min(1000)) * 1e-3, 0.0);
    }
    bench
}

/// So many ticks, the device where it is to be in each.
fn stay(bench: &mut Bench<f64>, ticks: u32, at: impl Fn(u32) -> f64) {
    for tick in 0..ticks {
        bench.at(at(tick), 0.0);
    }
}

#[test]
fn opened_and_closed_somewhere_else_nothing_jumps_and_the_world_stands() {
    let mut bench = pressed(&held());
    let object = bench.peer.observed()[0].object.position;
    assert!((object - 0.002).abs() < 1e-6, "{object}");
    // 2 N over 0.1 s is 0.02 N a tick.
    let (mut force, mut free) = (bench.at(0.004, 0.0).forces[0], 0);
    assert!((force + 2.0).abs() < 1e-3, "{force} N");
    let mut goes = |bench: &mut Bench<f64>, ticks: u32, at: &dyn Fn(f64) -> f64| {
        for tick in 0..ticks {
            let now = bench.at(at(f64::from(tick) * 1e-3), 0.0).forces[0];
            assert!((now - force).abs() <= 0.02 + 1e-9, "from {force} N to {now} N");
            force = now;
            free += u32::from(now == 0.0);
            let seen = bench.peer.observed()[0];
            assert!((seen.object.position - object).abs() < 1e-9, "{seen:?}");
            assert!((seen.contact_force - 2.0).abs() < 1e-3, "{seen:?}");
        }
        force
    };
    bench.command(Command::Clutch);
    goes(&mut bench, 120, &|_| 0.004);
    // Half a metre a second, 60 mm back.
    assert_eq!(goes(&mut bench, 120, &|time| 0.004 - 0.5 * time), 0.0);
    bench.command(Command::Release);
    let force = goes(&mut bench, 300, &|_| 0.004 - 0.0595);
    assert!((force + 2.0).abs() < 1e-3, "{force} N");
    assert!(free > 120, "{free} ticks without force");
    assert!((bench.peer.observed()[0].device.position - 0.004).abs() < 1e-9);
}

/// What the hand does at the device is what the device does in the world, whatever the clutch does meanwhile.
#[test]
fn a_clutch_that_opens_and_closes_under_a_moving_hand_makes_no_energy() {
    let mut settings = held();
    (settings.contact.damping_n_s_per_m, settings.safety.max_slew_n_per_s) = (0.0, 1e6);
    let mut bench = Bench::<f64>::armed(&settings);
    let (mut at_the_hand, mut in_the_world, mut moved) = (0.0, 0.0, 0.0_f64);
    let mut before: Option<(f64, f64, f64, f64)> = None;
    for tick in 0..20_000 {
        let time = f64::from(tick) * 1e-3;
        match tick % 370 {
            100 => bench.command(Command::Clutch),
            // Sometimes before it is open.
            n if n == 130 + tick % 97 => bench.command(Command::Release),
            _ => {}
        }
        let device = 0.003 * (9.0 * time).sin() + 0.002 * (23.0 * time).sin();
        let force = bench.at(device, 0.0).forces[0];
        let seen = *bench.peer.observed()[0];
        if let Some((device_before, force, world, felt)) = before {
            at_the_hand += force * (device - device_before);
            in_the_world -= felt * (seen.device.position - world);
            moved += (force * (device - device_before)).abs();
        }
        before = Some((device, force, seen.device.position, seen.contact_force));
    }
    assert_eq!(bench.peer.mode(), Mode::Armed);
    assert!(
        moved > 0.03 && (at_the_hand - in_the_world).abs() < 1e-9,
        "{at_the_hand} J, {in_the_world} J of {moved} J"
    );
}

#[test]
fn motors_go_off_with_the_clutch_open_as_ever_and_arming_closes_it() {
    for clutch in [Command::Clutch, Command::Release] {
        let mut bench = pressed(&held());
        bench.command(Command::Clutch);
        stay(&mut bench, 30, |_| 0.004);
        bench.command(clutch);
        assert!(bench.at(0.004, 0.0).forces[0] != 0.0);
        bench.command(Command::Disarm);
        let off = bench.at(0.004, 0.0);
        assert_eq!((off.forces, off.enable), ([0.0; AXES], false));
        // While the motors are off there is no clutch to be opened.
        bench.command(Command::Clutch);
        bench.command(Command::Arm);
        // The object is put where the device is, from which the guide has drawn it for a tick.
        assert!(bench.at(0.004, 0.0).forces[0].abs() < 0.02);
        // Closed: a device that moves is felt at once.
        let force = bench.at(0.005, 0.0).forces[0];
        assert!(force < -0.3, "{force} N");
    }
}

#[test]
fn a_clutched_device_is_guarded_as_ever() {
    let mut settings = held();
    settings.safety.max_speed_m_per_s = 0.5;
    let mut bench = pressed(&settings);
    bench.command(Command::Clutch);
    stay(&mut bench, 200, |_| 0.004);
    bench.at(0.004, 0.76);
    assert!(matches!(bench.peer.mode(), Mode::Faulted(_)), "{:?}", bench.peer.mode());
}

/// Who never clutched is in the world where its device is, and so is who was set to zero again.
#[test]
fn the_encoders_zero_is_the_worlds_again_after_home() {
    let mut bench = pressed(&held());
    bench.command(Command::Clutch);
    stay(&mut bench, 200, |_| 0.004);
    stay(&mut bench, 100, |tick| 0.004 + 1e-4 * f64::from(tick));
    bench.command(Command::Release);
    stay(&mut bench, 200, |_| 0.0139);
    assert!((bench.peer.observed()[0].device.position - 0.004).abs() < 1e-9);
    bench.command(Command::Disarm);
    let read = |bench: &mut Bench<f64>| {
        bench.read(Reading::Exact([Motion::at(0.0139), Motion::REST]));
        bench.peer.observed()[0].device.position
    };
    assert!((read(&mut bench) - 0.004).abs() < 1e-9);
    bench.command(Command::Home);
    assert_eq!(read(&mut bench), 0.0139);
}
