//! Tests of `src/font.rs` from inside.

use super::*;

#[test]
fn the_font_is_readable_and_widths_add_up() {
    assert!(font(20.0).box_size("m").is_ok());
    let (one, ten) = (width("m", 20.0), width("mmmmmmmmmm", 20.0));
    assert!(one > 10.0 && one < 25.0, "{one}");
    assert!((ten - 10.0 * one).abs() < 0.01 * ten, "{ten} {one}");
    assert!(width("K_T", 20.0) < width("KT", 20.0));
    assert_eq!(width("", 20.0), 0.0);
}

#[test]
fn indices_and_powers_are_found_and_names_are_left_alone() {
    let run = |level, text: &str| (level, text.to_owned());
    let expected = [
        run(Level::Base, "(K"),
        run(Level::Below, "LC"),
        run(Level::Base, " = 10"),
        run(Level::Above, "−3"),
        run(Level::Base, ")"),
    ];
    assert_eq!(runs("(K_LC = 10^−3)"), expected);
    for plain in ["object_1_m", "a _b", "_", "x_", "^2", "2^ 3", "K_ T", ""] {
        assert_eq!(runs(plain).iter().map(|(_, run)| run.as_str()).collect::<String>(), plain);
    }
}

#[test]
fn lines_break_at_spaces_and_keep_every_word() {
    let text = "the largest stable coordination stiffness against the contact stiffness";
    let lines = wrap(text, 20.0, 200.0);
    assert!(lines.len() > 2 && lines.iter().all(|line| width(line, 20.0) <= 200.0));
    assert_eq!(lines.join(" "), text);
    assert_eq!(wrap("unbreakable", 20.0, 1.0), ["unbreakable"]);
    assert!(wrap("", 20.0, 100.0).is_empty());
}
