//! `cohold play`, a live page: two people hold one virtual object in two browser windows, in real time, over a network that is as bad
//! as they set it.
//!
//! | file | holds |
//! |---|---|
//! | [`cohold_live::hand`] | a pointer becomes a hand: spring and damper, play-out |
//! | `partner` | who holds the other hand while nobody else does |
//! | `environment` | what is stepped and drawn, whatever it is |
//! | `kinds` | which there are |
//! | `pair_columns` | what is in a sample of two peers, along one axis or several |
//! | `session` | the two peers, their devices and hands, and the network, tick by tick |
//! | `remote` | one peer, whose partner is on another machine |
//! | `shared_environment` | a shared environment of another guest ([`cohold_live::playable`]) |
//! | `three_laws` | three laws under the same pushes and packets, on a bad network |
//! | `story` | two simulated hands on one object, in a scene that tells something |
//! | `moving_picture` | that story as a file that moves by itself |
//! | `boards`, `boards_line` | boards as their operator has them, and what a page may say to them |
//! | `orders` | what a page may ask to be set, and what scene that gives |
//! | `opened`, `opened_page` | a recording as a page shows it, and its page |
//! | `judge` | whether that scene is stable, and what to change if not |
//! | `mailbox` | what lies between the control loop, the judge and the windows |
//! | `control_loop` | 1 kHz by the clock |
//! | `roles`, `connections` | who may do what, and how many are let in |
//! | `messages` | what a window says, read |
//! | `doors`, `qr` | this machine, and a local network where that is asked for, with a code to scan |
//! | `web` | the page's files, and a WebSocket for each window |
//! | `page` | all of that together |
//!
//! **Threads.** The control loop has one, the judge one, each window one. The control loop waits for nobody: it only
//! tries the mailbox's lock, and what it could not lay down now it lays down a tick later. A window is sent what it
//! asks for and nothing else, so one that sleeps or does not read costs a thread that waits, and no tick.

#![forbid(unsafe_code)]

mod boards;
mod boards_line;
mod command;
mod connections;
mod control_loop;
mod doors;
mod environment;
mod judge;
mod kinds;
mod line_words;
mod mailbox;
mod messages;
mod moving_picture;
mod opened;
mod opened_page;
mod orders;
mod page;
mod pair_columns;
mod partner;
mod qr;
mod remote;
mod roles;
mod session;
mod shared_environment;
mod story;
mod three_laws;
mod web;

use boards::{Boards, Place};
use cohold_cli::{Cli, Ui, columns::TableKind};
use command::PageCommands;
use control_loop::channels;
use judge::HAND;
use kinds::{EnvironmentKind, Kinds};
use moving_picture::moving_picture;
use opened::Opened;
use opened_page::OpenedPage;
use page::{At, Page, Shown};
use partner::Model;
use remote::End;
use roles::Role;

/// Adds the page to a command line.
pub fn join(cli: Cli) -> Cli {
    cli.with_commands::<PageCommands>("").with_tables(tables)
}

/// What the page records.
fn tables(ui: &Ui) -> Vec<TableKind> {
    channels(Kinds(ui.environments), "/both/ticks").into_iter().map(|channel| TableKind::of("play", channel)).collect()
}

#[cfg(test)]
#[path = "../tests/inside/measure.rs"]
mod measure;

#[cfg(any(test, fuzzing))]
#[path = "../fuzz/src/page.rs"]
#[allow(unreachable_pub)] // The fuzzer reaches it.
mod fuzz;
#[cfg(fuzzing)]
pub use fuzz::run as page_hears;
