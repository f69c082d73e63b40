//! ADC1's injected group, or ADC2's, as the image uses it: three ranks, started by a trigger output of TIM1, 16 bits, an interrupt at their end.
//!
//! What its inputs read comes from outside ([`Converter::sample`], at the trigger). The emulator's own converter knows no injected group and
//! takes no trigger. With its interrupt off, what was sampled is there at once: nobody can see when.
//!
//! Its regulator takes some time; what was calibrated before that, or without linearity, misses codes at multiples of 2¹².
//!
//! Calibration takes as long as ST's own library waits for it. What is written to the control register meanwhile spoils it for good.
//!
//! Left out: the other group, the queue of contexts, watchdogs, and its clock: 32 MHz are taken for granted.

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::emulator::InterruptLine;
use rigless::soc::stm32h743::generated::adc3::Register;
use rigless::time::{EventId, VirtualNanos};

const LINE: InterruptLine = InterruptLine::new(18).expect("ADC1 and ADC2 have a line");
/// Flags: ready, end of a conversion, end of the group, regulator ready.
const ADRDY: u64 = 1;
const JEOC: u64 = 1 << 5;
const JEOS: u64 = 1 << 6;
const LDORDY: u64 = 1 << 12;
/// Controls: enable, start of the group, regulator, calibration.
const ADEN: u64 = 1;
const JADSTART: u64 = 1 << 3;
const ADCALLIN: u64 = 1 << 16;
const ADVREGEN: u64 = 1 << 28;
const ADCAL: u64 = 1 << 31;
/// An external trigger on its rising edge, 0 or 8, and three ranks.
const TRIGGERED: [u64; 2] = [1 << 7 | 2, 1 << 7 | 8 << 2 | 2];
/// How long the regulator takes, ns: more than anybody waits who does not ask for it.
const REGULATED_NS: u64 = 30_000;
/// 165,010 clocks of 32 MHz, ns.
const CALIBRATED_NS: u64 = 5_156_563;
/// Codes that are missing around each multiple of 2¹² where linearity was not calibrated.
const MISSING: u16 = 8;
/// What channels 15, 10 and 5 read while nothing hangs on them: no current, 24 V.
pub const IDLE: [u16; 3] = [0x8000, 0x8000, 43_330];
/// Three times 17 clocks of 32 MHz, ns.
const LASTS_NS: u64 = 1594;

/// Model of ADC1's injected group.
#[derive(Debug, Default)]
pub struct Converter {
    flags: u64,
    enables: u64,
    /// Triggers so far.
    triggers: u64,
    started: bool,
    /// When the regulator was turned on, ns.
    regulator_ns: Option<u64>,
    /// When the calibration ends that is under way, ns.
    calibrates_ns: Option<u64>,
    /// Calibrated with linearity, and with its regulator ready.
    linear: bool,
    /// JSQR.
    sequence: u64,
    sampled: [u16; 3],
    data: [u16; 3],
    ended: Option<EventId>,
    /// Groups that were asked for while one was under way.
    pub missed: u64,
    /// What channel 3 reads, a motor's thermistor, of 65536: nothing after a reset.
    pub thermistor: u16,
    /// So many triggers do not reach it.
    pub misses: u32,
}

impl Converter {
    /// Channels 15, 10 and 5 read this while TIM1 gives its trigger for the so-manieth time, or again for the last.
    pub fn sample(&mut self, triggers: u64, reads: [u16; 3], c: &mut DeviceContext<'_>) {
        let again = triggers == core::mem::replace(&mut self.triggers, triggers);
        if again || !self.started || !TRIGGERED.contains(&(self.sequence & 0x1FF)) {
            return;
        }
        if let Some(left) = self.misses.checked_sub(1) {
            self.misses = left;
            return;
        }
        if self.ended.is_some() {
            self.missed += 1;
            return;
        }
        self.sampled = self.ranks(reads);
        if self.enables & JEOS != 0 {
            self.ended = Some(c.schedule(VirtualNanos(c.now().0 + LASTS_NS)));
        } else {
            self.data = self.sampled;
            self.flags |= JEOC | JEOS;
        }
    }

    /// The channel of each rank has the read of that input.
    fn ranks(&self, reads: [u16; 3]) -> [u16; 3] {
        [9, 15, 21].map(|at| match self.sequence >> at & 31 {
            15 => self.code(reads[0]),
            10 => self.code(reads[1]),
            5 => self.code(reads[2]),
            3 => self.code(self.thermistor),
            _ => 0,
        })
    }

    /// The code that comes of what it should be.
    fn code(&self, read: u16) -> u16 {
        let multiple = read.saturating_add(MISSING) & 0xF000;
        if self.linear || read.abs_diff(multiple) > MISSING { read } else { multiple.saturating_add(MISSING) }
    }

    fn is_calibrating(&self, now: VirtualNanos) -> bool {
        self.calibrates_ns.is_some_and(|ends| now.0 < ends)
    }

    /// What a register reads that is not as it was written.
    fn word(&self, r: Register, f: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        let [one, two, three] = self.data.map(u64::from);
        match r {
            Register::Cr if self.is_calibrating(now) => Some(f.get(Register::Cr) | ADCAL),
            Register::Isr => Some(self.flags | if self.is_regulated(now) { LDORDY } else { 0 }),
            Register::Jdr1 => Some(one),
            Register::Jdr2 => Some(two),
            Register::Jdr3 => Some(three),
            _ => None,
        }
    }

    fn is_regulated(&self, now: VirtualNanos) -> bool {
        self.regulator_ns.is_some_and(|began| now.0 >= began + REGULATED_NS)
    }
}

impl Device for Converter {
    type Register = Register;

    fn read(&mut self, r: Register, f: &mut RegisterFile, c: &mut DeviceContext<'_>) -> Option<u64> {
        self.word(r, f, c.now())
    }
    fn peek(&self, r: Register, f: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        self.word(r, f, now)
    }
    fn write(&mut self, r: Register, value: u64, f: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        match r {
            Register::Isr => self.flags &= !value,
            Register::Ier => self.enables = value,
            Register::Jsqr => self.sequence = value,
            Register::Cr => {
                let now = f.get(Register::Cr) & !ADCAL;
                if self.is_calibrating(c.now()) {
                    // It never comes any more.
                    self.calibrates_ns = Some(u64::MAX);
                    return;
                }
                let ready = if value & ADEN != 0 { ADRDY } else { 0 };
                self.flags |= ready;
                if now & ADVREGEN != 0 {
                    self.regulator_ns.get_or_insert(c.now().0);
                }
                if value & ADCAL != 0 {
                    self.linear = value & ADCALLIN != 0 && self.is_regulated(c.now());
                    self.calibrates_ns = Some(c.now().0 + CALIBRATED_NS);
                }
                self.started = now & JADSTART != 0;
                if self.started {
                    self.data = self.ranks(IDLE);
                }
                f.set(Register::Cr, now);
            }
            _ => {}
        }
        if self.flags & self.enables & JEOS == 0 {
            c.drive_line(LINE, Level::Low);
        }
    }
    fn on_event(&mut self, event: EventId, _: &mut RegisterFile, c: &mut DeviceContext<'_>) {
        if self.ended == Some(event) {
            self.ended = None;
            self.data = self.sampled;
            self.flags |= JEOC | JEOS;
            if self.enables & JEOS != 0 {
                c.drive_line(LINE, Level::High);
            }
        }
    }
    fn reset(&mut self) {
        *self = Self::default();
    }
}
