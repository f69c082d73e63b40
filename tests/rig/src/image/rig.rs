//! The loop: what is played, what is measured, what is answered.

use cortex_m::asm;
use cortex_m::peripheral::NVIC;
use stm32_metapac::Interrupt;

use cohold_rig::device::Device;
use cohold_rig::order::{Line, Order, Text};
use cohold_rig::pulses::{Pulses, Seen};

use crate::serial::Serial;
use crate::{captures, clocks, pins};

/// Instructions between two edges of an encoder: more than its filter takes, 33 ns.
const APART: u32 = 96;
/// How long a sensor is at its end after an edge, counts of 240 MHz, and where that is, of 4095: 8 µs, 3.06 V.
const RINGS: u32 = 1920;
const END: u16 = 3800;
/// How long PE14 may stay high after a line was pulled, counts of 240 MHz: 20 µs.
const PATIENCE: u32 = 4_800;
/// A gate that opens for both.
const GATE: u32 = 8;
/// Steps of 50 µs in a millisecond.
const STEPS_PER_MS: u32 = 20;

/// What is being measured.
#[derive(Clone, Copy)]
enum Job {
    Nothing,
    /// So many periods are still to be seen.
    Pulses(u32),
    /// PE14 is to fall within so many steps.
    Watch(u32),
    /// A line is pulled after so many steps: by then whoever looks on has seen the light.
    Pull(Line, u32),
}

/// Movement of the analogue output.
#[derive(Clone, Copy)]
enum Output {
    Stays,
    /// It falls from this level. A step multiplies it by this.
    Falls(f32, f32),
    /// It follows the current of a winding, and is at this level.
    Senses(u16),
}

/// Where an encoder is, counts, and which of its wires are on.
#[derive(Clone, Copy)]
struct Encoder {
    at: i32,
    wires: [bool; 2],
}

struct Rig {
    /// The output of the amplifiers' gate for its inputs, a bit each.
    gate: u32,
    device: Device,
    encoders: [Encoder; 2],
    pulses: Pulses,
    job: Job,
    output: Output,
    /// The largest command while amplifiers were enabled, counts of 6000.
    asked: u32,
    serial: Serial,
}

/// Runs for ever.
pub(crate) fn run() -> ! {
    let mut rig = Rig {
        gate: GATE,
        device: Device::default(),
        encoders: [Encoder { at: 0, wires: [true; 2] }; 2],
        pulses: Pulses::default(),
        job: Job::Nothing,
        output: Output::Stays,
        asked: 0,
        serial: Serial::default(),
    };
    loop {
        asm::wfi();
        if let Some(fell) = captures::fall() {
            rig.ring(fell);
        }
        if let Some([fell, rose]) = captures::pulse() {
            rig.pulses.see(fell, rose);
            rig.ring(rose);
        }
        if clocks::step_is_due() {
            rig.step();
        }
        if let Some(line) = rig.serial.receive() {
            rig.hear(&line);
        }
        rig.serial.send();
        // What is still due is pending again at once.
        [Interrupt::TIM2, Interrupt::TIM7, Interrupt::USART3].into_iter().for_each(NVIC::unpend);
    }
}

impl Rig {
    /// PE9 has changed: a sensor that rides on it is at its end, and comes back.
    fn ring(&self, edge: u32) {
        if let Output::Senses(level) = self.output {
            while captures::now().wrapping_sub(edge) < RINGS {
                pins::volts(END);
            }
            pins::volts(level);
        }
    }

    /// 50 µs have passed.
    fn step(&mut self) {
        let (enabled, timer) = (pins::is_high(pins::ENABLE), pins::is_high(pins::TIMER));
        let passes = self.gate >> (2 * u32::from(enabled) + u32::from(timer)) & 1 != 0;
        pins::set(pins::GATE, passes);
        let now = captures::now();
        if passes && enabled {
            self.asked = self.asked.max(self.pulses.asked(now));
        }
        let given = self.pulses.share(now);
        let mut share = if passes { given } else { 0.0 };
        match &mut self.output {
            Output::Stays => {}
            Output::Falls(level, keeps) => {
                *level *= *keeps;
                // A cast takes what is beyond an integer, and what is no number, to one.
                pins::volts(*level as u16);
            }
            Output::Senses(level) => {
                (share, *level) = self.device.wind(enabled.then_some(given));
                pins::volts(*level);
            }
        }
        let counts = self.device.step(share);
        self.turn(0, counts);
        self.measure();
    }

    fn turn(&mut self, joint: usize, counts: i32) {
        let Some(Encoder { at, wires }) = self.encoders.get_mut(joint) else { return };
        for _ in 0..counts.unsigned_abs() {
            *at = at.wrapping_add(counts.signum());
            pins::turn(joint, *at, *wires);
            asm::delay(APART);
        }
    }

    fn measure(&mut self) {
        match &mut self.job {
            Job::Nothing => {}
            Job::Pulses(left) => {
                let Seen { periods, changes, in_step, off, residue, missing } = self.pulses.seen;
                if periods >= *left {
                    let told = [periods, changes, in_step, off, residue, missing];
                    self.end(told.into_iter().fold(Text::of("ok pulses"), Text::number));
                }
            }
            Job::Watch(left) => {
                if let Some(fell) = captures::fell() {
                    let [edge, change] = self.pulses.until(fell);
                    self.end(Text::of("ok fell").number(edge).number(change));
                } else if *left == 0 {
                    self.end(Text::of("error PE14 did not fall"));
                } else {
                    *left -= 1;
                }
            }
            Job::Pull(line, 0) => {
                let line = *line;
                self.end(pull(line));
            }
            Job::Pull(_, left) => *left -= 1,
        }
    }

    fn end(&mut self, answer: Text) {
        self.job = Job::Nothing;
        self.serial.answer(answer);
    }

    fn hear(&mut self, line: &Text) {
        let mut answer = Text::of("ok");
        match Order::read(line.bytes()) {
            Some(Order::Who) => answer = Text::of("ok rig 1"),
            Some(Order::Gate(gate)) => self.gate = gate,
            Some(Order::Device(moves)) => self.device.moved_by(moves),
            Some(Order::Pulses(periods, tick)) => {
                self.pulses.count(tick);
                self.job = Job::Pulses(periods);
                return;
            }
            Some(Order::Pull(line)) => {
                if pins::is_high(pins::TIMER) {
                    pins::set(pins::LIGHT, true);
                    captures::look_at(line);
                    self.job = Job::Pull(line, 1);
                    return;
                }
                answer = Text::of("error PE14 is low already");
            }
            Some(Order::Watch(ms)) => {
                captures::wait_for_the_fall();
                self.job = Job::Watch(ms.saturating_mul(STEPS_PER_MS));
            }
            Some(Order::Lines) => {
                answer = answer.number(pins::is_high(pins::TIMER).into()).number(pins::is_high(pins::ENABLE).into());
            }
            Some(Order::Turn(joint, edges, upward)) => {
                let edges = i32::try_from(edges).unwrap_or(i32::MAX);
                let counts = if upward { edges } else { -edges };
                if joint == 0 {
                    self.device.turned(counts);
                }
                self.turn(joint, counts);
            }
            Some(Order::Push(milli_n, upward)) => self.device.push(milli_n, upward),
            Some(Order::Mark) => {
                pins::set(pins::INDEX, true);
                asm::delay(APART);
                pins::set(pins::INDEX, false);
            }
            Some(Order::Asked) => answer = answer.number(core::mem::take(&mut self.asked)),
            Some(Order::Cut(joint, second)) => {
                if let Some(Encoder { wires: [a, b], .. }) = self.encoders.get_mut(joint) {
                    *(if second { b } else { a }) = false;
                }
            }
            Some(Order::Mend) => self.encoders.iter_mut().for_each(|encoder| encoder.wires = [true; 2]),
            Some(Order::Volts(share)) => {
                self.output = Output::Stays;
                pins::volts(share);
            }
            Some(Order::Winding) => self.output = Output::Senses(0),
            Some(Order::Fall(from, ms)) => {
                let steps = ms.saturating_mul(STEPS_PER_MS).max(1) as f32;
                self.output = Output::Falls(f32::from(from), steps / (steps + 1.0));
            }
            Some(Order::Stop(open)) => pins::pull(Line::Stop, open),
            Some(Order::Button(down)) => pins::set(pins::BUTTON, down),
            None => answer = Text::of("error no such order"),
        }
        self.serial.answer(answer);
    }
}

/// Pulls a line until PE14 has fallen, and says how long that took.
fn pull(line: Line) -> Text {
    let begun = captures::now();
    pins::pull(line, true);
    let took = loop {
        if let Some(took) = captures::both_fell(line) {
            break Some(took);
        }
        if captures::now().wrapping_sub(begun) > PATIENCE {
            break None;
        }
    };
    pins::pull(line, false);
    pins::set(pins::LIGHT, false);
    captures::look_at_pulses();
    took.map_or(Text::of("error PE14 stays high"), |took| Text::of("ok fell").number(took))
}
