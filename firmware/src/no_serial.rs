//! No serial port: an image that talks by Ethernet has its log.

use embassy_executor::Spawner;

use crate::{board::cable::Serial, console::Console};

/// Begins nothing.
pub(crate) fn start(_: Serial, _: &Spawner) {}

/// Says nothing.
pub(crate) fn say(_: &str) {}

/// Tells nothing.
pub(crate) struct Teller;

impl Teller {
    pub(crate) fn new() -> Self {
        Self
    }

    pub(crate) fn look(&mut self, _: &Console) {}
}
