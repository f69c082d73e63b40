//! `host-sim board`: a PC beside a board.

mod calibrate;
mod operator;
mod record;

super::commands! {
    /// What is done with a board.
    Board {
        /// Say lines to a board: arm, stop, set up; sealed.
        Operator(operator::Operate),
        /// What a board's encoders and motors are, found together with the person at it; leaves a settings file.
        Calibrate(calibrate::Calibrate),
        /// What one peer of a scene reads, for the same peer on another processor.
        Record(record::Record),
    }
}
