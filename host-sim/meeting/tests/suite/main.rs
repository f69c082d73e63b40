//! Two homes without a socket: frames, invites, the agreement, the meeting place, and carriers behind routers in virtual time.

mod agreement;
mod attacks;
mod bridge;
mod carrier;
mod frame;
mod invite;
mod mapping;
mod place;
mod vectors;
mod world;
