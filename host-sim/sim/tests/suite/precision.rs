//! What number types make of a self-timed line in hours (THEORY §8), from minutes: the relative mode of the copies does not walk, and
//! the common one, which nothing pulls back, walks at random, by micrometres neither in ten hours.

use cohold_core::num::Fixed;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::{Laws, Scene, scenes};

const MINUTES: usize = 20;
const TICKS_OF_A_MINUTE: usize = 60_000;

/// `any-network` under the pushes of §5.2.
fn scene() -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    for push in ["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"] {
        scene.apply_override(push).expect("a good override");
    }
    scene
}

/// Largest difference from f64 of x_1 − x_2 in each minute, and of (x_1 + x_2)/2 at the end of each, m.
fn differences<S: Number>() -> [(f64, f64); MINUTES] {
    let scene = scene();
    let (mut exact, mut rounded) =
        (Pair::<f64>::new(&scene).expect("a good scene"), Pair::<S>::new(&scene).expect("a good scene"));
    [(); MINUTES].map(|()| {
        let (mut relative, mut common) = (0.0_f64, 0.0);
        for _ in 0..TICKS_OF_A_MINUTE {
            exact.step();
            rounded.step();
            let wanted = exact.sides().map(|side| side.peer.observed()[0].object.position);
            let got = rounded.sides().map(|side| side.peer.observed()[0].object.position.to_f64());
            let [first, second] = [got[0] - wanted[0], got[1] - wanted[1]];
            relative = relative.max((first - second).abs());
            common = 0.5 * (first + second);
        }
        assert!(exact.fault().is_none() && rounded.fault().is_none());
        (relative, common)
    })
}

/// Farthest that rounding may move the copies apart, m: 16 steps of f32, which are 2⁻²⁸ m where they move by up to 62 mm.
const MOST_M: f64 = 6e-8;

/// Ten hours are 600 minutes, and a random walk of so many steps goes √600 times as far as one.
fn stays<S: Number>() {
    let minutes = differences::<S>();
    for (relative, _) in minutes {
        assert!(relative < MOST_M, "{}: {minutes:?}", S::NAME);
    }
    let walks: Vec<f64> = minutes.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    let rms = (walks.iter().map(|walk| walk * walk).sum::<f64>() / walks.len() as f64).sqrt();
    assert!(rms * 600.0_f64.sqrt() < 1e-6, "{}: {rms} m a minute", S::NAME);
}

#[test]
fn a_self_timed_line_stays_within_a_micrometre_for_ten_hours() {
    stays::<f32>();
    stays::<Fixed>();
}
