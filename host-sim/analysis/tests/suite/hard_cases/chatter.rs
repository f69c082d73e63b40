//! One-sided contact: at rest on the surface, across a gap, and at the edge of chatter.

use cohold_analysis::{Effort, Range, limit};
use cohold_core::num::Fixed;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::scene::Scene;

use super::setup::{COMMS, scene};

/// Both devices touch exactly and nobody pushes.
fn stays<S: Number>(scene: &Scene) {
    let mut pair = Pair::<S>::new(scene).expect("a good scene");
    let start = pair.sides().map(|side| side.plant.motions());
    for _ in 0..5000 {
        pair.step();
        for (side, start) in pair.sides().into_iter().zip(&start) {
            let seen = side.peer.observed()[0];
            assert_eq!((seen.contact_force, seen.coordination_force), (S::ZERO, S::ZERO), "{}", S::NAME);
            assert_eq!(&side.plant.motions(), start, "{}", S::NAME);
        }
    }
    assert_eq!(pair.fault(), None);
}

/// Why: a device that rests on the surface is where contact is decided by the last bit. Nothing may hum: not a bit moves,
/// with exact positions and with encoder counts, touching or a gap away.
#[test]
fn a_device_at_rest_on_the_surface_stays_at_rest() {
    for (law, stiffness) in COMMS {
        let encoders =
            ["difference", "filtered", "adaptive"].map(|name| format!("plant.encoder=true axis.velocity={name}"));
        for sensing in encoders.iter().map(String::as_str).chain([""]) {
            for gap_m in [0.0, 0.005] {
                let scene = scene(&format!(
                    "coordination.comm={law} coordination.stiffness_n_per_m={stiffness} contact.one_sided=true \
                     contact.gap_m={gap_m} {sensing}"
                ));
                stays::<f32>(&scene);
                stays::<f64>(&scene);
                stays::<Fixed>(&scene);
            }
        }
    }
}

/// Why: `contact.gap_m` is the free travel before contact. It was twice that: the object was put a gap away from the
/// device, and contact began another gap behind it.
#[test]
fn contact_begins_after_the_gap() {
    for gap_m in [0.0, 0.001, 0.005, 0.1] {
        let scene = scene(&format!("contact.one_sided=true contact.gap_m={gap_m} user.1.push_n=0.1 user.2.push_n=0.1"));
        let mut pair = Pair::<f64>::new(&scene).expect("a good scene");
        let start = pair.sides().map(|side| side.plant.motions()[0].position);
        loop {
            pair.step();
            let travels = [0, 1].map(|at: usize| {
                let seen = pair.sides()[at].peer.observed()[0];
                ((seen.device.position - start[at]).abs(), seen.device.velocity.abs(), seen.contact_force != 0.0)
            });
            let one_tick_m = 1e-3 * travels[0].1 + 1e-6;
            for (travel_m, _, touches) in travels {
                assert_eq!(touches, travel_m > gap_m, "{travel_m} m of {gap_m} m");
                assert!(travel_m < gap_m + one_tick_m);
            }
            if travels.iter().all(|travel| travel.2) {
                break;
            }
        }
    }
}

/// How often contact begins or ends in the last five of ten seconds, and the largest contact force then, N.
fn chatter<S: Number>(scene: &Scene) -> (u32, f64) {
    let mut pair = Pair::<S>::new(scene).expect("a good scene");
    let (mut touched, mut changes, mut largest_n) = ([false; 2], 0, 0.0_f64);
    for tick in 0..10_000 {
        pair.step();
        for (side, touched) in pair.sides().into_iter().zip(&mut touched) {
            let force_n = side.peer.observed()[0].contact_force.to_f64();
            let touches = force_n != 0.0;
            if std::mem::replace(touched, touches) != touches && tick > 5000 {
                changes += 1;
            }
            if tick > 5000 {
                largest_n = largest_n.max(force_n.abs());
            }
        }
    }
    assert_eq!(pair.fault(), None);
    (changes, largest_n)
}

/// Why: the linear limit of the contact stiffness is the edge of chatter. 1 % below it two users who press on the object
/// come to rest in contact; 1 % above they never do, at any push; and since contact that breaks cannot feed the
/// oscillation, its size is set by the push, not by time. In all three number types alike.
#[test]
fn chatter_begins_at_the_limit_of_the_linear_contact() {
    for (law, stiffness) in COMMS {
        let base = format!(
            "coordination.comm={law} coordination.stiffness_n_per_m={stiffness} contact.one_sided=true \
             object.integrator=exact"
        );
        let range = Range { key: "contact.stiffness_n_per_m".to_owned(), from: 1.0, to: 20_000.0 };
        let edge = limit(&scene(&base), range, Effort::default()).expect("a limit").crossings[0];
        for push_n in [0.001, 0.1, 1.0] {
            for (factor, rests) in [(0.5, true), (0.99, true), (1.01, false), (1.5, false)] {
                let contact = factor * edge;
                let scene = scene(&format!(
                    "{base} contact.stiffness_n_per_m={contact} user.1.push_n={push_n} user.2.push_n={push_n}"
                ));
                let all = [chatter::<f64>(&scene), chatter::<f32>(&scene), chatter::<Fixed>(&scene)];
                println!("{law}, {push_n} N, K_LC = {factor} · {edge:.0} N/m: changes and force in 5 s {all:?}");
                for (changes, largest_n) in all {
                    assert_eq!(changes == 0, rests, "{changes} changes");
                    assert!(largest_n < 20.0 * push_n, "{largest_n} N");
                }
            }
        }
    }
}
