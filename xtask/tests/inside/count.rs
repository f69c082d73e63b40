//! Tests of `src/count.rs` from inside.

use super::*;

#[test]
fn a_change_of_more_than_the_tolerance_is_told_and_so_is_a_row_that_comes_or_goes() {
    let reviewed = "# comment\nopen a flow  1000\ntick/wave  100 200 300\ngone  5\n";
    let printed = "# other\nopen a flow  1019\ntick/wave  100 200 310\nnew  7\n";
    let told = differences(reviewed, printed);
    assert_eq!(told.len(), 3, "{told:?}");
    for (told, what) in told.iter().zip(["tick/wave", "new was not", "gone is no longer"]) {
        assert!(told.starts_with(what), "{told}");
    }
    assert!(differences(reviewed, reviewed).is_empty());
}
