//! Pins that the rig drives, and those at which it looks.

use stm32_metapac::gpio::Gpio;
use stm32_metapac::{DAC1, GPIOA, GPIOB, GPIOC, GPIOD, GPIOE, GPIOF};

use haptic_rig::device::levels;
use haptic_rig::order::Line;

/// Modes of a pin.
const OUTPUT: u32 = 1;
const FUNCTION: u32 = 2;
const ANALOGUE: u32 = 3;

/// Sets the mode of a pin of 0 to 15.
#[inline(always)]
fn mode(port: Gpio, pin: u32, mode: u32) {
    port.moder().modify(|w| w.0 = w.0 & !(3 << (2 * pin)) | mode << (2 * pin));
}

/// The pin is an input without a pull.
#[inline(always)]
fn input(port: Gpio, pin: u32) {
    mode(port, pin, 0);
}

/// The pin is an output at this level.
#[inline(always)]
fn output(port: Gpio, pin: u32, high: bool) {
    set(port, pin, high);
    mode(port, pin, OUTPUT);
}

/// The pin is led to this alternate function.
#[inline(always)]
fn function(port: Gpio, pin: u32, number: u32) {
    let shift = 4 * (pin % 8);
    let half = if pin < 8 { 0 } else { 1 };
    port.afr(half).modify(|w| w.0 = w.0 & !(15 << shift) | number << shift);
    mode(port, pin, FUNCTION);
}

/// The level of an output.
#[inline(always)]
fn set(port: Gpio, pin: u32, high: bool) {
    port.bsrr().write(|w| w.0 = 1 << if high { pin } else { pin + 16 });
}

#[inline(always)]
fn is_high(port: Gpio, pin: u32) -> bool {
    port.idr().read().0 & 1 << pin != 0
}

/// Everything at rest: encoders at 0, the gate shut, the stop's contact closed, no fault.
pub(crate) fn start() {
    for (port, pin) in [(GPIOC, 6), (GPIOC, 7), (GPIOC, 8), (GPIOD, 12), (GPIOD, 13), (GPIOD, 14), (GPIOD, 15)] {
        output(port, pin, false);
    }
    output(GPIOE, 15, true);
    // The board pulls this line up, and so may others pull it down.
    GPIOE.otyper().modify(|w| w.0 |= 1 << 6);
    output(GPIOE, 6, true);
    output(GPIOE, 1, false);
    // Captured by TIM2: PE9 and PE14 of the board, the fault line and the stop.
    function(GPIOA, 5, 1);
    function(GPIOB, 3, 1);
    function(GPIOB, 10, 1);
    function(GPIOB, 11, 1);
    input(GPIOF, 3);
    function(GPIOD, 8, 7);
    function(GPIOD, 9, 7);
    mode(GPIOA, 4, ANALOGUE);
    DAC1.cr().write(|w| w.set_en(0, true));
}

/// Channels of an encoder (0 or 1) as they are at this count; a wire that is off stays as it was.
#[inline(always)]
pub(crate) fn turn(joint: u8, counts: i32, on: [bool; 2]) {
    let (port, first) = if joint == 0 { (GPIOC, 6) } else { (GPIOD, 12) };
    let ([a, b], [a_on, b_on]) = (levels(counts), on);
    if a_on {
        set(port, first, a);
    }
    if b_on {
        set(port, first + 1, b);
    }
}

/// The index of the first encoder.
pub(crate) fn index(there: bool) {
    set(GPIOC, 8, there);
}

/// The output of the amplifiers' gate.
pub(crate) fn gate(passes: bool) {
    set(GPIOD, 15, passes);
}

/// Holds the board's blue button down, or lets it go.
pub(crate) fn button(down: bool) {
    set(GPIOD, 14, down);
}

/// Pulls a line that takes the motors off, or lets it go.
#[inline(always)]
pub(crate) fn pull(line: Line, pulled: bool) {
    match line {
        Line::Stop => set(GPIOE, 15, !pulled),
        Line::Fault => set(GPIOE, 6, !pulled),
    }
}

/// The yellow light is on, and so is the trigger of an oscilloscope: something is measured now.
pub(crate) fn measuring(now: bool) {
    set(GPIOE, 1, now);
}

/// The board's PE14.
pub(crate) fn timer_drives() -> bool {
    is_high(GPIOB, 10)
}

/// The board's PF3.
pub(crate) fn enabled() -> bool {
    is_high(GPIOF, 3)
}

/// The analogue output, of 4095.
pub(crate) fn volts(share: u16) {
    DAC1.dhr12r(0).write(|w| w.set_dhr(share));
}
