//! Folders for what is written.

use std::path::Path;

use crate::ReportError;

/// Makes sure that the folder of `path` exists.
pub fn create_folder(path: &Path, format: &'static str) -> Result<(), ReportError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(ReportError::write(path, format))
}
