//! What a hand feels, against closed forms.

use cohold_sim::measure::impedance::{BAND_HZ, Complex, POINTS, RemoteEnd, SPEED_M_PER_S, felt, frequencies_hz};
use cohold_sim::{Laws, Scene, scenes};

fn scene(settings: &[&str]) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("a built-in scene");
    let common = ["object.integrator=midpoint", "object.force_delay_ticks=0", "coordination.decode=implicit"];
    for setting in common.iter().chain(settings) {
        scene.apply_override(setting).expect("a good setting");
    }
    scene
}

#[track_caller]
fn close(got: Complex, want: Complex, within: f64) {
    assert!((got - want).norm() <= within * want.norm(), "{got:?}, not {want:?}");
}

/// Without coordination: the device, and behind its contact, a spring and a damper, the copy's mass. Far below the control rate
/// all of it is continuous but for the force, which is held and late.
#[test]
fn without_coordination_a_hand_feels_device_contact_and_copy() {
    let scene = scene(&["coordination.comm=none"]);
    let (contact, copy) = (&scene.peer.contact, &scene.peer.object);
    let device = &scene.world.device;
    for frequency_hz in [0.5, 2.0, 5.0, 20.0] {
        let omega = core::f64::consts::TAU * frequency_hz;
        let late = omega * 1e-3 * (device.force_delay_ticks + 0.5);
        let contact = Complex::new(contact.damping_n_s_per_m, -contact.stiffness_n_per_m / omega);
        let behind = (contact.inv() + Complex::new(0.0, omega * copy.mass_kg).inv()).inv();
        let want = behind * Complex::cis(-late) + Complex::new(device.damping_n_s_per_m, omega * device.mass_kg);
        for far in [RemoteEnd::Held, RemoteEnd::LetGo] {
            let got = felt(&scene, far, frequency_hz, SPEED_M_PER_S).expect("good settings").expect("it repeats");
            close(got, want, 0.01);
        }
    }
}

/// THEORY §4: a line of impedance b and transit time T to a copy that is let go is an inertia of b·T more than the two copies; to one
/// that is held, a spring of stiffness b/T.
#[test]
fn a_wave_line_weighs_and_yields_as_its_transit_time_says() {
    let settings = [
        "coordination.comm=passive-mean",
        "timing.ticks_per_packet=1",
        "network.one_way_delay_packets=20",
        "coordination.stiffness_n_per_m=1000000",
        "contact.stiffness_n_per_m=100000",
        "contact.damping_n_s_per_m=0",
        "device.damping_n_s_per_m=0",
        // Without any damping the line rings for ever, and a hundredth of that is in what is projected.
        "object.damping_n_s_per_m=0.5",
    ];
    let scene = scene(&settings);
    let omega = core::f64::consts::TAU * 0.5;
    let feels = |far| felt(&scene, far, 0.5, SPEED_M_PER_S).expect("good settings").expect("it repeats");
    // A wave leaves the tick after it was made: 21 ticks.
    let (impedance, transit_s) = (10.0, 0.021);
    let mass_kg = feels(RemoteEnd::LetGo).im / omega;
    let want_kg = scene.world.device.mass_kg + 2.0 * scene.peer.object.mass_kg + impedance * transit_s;
    assert!((mass_kg / want_kg - 1.0).abs() < 0.01, "{mass_kg} kg, not {want_kg}");
    let moving_kg = scene.world.device.mass_kg + scene.peer.object.mass_kg;
    let stiffness = omega * (omega * moving_kg - feels(RemoteEnd::Held).im);
    let want = impedance / transit_s;
    assert!((stiffness / want - 1.0).abs() < 0.02, "{stiffness} N/m, not {want}");
}

/// What runs away is no answer.
#[test]
fn an_unstable_scene_has_no_impedance() {
    let scene = scene(&["coordination.comm=power", "coordination.stiffness_n_per_m=20000"]);
    assert_eq!(felt(&scene, RemoteEnd::LetGo, 5.0, SPEED_M_PER_S), Ok(None));
}

/// Whole control periods in each, and none that packets meet at the same phases for ever.
#[test]
fn frequencies_are_whole_ticks() {
    let frequencies = frequencies_hz(&scene(&[]), BAND_HZ, POINTS);
    assert!(frequencies.len() > 20 && frequencies.windows(2).all(|pair| pair[0] < pair[1]));
    assert!((frequencies[0] - 0.5).abs() < 1e-9 && frequencies[frequencies.len() - 1] <= 200.0);
    for frequency_hz in frequencies {
        let ticks = 1000.0 / frequency_hz;
        assert!((ticks - ticks.round()).abs() < 1e-9 && 16 % (ticks.round() as u32) != 0, "{frequency_hz} Hz");
    }
}
