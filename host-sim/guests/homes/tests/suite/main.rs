//! Two homes: frames, invites, the agreement, the meeting place, carriers behind routers in virtual time; and over sockets on loopback.

mod agreement;
mod asking;
mod attacks;
mod beside;
mod bridge;
mod carrier;
mod frame;
mod fuzz;
mod homes_world;
mod invitation;
mod invite;
mod mapping;
mod place;
mod two_homes;
mod vectors;
mod world;
