//! The loop: what is played, what is measured, what is answered.

use cortex_m::asm;
use cortex_m::peripheral::NVIC;
use stm32_metapac::Interrupt;

use haptic_rig::device::Device;
use haptic_rig::order::{Gate, Line, Order, Text};
use haptic_rig::pulses::{Pulses, Seen};

use crate::serial::Serial;
use crate::{captures, clocks, pins};

/// Instructions between two edges of an encoder: more than its filter takes, 33 ns.
const APART: u32 = 96;
/// How long PE14 may stay high after a line was pulled, counts of 240 MHz: 20 µs.
const PATIENCE: u32 = 4_800;
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
    /// The analogue output goes from the first to the second, a step every so many steps of 50 µs; so many are left.
    Ramp(u16, u16, u32, u32),
}

struct Rig {
    gate: Gate,
    device: Device,
    /// Where each encoder is, counts, and which of its wires are on.
    counts: [i32; 2],
    wires: [[bool; 2]; 2],
    pulses: Pulses,
    job: Job,
    /// The analogue output while it falls, and what is left of it after a step.
    falling: Option<(f32, f32)>,
    /// The largest command while amplifiers were enabled, counts of 6000.
    asked: u32,
    serial: Serial,
}

/// Runs for ever.
pub(crate) fn run() -> ! {
    let mut rig = Rig {
        gate: Gate::Both,
        device: Device::default(),
        counts: [0; 2],
        wires: [[true; 2]; 2],
        pulses: Pulses::default(),
        job: Job::Nothing,
        falling: None,
        asked: 0,
        serial: Serial::default(),
    };
    loop {
        asm::wfi();
        if let Some([fell, rose]) = captures::pulse() {
            rig.pulses.see(fell, rose);
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
    /// 50 µs have passed.
    fn step(&mut self) {
        let passes = self.gate.passes(pins::enabled(), pins::timer_drives());
        pins::gate(passes);
        let now = captures::now();
        if passes && pins::enabled() {
            self.asked = self.asked.max(self.pulses.asked(now));
        }
        let share = if passes { self.pulses.share(now) } else { 0.0 };
        let counts = self.device.step(share);
        self.turn(0, counts);
        if let Some((level, keeps)) = &mut self.falling {
            *level *= *keeps;
            // A cast takes what is beyond an integer, and what is no number, to one.
            pins::volts(*level as u16);
        }
        self.measure();
    }

    fn turn(&mut self, joint: u8, counts: i32) {
        let [first, second] = &mut self.counts;
        let [one, two] = self.wires;
        let (at, wires) = if joint == 0 { (first, one) } else { (second, two) };
        for _ in 0..counts.unsigned_abs() {
            *at = at.wrapping_add(counts.signum());
            pins::turn(joint, *at, wires);
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
            Job::Pull(_, left) | Job::Ramp(.., left @ 1..) => *left -= 1,
            Job::Ramp(now, to, ..) if now == to => self.end(Text::of("ok")),
            Job::Ramp(now, to, every, left) => {
                *now = if *now < *to { now.saturating_add(1) } else { now.saturating_sub(1) };
                *left = *every;
                pins::volts(*now);
            }
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
            Some(Order::Pulses(periods)) => {
                self.pulses.count();
                self.job = Job::Pulses(periods);
                return;
            }
            Some(Order::Pull(line)) => {
                if pins::timer_drives() {
                    pins::measuring(true);
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
                answer = answer.number(pins::timer_drives().into()).number(pins::enabled().into());
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
                pins::index(true);
                asm::delay(APART);
                pins::index(false);
            }
            Some(Order::Asked) => answer = answer.number(core::mem::take(&mut self.asked)),
            Some(Order::Cut(joint, second)) => {
                for (number, wires) in (0..).zip(&mut self.wires) {
                    let [a, b] = wires;
                    if number == joint {
                        *(if second { b } else { a }) = false;
                    }
                }
            }
            Some(Order::Mend) => self.wires = [[true; 2]; 2],
            Some(Order::Volts(share)) => {
                self.falling = None;
                pins::volts(share);
            }
            Some(Order::Fall(from, ms)) => {
                let steps = ms.saturating_mul(STEPS_PER_MS).max(1) as f32;
                self.falling = Some((f32::from(from), steps / (steps + 1.0)));
            }
            Some(Order::Stop(open)) => pins::pull(Line::Stop, open),
            Some(Order::Ramp(from, to, ms)) => {
                self.falling = None;
                let every = ms.saturating_mul(STEPS_PER_MS);
                pins::volts(from);
                self.job = Job::Ramp(from, to, every, every);
                return;
            }
            Some(Order::Button(down)) => pins::button(down),
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
    pins::measuring(false);
    captures::look_at_pulses();
    took.map_or(Text::of("error PE14 stays high"), |took| Text::of("ok fell").number(took))
}
