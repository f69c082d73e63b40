//! The stability analysis against everything it must agree with: THEORY's numbers, an independent oracle, the simulator, and what is
//! claimed of the implicit decode. A second construction is in `tests/oracle`.

mod advice;
mod answers;
mod backward_euler;
mod bounds;
mod curve;
mod driven;
mod finding;
mod hard_cases;
mod held_back;
mod kinds;
mod midpoint;
mod modes;
mod oracle;
mod published;
mod random;
mod reached;
mod self_timed;
mod several;
mod sweeps;
mod theory;
mod verdicts;
mod winding;

use cohold_analysis::figure4;
