//! A device that is smaller or larger than the world: what its hand feels, and that every limit stays the device's own.

use cohold_core::device::encoder::Marks;
use cohold_core::device::motor::Motor;
use cohold_core::device::velocity::VelocityName;
use cohold_core::device::{AXES, Counts, Reading, kinematics::KinematicsName};
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

use super::Bench;

/// A pure spring to an object that hardly moves, on a device that counts.
fn spring(model: KinematicsName, [position, force]: [f64; 2]) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "none";
    settings.contact.stiffness_n_per_m = 100.0;
    settings.contact.damping_n_s_per_m = 0.0;
    settings.object.mass_kg = 1000.0;
    settings.axis.velocity = VelocityName::Difference;
    settings.kinematics.model = model;
    settings.axis.count = if model == KinematicsName::FiveBar { 2 } else { 1 };
    (settings.axis.hold_stiffness_n_per_m, settings.axis.hold_damping_n_s_per_m) = (0.0, 0.0);
    (settings.scale.position, settings.scale.force) = (position, force);
    settings
}

/// The joint forces that come of a device which stands still so many counts from where it was switched on.
fn joint_forces(settings: &Settings, counts: u16) -> [f64; AXES] {
    let mut bench = Bench::<f64>::armed(settings);
    let read = |bench: &mut Bench<f64>, counts| bench.read(Reading::Counts([Counts(counts), Counts(0)]));
    let mut actuators = Actuators::default();
    for at in (0..=counts).step_by(10).chain([counts; 200]) {
        actuators = read(&mut bench, at);
    }
    assert_eq!(bench.peer.mode(), Mode::Armed, "{:?}", settings.kinematics.model);
    let motor = Motor::<f64>::build(settings);
    actuators.duties.map(|duty| motor.joint_force(duty))
}

#[test]
fn a_hand_feels_the_spring_of_the_world_times_the_ratio_of_the_scales_through_any_mechanism() {
    for model in [KinematicsName::Direct, KinematicsName::Capstan, KinematicsName::FiveBar] {
        let plain = joint_forces(&spring(model, [1.0; 2]), 400);
        assert!(plain[0].abs() > 1e-3, "{model:?}");
        for scale @ [longer, stronger] in [[10.0, 10.0], [0.1, 0.1], [10.0, 1.0], [1.0, 10.0], [2.0, 0.5], [0.1, 1.0]] {
            let forces = joint_forces(&spring(model, scale), 400);
            for (force, plain) in forces.iter().zip(plain) {
                // Half a code of the duty is 0.6 mN.
                let felt = longer / stronger;
                let wanted = plain * felt;
                assert!((force - wanted).abs() < 1e-3 * (1.0 + felt), "{model:?} {scale:?}: {force} N, not {wanted}");
            }
        }
    }
}

#[test]
fn limits_of_force_and_slew_are_newtons_of_the_device() {
    for scale @ [_, stronger] in [[1.0; 2], [10.0, 0.1], [4.0, 2.0]] {
        let mut settings = spring(KinematicsName::Direct, scale);
        settings.contact.stiffness_n_per_m = 1e6;
        (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (2.0, 100.0);
        let mut bench = Bench::<f64>::armed(&settings);
        let (mut last, mut largest) = (0.0_f64, 0.0_f64);
        for tick in 0..90 {
            let position = scale[0] * 1e-3 * f64::from(tick);
            let force = bench.at(position, 0.0).forces[0] / stronger;
            assert!(force.abs() <= last.abs() + 0.1 * (1.0 + 1e-12), "{scale:?}: {last} N, then {force}");
            last = force;
            largest = largest.max(force.abs());
        }
        assert!((largest - 2.0).abs() < 1e-9, "{scale:?}: {largest} N");
    }
}

#[test]
fn limits_of_speed_and_workspace_are_metres_of_the_device() {
    for longer in [0.1, 1.0, 10.0] {
        let mut settings = spring(KinematicsName::Direct, [longer, 1.0]);
        (settings.safety.max_speed_m_per_s, settings.safety.workspace_m) = (0.5, 0.02);
        settings.contact.stiffness_n_per_m = 0.0;
        settings.axis.velocity = VelocityName::Measured;
        let stopped = |position: f64, velocity: f64| {
            let mut bench = Bench::<f64>::armed(&settings);
            bench.at(longer * position, longer * velocity);
            bench.peer.mode()
        };
        assert_eq!(stopped(0.0199, 0.749), Mode::Armed);
        assert_eq!(stopped(0.0, 0.751), Mode::Faulted(Fault::Overspeed));
        assert_eq!(stopped(0.0201, 0.0), Mode::Faulted(Fault::OutOfWorkspace));
    }
}

#[test]
fn a_device_that_only_counts_is_as_far_and_as_fast_as_its_own_limits_say() {
    // 200 counts to the millimetre: 0.4 m/s is 80 counts a tick, whatever the scale.
    for longer in [0.1, 1.0, 10.0] {
        let mut settings = spring(KinematicsName::Direct, [longer, 1.0]);
        settings.safety.max_speed_m_per_s = 0.5;
        settings.contact.stiffness_n_per_m = 0.0;
        for (step, mode) in [(80_u16, Mode::Armed), (160, Mode::Faulted(Fault::Overspeed))] {
            let mut bench = Bench::<f64>::armed(&settings);
            for at in [0, step, 2 * step] {
                bench.read(Reading::Counts([Counts(at), Counts(0)]));
            }
            assert_eq!(bench.peer.mode(), mode, "{longer} {step}");
        }
    }
}

/// The power that the hand puts in, weighed, is what the world gets: no scale makes energy.
#[test]
fn power_in_the_world_is_that_at_the_hand_times_both_scales() {
    let [longer, stronger] = [5.0, 0.4];
    let mut settings = spring(KinematicsName::Direct, [longer, stronger]);
    settings.contact.damping_n_s_per_m = 3.0;
    let mut bench = Bench::<f64>::armed(&settings);
    let motor = Motor::<f64>::build(&settings);
    for tick in 0..400_u16 {
        let counts = tick * 5;
        let actuators = bench.read(Reading::Counts([Counts(counts), Counts(0)]));
        let Motion { velocity, .. } = bench.peer.observed()[0].device;
        let (in_the_world, at_the_hand) = (
            actuators.forces[0] * velocity,
            motor.joint_force(actuators.duties[0]) * 5.0 / settings.encoder.counts_per_m * 1e3,
        );
        if tick > 0 {
            let error = in_the_world - longer * stronger * at_the_hand;
            assert!(error.abs() < 2e-3 * stronger * longer, "tick {tick}: {in_the_world} W, {at_the_hand} W");
        }
    }
}

/// Friction and cogging that the motors take over are newtons of the device, and its detents metres of the device.
#[test]
fn what_motors_take_over_is_the_devices() {
    for scale @ [longer, _] in [[1.0; 2], [10.0, 0.1], [0.1, 10.0], [2.0, 0.5]] {
        let mut settings = spring(KinematicsName::Direct, scale);
        settings.contact.stiffness_n_per_m = 0.0;
        settings.encoder.index = true;
        (settings.motor.cogging_n_or_n_m, settings.motor.cogging_period_m_or_rad) = (0.5, 0.004);
        settings.motor.cogging_at_m_or_rad = 0.001;
        let motor = Motor::<f64>::build(&settings);
        let force = |index: Option<u16>| {
            let mut bench = Bench::<f64>::at_rest(&settings, Motion::REST);
            let mut read = |counts, index: Option<u16>| {
                let marks = [index, None].map(|index| Marks { lone: false, index: index.map(Counts) });
                let reading = Reading::Counts([Counts(counts), Counts(0)]);
                bench.peer.tick(&Sensors { marks: Some(marks), ..Sensors::of(reading) })
            };
            read(0, None);
            read(10, index);
            bench.command(Command::Arm);
            let duty = |bench: &mut Bench<f64>| bench.read(Reading::Counts([Counts(10), Counts(0)])).duties[0];
            duty(&mut bench);
            motor.joint_force(duty(&mut bench))
        };
        // 10 counts are 50 µm, and 5 of them past the index 25.
        assert_eq!(force(None), 0.0, "the index was not met");
        let exact = -0.5 * (std::f64::consts::TAU * (0.025e-3 - 1e-3) / 4e-3).sin();
        assert!((force(Some(5)) - exact).abs() < 1e-3, "{scale:?}: {} N, should be {exact}", force(Some(5)));

        (settings.motor.cogging_n_or_n_m, settings.motor.friction_n) = (0.0, 0.4);
        let mut bench = Bench::<f64>::armed(&settings);
        let duty = (0..100).map(|at: u16| bench.read(Reading::Counts([Counts(40 * at), Counts(0)])).duties[0]).last();
        let force = motor.joint_force(duty.expect("a hundred"));
        assert!((force - 0.4).abs() < 1e-3, "{scale:?}, {longer}: {force} N");
    }
}
