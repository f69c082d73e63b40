//! Replay window: the known cases for RFC 6479, and every order against a set that forgets nothing.

use std::collections::HashSet;

use cohold_protocol::link::Error;
use cohold_protocol::replay::{SEQUENCE_LIMIT, Window};
use proptest::prelude::*;

/// Takes each number in turn and compares with what is wanted.
fn takes(cases: &[(u64, bool)]) {
    let mut window = Window::default();
    for (step, (sequence, wanted)) in cases.iter().enumerate() {
        let before = window;
        let checked = window.check(*sequence);
        assert_eq!(window, before, "a check changes nothing");
        assert_eq!(window.take(*sequence), checked, "step {step}: {sequence}");
        assert_eq!(checked.is_ok(), *wanted, "step {step}: {sequence} gave {checked:?}");
    }
}

fn all(numbers: impl Iterator<Item = u64>) -> Vec<(u64, bool)> {
    numbers.map(|number| (number, true)).collect()
}

const REACH: u64 = Window::REACH;
/// One further back than the window tells apart.
const OUT: u64 = REACH + 1;

/// The counter cases that the Linux implementation of RFC 6479 (WireGuard) tests itself with, for this window's size.
#[test]
fn known_cases() {
    let limit = SEQUENCE_LIMIT;
    takes(&[
        (0, true),
        (1, true),
        (1, false),
        (9, true),
        (8, true),
        (7, true),
        (7, false),
        (OUT, true),
        (OUT - 1, true),
        (OUT - 1, false),
        (OUT - 2, true),
        (2, true),
        (2, false),
        (OUT + 16, true),
        (3, false),
        (OUT + 16, false),
        (OUT * 4, true),
        (OUT * 4 - (OUT - 1), true),
        (10, false),
        (OUT * 4 - OUT, false),
        (OUT * 4 - (OUT + 1), false),
        (OUT * 4 - (OUT - 2), true),
        (OUT * 4 + 1 - OUT, false),
        (0, false),
        (limit, false),
        (limit - 1, true),
        (limit, false),
        (limit - 1, false),
        (limit - 2, true),
        (limit + 1, false),
        (limit + 2, false),
        (limit - 2, false),
        (limit - 3, true),
        (0, false),
    ]);
    takes(&[all(1..=REACH), vec![(0, true), (0, false)]].concat());
    takes(&[all(2..=REACH + 1), vec![(1, true), (0, false)]].concat());
    takes(&all((0..=REACH).rev()));
    takes(&[all((1..=REACH + 1).rev()), vec![(0, false)]].concat());
    takes(&[all((1..=REACH).rev()), vec![(REACH + 1, true), (0, false)]].concat());
    takes(&[all((1..=REACH).rev()), vec![(0, true), (REACH + 1, true)]].concat());
}

#[test]
fn errors_say_which() {
    let mut window = Window::default();
    assert_eq!(window.newest(), None);
    assert_eq!(window.take(1_000), Ok(()));
    assert_eq!(window.newest(), Some(1_000));
    assert_eq!(window.take(1_000), Err(Error::Replayed));
    assert_eq!(window.take(1_000 - OUT), Err(Error::TooOld));
    assert_eq!(window.take(u64::MAX), Err(Error::BeyondLast));
    assert_eq!(window.take(1_000 - REACH), Ok(()));
}

proptest! {
    #[test]
    fn agrees_with_a_set_that_forgets_nothing(start in 0..u64::MAX / 2, steps in prop::collection::vec(-300i64..300, 1..2_000)) {
        let (mut window, mut taken, mut newest) = (Window::default(), HashSet::new(), None::<u64>);
        let mut at = start;
        for step in steps {
            at = at.saturating_add_signed(step);
            let wanted = match newest {
                Some(newest) if newest.saturating_sub(at) > REACH => Err(Error::TooOld),
                _ if taken.contains(&at) => Err(Error::Replayed),
                _ => Ok(()),
            };
            prop_assert_eq!(window.check(at), wanted);
            prop_assert_eq!(window.take(at), wanted);
            if wanted.is_ok() {
                taken.insert(at);
                newest = newest.max(Some(at));
            }
        }
    }
}
