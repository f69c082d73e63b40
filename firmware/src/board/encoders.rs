//! Two quadrature encoders, or three (feature `three-axes`), on 16-bit counters: every edge counts, and the counter wraps; the peer takes care of that.
//!
//! The input filter takes an edge only when 8 samples at a quarter of the timer's clock agree (0.13 µs): what the bridges' edges
//! put on the wires is shorter, and a level of the fastest encoder allowed, 3 MHz of edges, lasts five times as long.
//!
//! No pull inside the chip is on: with one, a pin that bears 5 V does not bear them (its data sheet, "I/O structure"). What open
//! collectors and cut wires need is on the wiring (docs/guides/board/assembly.md).
//!
//! Beside counting, channels 1 and 2 capture at rising edges of A and B, which leaves a flag at the first and another one at the next:
//! a wire that is cut shows none. Channel 3 captures the counter at a rising edge of the index, in hardware: this timer has no index
//! of its own in encoder mode (RM0433 §39.3.22).

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::safety::Fault;
use cohold_core::settings::{Refused, Settings};
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::pac::timer::{TimGp16, regs, vals};
#[cfg(feature = "three-axes")]
use embassy_stm32::peripherals::{PA5, PB3, PB10, TIM2};
use embassy_stm32::peripherals::{PC6, PC7, PC8, PD12, PD13, PD14, TIM3, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::{Peri, pac};
use firmware_parts::image::JOINTS;
use firmware_parts::signals::Signals;

/// An encoder's timer, and its pins: A, B, index.
type Encoder<T, A, B, I> = (Peri<'static, T>, Peri<'static, A>, Peri<'static, B>, Peri<'static, I>);

/// Each encoder's.
pub(crate) struct Pins {
    pub(crate) one: Encoder<TIM3, PC6, PC7, PC8>,
    pub(crate) two: Encoder<TIM4, PD12, PD13, PD14>,
    #[cfg(feature = "three-axes")]
    pub(crate) three: Encoder<TIM2, PA5, PB3, PB10>,
}

/// Starts an encoder's counter, at 0; its index is at this alternate function.
macro_rules! start {
    ($pins:expr, $number:literal, $function:literal) => {{
        let (timer, a, b, index) = $pins;
        let config = Config { ch1_pull: Pull::None, ch2_pull: Pull::None, ..Config::default() };
        // Dropping a counter would stop its clock: they run until the power goes.
        core::mem::forget(Qei::new(timer, a, b, config));
        look(timers()[$number], Flex::new(index), $function);
    }};
}

/// Starts all counters; of the third one the lower half counts.
pub(crate) fn init(pins: Pins) {
    start!(pins.one, 0, 2);
    start!(pins.two, 1, 2);
    #[cfg(feature = "three-axes")]
    start!(pins.three, 2, 1);
}

/// Filters of an encoder that counts already, and its index, to which this alternate function of the pin leads.
fn look(timer: TimGp16, mut index: Flex<'static>, function: u8) {
    // Without an index there is never an edge.
    index.set_as_af_unchecked(function, AfType::input(Pull::None));
    core::mem::forget(index);
    timer.ccmr_input(0).modify(|w| {
        w.set_icf(0, vals::FilterValue::FDTS_DIV4_N8);
        w.set_icf(1, vals::FilterValue::FDTS_DIV4_N8);
    });
    timer.ccmr_input(1).modify(|w| {
        w.set_ccs(0, vals::CcmrInputCcs::TI4);
        w.set_icf(0, vals::FilterValue::FDTS_DIV4_N8);
    });
    timer.ccer().modify(|w| w.set_cce(2, true));
}

#[cfg(not(feature = "three-axes"))]
#[inline(always)]
fn timers() -> [TimGp16; JOINTS] {
    [pac::TIM3, pac::TIM4]
}

#[cfg(feature = "three-axes")]
#[inline(always)]
fn timers() -> [TimGp16; JOINTS] {
    // SAFETY: TIM2 is one of these with longer counters, whose lower halves lie where theirs do.
    [pac::TIM3, pac::TIM4, unsafe { TimGp16::from_ptr(pac::TIM2.as_ptr()) }]
}

/// What the settings make of them: nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan;

impl Plan {
    pub(crate) fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
}

/// All of them. What is wrong with one shows in its marks and to the peer.
pub(crate) struct Encoders;

impl Encoders {
    pub(crate) fn start(_: &'static Signals) -> Self {
        Self
    }

    /// Nothing that the peer would not say.
    pub(crate) fn says(_: &Signals) -> [Option<&'static str>; 2] {
        [None; 2]
    }

    #[inline(always)]
    pub(crate) fn forget(&self) {}

    #[inline(always)]
    pub(crate) fn read(&mut self, _: &Plan, _: bool, _: &mut Option<Fault>) -> [Counts; JOINTS] {
        timers().map(|timer| Counts(timer.cnt().read().cnt()))
    }

    #[inline(always)]
    pub(crate) fn marks(&mut self) -> Option<[Marks; JOINTS]> {
        see().map(marks)
    }
}

/// The flags of what the encoders showed since this was asked last; none where they mean no mark, as in most ticks.
#[inline(always)]
fn see() -> Option<[regs::SrGp16; JOINTS]> {
    let seen = timers().map(|timer| {
        let seen = timer.sr().read();
        // A flag goes off where 0 is written; what came since it was read stays.
        timer.sr().write_value(regs::SrGp16(!seen.0));
        seen
    });
    seen.chunks(2).any(shows).then_some(seen)
}

/// Whether one of two timers shows an index, or a channel that rose twice beside one that did not rise: [`Marks::of`], of both at once.
#[inline(always)]
fn shows(pair: &[regs::SrGp16]) -> bool {
    const INDEX: u32 = 1 << 3;
    const A: u32 = 1 << 1;
    const B: u32 = 1 << 2;
    /// From the flag of a channel that rose to the one that it rose again.
    const AGAIN: u32 = 8;
    let of_both = |flag: u32| flag | flag << 16;
    let flags = pair.iter().fold(0, |flags: u32, seen| flags << 16 | seen.0);
    let other_rose = flags >> 1 & of_both(A) | flags << 1 & of_both(B);
    flags & of_both(INDEX) | flags >> AGAIN & of_both(A | B) & !other_rose != 0
}

/// The marks that these flags mean.
#[cold]
#[inline(never)]
#[unsafe(link_section = ".itcm.marks")]
fn marks(seen: [regs::SrGp16; JOINTS]) -> [Marks; JOINTS] {
    let mut marks = [Marks::default(); JOINTS];
    for ((marks, timer), seen) in marks.iter_mut().zip(timers()).zip(seen) {
        let index = seen.ccif(2).then(|| Counts(timer.ccr(2).read().ccr()));
        *marks = Marks::of([0, 1].map(|channel| seen.ccif(channel)), [0, 1].map(|channel| seen.ccof(channel)), index);
    }
    marks
}
