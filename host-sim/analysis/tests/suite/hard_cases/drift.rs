//! Ten hours of position, in f32.

use core::f64::consts::TAU;

use cohold_core::num::Motion;
use cohold_core::object::euler::{ForwardEuler, SemiImplicit};
use cohold_core::object::exact::Exact;
use cohold_core::object::{Before, Integrator};
use cohold_core::settings::Settings;

/// Ten hours of milliseconds.
const TICKS: usize = 36_000_000;

/// What ten hours may add, m.
const ALLOWED_M: f64 = 1e-6;

/// An object of the default mass whose force acts in the tick it is computed.
fn settings(damping_n_s_per_m: f64) -> Settings {
    let mut settings = Settings::default();
    settings.object.damping_n_s_per_m = damping_n_s_per_m;
    settings.object.force_delay_ticks = 0.0;
    settings
}

/// The motion after ten hours of a force that repeats itself.
fn driven<I: Integrator<f32, State = Before<f32>>>(
    settings: &Settings,
    from: Motion<f32>,
    forces: &[f32],
) -> Motion<f32> {
    let integrator = I::build(settings).expect("good settings");
    let mut state = I::State::default();
    let mut motion = from;
    assert_eq!(TICKS % forces.len(), 0);
    for _ in 0..TICKS / forces.len() {
        for force in forces {
            motion = integrator.step(&mut state, motion, *force);
        }
    }
    motion
}

/// A cosine of `period` ticks whose second half is exactly minus the first, so that rounding leaves no steady force.
fn cosine(amplitude_n: f64, period: usize) -> Vec<f32> {
    let half: Vec<f32> =
        (0..period / 2).map(|tick| (amplitude_n * (TAU * tick as f64 / period as f64).cos()) as f32).collect();
    half.iter().copied().chain(half.iter().map(|force| -force)).collect()
}

/// Re(gain/(e^(iθ) − pole)): velocity at tick 0 of v⁺ = pole·v + gain·cos(θn), in its steady state.
fn steady_velocity(gain: f64, pole: f64, period: usize) -> f64 {
    let (sine, cosine) = (TAU / period as f64).sin_cos();
    let (re, im) = (cosine - pole, sine);
    gain * re / (re * re + im * im)
}

/// Why: a session lasts hours, and a position is a sum of a thousand steps a second. At a steady 10 µm/s each step of 10 nm
/// is less than half a step of f32 at 0.36 m: a plain sum stops dead. The compensated one (`cohold_core::sum`) comes out
/// within a micrometre of v·t, in every integrator.
#[test]
fn ten_hours_at_a_steady_creep() {
    let velocity = 1e-5_f32;
    let settings = settings(0.0);
    let from = Motion { position: 0.0, velocity };
    let ends = [
        ("forward-euler", driven::<ForwardEuler<f32>>(&settings, from, &[0.0])),
        ("semi-implicit", driven::<SemiImplicit<f32>>(&settings, from, &[0.0])),
        ("exact", driven::<Exact<f32>>(&settings, from, &[0.0])),
    ];
    let wanted = f64::from(velocity) * 1e-3 * TICKS as f64;
    for (name, end) in ends {
        let drift_m = f64::from(end.position) - wanted;
        println!("{name}: 10 h at 10 um/s, drift {:.4} um of {wanted:.3} m", 1e6 * drift_m);
        assert!(drift_m.abs() < ALLOWED_M, "{name}: {drift_m} m");
    }
    let step = velocity * 1e-3_f32;
    let plain = (0..TICKS).fold(0.0_f32, |sum, _| sum + step);
    let drift_m = f64::from(plain) - wanted;
    println!("plain sum: drift {:.1} um", 1e6 * drift_m);
    assert!(drift_m.abs() > 1000.0 * ALLOWED_M, "without compensation only {drift_m} m");
}

/// Why: what an object does all day is swing. Under a periodic force, started in its steady state (closed form of each
/// integrator's own recurrence), it must be back where it was after 36,000 swings of 1 s and 13 cm.
#[test]
fn ten_hours_of_swinging() {
    let (period, damping) = (1000, 1.0);
    let (settings, forces) = (settings(damping), cosine(1.0, period));
    let (mass, tick_s) = (settings.object.mass_kg, settings.timing.control_period_s);
    let euler = steady_velocity(tick_s / mass, 1.0 - tick_s / mass * damping, period);
    let kept = (-damping * tick_s / mass).exp();
    let held = steady_velocity((1.0 - kept) / damping, kept, period);
    let from = |velocity: f64| Motion { position: 0.1_f32, velocity: velocity as f32 };
    let ends = [
        ("forward-euler", euler, driven::<ForwardEuler<f32>>(&settings, from(euler), &forces)),
        ("semi-implicit", euler, driven::<SemiImplicit<f32>>(&settings, from(euler), &forces)),
        ("exact", held, driven::<Exact<f32>>(&settings, from(held), &forces)),
    ];
    for (name, velocity, end) in ends {
        let drift_m = f64::from(end.position) - f64::from(0.1_f32);
        println!("{name}: 10 h of swinging, drift {:.4} um", 1e6 * drift_m);
        assert!(drift_m.abs() < ALLOWED_M, "{name}: {drift_m} m");
        assert!((f64::from(end.velocity) / velocity - 1.0).abs() < 1e-4, "{name}: {} {velocity}", end.velocity);
    }
    let (mut plain, mut speed) = (0.1_f32, euler as f32);
    let (gain, damping, tick_s) = ((tick_s / mass) as f32, damping as f32, tick_s as f32);
    for tick in 0..TICKS {
        plain += tick_s * speed;
        speed += gain * (forces[tick % period] - damping * speed);
    }
    let drift_m = f64::from(plain) - f64::from(0.1_f32);
    println!("plain sum: drift {:.1} um", 1e6 * drift_m);
    assert!(drift_m.abs() > ALLOWED_M, "without compensation only {drift_m} m");
}

/// Why: the limit of this, stated. Positions are exact sums of what the velocity says, but the velocity is rounded too, by
/// up to 7e-9 m/s a tick; where only 0.1 N·s/m holds the object, that walks it by millimetres in ten hours. Coupled to a
/// device and a remote copy it does not: there the same forces act on what the velocities really are.
#[test]
fn the_velocity_of_a_loose_object_rounds() {
    let period = 1000;
    let settings = settings(0.1);
    let gain = settings.timing.control_period_s / settings.object.mass_kg;
    let velocity = steady_velocity(gain, 1.0 - 0.1 * gain, period);
    let from = Motion { position: 0.1_f32, velocity: velocity as f32 };
    let end = driven::<SemiImplicit<f32>>(&settings, from, &cosine(1.0, period));
    let drift_m = f64::from(end.position) - 0.1;
    println!("0.1 N·s/m: 10 h of swinging, drift {:.1} um", 1e6 * drift_m);
    assert!(drift_m.abs() < 5e-3, "{drift_m} m");
}
