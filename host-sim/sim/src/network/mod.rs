//! The simulated network between peers: the fate of each packet, drawn or from any [`rule`] or a recorded [`trace`],
//! and the packets that are under way in each direction ([`link`]).

pub mod clocks;
pub mod fitted;
mod irtt;
pub mod link;
mod measured;
mod ping;
pub mod rule;
pub mod trace;
