//! Tables and files.
mod error;
pub mod files;
pub mod table;
pub mod text;
pub use error::ReportError;
