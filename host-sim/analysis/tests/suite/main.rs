//! The stability analysis against everything it must agree with: THEORY's numbers, an independent oracle, a second
//! construction, the simulator, and what is claimed of the implicit decode.

mod advice;
mod agreement;
mod answers;
mod backward_euler;
mod bounds;
mod envelope;
mod finding;
mod hard_cases;
mod held_back;
mod midpoint;
mod modes;
mod oracle;
mod published;
mod random;
mod self_timed;
mod several;
mod sweeps;
mod theory;
mod winding;
