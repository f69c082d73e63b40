//! What the emulator met and did not model, against the reviewed list `reviewed.txt`: a test must not pass because of it.
//!
//! A line of the list is what [`crate::node::Report`] says, two spaces or more, and why it does no harm. A `*` at the end
//! of the first part stands for any rest. What is met and not on the list fails; what is on the list need not be met.

use crate::node::Report;

const LIST: &str = include_str!("../reviewed.txt");

/// Patterns of the list, each with its reason.
fn list() -> impl Iterator<Item = (&'static str, &'static str)> {
    LIST.lines().filter(|line| !line.starts_with('#') && !line.trim().is_empty()).map(|line| {
        let (what, why) = line.split_once("  ").unwrap_or_else(|| panic!("reviewed.txt: no reason in {line:?}"));
        (what.trim(), why.trim())
    })
}

fn covers(pattern: &str, line: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == line, |start| line.starts_with(start))
}

/// Lines of a report that nobody has looked at.
pub fn unreviewed(report: &Report) -> Vec<&str> {
    report.lines.iter().map(String::as_str).filter(|line| !list().any(|(what, _)| covers(what, line))).collect()
}

/// Fails on what nobody has looked at.
///
/// # Panics
/// There is such a thing: give it a line in reviewed.txt with the reason why it does no harm, or model it.
pub fn check(report: &Report) {
    let unreviewed = unreviewed(report);
    assert!(unreviewed.is_empty(), "not modelled, and not in tests/board/reviewed.txt:\n{}", unreviewed.join("\n"));
}

/// [`check`] of boards that were never reset.
///
/// # Panics
/// As [`check`]; or one was reset.
pub fn check_all(reports: &[Report]) {
    for report in reports {
        assert_eq!(report.resets, Vec::<String>::new());
        check(report);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_has_a_reason_and_the_list_covers_only_what_it_names() {
        assert!(list().all(|(what, why)| !what.is_empty() && why.len() > 10));
        assert!(covers("told Told*", "told Told { x }") && !covers("unmapped 0x1", "unmapped 0x12"));
    }
}
