//! An external clock that does not come: in place of the clock controller's model from the start until the firmware gives the oscillator
//! up. Registers keep what is written, and the oscillator is never ready; nothing else is asked of the controller in that time.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32h743::generated::rcc::Register;

/// The bit HSEON of the register CR.
const ON: u64 = 1 << 16;

/// Stands in while the clock is missing.
#[derive(Debug, Default)]
pub struct Missing {
    /// Whether it still does.
    pub wanted: bool,
    asked: bool,
}

impl Device for Missing {
    type Register = Register;
    fn write(&mut self, register: Register, value: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        if matches!(register, Register::Cr) {
            let on = value & ON != 0;
            self.wanted &= on || !self.asked;
            self.asked |= on;
        }
    }
}
