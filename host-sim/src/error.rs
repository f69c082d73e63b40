//! Why a face says no.

/// Why a command, a page or a trial did not do what was asked: whatever a package below says, or a sentence. One line.
pub type Error = Box<dyn std::error::Error + Send + Sync>;
