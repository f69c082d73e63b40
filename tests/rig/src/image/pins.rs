//! Pins that the rig drives, and those at which it looks.

use stm32_metapac::gpio::Gpio;
use stm32_metapac::{DAC1, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF};

use cohold_rig::device::levels;
use cohold_rig::order::Line;

/// A pin, 0 to 15 of its port.
pub(crate) type Pin = (Gpio, u32);
/// The index of the first encoder, the output of the amplifiers' gate, and the board's blue button.
pub(crate) const INDEX: Pin = (GPIOC, 8);
pub(crate) const GATE: Pin = (GPIOD, 15);
pub(crate) const BUTTON: Pin = (GPIOD, 14);
/// The yellow light, and so the trigger of an oscilloscope: something is measured now.
pub(crate) const LIGHT: Pin = (GPIOE, 1);
/// The board's PE14 and PF3.
pub(crate) const TIMER: Pin = (GPIOB, 10);
pub(crate) const ENABLE: Pin = (GPIOF, 3);
/// Lines that take the motors off: both are low while they do.
const STOP: Pin = (GPIOE, 15);
const FAULT: Pin = (GPIOE, 6);

/// Modes of a pin.
const INPUT: u32 = 0;
const OUTPUT: u32 = 1;
const FUNCTION: u32 = 2;
const ANALOGUE: u32 = 3;

/// Sets the mode of a pin.
#[inline(always)]
fn mode((port, pin): Pin, mode: u32) {
    port.moder().modify(|w| w.0 = w.0 & !(3 << (2 * pin)) | mode << (2 * pin));
}

/// The pin is an output at this level.
#[inline(always)]
fn output(pin: Pin, high: bool) {
    set(pin, high);
    mode(pin, OUTPUT);
}

/// The pin is led to this alternate function.
#[inline(always)]
fn function((port, pin): Pin, number: u32) {
    let shift = 4 * (pin % 8);
    let half = if pin < 8 { 0 } else { 1 };
    port.afr(half).modify(|w| w.0 = w.0 & !(15 << shift) | number << shift);
    mode((port, pin), FUNCTION);
}

/// The level of an output.
#[inline(always)]
pub(crate) fn set((port, pin): Pin, high: bool) {
    port.bsrr().write(|w| w.0 = 1 << if high { pin } else { pin + 16 });
}

#[inline(always)]
pub(crate) fn is_high((port, pin): Pin) -> bool {
    port.idr().read().0 & 1 << pin != 0
}

/// Everything at rest: encoders at 0, the gate shut, the stop's contact closed, no fault.
pub(crate) fn start() {
    for pin in [(GPIOC, 6), (GPIOC, 7), INDEX, (GPIOD, 12), (GPIOD, 13), BUTTON, GATE, LIGHT] {
        output(pin, false);
    }
    output(STOP, true);
    // The board pulls this line up, and so may others pull it down.
    GPIOE.otyper().modify(|w| w.0 |= 1 << 6);
    output(FAULT, true);
    // Captured by TIM2: PE9 and PE14 of the board, the fault line and the stop.
    for captured in [(GPIOA, 5), (GPIOB, 3), TIMER, (GPIOB, 11)] {
        function(captured, 1);
    }
    mode(ENABLE, INPUT);
    function((GPIOD, 8), 7);
    function((GPIOD, 9), 7);
    mode((GPIOA, 4), ANALOGUE);
    DAC1.cr().write(|w| w.set_en(0, true));
}

/// Channels of an encoder (0 or 1) as they are at this count; a wire that is off stays as it was.
#[inline(always)]
pub(crate) fn turn(joint: usize, counts: i32, on: [bool; 2]) {
    let (port, first) = if joint == 0 { (GPIOC, 6) } else { (GPIOD, 12) };
    let ([a, b], [a_on, b_on]) = (levels(counts), on);
    if a_on {
        set((port, first), a);
    }
    if b_on {
        set((port, first + 1), b);
    }
}

/// Pulls a line that takes the motors off, or lets it go.
#[inline(always)]
pub(crate) fn pull(line: Line, pulled: bool) {
    match line {
        Line::Stop => set(STOP, !pulled),
        Line::Fault => set(FAULT, !pulled),
    }
}

/// The analogue output, of 4095.
pub(crate) fn volts(share: u16) {
    DAC1.dhr12r(0).write(|w| w.set_dhr(share));
}
