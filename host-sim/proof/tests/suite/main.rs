//! Forces stay within their limits, whatever comes in: of every law, not of a planted fault, and by ranges that hold what numbers do.

mod laws;
mod planted;
mod ranges;
