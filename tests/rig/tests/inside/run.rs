//! Numbers in the board's answers.

use super::*;

#[test]
fn numbers_are_all_that_are_there_or_none() {
    assert_eq!(numbers("pulses 20 1"), Some([20, 1]));
    assert_eq!(numbers::<1>("pulses 20 1"), None);
    assert_eq!((ns(BREAK), ns(240)), (1270, 1000));
}
