//! The wire between two haptic peers: sealed, versioned, sans-IO.
//!
//! What arrives over a network here becomes force on a human hand. So every datagram is authenticated and encrypted, every
//! message is taken once, and the coordination acts only as far as the other peer is known to be there. Bytes and `now` (µs)
//! come in, bytes and messages go out; sockets, clocks and random numbers are the caller's. There is no way to send
//! anything in the open.
//!
//! Where to begin: [`link::Link`], one peer's end of the wire, is the only thing a firmware needs; [`lines`] is an operator's port on
//! it; [`wire`] has the layouts, which `FORMAT.md` says for other languages, and [`bytes`] what they are declared with.
//!
//! **Contract**: no function here panics, whatever bytes, times or numbers it is given, and none touches a byte outside
//! the slice it is given. Nothing allocates; a link is one value of fixed size. An error is one sentence about what was
//! wrong and never a reason to stop.
//!
//! **Limits**: whoever holds the shared key can pretend to be either end from then on, and read nothing of what was recorded before. An
//! enemy on the path can drop datagrams, which fades the coordination, and delay them, within what [`link::Link::within`] allows, and
//! cannot do more. Addresses prove nothing and are the caller's: send to the configured one, not to whoever wrote last.
//!
//! # Two links, one wire
//!
//! What a task on a board does each packet period, here with both peers in one loop:
//!
//! ```
//! use cohold_protocol::ends::Ends;
//! use cohold_protocol::link::{Config, Link, Notice, Stage};
//! use cohold_protocol::wire::{AxisFlow, Event, Flow, MAX_DATAGRAM, Message, PeerId};
//! use cohold_protocol::{key::Key, parameters::Parameters, parameters::Table};
//!
//! fn link(local: u8, remote: u8) -> Link {
//!     let mut parameters = Parameters::new();
//!     parameters.add(Table::new("coordination").text("comm", "passive-wave").number("stiffness_n_per_m", 1e4)).unwrap();
//!     Link::new(Config {
//!         key: Key::new([7; 32]), // from a key file, the same for both
//!         ends: Ends { local: PeerId(local), remote: PeerId(remote) },
//!         packet_period_us: 8_000,
//!         parameters,           // the settings that both must share
//!         entropy: [local; 32], // from the random number generator, at every start
//!     })
//!     .unwrap()
//! }
//!
//! /// One packet period of one peer: what came goes in, what it wants to say comes out.
//! fn period(link: &mut Link, now: u64, came: Vec<Vec<u8>>, flow: Flow) -> (Vec<Vec<u8>>, Option<Flow>) {
//!     let (mut out, mut say, mut newest) = ([0; MAX_DATAGRAM], Vec::new(), None);
//!     for mut datagram in came {
//!         // A refused datagram is only worth a line in a log.
//!         if let Ok(Some(Message::Flow(flow))) = link.receive(now, &mut datagram) {
//!             newest = Some(flow);
//!         }
//!     }
//!     let mut due = link.send(now, flow, &mut out);
//!     while let Some(len) = due.or_else(|| link.poll(now, &mut out)) {
//!         say.push(out[..len].to_vec());
//!         due = None;
//!     }
//!     (say, newest)
//! }
//!
//! let (mut one, mut two) = (link(1, 2), link(2, 1));
//! one.push_event(Event::new(42, b"take it").unwrap()).unwrap();
//! let (mut to_one, mut seen) = (Vec::new(), None);
//! for tick in (0..400).step_by(8) {
//!     let now = u64::from(tick) * 1_000;
//!     let axes = [AxisFlow { position: 0.01, ..AxisFlow::default() }];
//!     let flow = Flow { engaged: one.stage() == Stage::Running, tick, axes, ..Flow::default() };
//!     let (to_two, _) = period(&mut one, now, to_one, flow);
//!     let (said, newest) = period(&mut two, now, to_two, Flow::default());
//!     to_one = said;
//!     seen = newest.or(seen);
//! }
//! assert_eq!((one.stage(), two.stage()), (Stage::Running, Stage::Running));
//! assert_eq!(seen.map(|flow| (flow.tick, flow.axes[0].position)), Some((392, 0.01)));
//! assert_eq!(two.take_event().map(|event| event.payload().to_vec()), Some(b"take it".to_vec()));
//! assert_eq!(two.take_event(), None);
//! assert_eq!(one.take_notice(), Some(Notice::NewPeer(0)));
//! ```
//!
//! In an Embassy task the same calls stand around a `select` of socket and ticker: `firmware/src/flow.rs`. Poll a `send_to` once and
//! drop it when it is not ready: flow that has to wait is flow that is late.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::unreachable)
)]

pub mod aged;
pub mod bytes;
pub mod cipher;
pub mod clock;
#[cfg(feature = "peer")]
pub mod end;
pub mod ends;
mod engagement;
mod error;
mod handshake;
pub mod key;
pub mod lease;
pub mod lines;
pub mod link;
pub mod notices;
pub mod parameters;
pub mod path;
#[cfg(feature = "peer")]
pub mod peer;
#[cfg(feature = "peer")]
pub mod record;
mod reliable;
pub mod replay;
mod session;
pub mod wire;

#[cfg(test)]
#[path = "../tests/inside/mod.rs"]
mod inside;
