//! Hard cases: where numbers get extreme, gains sit on an edge, or something should cancel exactly. Each test says why it is
//! here; each prints what it measured (`cargo test -p host-sim --test hard_cases -- --nocapture`).

mod boundary;
mod extremes;
mod setup;
