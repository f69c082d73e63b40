//! A folder for the files of one test, removed when the test ends.

use std::path::{Path, PathBuf};

/// The folder; a path inside it is made with `join`.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    /// An empty folder for the test of this name.
    pub(crate) fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("report-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl std::ops::Deref for Scratch {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Left over at worst; not a reason to fail.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
