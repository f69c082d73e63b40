//! The newest orders are kept, and all are counted.

use super::{Asked, KEPT};

/// An emulator that runs for days does not grow with them.
#[test]
fn the_newest_orders_are_kept_and_all_are_counted() {
    let mut asked = Asked::<1>::default();
    let count = 5 * KEPT as u64 + 3;
    (0..count).for_each(|at| asked.push(at as f64, [if at % 1000 == 7 { 1.0 } else { 0.0 }]));
    assert!((KEPT..=2 * KEPT).contains(&asked.len()), "{}", asked.len());
    let all = asked.windows(2).all(|two| two[1].0 == two[0].0 + 1.0);
    assert!(all && asked.last().map(|last| last.0) == Some(count as f64 - 1.0));
    let last_push_s = (0..count).rev().find(|at| at % 1000 == 7).map(|at| at as f64);
    assert_eq!((asked.count(), asked.last_push_s()), (count, last_push_s));
}
