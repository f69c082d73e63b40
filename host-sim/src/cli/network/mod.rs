//! `host-sim network`: bad networks, and peers that are tried on them.

mod flood;
mod relay;
mod restarts;
mod trace;

super::commands! {
    /// What a network does, and what is done over it.
    Network {
        /// A bad network between two live peers.
        Relay(relay::Relay),
        /// Write down what a scene's network does to every packet.
        Trace(trace::Trace),
        /// Forged datagrams by the hundred thousand against two peers on loopback: what they change, and what comes through.
        Flood(flood::Flood),
        /// Peers that restart at random instants, in virtual time: how soon and how gently they are together again.
        Restarts(restarts::Restarts),
    }
}
