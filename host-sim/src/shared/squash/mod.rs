//! Force Feedback Multi-player Squash, played by bots (Buttolo et al. 1997, §3.2.1; `haptic_protocol::roles::squash`).
//!
//! | module | holds |
//! |---|---|
//! | [`bot`] | a player's hand and head: reaction time, noise, a force-limited arm |
//! | [`contestant`] | the bot at its role, simulated or live |
//! | [`world`] | players, server, clocks, network: one game from one seed |
//! | [`referee`] | what is true: where the ball was, who knew when, what everybody thinks that the rallies came to |
//! | [`sweep`] | games over round trips, with and without the bounders |
//! | [`picture`] | a game as figures |

pub mod bot;
pub mod contestant;
mod game;
pub mod picture;
pub mod referee;
pub mod sweep;
pub mod world;

pub use game::{Change, Game, Moment, Options};
pub use referee::Report;
pub use world::play;
