use super::*;

/// Ripple (N, rms) of the force that drags a device of 0.4 kg at 0.1 m/s, and how far behind the pointer it is (ms).
fn drag(comes: impl Fn(u64) -> bool) -> (f64, f64) {
    let (mut hand, mut x, mut v, mut forces) = (Hand::default(), 0.0, 0.0, Vec::new());
    for tick in 0..3000 {
        if comes(tick) {
            hand.point(tick, Some([1e-4 * tick as f64]), [x]);
        }
        let [force] = hand.pull(tick, [Motion { position: x, velocity: v }], 1e-3);
        v += 1e-3 * (force - v) / 0.4;
        x += 1e-3 * v;
        if tick >= 2000 {
            forces.push(force);
        }
    }
    let mean = forces.iter().sum::<f64>() / forces.len() as f64;
    let ripple = (forces.iter().map(|force| (force - mean).powi(2)).sum::<f64>() / forces.len() as f64).sqrt();
    (ripple, (0.3 - x) / 1e-4)
}

/// In the steady state the force is the device's damping times its speed, 1 N·s/m · 0.1 m/s, which stretches the spring by 0.5 mm: 5 ms
/// at that speed, behind 24 of play-out.
#[test]
fn frames_do_not_rattle() {
    let (even, behind) = drag(|tick| matches!(tick % 50, 0 | 17 | 33));
    let (uneven, _) = drag(|tick| matches!(tick % 50, 0 | 23 | 29));
    assert!(even < 1e-6 && uneven < 1e-6, "{even} {uneven}");
    assert!((behind - 29.0).abs() < 1.5, "{behind}");
}

#[test]
fn a_frame_that_is_late_is_no_blow() {
    let (mut hand, mut hardest) = (Hand::default(), 0.0_f64);
    for tick in 0..400 {
        if tick % 16 == 0 && !(100..200).contains(&tick) {
            hand.point(tick, Some([if tick < 100 { 0.0 } else { 0.02 }]), [0.0]);
        }
        hardest = hardest.max(hand.pull(tick, [Motion::REST], 1e-3)[0].abs());
    }
    // A spring that is stretched so far, and a damper at the fastest that a hand goes.
    assert!(hardest <= STIFFNESS * 0.02 + DAMPING * FASTEST, "{hardest}");
}

#[test]
fn a_hand_is_no_stronger_than_it_says_and_lets_go() {
    let mut hand = Hand::default();
    hand.point(0, Some([0.2]), [0.0]);
    let pulled = (0..600).map(|tick| hand.pull(tick, [Motion::REST], 1e-3)).last();
    assert_eq!(pulled, Some([STRENGTH]));
    assert_eq!(hand.holds(), Some([0.2]));
    hand.point(600, None, [0.0]);
    assert_eq!((hand.pull(600, [Motion::REST], 1e-3), hand.holds()), ([0.0], None));
}

/// Of two axes a hand is as strong as along one, in the direction in which it pulls.
#[test]
fn a_hand_in_the_plane_is_no_stronger_than_along_a_line() {
    let mut hand = Hand::default();
    hand.point(0, Some([0.12, -0.16]), [0.0; 2]);
    let pulled = (0..900).map(|tick| hand.pull(tick, [Motion::REST; 2], 1e-3)).last();
    let [along, across] = pulled.expect("a force");
    assert!((along - 0.6 * STRENGTH).abs() < 1e-9 && (across + 0.8 * STRENGTH).abs() < 1e-9, "{along} {across}");
    let fast = (hand.at[0].hypot(hand.at[1]) - 0.2).abs();
    assert!(fast < 1e-9, "{:?}", hand.at);
}
