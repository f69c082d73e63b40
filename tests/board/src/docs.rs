//! Tables of the documentation that tests write: `COHOLD_BLESS=1` writes one, otherwise it must be there.

use std::path::Path;

/// Puts a table where a page of docs/ has the marks of `test` (a file of tests/boards).
///
/// # Panics
/// The page has no such marks, or another table.
pub fn table(page: &str, test: &str, head: &str, rows: &[String]) {
    let begin = format!("<!-- {test}: written by tests/board/tests/boards/{test}.rs -->\n");
    let end = format!("<!-- end of {test} -->");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(page);
    let text = std::fs::read_to_string(&path).expect(page);
    let (before, rest) = text.split_once(&begin).unwrap_or_else(|| panic!("docs/{page} has no {begin}"));
    let (_, after) = rest.split_once(&end).unwrap_or_else(|| panic!("docs/{page} has no {end}"));
    let line = "|---".repeat(head.matches('|').count() - 1);
    let table = format!("{head}\n{line}|\n{}\n", rows.join("\n"));
    let new = format!("{before}{begin}{table}{end}{after}");
    if std::env::var_os("COHOLD_BLESS").is_some() {
        std::fs::write(&path, new).expect(page);
    } else {
        assert!(text == new, "the table of docs/{page} is not this one; COHOLD_BLESS=1 writes it:\n{table}");
    }
}
