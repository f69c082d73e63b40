//! Writing files, and what can go wrong with it.

use std::path::{Path, PathBuf};

/// A report file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {} as {format}: {cause}", path.display())]
pub struct ReportError {
    /// The file.
    pub path: PathBuf,
    /// What it was to contain: `CSV`, `Parquet`, `SVG`, `PNG` or `TOML`.
    pub format: &'static str,
    /// What the operating system or the encoder said.
    pub cause: String,
}

impl ReportError {
    /// What a failed write of `path` as `format` becomes, for `map_err`.
    pub fn write<E: std::fmt::Display>(path: &Path, format: &'static str) -> impl Fn(E) -> Self + use<E> {
        let path = path.to_owned();
        move |cause| Self { path: path.clone(), format, cause: cause.to_string() }
    }
}

/// Writes a file, its folder made if needed.
///
/// # Errors
/// What the operating system says.
pub fn write_file(path: &Path, format: &'static str, bytes: &[u8]) -> Result<(), ReportError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, bytes));
    written.map_err(ReportError::write(path, format))
}
