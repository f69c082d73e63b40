//! Two copies that a law holds together, hands and packets prescribed: each law's own promise, and numbers of the paper it comes from.

mod four_channel;
mod p_plus_d;
