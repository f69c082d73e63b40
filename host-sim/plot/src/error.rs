//! Why there is no figure.

use std::path::{Path, PathBuf};

/// What the operating system, an encoder or a painter said.
pub(crate) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a figure was not drawn, or a file not written: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A painter could not draw, and what it said.
    #[error(transparent)]
    Painter(#[from] Cause),
    /// A file could not be written.
    #[error("cannot write {} as {format}: {cause}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Format of the file: `CSV`, `Parquet`, `SVG`, `PNG` or `TOML`.
        format: &'static str,
        /// What the operating system or the encoder said.
        cause: Cause,
    },
}

impl Error {
    /// What a failed write of `path` as `format` becomes, for `map_err`.
    pub fn write<E: Into<Cause>>(path: &Path, format: &'static str) -> impl Fn(E) -> Self + use<E> {
        let path = path.to_owned();
        move |cause| Self::File { path: path.clone(), format, cause: cause.into() }
    }
}
