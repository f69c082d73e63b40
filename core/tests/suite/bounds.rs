//! What another end may say: no law that keeps within the limits of its scene ever says more, whatever it hears and however it is moved.

use cohold_core::law::bounds::Bounds;
use cohold_core::law::{Law, Observation, Packet};
use cohold_core::num::Motion;
use cohold_core::object::Port;
use cohold_core::settings::{Settings, Value};
use proptest::prelude::*;

use crate::{AnyLaw, BOUNDED, SCHEMA};

fn settings(law: &'static str, ticks_per_packet: u32, impedance: f64) -> Settings {
    let mut settings = Settings::default();
    for (key, value) in [
        ("object.integrator", Value::Text("midpoint")),
        ("object.force_delay_ticks", Value::Number(0.0)),
        ("coordination.decode", Value::Text("implicit")),
        ("coordination.wave_impedance_n_s_per_m", Value::Number(impedance)),
        ("timing.ticks_per_packet", Value::Number(ticks_per_packet.into())),
    ] {
        SCHEMA.set(&mut settings, key, value).expect("an allowed value");
    }
    settings.coordination.comm = law;
    settings
}

/// What happens to an end in a tick: how the copy moves, m/s, and what comes, with how many ticks it is over.
#[derive(Clone, Copy, Debug)]
struct Tick {
    velocity: f64,
    hears: Option<(f64, u8)>,
    is_lost: bool,
}

fn ticks() -> impl Strategy<Value = Vec<Tick>> {
    let heard = prop::option::weighted(0.3, (-20.0..20.0_f64, 0..30_u8));
    let tick = (-2.0..2.0_f64, heard, prop::bool::weighted(0.3));
    prop::collection::vec(tick.prop_map(|(velocity, hears, is_lost)| Tick { velocity, hears, is_lost }), 1..400)
}

proptest! {
    /// The limits are those that the end itself kept: its fastest motion and its largest force, and no more.
    #[test]
    fn no_law_says_more_than_the_limits_that_it_keeps(
        law in prop::sample::select(BOUNDED),
        ticks in ticks(),
        ticks_per_packet in 1..10_u32,
        impedance in 1.0..100.0_f64,
        most_kg in prop::sample::select(&[0.0, 0.2, 4.0][..]),
        claims in prop::sample::select(&[0.0, 0.3, 1.0, 100.0][..]),
    ) {
        let mut settings = settings(law, ticks_per_packet, impedance);
        SCHEMA.set(&mut settings, "coordination.most_line_mass_kg", Value::Number(most_kg)).expect("it is allowed");
        let law = AnyLaw::<f64>::build(&settings).expect("good settings");
        let own_time = AnyLaw::<f64>::info(&settings).expect("a law").own_time;
        let mut state = law.start(Motion::REST);
        let (mut local, mut heard) = (Motion::REST, Packet::<f64>::default());
        let (mut speed, mut force, mut said) = (0.0_f64, 0.0_f64, Vec::new());
        // Between a line with a time of its own and its spring lies a slip, part of which is elastic: how fast the line goes is had from its place.
        let elastic_m_per_n =
            1e-3 / (200.0 * (0.5e-3 * settings.coordination.stiffness_n_per_m + settings.coordination.damping_n_s_per_m));
        let (mut slipped, mut place) = (0.0, None::<f64>);
        // Where the line is after the last tick is seen in one more.
        let after = Tick { velocity: 0.0, hears: None, is_lost: true };
        for (number, tick) in ticks.iter().chain([&after]).enumerate() {
            if let Some((wave, ticks)) = tick.hears {
                let ticks = u32::from(ticks);
                heard.wave = wave;
                if own_time {
                    // What it says of itself: whether it hears anything, and what the line should weigh.
                    heard.wave = 0.1 * wave;
                }
                heard.motion.velocity = tick.velocity;
                heard.live_ticks += ticks;
                heard.wave_integral += 1e-3 * f64::from(ticks) * wave;
                heard.energy_j += claims * 0.5e-3 * f64::from(ticks) * wave * wave;
                law.receive(&mut state, heard);
            }
            let seen = Observation { local, contact_force: 0.0, age_ticks: 0 };
            let coupled = law.couple(&mut state, &seen, |_: Port<f64>| tick.velocity);
            local = Motion { position: local.position + 1e-3 * tick.velocity, velocity: tick.velocity };
            if own_time {
                let now = coupled.desired.position - slipped;
                speed = place.map_or(speed, |before| speed.max((now - before).abs() / 1e-3));
                place = Some(now);
                slipped = law.send(&state, local).motion.position - elastic_m_per_n * coupled.force;
            }
            speed = speed.max(coupled.desired.velocity.abs());
            force = force.max(coupled.force.abs());
            if (number + 1).is_multiple_of(ticks_per_packet as usize) && !tick.is_lost {
                said.push(law.send(&state, local));
            }
        }
        // Rounding of the law's own constants, and of a step of the line.
        let more = 1.0 + 1e-9;
        (settings.safety.max_speed_m_per_s, settings.safety.max_force_n) = (more * speed, more * force);
        let bounds = AnyLaw::<f64>::bounds(&settings);
        let mut newest = None;
        for packet in &said {
            prop_assert_eq!(bounds.take(&mut newest, packet), Ok(()), "{:?}", packet);
        }
    }

    /// Whatever is let in, no difference of two sums leaves the range of numbers, and every mean of what is new is a wave within the
    /// bound.
    #[test]
    fn what_is_let_in_is_finite_and_within_the_bound(
        said in prop::collection::vec((any::<f64>(), any::<f64>(), any::<f64>(), any::<u32>()), 1..40),
        scale in prop::sample::select(&[1.0, 1e-3, 1e-150, 1e-300][..]),
    ) {
        let bounds = AnyLaw::<f64>::bounds(&settings("self-timed", 1, 10.0));
        let (mut newest, mut before) = (None, None::<Packet<f64>>);
        for (wave, sum, energy, live_ticks) in said {
            let packet = Packet { wave: scale * wave, wave_integral: scale * sum, energy_j: scale * energy, live_ticks, ..Packet::default() };
            if bounds.take(&mut newest, &packet).is_err() {
                continue;
            }
            prop_assert!(packet.is_finite() && packet.wave.abs() <= bounds.wave());
            if let Some(before) = before {
                let ticks = packet.live_ticks.wrapping_sub(before.live_ticks).cast_signed();
                if ticks <= 0 {
                    continue;
                }
                let mean = (packet.wave_integral - before.wave_integral) / (1e-3 * f64::from(ticks));
                prop_assert!(mean.abs() <= bounds.wave() * (1.0 + 1e-6) + 1e-9, "{mean}");
                prop_assert!((packet.energy_j - before.energy_j).is_finite());
            }
            before = Some(packet);
        }
    }
}

/// A copy that somebody else makes faster than its own limits allow sends larger waves than anybody would believe. What is
/// told of them is believed all the same, and in the end all of it is told.
#[test]
fn a_self_timed_end_that_is_pushed_beyond_its_limits_is_believed() {
    let mut settings = settings("self-timed", 1, 60.0);
    for key in ["coordination.most_line_mass_kg", "coordination.carry_damping_n_s_per_m"] {
        SCHEMA.set(&mut settings, key, Value::Number(0.0)).expect("it is allowed");
    }
    let law = AnyLaw::<f64>::build(&settings).expect("good settings");
    let bounds = AnyLaw::<f64>::bounds(&settings);
    let (mut state, mut local) = (law.start(Motion::REST), Motion::REST);
    let (mut heard, mut newest, mut larger, mut ends) = (Packet::<f64>::default(), None, 0, [0.0; 2]);
    for tick in 0..4_000_u32 {
        let (size, swing) = (if tick < 2_000 { 1.0 } else { 0.0 }, (0.01 * f64::from(tick)).sin());
        let (wave, velocity) = (3.0 * bounds.wave() * size * swing, 25.0 * size * swing);
        heard.live_ticks += 1;
        heard.wave_integral += 1e-3 * wave;
        heard.energy_j += 0.5e-3 * wave * wave;
        law.receive(&mut state, heard);
        let seen = Observation { local, contact_force: 0.0, age_ticks: 0 };
        let coupled = law.couple(&mut state, &seen, |_: Port<f64>| velocity);
        local = Motion { position: local.position + 1e-3 * velocity, velocity };
        larger += u32::from((2.0 * coupled.power_out).sqrt() > bounds.wave());
        let packet = law.send(&state, local);
        law.spoke(&mut state, &packet);
        assert_eq!(bounds.take(&mut newest, &packet), Ok(()), "tick {tick}");
        let last = coupled.desired.position * 120_f64.sqrt();
        ends = [packet.wave_integral, last - heard.wave_integral];
    }
    assert!(larger > 500, "{larger}");
    assert!((ends[0] - ends[1]).abs() < 1e-9, "{ends:?}");
}

/// An end that moves at the limit and pulls at the limit says just the bound: with 10 m/s, 40 N and 10 N·s/m (10·10 + 40)/√20 √W.
#[test]
fn the_bound_is_what_the_limits_come_to() {
    let bounds = Bounds::of_waves(&Settings::default());
    let most = 140.0 / 20.0_f64.sqrt();
    assert!((bounds.wave() / most - 1.0).abs() < 1e-15);
    assert!((bounds.beyond_a_junction().wave() / (3.0 * most) - 1.0).abs() < 1e-15);
    // A world that is five times as large and twice as strong.
    let mut scaled = Settings::default();
    (scaled.scale.position, scaled.scale.force) = (5.0, 2.0);
    assert!((Bounds::of_waves(&scaled).wave() / (580.0 / 20.0_f64.sqrt()) - 1.0).abs() < 1e-15);
    // What goes back into a line where N meet, all at the bound, is at most thrice the bound.
    for lines in 2..=16 {
        let (mean, own) = ((f64::from(lines) - 2.0) / f64::from(lines), -1.0);
        assert!(2.0 * mean - own <= 3.0);
    }
    for number in [f64::NAN, f64::INFINITY, -f64::INFINITY, f64::MAX] {
        for &law in BOUNDED {
            let bounds = AnyLaw::<f64>::bounds(&settings(law, 8, 10.0));
            let still = Packet::<f64>::default();
            for packet in [
                Packet { motion: Motion { position: number, velocity: 0.0 }, ..still },
                Packet { motion: Motion { position: 0.0, velocity: number }, ..still },
                Packet { energy_j: number, ..still },
                Packet { wave_integral: number, ..still },
            ] {
                assert!(bounds.take(&mut None, &packet).is_err(), "{packet:?}");
            }
        }
    }
}
