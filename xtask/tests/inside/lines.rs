//! Tests of `src/lines.rs` from inside.

use super::*;
use std::fs;

const PACKED: &str = "use std::fmt;pub struct Point{pub x:f64,pub y:f64}
impl Point{pub fn sum(&self)->f64{let a=self.x;let b=self.y;a+b}}
";
/// The same, spread, with comments and blank lines.
const WIDE: &str = "//! A file.

use std::fmt;

/* Two
   lines */
/// A point.
pub struct Point {
    pub x: f64,

    // Up.
    pub y: f64,
}

impl Point {
    pub fn sum(
        &self,
    ) -> f64 {
        let a = self.x;


        let b =
            self.y;
        a + b
    }
}
";

/// Writes files into a folder of this test below the target folder, and counts them.
fn counted(test: &str, files: &[(&str, &str)]) -> Result<BTreeMap<String, usize>, Failure> {
    let folder = crate::board::target().join("lines").join(test);
    fs::create_dir_all(&folder).expect("a folder");
    for (name, text) in files {
        fs::write(folder.join(name), text).expect("a file");
    }
    of_files(&folder, &files.iter().map(|(name, _)| *name).collect::<Vec<_>>())
}

#[test]
fn packed_and_wide_count_the_same_and_comments_nothing() {
    let lines = counted("same", &[("packed.rs", PACKED), ("wide.rs", WIDE), ("empty.rs", "// Nothing.\n\n")])
        .expect("good files");
    assert_eq!((lines["packed.rs"], lines["wide.rs"], lines["empty.rs"]), (12, 12, 0));
}

#[test]
fn a_file_that_does_not_parse_is_named() {
    let wrong =
        counted("wrong", &[("good.rs", PACKED), ("bad.rs", "fn bad( {\n")]).expect_err("it does not parse").to_string();
    assert!(wrong.contains("lines of bad.rs") && wrong.contains("bad.rs:1:"), "{wrong}");
}
