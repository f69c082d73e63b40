//! What others said, printed: shown, and never obeyed.
//!
//! A terminal takes some characters as orders: to clear itself, to write its title, to answer as if somebody had typed. Others turn the
//! direction of writing around, so that a line reads as another one. A board, a file or the far end of a line may send any of them.
//! [`out`] and [`say`] print them as JSON spells them, `\u001b`, which is right in a JSON document as well; [`escaped`] does so where a
//! text must be one line.

use std::borrow::Cow;
use std::fmt::{self, Display, Write as _};
use std::io::{self, IsTerminal as _};

/// Whether a terminal does more with it than to show it.
fn is_order(character: char) -> bool {
    match character {
        '\t' => false,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}' => true,
        other => other.is_control(),
    }
}

fn spelled(text: &str, keeps: fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(|character| is_order(character) && !keeps(character)) {
        return Cow::Borrowed(text);
    }
    let mut spelled = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        if is_order(character) && !keeps(character) {
            let _ = write!(spelled, "\\u{:04x}", u32::from(character));
        } else {
            spelled.push(character);
        }
    }
    Cow::Owned(spelled)
}

/// The text as one line that does nothing to a terminal.
pub fn escaped(text: &str) -> Cow<'_, str> {
    spelled(text, |_| false)
}

/// Prints on standard output; ends of lines are kept.
///
/// # Errors
/// Standard output takes no more.
pub fn out(text: fmt::Arguments<'_>) -> io::Result<()> {
    print(io::stdout(), &text.to_string())
}

/// Prints on standard error, with the end of a line; ends of lines in it are kept. Nobody is told where nobody can be.
pub fn say(text: impl Display) {
    let _ = print(io::stderr(), &format!("{text}\n"));
}

/// Black, and white paper under it, of the 256 colours that are the same in every terminal; and the end of both.
const INK_ON_PAPER: [&str; 2] = ["\u{1b}[38;5;16;48;5;231m", "\u{1b}[0m"];

/// Prints a picture of block characters on standard error, line by line: black on white where that is a terminal, whether its own colours are
/// dark or light.
pub fn draw(lines: impl IntoIterator<Item: AsRef<str>>) {
    let coloured = io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|name| name != "dumb");
    let [ink, end] = if coloured { INK_ON_PAPER } else { [""; 2] };
    let lines = lines.into_iter().map(|line| format!("{ink}{}{end}\n", escaped(line.as_ref())));
    let _ = io::Write::write_all(&mut io::stderr(), lines.collect::<String>().as_bytes());
}

fn print(mut to: impl io::Write, text: &str) -> io::Result<()> {
    to.write_all(spelled(text, |character| character == '\n').as_bytes())
}
