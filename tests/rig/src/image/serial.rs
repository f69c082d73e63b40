//! The serial port to the PC, through the ST-LINK: USART3, 115200 baud.

use cortex_m::peripheral::NVIC;
use stm32_metapac::{Interrupt, USART3};

use cohold_rig::order::Text;

/// 120 MHz / 1042 = 115 163 baud, 0.03 % off.
const DIVIDER: u16 = 1042;
/// In ISR: a byte is there, there is room for one, bytes were lost.
const RECEIVED: u32 = 1 << 5;
const ROOM: u32 = 1 << 7;
/// In CR1: on, receiver, transmitter, and what wakes.
const ON: u32 = 1 | 1 << 2 | 1 << 3 | RECEIVED;
/// In ICR: all that can go wrong with a byte.
const ERRORS: u32 = 0xF;

/// Turns it on.
pub(crate) fn start() {
    USART3.brr().write(|w| w.set_brr(DIVIDER));
    USART3.cr1().write(|w| w.0 = ON);
    // SAFETY: interrupts are masked: these wake, and are never taken.
    unsafe {
        NVIC::unmask(Interrupt::USART3);
        NVIC::unmask(Interrupt::TIM7);
    }
}

/// The two sides of the line.
#[derive(Default)]
pub(crate) struct Serial {
    line: Text,
    answer: Text,
    sent: usize,
}

impl Serial {
    /// The line that has come in, if its end has.
    pub(crate) fn receive(&mut self) -> Option<Text> {
        if USART3.isr().read().0 & RECEIVED == 0 {
            return None;
        }
        USART3.icr().write(|w| w.0 = ERRORS);
        match USART3.rdr().read().0 as u8 {
            b'\n' => Some(core::mem::take(&mut self.line)),
            b'\r' => None,
            byte => {
                self.line.push(byte);
                None
            }
        }
    }

    /// Answers with this line; what was not sent yet of the one before is lost.
    pub(crate) fn answer(&mut self, mut text: Text) {
        text.push(b'\n');
        (self.answer, self.sent) = (text, 0);
        USART3.cr1().write(|w| w.0 = ON | ROOM);
    }

    /// Sends the next byte, if there is one and room for it.
    pub(crate) fn send(&mut self) {
        let Some(byte) = self.answer.bytes().get(self.sent) else {
            return;
        };
        if USART3.isr().read().0 & ROOM != 0 {
            USART3.tdr().write(|w| w.0 = u32::from(*byte));
            self.sent += 1;
            if self.sent == self.answer.bytes().len() {
                USART3.cr1().write(|w| w.0 = ON);
            }
        }
    }
}
