//! Tests of `src/collaborative/history.rs` from inside.

use super::*;

#[test]
fn one_branch_is_well_and_two_are_a_lost_update() {
    let mut history = History::default();
    let one = history.edit(&Value::default());
    let two = history.edit(&one);
    let other = history.edit(&Value::default());
    // Told in another order than made: well.
    history.publish(&two);
    history.publish(&one);
    history.last(0, &two);
    history.official(&one);
    history.official(&two);
    assert_eq!(history.wrong, None);
    let wrong = |what: &dyn Fn(&mut History)| {
        let mut history = history.clone();
        what(&mut history);
        history.wrong.expect("something is wrong")
    };
    assert!(wrong(&|history| history.last(0, &one)).contains("edit 2 was published"));
    assert!(wrong(&|history| history.publish(&other)).contains("do not build on each other"));
    assert!(wrong(&|history| history.official(&other)).contains("does not build on edit 2"));
    assert!(wrong(&|history| history.publish(&[9; 24])).contains("nobody has made"));
}
