//! The node where N wave lines meet: lossless to rounding, and what its closed form says.

use cohold_core::num::{Fixed, Scalar};
use cohold_environments::cooperative::node::Node;
use proptest::prelude::*;

fn energy<S: Scalar>(waves: &[S]) -> f64 {
    waves.iter().map(|wave| wave.to_f64() * wave.to_f64()).sum()
}

/// Σw² = Σu², and no force left over: Σ√(b_i/2)·(w_i − u_i) = 0 (the force out of each line is √(b/2)·(u_in − u_out)).
fn lossless<S: Scalar, const N: usize>(impedances: [f64; N], waves: [f64; N], within: f64) {
    let waves = waves.map(S::from_f64);
    let back = Node::<S, N>::new(impedances).scatter(waves).back;
    let (into, out) = (energy(&waves), energy(&back));
    assert!((out - into).abs() <= within * into, "{N} lines in {}: {out} of {into}", S::NAME);
    let force = |sign: f64| {
        let each = impedances.iter().zip(waves).zip(back);
        each.map(|((b, u), w)| (b / 2.0_f64).sqrt() * (w.to_f64() - sign * u.to_f64())).sum::<f64>()
    };
    let scale = impedances.iter().zip(waves).map(|(b, u)| (b / 2.0).sqrt() * u.to_f64().abs()).sum::<f64>();
    assert!(force(1.0).abs() <= 100.0 * within * scale, "{} N left of {scale} N", force(1.0));
}

macro_rules! for_counts {
    ($impedances:ident, $waves:ident: $($count:literal)+) => { $(
        let first = |all: &[f64]| <[f64; $count]>::try_from(&all[..$count]).unwrap();
        let (impedances, waves) = (first(&$impedances), first(&$waves));
        lossless::<f64, $count>(impedances, waves, 1e-14);
        lossless::<f32, $count>(impedances, waves, 5e-6);
    )+ };
}

proptest! {
    #[test]
    fn two_to_sixteen_lines_are_lossless(
        logs in prop::collection::vec(-1.0..2.0_f64, 16),
        waves in prop::collection::vec(-10.0..10.0_f64, 16),
    ) {
        let impedances: Vec<f64> = logs.iter().map(|log| 10.0_f64.powf(*log)).collect();
        for_counts!(impedances, waves: 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16);
    }
}

#[test]
fn two_equal_lines_are_joined() {
    let back = Node::<f64, 2>::new([10.0; 2]).scatter([0.3, -0.7]).back;
    assert!((back[0] + 0.7).abs() < 1e-15 && (back[1] - 0.3).abs() < 1e-15, "{back:?}");
    let back = Node::<Fixed, 2>::new([10.0; 2]).scatter([0.3, -0.7].map(Fixed::from_f64)).back;
    assert!((back[0].to_f64() + 0.7).abs() < 1e-8);
}

/// One line against the three others of the same kind: as a mass against three, in closed form (2/4 − 1 back, 2/4 on).
#[test]
fn one_wave_into_four_lines() {
    let scattered = Node::<f64, 4>::new([8.0; 4]).scatter([1.0, 0.0, 0.0, 0.0]);
    assert_eq!(scattered.back, [-0.5, 0.5, 0.5, 0.5]);
    assert_eq!(scattered.velocity, 0.125);
}

#[test]
fn closed_ports_change_nothing() {
    let open = Node::<f64, 2>::new([10.0, 40.0]).scatter([0.3, -0.7]);
    let more = Node::<f64, 4>::new([10.0, 40.0, 0.0, 0.0]).scatter([0.3, -0.7, 5.0, -3.0]);
    assert_eq!((more.velocity, &more.back[..2], &more.back[2..]), (open.velocity, &open.back[..], &[0.0, 0.0][..]));
    assert_eq!(Node::<f64, 2>::new([0.0; 2]).scatter([1.0, 2.0]).back, [0.0, 0.0]);
}
