//! Texts for people, within the width of their terminal: what a list of named things says of each, one below the other.

use super::Ui;

/// Width where there is no terminal, and at the most: longer lines are hard to read.
const WIDTH: usize = 100;
/// Narrower than this no text is set.
const LEAST: usize = 40;

/// One thing of a list: its name with what is short of it, and sentences below.
pub(super) struct Item {
    pub(super) head: String,
    pub(super) body: Vec<String>,
}

/// Prints the things, each with its sentences indented.
pub(super) fn list(ui: &Ui, items: &[Item]) {
    let width = terminal_size::terminal_size().map_or(WIDTH, |(width, _)| usize::from(width.0)).clamp(LEAST, WIDTH);
    for Item { head, body } in items {
        writeln!(ui, "{head}");
        body.iter().filter(|text| !text.is_empty()).for_each(|text| writeln!(ui, "{}", wrapped(text, width, 4)));
    }
}

/// A text in lines of this width at the most, where its words let it, each indented.
fn wrapped(text: &str, width: usize, indent: usize) -> String {
    let margin = " ".repeat(indent);
    let mut lines = vec![margin.clone()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > indent && line + 1 + word.chars().count() > width {
            lines.push(margin.clone());
        }
        if let Some(line) = lines.last_mut() {
            if line.len() > indent {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

#[cfg(test)]
#[path = "../tests/inside/listing.rs"]
mod tests;
