//! States that decay below the smallest normal number.

use cohold_core::num::StateVector;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;

use super::setup::{COMMS, scene};

/// Ticks that a pair is watched.
const TICKS: u64 = 100_000;

/// What became of a pair kicked by almost nothing.
struct Fate {
    /// State numbers of both peers.
    numbers: u64,
    /// Ticks after which at least one of them was subnormal.
    ticks_subnormal: u64,
    /// How many at most.
    most_subnormal: u64,
    /// The largest at the end.
    left: f64,
}

/// Kicks both devices, held by arms so that everything decays, and counts.
fn fate<S: Number>(law: &str, stiffness: f64, kick_m_per_s: f64, is_subnormal: impl Fn(S) -> bool) -> Fate {
    let arms = "user.1.arm_stiffness_n_per_m=50 user.1.arm_damping_n_s_per_m=1 \
                user.2.arm_stiffness_n_per_m=50 user.2.arm_damping_n_s_per_m=1";
    let scene = scene(&format!("coordination.comm={law} coordination.stiffness_n_per_m={stiffness} {arms}"));
    let mut pair = Pair::<S>::new(&scene).expect("a good scene");
    for (side, share) in pair.sides_mut().zip([1.0, -0.3]) {
        side.plant.free_axis().0.velocity = share * kick_m_per_s;
    }
    let mut fate = Fate { numbers: 0, ticks_subnormal: 0, most_subnormal: 0, left: 0.0 };
    for tick in 0..TICKS {
        pair.step();
        let (mut numbers, mut subnormal, mut largest) = (0, 0, 0.0_f64);
        for side in pair.sides() {
            let mut state = side.peer.clone();
            state.visit(&mut |number: &mut S| {
                assert!(number.is_finite());
                numbers += 1;
                subnormal += u64::from(is_subnormal(*number));
                largest = largest.max(number.to_f64().abs());
            });
        }
        // Forces are up to K times a position.
        assert!(largest <= 1e4 * kick_m_per_s, "{largest} in tick {tick}");
        fate.numbers = numbers;
        fate.ticks_subnormal += u64::from(subnormal > 0);
        fate.most_subnormal = fate.most_subnormal.max(subnormal);
        fate.left = largest;
    }
    assert_eq!(pair.fault(), None);
    fate
}

/// Why: rounding to nearest keeps the smallest subnormal alive under any factor above one half, so a decaying state need
/// never reach zero; and processors that compute subnormals in microcode slow down by a hundred cycles for each. Here
/// everything decays into that range and may stay there for ever: nothing grows again, nothing becomes infinite, no branch
/// or loop of the tick depends on it, and at most the state's own numbers (some sixteen of both peers) are subnormal at a
/// time, which bounds what a tick can cost (measured here: 1.6 times as long). What is left at the end is subnormal in the
/// power domain; a wave link stands still where its rest mode has come to rest. I32F32 has no subnormals.
#[test]
fn states_decay_through_the_subnormal_range() {
    for (law, stiffness) in COMMS {
        let (single_kick, double_kick) = (1e-30, 1e-300);
        let single = fate::<f32>(law, stiffness, single_kick, f32::is_subnormal);
        let double = fate::<f64>(law, stiffness, double_kick, f64::is_subnormal);
        for (name, fate, kick) in [("f32", single, single_kick), ("f64", double, double_kick)] {
            let Fate { numbers, ticks_subnormal, most_subnormal, left } = fate;
            println!(
                "{law} in {name}: subnormal numbers in {ticks_subnormal} of {TICKS} ticks, at most {most_subnormal} of \
                 {numbers}; at the end {left:e}"
            );
            assert!(ticks_subnormal > 100 && most_subnormal <= numbers && numbers <= 40);
            assert!(left < if law == "power" { 1e-8 } else { 1e-3 } * kick, "{left:e} is left of {kick:e}");
        }
    }
}
