//! The self-timed line (THEORY §8) at constant delay: random scenes that are let go of, and what it needs.

use cohold_analysis::judge;

use crate::kinds::self_timed;
use crate::midpoint::released;
use crate::random::Random;

/// Whatever is drawn, with a stated credit and with one that follows, light lines and heavy ones: nothing grows that nobody holds. Ten thousand of them:
/// `SCENES=10000 cargo test --release -p cohold-analysis --test suite no_scene_that_is_let_go_of`.
#[test]
fn no_scene_that_is_let_go_of_is_unstable() {
    let scenes = std::env::var("SCENES").ok().and_then(|scenes| scenes.parse().ok()).unwrap_or(1000);
    let mut random = Random::new(5);
    let mut worst = 0.0_f64;
    for number in 0..scenes {
        let (ticks, delay) = (random.whole(1, 16), random.whole(0, 20));
        let credit = if random.whole(0, 2) == 0 { 0 } else { ticks * (delay + 1) + random.whole(0, 30) };
        let mut scene = self_timed(ticks, delay, credit);
        scene.peer.timing.control_period_s = random.spread(1e-4, 5e-3);
        scene.peer.coordination.stiffness_n_per_m = random.spread(10.0, 1e6);
        scene.peer.coordination.damping_n_s_per_m = 20.0 * random.unit();
        scene.peer.coordination.wave_impedance_n_s_per_m = random.spread(1.0, 200.0);
        scene.peer.object.mass_kg = random.spread(1e-3, 10.0);
        let most_kg = [0.0, 4.0, random.spread(0.01, 100.0)][random.whole(0, 2) as usize];
        scene.set_number("coordination.most_line_mass_kg", most_kg).expect("it is allowed");
        let radius = released(&scene);
        worst = worst.max(radius);
        assert!(radius <= 1.0 + 1e-6, "scene {number}, credit {credit}: {radius} of {:?}", scene.peer);
    }
    println!("{scenes} scenes, largest spectral radius {worst}");
}

/// A credit below the delay: the line holds still part of the time, and is judged as it runs.
#[test]
fn a_line_that_stands_is_judged_as_it_runs() {
    let (short, follows) = (judge(&self_timed(1, 30, 12)), judge(&self_timed(1, 30, 0)));
    let (short, follows) = (short.expect("a good scene"), follows.expect("a good scene"));
    assert!(short.worst.states == 0 && follows.worst.states > 0, "{short:?}, {follows:?}");
    for judged in [short, follows] {
        assert!(judged.not_judged.iter().any(|what| what.contains("the line stands")), "{:?}", judged.not_judged);
    }
}
