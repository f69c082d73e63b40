//! Windings against a second method (small steps of the differential equation), closed forms, and figures worked out by hand.

use cohold_core::device::current::PWM_PERIOD_S;
use cohold_core::device::motor::Duty;
use cohold_core::peer::Actuators;
use cohold_sim::Laws;
use cohold_sim::plant::{Converter, Drive, Plant, Winding};
use cohold_sim::scene::Scene;

const WINDING: Winding = Winding { resistance_ohm: 1.5, inductance_h: 0.5e-3, supply_v: 24.0, dead_time_s: 0.0 };

/// One period in 200 000 steps of the midpoint rule: the counter decides which leg is high. End, mean and the current at a time.
fn stepped(mut current: f64, share: f64, emf: f64, sample_s: f64) -> [f64; 3] {
    const STEPS: u32 = 200_000;
    let step = PWM_PERIOD_S / f64::from(STEPS);
    let (mut charge, mut sampled) = (0.0, current);
    for n in 0..STEPS {
        // Up and down again: 0 at the ends, 1 in the middle.
        let counter = 1.0 - (2.0 * (f64::from(n) + 0.5) / f64::from(STEPS) - 1.0).abs();
        let leg = |sign: f64| f64::from(u8::from(counter < 0.5 * (1.0 + sign * share)));
        let slope = |current: f64| (24.0 * (leg(1.0) - leg(-1.0)) - emf - 1.5 * current) / 0.5e-3;
        if f64::from(n) * step <= sample_s {
            sampled = current;
        }
        let next = current + step * slope(current + 0.5 * step * slope(current));
        charge += 0.5 * step * (current + next);
        current = next;
    }
    [current, charge / PWM_PERIOD_S, sampled]
}

#[test]
fn a_period_is_what_small_steps_make_of_it() {
    for (current, share, emf) in
        [(0.0, 0.5, 0.0), (2.0, -0.9, 3.0), (-1.0, 0.04, -7.0), (0.3, 1.0, 0.0), (0.3, 0.0, 2.0)]
    {
        for sample_s in [0.0, 8e-6, 25e-6, 40e-6] {
            let flow = WINDING.period(current, share, emf, sample_s);
            let [end, mean, sampled] = stepped(current, share, emf, sample_s);
            for (exact, found) in [(end, flow.end_a), (mean, flow.mean_a), (sampled, flow.sampled_a)] {
                assert!((exact - found).abs() < 3e-5, "{current} A, {share}, {emf} V, {sample_s} s: {exact}, {found}");
            }
        }
    }
}

/// Settled, the mean is (share·V − emf)/R; at half of the voltage a sample 0.27 µs after the start is 7.9 mA below it.
#[test]
fn what_flows_in_the_end_is_ohms_law() {
    let settle = |share: f64, emf: f64| {
        (0..400).fold(Default::default(), |flow: cohold_sim::plant::Flow, _| {
            WINDING.period(flow.end_a, share, emf, 0.27e-6)
        })
    };
    for (share, emf) in [(0.5, 0.0), (-0.25, 2.0), (0.0, -3.0)] {
        let flow = settle(share, emf);
        assert!((flow.mean_a - (24.0 * share - emf) / 1.5).abs() < 1e-9, "{share} {emf}");
    }
    let half = settle(0.5, 0.0);
    assert!((half.sampled_a - half.mean_a + 0.0079).abs() < 2e-4, "{}", half.sampled_a - half.mean_a);
    assert_eq!(settle(0.0, 0.0).sampled_a, 0.0);
}

/// 1 µs at 24 V takes 0.96 V from whatever drives the current, and stops no more than there is.
#[test]
fn dead_time_takes_its_voltage_either_way() {
    let dead = Winding { dead_time_s: 1e-6, ..WINDING };
    let settle = |share: f64| (0..600).fold(0.0, |current, _| dead.period(current, share, 0.0, 0.0).end_a);
    let mean = |share: f64| dead.period(settle(share), share, 0.0, 0.0).mean_a;
    assert!((mean(0.5) - (12.0 - 0.96) / 1.5).abs() < 0.01, "{}", mean(0.5));
    assert!((mean(-0.5) + (12.0 - 0.96) / 1.5).abs() < 0.01);
    for share in [0.0, 0.03, -0.039] {
        assert_eq!(settle(share), 0.0, "{share}");
    }
    assert!(settle(0.05) > 0.0);
}

fn scene(keys: &[&str]) -> Scene {
    let keys: Vec<String> =
        ["plant.motor=true", "plant.winding=true"].iter().chain(keys).map(|key| key.to_string()).collect();
    Scene::load(Laws::built_in(), None, &keys).unwrap()
}

fn drive(keys: &[&str]) -> Drive {
    let scene = scene(keys);
    Drive::new(&scene.peer, &scene.world.plant, 1).unwrap()
}

/// Force after some periods at a constant duty and speed.
fn settled(mut drive: Drive, duty: i16, speed: f64) -> f64 {
    drive.command(Duty(duty), speed);
    (0..2000).map(|_| drive.period(speed)).last().unwrap()
}

/// k²/R = 8²/4.8: 13.3 N·s/m of drag that nobody asked for, and none of it with the loop.
#[test]
fn an_open_bridge_drags_and_a_loop_does_not() {
    let drag = settled(drive(&[]), 0, 0.3);
    assert!((drag + 0.3 * 64.0 / 4.8).abs() < 1e-6, "{drag}");
    // A quarter of full force: 10 N, at any speed that the supply can do.
    for speed in [0.0, 0.3, -0.8] {
        for keys in [
            &["plant.drive=current"][..],
            &["plant.drive=current", "plant.resistance_ratio=1.25", "plant.dead_time_s=1e-6"],
        ] {
            let mut quiet = keys.to_vec();
            quiet.push("plant.current_noise_a=0");
            let force = settled(drive(&quiet), 8192, speed);
            // A step of the converter is 2.7 mA, 21 mN.
            assert!((force - 10.0).abs() < 0.06, "{speed} m/s: {force} {keys:?}");
        }
    }
    // Standing still, an open bridge that is configured with the supply over R as full scale gives what is asked for.
    assert!((settled(drive(&[]), 8192, 0.0) - 10.0).abs() < 0.01);
    let against = settled(drive(&["plant.drive=current", "motor.reversed=true", "plant.current_noise_a=0"]), 8192, 0.3);
    assert!((against + 10.0).abs() < 0.06, "{against}");
}

/// 25 N take 15 V and what the motor makes by moving: to -21.4 V, where the sensor's leg rises 1.4 µs before a period begins.
#[test]
fn what_an_edge_disturbs_is_not_measured() {
    for (duty, speed) in [(20_480, 0.3), (20_480, -0.8), (-20_480, 0.3), (-20_480, 0.0), (-20_480, -0.8)] {
        let force = settled(drive(&["plant.drive=current", "plant.current_noise_a=0"]), duty, speed);
        assert!((force - 40.0 * f64::from(duty) / 32767.0).abs() < 0.06, "{duty} at {speed} m/s: {force}");
    }
}

/// In the end a stage measures the current that was asked for, and of the voltage what resistance and back-EMF take.
#[test]
fn a_stage_measures_what_flows() {
    let mut drive = drive(&["plant.drive=current", "plant.supply_v=20"]);
    assert_eq!(drive.measured(), None, "nothing yet");
    for _ in 0..100 {
        drive.command(Duty(8192), 0.3);
        for _ in 0..20 {
            drive.period(0.3);
        }
    }
    let flow = drive.measured().unwrap();
    // 3.2 mA of noise are 21 codes, a step of the converter 18; the mean is of 20.
    assert!((i32::from(flow.mean) - 8192).abs() < 20 && (i32::from(flow.last) - 8192).abs() < 100, "{flow:?}");
    let volts = 20.0 * f64::from(flow.voltage) / 32767.0;
    assert!((volts - (4.8 * 1.25 + 8.0 * 0.3)).abs() < 0.05, "{volts}");
    drive.off();
    (0..20).for_each(|_| assert_eq!(drive.period(0.3), 0.0));
    let off = drive.measured().unwrap();
    assert!(off.mean.abs() < 20 && off.voltage == 0, "{off:?}");
}

/// A period of the tick, one of the loop, and then it comes; without the loop a period earlier.
#[test]
fn a_force_comes_when_it_is_said_to() {
    for (keys, dead_periods) in [(&[][..], 1), (&["plant.drive=current", "plant.current_noise_a=0"], 2)] {
        let mut drive = drive(keys);
        drive.command(Duty(8192), 0.0);
        let forces: Vec<f64> = (0..4).map(|_| drive.period(0.0)).collect();
        assert_eq!(forces.iter().position(|force| force.abs() > 0.1), Some(dead_periods), "{keys:?}: {forces:?}");
    }
}

#[test]
fn off_is_off_at_once_and_forgets() {
    let mut drive = drive(&["plant.drive=current"]);
    drive.command(Duty(20_000), 0.0);
    assert!((0..100).map(|_| drive.period(0.0)).fold(0.0, f64::max) > 20.0);
    drive.off();
    assert_eq!(drive.period(0.0), 0.0);
}

#[test]
fn a_converter_rounds_clips_and_is_noisy_the_same_way_again() {
    let scene = scene(&["plant.current_noise_a=0"]);
    let mut quiet = Converter::new(&scene.peer, &scene.world.plant, 1);
    assert_eq!([0.0, 6.875 / 2048.0, -99.0, 99.0].map(|current| quiet.read(current)), [2048, 2049, 62, 3847]);
    let scene = self::scene(&["plant.current_noise_a=0.1", "plant.current_bits=16"]);
    let read = |seed: u64| {
        let mut converter = Converter::new(&scene.peer, &scene.world.plant, seed);
        (0..20_000).map(|_| (f64::from(converter.read(1.0)) - 32768.0) * 6.875 / 32768.0).collect::<Vec<f64>>()
    };
    let all = read(7);
    assert!(all == read(7) && all != read(8));
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let deviation = (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt();
    assert!((mean - 1.0).abs() < 0.003 && (deviation - 0.1).abs() < 0.003, "{mean} {deviation}");
}

/// A device of 0.1 kg pushed by a constant duty through the loop: ẍ = F/m from when the force has come, which the lag says.
#[test]
fn a_device_moves_as_its_delayed_force_says() {
    let scene = scene(&["plant.drive=current", "plant.current_noise_a=0", "device.damping_n_s_per_m=0"]);
    let (mut plant, duties) = (Plant::new(&scene, 0), [Duty(8192), Duty::OFF]);
    let actuators = Actuators::<f64> { duties, enable: true, ..Actuators::default() };
    (0..5).for_each(|_| plant.step(0.0, &actuators));
    // A quarter of a period more than on the average: no voltage is negative.
    let late = scene.force_delay_ticks() + 0.0125;
    assert!((late - 0.184).abs() < 0.001, "{late}");
    // What the loop lacks while the back-EMF grows is as if the device were heavier by k²/(ω_c·R).
    let mass = 0.1 + 64.0 / (std::f64::consts::TAU * 1000.0 * 4.8);
    let exact = 10.0 / mass * 1e-3 * (5.0 - late);
    let velocity = plant.motions()[0].velocity;
    // The force itself is known to half a step of the converter.
    assert!((velocity - exact).abs() < 0.006 * exact, "{velocity} {exact}");
    let force = *plant.free_axis().1;
    assert!((force - 0.1 * exact / (1e-3 * (5.0 - late))).abs() < 0.06, "{force}");
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |keys: &[&str]| {
        let keys: Vec<String> = keys.iter().map(|key| key.to_string()).collect();
        Scene::load(Laws::built_in(), None, &keys).unwrap_err().to_string()
    };
    assert_eq!(
        refused(&["plant.winding=true"]),
        "scene: plant.winding = true is not allowed with plant.motor = false: a winding is driven by motor duties"
    );
    let on = ["plant.winding=true", "plant.motor=true", "plant.drive=current"];
    let slow = refused(&[&on[..], &["motor.current_loop_hz=100"]].concat());
    assert!(
        slow.starts_with("scene: motor.current_loop_hz = 100 is not allowed with timing.control_period_s = 0.001: "),
        "{slow}"
    );
    let short = refused(&[&on[..], &["motor.sense_a=4"]].concat());
    assert!(short.starts_with("scene: motor.sense_a = 4 is not allowed"), "{short}");
    let uneven = refused(&[&on[..], &["timing.control_period_s=0.00033"]].concat());
    assert!(uneven.starts_with("scene: timing.control_period_s = 0.00033 is not allowed"), "{uneven}");
    assert!(refused(&["plant.drive=force"]).contains("one of \"voltage\", \"current\""));
}
