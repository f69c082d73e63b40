//! The window watchdog (RM0433 §44): once started it counts the bus's clock down, and resets the chip when bit 6 of the count
//! falls, or when it is wound up while the count is above the window.
//!
//! Not modelled: the interrupt before the end, and a bus clock that changes meanwhile (RM0433 §8: PCLK3 of this image stays).

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::wwdg::Register;
use rigless::time::{EventId, VirtualNanos};

/// PCLK3 of the image, Hz.
const CLOCK_HZ: u64 = 120_000_000;
const RUNNING: u64 = 1 << 7;
/// The bit that must not fall.
const ALIVE: u64 = 1 << 6;

/// Model of the window watchdog.
#[derive(Debug, Default)]
pub struct Wwdg {
    /// When it was wound up last, ns, and to which count; `None` until it is started.
    wound: Option<(u64, u64)>,
    due: Option<EventId>,
}

impl Wwdg {
    /// Nanoseconds of so many counts, rounded up.
    fn ns(f: &RegisterFile, counts: u64) -> u64 {
        let prescaler = f.get(Register::Cfr) >> 11 & 7;
        (counts * (4096 << prescaler) * 1_000_000_000).div_ceil(CLOCK_HZ)
    }
}

impl Device for Wwdg {
    type Register = Register;
    fn write(&mut self, register: Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        // Started, it runs until the reset whatever is written.
        if !matches!(register, Register::Cr) || (self.wound.is_none() && value & RUNNING == 0) {
            return;
        }
        let now = c.now().0;
        if let Some((at, count)) = self.wound {
            let window = f.get(Register::Cfr) & 0x7F;
            let early = count > window && now < at + Self::ns(f, count - window);
            if early || value & ALIVE == 0 {
                c.request_reset();
            }
        }
        let count = value & 0x7F;
        self.wound = Some((now, count));
        self.due = Some(c.schedule(VirtualNanos(now + Self::ns(f, (count & !ALIVE) + 1))));
    }
    fn on_event(&mut self, event: EventId, _: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.due == Some(event) {
            c.request_reset();
        }
    }
    fn reset(&mut self) {
        *self = Self::default();
    }
}
