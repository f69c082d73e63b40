//! Letters: the built-in font, how wide a text is, and where its lines break.
//!
//! Ubuntu Light from `epaint_default_fonts`, so that no figure depends on the fonts of the machine. It has Latin, Greek
//! and common signs (− × ± ≤ ≥ ≈ ² ° µ Ω …) but no arrows; what it lacks is drawn as an empty box. A text may hold an
//! index (`K_T`) and a power (`10^−3`).

use std::sync::Once;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

/// The name under which the font is registered with plotters.
pub(crate) const NAME: &str = "report";
/// (Ascender − descender) / em of this font: plotters sizes letters by the former, the sheet by the latter.
pub(crate) const LINE_PER_EM: f64 = 1.121;

/// Em at which widths are measured, in whole pixels.
const MEASURE: f64 = 500.0;
/// Between words, in ems.
const SPACE: f64 = 0.3;

/// The font at an em of `size` pixels.
pub(crate) fn font(size: f64) -> FontDesc<'static> {
    static REGISTERED: Once = Once::new();
    // The bytes are part of the program and one test draws letters with them: this cannot fail in use.
    REGISTERED.call_once(|| drop(register_font(NAME, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)));
    FontDesc::new(FontFamily::Name(NAME), size * LINE_PER_EM, FontStyle::Normal)
}

/// Where letters stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Base,
    Below,
    Above,
}

/// The text in runs of one level. `_` after a single letter starts an index (`K_T`, not `object_1_m`), `^` a power
/// (`10^−3`); each ends at the first character that is not a letter, a digit or a sign.
fn runs(text: &str) -> Vec<(Level, String)> {
    let letters: Vec<char> = text.chars().collect();
    let word = |i: Option<usize>| i.and_then(|i| letters.get(i)).is_some_and(|c| c.is_alphanumeric() || *c == '_');
    let sign = |i: usize| matches!(letters.get(i), Some('-' | '−'));
    let mut runs: Vec<(Level, String)> = Vec::new();
    let mut level = Level::Base;
    for (i, letter) in letters.iter().enumerate() {
        let (before, after) = (word(i.checked_sub(1)), word(Some(i + 1)));
        let next = match letter {
            '_' if level == Level::Base && before && !word(i.checked_sub(2)) && after => Level::Below,
            '^' if level == Level::Base && before && (after || sign(i + 1)) => Level::Above,
            _ if level != Level::Base && !letter.is_alphanumeric() && !(level == Level::Above && sign(i)) => {
                Level::Base
            }
            _ => level,
        };
        let marker = next != level && next != Level::Base;
        level = next;
        match runs.last_mut().filter(|(last, _)| *last == level) {
            Some((_, run)) if !marker => run.push(*letter),
            _ if marker => runs.push((level, String::new())),
            _ => runs.push((level, letter.to_string())),
        }
    }
    runs
}

/// A word at its place.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Word {
    pub(crate) text: String,
    /// Distance from the start of the text.
    pub(crate) x: f64,
    pub(crate) width: f64,
    /// Height above the base line.
    pub(crate) rise: f64,
    /// Em.
    pub(crate) size: f64,
}

/// The words of a text at an em of `size`, and how wide it is. Words stand apart by a fixed space: the font's own pairs
/// of a letter and a space are too tight to read.
pub(crate) fn words(text: &str, size: f64) -> (Vec<Word>, f64) {
    let mut words = Vec::new();
    let mut x = 0.0;
    for (level, run) in runs(text) {
        // Em relative to the base letters, and height above their base line in base ems.
        let (scale, rise) = match level {
            Level::Base => (1.0, 0.0),
            Level::Below => (0.75, -0.17),
            Level::Above => (0.75, 0.38),
        };
        for (i, text) in run.split(' ').enumerate() {
            x += if i > 0 { SPACE * size } else { 0.0 };
            let guess = 0.5 * MEASURE * text.chars().count() as f64;
            let measured = font(MEASURE).box_size(text).map_or(guess, |(width, _)| f64::from(width));
            let width = measured / MEASURE * scale * size;
            if !text.is_empty() {
                words.push(Word { text: text.to_owned(), x, width, rise: rise * size, size: scale * size });
            }
            x += width;
        }
    }
    (words, x)
}

/// Width of a text in pixels at an em of `size`.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    words(text, size).1
}

/// The text in lines no wider than `limit`, broken at spaces; a single longer word stays whole.
pub(crate) fn wrap(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if width(&format!("{line} {word}"), size) <= limit => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
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
}
