//! The independent watchdog (RM0433 §45): once started it counts down on its own 32 kHz, and resets the chip at zero.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::iwdg::Register;
use rigless::time::{EventId, VirtualNanos};

/// Nominal frequency of the oscillator behind it, Hz.
const LSI_HZ: u64 = 32_000;

/// Model of the independent watchdog.
#[derive(Debug, Default)]
pub struct Iwdg {
    running: bool,
    due: Option<EventId>,
}

impl Iwdg {
    fn reload(&mut self, f: &RegisterFile, c: &mut DeviceContext<'_>) {
        let counts = (f.get(Register::Rlr) & 0xFFF) + 1;
        let divider = 4 << (f.get(Register::Pr) & 7).min(6);
        self.due = Some(c.schedule(VirtualNanos(c.now().0 + counts * divider * 1_000_000_000 / LSI_HZ)));
    }
}

impl Device for Iwdg {
    type Register = Register;
    fn write(&mut self, register: Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        match (register, value) {
            (Register::Kr, 0xCCCC) => {
                self.running = true;
                self.reload(f, c);
            }
            (Register::Kr, 0xAAAA) | (Register::Rlr | Register::Pr, _) if self.running => self.reload(f, c),
            _ => {}
        }
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
