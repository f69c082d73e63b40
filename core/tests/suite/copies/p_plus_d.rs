//! A spring and a damper to the ground: where copies stand, what they drag, and up to which delay they are passive.

use cohold_core::settings::Settings;

use crate::two_copies::{Copies, PERIOD, SOFT, settings};

fn scene(stiffness: f64, damping: f64) -> Settings {
    settings(
        "p-plus-d",
        &[
            ("coordination.stiffness_n_per_m", stiffness),
            ("coordination.damping_n_s_per_m", damping),
            ("contact.stiffness_n_per_m", SOFT),
            ("contact.damping_n_s_per_m", 0.0),
        ],
    )
}

/// Two hands that push F against each other stand F/K_T apart from each other, whatever the delay.
#[test]
fn copies_stand_apart_by_the_spring() {
    for delay in [0, 20] {
        let mut copies = Copies::<f64>::new(&scene(310.0, 30.0), delay);
        let mut seen = copies.pushed([1.0, -1.0]);
        (0..20_000).for_each(|_| seen = copies.pushed([1.0, -1.0]));
        let [one, two] = seen.map(|seen| seen.object.position);
        let force = seen[0].contact_force;
        assert!(((one - two) / (force / 310.0) - 1.0).abs() < 1e-6, "{} mm", 1e3 * (one - two));
    }
}

/// Pushed alike they go at F/(B_T + K_T·T) each, with T half a tick more than the way: what Lee and Spong's damping costs.
#[test]
fn a_common_push_drags_through_the_damper_and_the_delay() {
    for delay in [0_u32, 5, 50] {
        let mut copies = Copies::<f64>::new(&scene(310.0, 30.0), delay as usize);
        let mut seen = copies.pushed([1.0, 1.0]);
        (0..2000).for_each(|_| seen = copies.pushed([1.0, 1.0]));
        let late = PERIOD * (f64::from(delay) + 0.5);
        for seen in seen {
            let drag = seen.contact_force / seen.object.velocity;
            let closed = 30.0 + 310.0 * late;
            assert!((drag / closed - 1.0).abs() < 0.005, "{delay} ticks: {drag} N·s/m, {closed} by the law");
        }
    }
}

/// With the damping of the delay the copies' swing dies away, however long that is; with a tenth of it it grows.
#[test]
fn the_damper_pays_for_the_delay() {
    for delay in [10_u32, 40, 200] {
        let late = PERIOD * (f64::from(delay) + 0.5);
        // The fastest that the copies go against each other in each second after a kick, over the kick.
        let swing = |damping: f64| {
            let mut copies = Copies::<f64>::new(&scene(310.0, damping), delay as usize);
            let mut most = |ticks: u32, force: f64| {
                (0..ticks).fold(0.0_f64, |most, _| {
                    let [one, two] = copies.pushed([force, -force]).map(|seen| seen.object.velocity);
                    most.max((one - two).abs())
                })
            };
            let kicked = most(10, 1e-6);
            [0; 5].map(|_| most(1000, 0.0) / kicked)
        };
        let (paid, unpaid) = (swing(310.0 * late), swing(31.0 * late));
        assert!(paid[4] < 0.7, "{delay} ticks: {paid:?}");
        assert!(unpaid.iter().any(|second| *second > 10.0), "{delay} ticks, a tenth of the damping: {unpaid:?}");
    }
}
