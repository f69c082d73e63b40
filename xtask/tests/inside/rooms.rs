//! Tests of `src/rooms.rs` from inside.

use super::*;

#[test]
fn who_leans_on_whom_is_read_from_what_cargo_says() {
    let tree = "0one v0.1.0 (/house/one)\n1serde v1.0.0\n1two v0.1.0 (/house/inside/two) (*)\n1two v0.1.0 (/house/inside/two)\n\n\
                0two v0.1.0 (/house/inside/two)\n1three v0.1.0 (/elsewhere/three)\n";
    let found = leaning(tree, Path::new("/house"));
    assert_eq!(found.keys().collect::<Vec<_>>(), ["inside/two", "one"]);
    assert_eq!(found["one"], ["inside/two"]);
    assert!(found["inside/two"].is_empty());
}

#[test]
fn what_is_allowed_is_read_and_a_line_that_says_nothing_is_named() {
    let read = allowed("# why\none 100: inside/two core\ncore 20:\n").expect("good lines");
    assert_eq!(read["one"], (100, vec!["inside/two".to_owned(), "core".to_owned()]));
    assert_eq!(read["core"], (20, vec![]));
    let wrong = allowed("one many: two").err().map(|failure| failure.to_string()).unwrap_or_default();
    assert!(wrong.contains("`one many: two` is not"), "{wrong}");
}
