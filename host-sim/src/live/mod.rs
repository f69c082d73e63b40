//! Peers in real time, over real sockets: each an actor on the one loop of [`endpoint`].

mod apart;
pub mod batch;
pub mod endpoint;
pub(crate) mod hub;
mod links;
pub mod operator;
pub(crate) mod peer;
pub(crate) mod quantiles;
pub mod relay;
pub(crate) mod serve;
pub(crate) mod squash;
pub(crate) mod tell;
pub(crate) mod visit;
pub(crate) mod watch;
