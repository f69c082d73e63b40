//! Lines of `silicon.txt` that are written, and that are read.

use super::*;

fn shown(name: &str, passed: bool, figures: &str) -> Shown {
    let [name, day, image, figures] = [name, "2026-11-25", "v0.3-4-gabc", figures].map(str::to_owned);
    Shown { name, passed, day, image, figures }
}

#[test]
fn a_test_has_one_line_and_the_last_word_is_what_stands_there() {
    let text = with("", shown("soak", true, "a | b\nc")).unwrap();
    assert_eq!(text, "soak\tpassed\t2026-11-25\tv0.3-4-gabc\ta / b c\n");
    let text = with(&text, shown("dead-man", false, "2100 µs")).unwrap();
    let text = with(&text, shown("soak", false, "one fault")).unwrap();
    let told = read(&text).unwrap();
    assert_eq!(told, [shown("dead-man", false, "2100 µs"), shown("soak", false, "one fault")]);
}

#[test]
fn a_line_that_is_none_is_refused_by_its_number() {
    for (text, why) in [
        ("\nsoak passed\n", "line 2: 1 fields, must be 5, between tabs"),
        ("soke\tpassed\td\ti\tf", "line 1: there is no test soke"),
        ("soak\tok\td\ti\tf", "line 1: \"ok\" must be passed or FAILED"),
    ] {
        assert_eq!(read(text).unwrap_err(), why);
    }
}
