//! Letters: the built-in font, how wide a text is, and where its lines break.
//!
//! Ubuntu Light from `epaint_default_fonts`, so that no figure depends on the fonts of the machine. It has Latin, Greek and common signs
//! (− × ± ≤ ≥ ≈ ² ° µ Ω …) but no arrows; what it lacks is drawn as an empty box. A text may hold an index (`K_T`) and a power (`10^−3`).

use std::sync::Once;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

use super::sheet::LEAST;

/// The name under which the font is registered with plotters.
pub(crate) const NAME: &str = "report";
/// (Ascender − descender) / em of this font: plotters sizes letters by the former, the sheet by the latter.
pub(crate) const LINE_PER_EM: f64 = 1.121;

/// Em at which widths are measured, in whole pixels.
const MEASURE: f64 = 500.0;
/// Em of an index or a power, of that of its base.
const SMALL: f64 = 0.75;
/// Between words, in ems.
const SPACE: f64 = 0.3;

/// A space at which no line is broken.
const NO_BREAK: char = '\u{a0}';

/// The font at an em of `size` pixels.
pub(crate) fn font(size: f64) -> FontDesc<'static> {
    static REGISTERED: Once = Once::new();
    // The bytes are part of the program and one test draws letters with them: this cannot fail in use.
    REGISTERED.call_once(|| drop(register_font(NAME, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)));
    FontDesc::new(FontFamily::Name(NAME), size * LINE_PER_EM, FontStyle::Normal)
}

/// The line of writing: base, subscript or superscript.
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
    /// Size of the letters (em), pixels.
    pub(crate) size: f64,
}

/// The words of a text at an em of `size`, and how wide it is. Words stand apart by a fixed space: the font's own pairs
/// of a letter and a space are too tight to read.
pub(crate) fn words(text: &str, size: f64) -> (Vec<Word>, f64) {
    let mut words = Vec::new();
    let mut x = 0.0;
    for (level, run) in runs(text) {
        // Height above the base line, in ems of the base letters; indices and powers are smaller than these, as far as they can be read.
        let rise = match level {
            Level::Base => 0.0,
            Level::Below => -0.17,
            Level::Above => 0.38,
        };
        let small = if level == Level::Base { size } else { (SMALL * size).max(LEAST.min(size)) };
        for (i, text) in run.split([' ', NO_BREAK]).enumerate() {
            x += if i > 0 { SPACE * size } else { 0.0 };
            let guess = 0.5 * MEASURE * text.chars().count() as f64;
            let measured = font(MEASURE).box_size(text).map_or(guess, |(width, _)| f64::from(width));
            let width = measured / MEASURE * small;
            if !text.is_empty() {
                words.push(Word { text: text.to_owned(), x, width, rise: rise * size, size: small });
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

/// The text in lines no wider than `limit`, broken at spaces that may be broken; a single longer word stays whole.
pub(crate) fn wrap(text: &str, size: f64, limit: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let words = text.split(|letter: char| letter.is_whitespace() && letter != NO_BREAK);
    for word in words.filter(|word| !word.is_empty()) {
        // A word that fits on no line may be broken after a hyphen.
        let parts: Vec<&str> = if width(word, size) > limit { word.split_inclusive('-').collect() } else { vec![word] };
        for (at, part) in parts.into_iter().enumerate() {
            let space = if at == 0 { " " } else { "" };
            match lines.last_mut() {
                Some(line) if width(&format!("{line}{space}{part}"), size) <= limit => {
                    line.push_str(space);
                    line.push_str(part);
                }
                _ => lines.push(part.to_owned()),
            }
        }
    }
    lines
}

#[cfg(test)]
#[path = "../tests/inside/font.rs"]
mod tests;
