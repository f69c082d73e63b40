//! Runs against an independent oracle, and the parts that runs are made of.

mod carrying_on;
mod double_double;
mod engine;
mod faults;
mod fitted;
mod hands;
mod impulsive;
mod irtt;
mod lanes;
mod leader_follower;
mod limits;
mod link;
mod linkage;
mod measure;
mod midpoint;
mod node;
mod oracle;
mod outcome;
mod precision;
mod self_timed;
mod shared;
mod stiff;
mod tanks;
mod unlike;
mod winding;
