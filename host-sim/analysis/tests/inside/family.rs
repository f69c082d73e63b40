//! Tests of `src/family.rs` from inside: beside peers driven at every value.

use cohold_core::law::wave::Decode;
use cohold_core::names::Choice;

use super::*;
use crate::figure4;
use crate::spectrum::radius;
use crate::sweep::Range;

const KEYS: [(&str, f64); 4] = [
    ("contact.stiffness_n_per_m", 10_000.0),
    ("contact.damping_n_s_per_m", 100.0),
    ("coordination.stiffness_n_per_m", 12_000.0),
    ("coordination.damping_n_s_per_m", 100.0),
];

fn sweep(law: &'static str, decode: Decode, (key, to): (&str, f64)) -> Sweep {
    let mut scene = figure4::scene(law, 1);
    scene.peer.coordination.decode = decode;
    Sweep::new(&scene, Range { key: key.to_owned(), from: 0.0, to }).unwrap()
}

/// The largest difference of a radius, relative to the larger of it and 1, over a hundred values.
fn worst_difference(sweep: &Sweep, family: &Family, mode: Hands, [low, high]: [f64; 2]) -> f64 {
    let (mut followed, mut driven) = (Analyser::default(), Analyser::default());
    let values = (0..=100).map(|at| low * (high / low).powf(f64::from(at) / 100.0).clamp(1.0, high / low));
    let difference = |value: f64| {
        assert!(family.holds(value));
        let mut parts = Vec::new();
        family.eigenvalues(&mut followed, value, &mut parts).unwrap();
        let said = parts.iter().map(|part| radius(part)).fold(0.0, f64::max);
        let measured = sweep.radius(&mut driven, value, Some(mode)).unwrap();
        (said - measured).abs() / measured.max(1.0)
    };
    values.map(difference).fold(0.0, f64::max)
}

#[test]
fn radii_are_those_of_driven_peers() {
    let mut families = 0;
    for law in figure4::COMMS {
        for decode in Decode::ALL {
            for (key, to) in KEYS {
                let sweep = sweep(law, *decode, (key, to));
                let range = [1e-6 * to, to];
                for mode in Hands::ALL {
                    let Some(family) = Family::of(&sweep, *mode, range).unwrap() else { continue };
                    families += 1;
                    let worst_difference = worst_difference(&sweep, &family, *mode, range);
                    assert!(
                        worst_difference < 1e-9,
                        "{law}, {}, {key}, {}: {worst_difference}",
                        decode.name(),
                        mode.name()
                    );
                }
            }
        }
    }
    // With the paper's decode all of them, and with the other those that stand in no denominator.
    println!("{families} families");
    assert!(families >= 36, "{families}");
}

/// What a gain does in a denominator, over five decades, no few points tell: every value is driven.
#[test]
fn a_gain_in_a_denominator_makes_no_family() {
    let sweep = sweep("wave", Decode::Implicit, ("coordination.stiffness_n_per_m", 1e6));
    assert!(Family::of(&sweep, Hands::Both, [1.0, 1e6]).unwrap().is_none());
}

/// A spring that is not there at all leaves other modes at rest than a soft one.
#[test]
fn states_that_come_and_go_make_no_family() {
    let mut scene = figure4::scene("wave", 1);
    scene.peer.contact.damping_n_s_per_m = 0.0;
    let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 0.0, to: 1000.0 };
    let sweep = Sweep::new(&scene, range).unwrap();
    assert!(Family::of(&sweep, Hands::Both, [0.0, 1000.0]).unwrap().is_none());
    let family = Family::of(&sweep, Hands::Both, [1e-3, 1000.0]).unwrap().unwrap();
    assert!(family.holds(1e-3) && family.holds(1000.0) && !family.holds(0.0));
}

#[test]
fn only_gains_are_followed() {
    for (key, is_gain) in [("contact.stiffness_n_per_m", true), ("network.extra_delay_s", false)] {
        let range = Range { key: key.to_owned(), from: 0.0, to: 0.1 };
        assert_eq!(Sweep::new(&figure4::scene("wave", 1), range).unwrap().is_gain(), is_gain);
    }
}
