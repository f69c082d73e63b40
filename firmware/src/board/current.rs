//! The current loop: ADC1 samples both motors' currents and the supply at the start of every PWM period, ADC2 the currents and a motor's
//! thermistor in its middle. The interrupt at the end of the first, 20,000 times a second, gives both bridges their voltages for the next
//! period.
//!
//! **Which sample**: a sensor rides on its bridge's first leg, and needs 9.8 µs after each edge of it (TI, INA240: host-sim/sim/src/plant/drive.rs).
//! That leg rises (1 + V)·12.5 µs before a period begins and falls (1 − V)·12.5 µs before its middle, for a voltage of V of the supply. So
//! after a voltage below none the sample is that of the middle before, 25 µs older, and never one that is nearer to an edge than 12.5 µs.
//!
//! **Deadline**: the update after the one that started the conversions, 50 µs; it needs some 3, of which the conversions are 1.6. A period
//! that is missed keeps its voltage, and the next tick finds fewer periods than a tick has ([`Stage::measured`]): motors off, as
//! [`cohold_core::safety::Fault::LoopMissed`]. A loop that hangs keeps the tick from coming, and the dead man ends it.
//!
//! **Rules**: priority 0, above the tick; code in ITCM, data in DTCM; whole numbers only, so that the processor saves no registers of
//! the FPU; no lock, no wait, no panic. What tick and interrupt tell each other goes through [`firmware_parts::exchange::Latest`].
//!
//! **When**: the converter runs from the start of the board; the interrupt only while the tick drives ([`start`] to [`stop`]). With the
//! bridges off the tick itself looks at what was converted last: that is each sensor's zero.
//!
//! Clock of the converter: the chip's 64 MHz oscillator, halved; three conversions of 17 clocks (8.5 to sample, 16 bits) last 1.6 µs.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicU32, Ordering};

use cohold_core::device::current::{Controller, CurrentLoop, Gains, PWM_HZ, Sensor};
use cohold_core::device::kinematics::Joints;
use cohold_core::device::stage::{Flow, Measured};
use cohold_core::device::thermal::Thermistor;
use cohold_core::device::{AXES, encoder::Counts, motor::Duty};
use cohold_core::names::MotorDrive;
use cohold_core::settings::{Refused, Settings};
use cortex_m::peripheral::DWT;
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::pac;
use embassy_stm32::pac::adc::vals::{Boost, Exten, Pcsel, SampleTime};
use embassy_stm32::pac::timer::vals::{Mms, Mms2};
use embassy_time::{Duration, Instant};
use firmware_parts::exchange::{Reader, Writer, put};
use firmware_parts::image::Actuators;
use firmware_parts::rate::Rate;
use firmware_parts::record::{PERIODS_IN_ONE, Period};

use super::{legs, pace::Run};

/// What the pins PA3 and PC0 are to the converters: currents of motors 1 and 2.
const CURRENTS: [u8; AXES] = [15, 10];
/// The converters with their triggers, TIM1_TRGO, the bridges' timer's update, and TIM1_TRGO2, its top, and what each samples behind the
/// currents: PB1, the supply over 11, and PA6, the divider of the thermistor.
const CONVERTERS: [(pac::adc::Adc, u8, u8); 2] = [(pac::ADC1, 0, 5), (pac::ADC2, 8, 3)];
/// The second: a pulse as OC6REF rises ([`super::bridges`]).
const TOP: Mms2 = Mms2::COMPARE_PULSE_OC5_OR_OC6_RISING;
/// JEOC and JEOS in ISR: a conversion has ended, and all of a sample.
const ENDED: u32 = 1 << 5 | 1 << 6;
/// Bits of a conversion.
const BITS: u32 = 16;
/// Millivolts of the supply at the end of the converter's range: 3.3 V before an eleventh.
const SUPPLY_MV: u32 = 3_300 * 11;
/// PWM periods in a millisecond.
pub(crate) const PERIODS: u32 = PWM_HZ / 1000;

/// What one motor is to be given.
#[derive(Clone, Copy, Debug)]
enum MotorRequest {
    /// A current, and the back-EMF that is expected, counts.
    Current(Duty, i32),
    /// A voltage, timer counts.
    Voltage(i32),
}

/// What the tick tells the interrupt.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Order {
    gains: Gains,
    sensors: [Sensor; AXES],
    wanted: [MotorRequest; AXES],
}

/// No voltage, no gains.
impl Default for Order {
    fn default() -> Self {
        let (gains, sensors) = (Gains::default(), [Sensor::default(); AXES]);
        Self { gains, sensors, wanted: [MotorRequest::Voltage(0); AXES] }
    }
}

/// What the interrupt tells the tick, since the start of the board, and its runs since power came on; all of it wraps.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    /// How often the interrupt has run.
    runs: u32,
    /// Of the periods before the last one: currents, codes; voltages, counts; what the supply's rank read.
    codes: [i32; AXES],
    voltages: [i32; AXES],
    supply: u32,
    /// The currents of the last of them.
    last: [i32; AXES],
}

/// What the interrupt of the loop owns.
struct Loop {
    orders: Reader<'static, Order>,
    sums: Writer<'static, Sums>,
    total: Sums,
    /// Of this period, which the tick gets to see when it is over.
    now: Sums,
    controllers: [Controller; AXES],
    /// Voltages of the next period, counts.
    next: [i32; AXES],
    /// [`FIRST`] until it has run.
    first: u32,
}

static mut LOOP: MaybeUninit<Loop> = MaybeUninit::uninit();

/// Runs that are remembered: more than the longest tick has.
pub(crate) const RING: u32 = 32;
/// Of each: when it began and ended, how late in its period it began, in the timer's counts, with [`FIRST`] above, and the currents and the
/// voltages of both motors ([`Period`]). Start-up leaves them alone.
#[unsafe(link_section = ".uninit.periods")]
static TOOK: [[AtomicU32; 3 + 2 * AXES]; RING as usize] =
    [const { [const { AtomicU32::new(0) }; 3 + 2 * AXES] }; RING as usize];
const FIRST: u32 = 1 << 16;
/// How often the interrupt has run, since power came on.
#[unsafe(link_section = ".uninit.runs")]
static RUNS: AtomicU32 = AtomicU32::new(0);
/// Periods that are told of, the last ones in which motors were on.
pub(crate) const TOLD: u32 = 3 * PERIODS_IN_ONE as u32;
const _: () = assert!(TOLD < RING);

/// How often the interrupt has run, since power came on.
pub(crate) fn runs() -> u32 {
    RUNS.load(Ordering::Acquire)
}

/// Nothing of the runs before is known.
pub(crate) fn forget_runs() {
    TOOK.iter().flatten().chain([&RUNS]).for_each(|word| word.store(0, Ordering::Relaxed));
}

/// A run by its number, if it is one of the last [`RING`].
pub(crate) fn run(number: u32) -> Run {
    let [began, ended, late, ..] = TOOK[(number % RING) as usize].each_ref().map(|word| word.load(Ordering::Relaxed));
    Run { began, ended, late: late & (FIRST - 1), first: late & FIRST != 0 }
}

/// What a run saw and did, likewise.
pub(crate) fn period(number: u32) -> Period {
    let [.., a, b, c, d] =
        TOOK[(number % RING) as usize].each_ref().map(|word| word.load(Ordering::Relaxed).cast_signed());
    // A sensor reads more than a motor is asked for.
    let share = |codes: i32| codes.clamp(-32_767, 32_767) as i16;
    let of_supply = |counts: i32| share(counts * 32_767 / i32::from(legs::COUNTS));
    Period { currents: [a, b].map(share), voltages: [c, d].map(of_supply) }
}

/// Starts both converters; the interrupt stays off.
///
/// # Errors
/// Why motors must not be on: it did not come.
pub(crate) fn init() -> Result<(), &'static str> {
    pac::RCC.d3ccipr().modify(|w| w.set_adcsel(pac::rcc::vals::Adcsel::PER));
    pac::RCC.ahb1enr().modify(|w| w.set_adc12en(true));
    let _ = pac::RCC.ahb1enr().read();
    // Out of reset the pins are analogue, and so they stay.
    let by = Instant::now() + STARTS;
    for (adc, ..) in CONVERTERS {
        adc.cr().modify(|w| w.set_deeppwd(false));
        adc.cr().modify(|w| w.set_advregen(true));
        // Its regulator is ready when it says so (RM0433 §25.4.6).
        soon(by, || adc.isr().read().ldordy())?;
        adc.cr().modify(|w| w.set_boost(Boost::LT50));
        // Offset and linearity: without the latter codes are missing at multiples of 2¹², and no current is one of them (RM0433 §25.4.8).
        adc.cr().modify(|w| {
            w.set_adcallin(true);
            w.set_adcal(true);
        });
    }
    for (adc, trigger, third) in CONVERTERS {
        let [one, two] = CURRENTS;
        // Nothing may be written to CR until it is calibrated.
        soon(by, || !adc.cr().read().adcal())?;
        for channel in [one, two, third].map(usize::from) {
            adc.pcsel().modify(|w| w.set_pcsel(channel, Pcsel::PRESELECTED));
            adc.smpr(channel / 10).modify(|w| w.set_smp(channel % 10, SampleTime::CYCLES8_5));
        }
        adc.isr().write(|w| w.set_adrdy(true));
        adc.cr().modify(|w| w.set_aden(true));
        soon(by, || adc.isr().read().adrdy())?;
        adc.jsqr().write(|w| {
            w.set_jl(AXES as u8);
            w.set_jextsel(trigger);
            w.set_jexten(Exten::RISING_EDGE);
            for (rank, channel) in [one, two, third].into_iter().enumerate() {
                w.set_jsq(rank, channel);
            }
        });
        adc.cr().modify(|w| w.set_jadstart(true));
    }
    pac::TIM1.cr2().modify(|w| w.set_mms(Mms::UPDATE));
    pac::TIM1.cr2().modify(|w| w.set_mms2(TOP));
    Ok(())
}

/// Longest that the converter takes to start: its calibration, 165,010 of its clocks (ST's `ADC_CALIBRATION_TIMEOUT`), is 5.2 ms.
const STARTS: Duration = Duration::from_millis(20);

/// Waits for it until an instant.
fn soon(by: Instant, done: impl Fn() -> bool) -> Result<(), &'static str> {
    while !done() {
        if Instant::now() > by {
            return Err("the current sensors' converter did not start: power off and on");
        }
    }
    Ok(())
}

/// Hands the interrupt its side; call once, before the tick runs.
pub(crate) fn prepare(orders: Reader<'static, Order>, sums: Writer<'static, Sums>) {
    let this = Loop {
        orders,
        sums,
        total: Sums { runs: runs(), ..Sums::default() },
        now: Sums::default(),
        controllers: [Controller::default(); AXES],
        next: [0; AXES],
        first: FIRST,
    };
    // SAFETY: the interrupt that uses LOOP is not enabled yet.
    unsafe {
        let place = &raw mut LOOP;
        (*place).write(this)
    };
    interrupt::ADC.set_priority(Priority::P0);
    // SAFETY: the handler is there, and what it uses is set up.
    unsafe { interrupt::ADC.enable() };
}

/// The interrupt runs from the next period on, at rest.
#[inline(always)]
fn start() {
    // SAFETY: `prepare` ran before the tick did, and the interrupt is off.
    let this = unsafe {
        let place = &raw mut LOOP;
        (*place).assume_init_mut()
    };
    this.controllers = [Controller::default(); AXES];
    this.first = FIRST;
    (this.now, this.next) = (Sums::default(), [0; AXES]);
    forget();
    pac::ADC1.ier().write(|w| w.set_jeosie(true));
}

/// Takes note of what both converters have ended.
#[inline(always)]
fn forget() {
    for (adc, ..) in CONVERTERS {
        adc.isr().write(|w| w.0 = ENDED);
    }
}

#[unsafe(no_mangle)]
#[unsafe(link_section = ".itcm.current")]
extern "C" fn ADC() {
    let (began, late) = (DWT::cycle_count(), u32::from(pac::TIM1.cnt().read().cnt()));
    let whole = pac::ADC2.isr().read().jeos();
    forget();
    // SAFETY: `prepare` ran before the interrupt was enabled, and nothing but this handler touches LOOP.
    let this = unsafe {
        let place = &raw mut LOOP;
        (*place).assume_init_mut()
    };
    // Without a new sample of the middle the period is missed.
    if whole {
        this.period();
    }
    let run = this.total.runs;
    let late = late | core::mem::take(&mut this.first);
    let ([a, b], [c, d]) = (this.now.codes, this.now.voltages);
    let [a, b, c, d] = [a, b, c, d].map(i32::cast_unsigned);
    let words = [began, DWT::cycle_count(), late, a, b, c, d];
    for (place, word) in TOOK[(run % RING) as usize].iter().zip(words) {
        place.store(word, Ordering::Relaxed);
    }
    RUNS.store(run, Ordering::Release);
}

impl Loop {
    #[inline(always)]
    fn period(&mut self) {
        let (total, now) = (&mut self.total, &mut self.now);
        total.runs = total.runs.wrapping_add(1);
        total.supply = total.supply.wrapping_add(now.supply);
        for joint in 0..AXES {
            total.codes[joint] = total.codes[joint].wrapping_add(now.codes[joint]);
            total.voltages[joint] = total.voltages[joint].wrapping_add(now.voltages[joint]);
        }
        total.last = now.codes;
        self.sums.write(*total);

        self.orders.fetch();
        let order = self.orders.get();
        let drives = legs::driven();
        now.supply = pac::ADC1.jdr(AXES).read().jdata();
        for joint in 0..AXES {
            let adc = if now.voltages[joint] < 0 { pac::ADC2 } else { pac::ADC1 };
            now.voltages[joint] = self.next[joint];
            let codes = order.sensors[joint].codes(adc.jdr(joint).read().jdata() as u16);
            now.codes[joint] = codes;
            let controller = &mut self.controllers[joint];
            self.next[joint] = match order.wanted[joint] {
                MotorRequest::Current(duty, forward) if drives => controller.step(&order.gains, duty, codes, forward),
                wanted => {
                    *controller = Controller::default();
                    if let (MotorRequest::Voltage(counts), true) = (wanted, drives) { counts } else { 0 }
                }
            };
            if drives {
                legs::voltage(joint, self.next[joint]);
            }
        }
    }
}

/// The loop of one set of settings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Power {
    design: CurrentLoop,
    /// Its zero in the middle.
    sensor: Sensor,
    thermistor: Option<Thermistor>,
    /// Speed of a joint that moves a count a tick, m/s or rad/s.
    speed_per_count: f32,
    /// PWM periods in a tick, and ticks in a millisecond.
    periods: u32,
    per_ms: u32,
}

impl Power {
    /// From the table `motor`.
    ///
    /// # Errors
    /// What [`CurrentLoop::build`] refuses.
    pub(crate) fn build(settings: &Settings, rate: Rate) -> Result<Self, Refused<'static>> {
        let unit_per_count = 1.0 / Joints::of(settings).counts_per_unit;
        let unit_per_count = if settings.encoder.reversed { -unit_per_count } else { unit_per_count };
        Ok(Self {
            design: CurrentLoop::build(settings, legs::COUNTS)?,
            sensor: Sensor::build(settings, BITS),
            thermistor: Thermistor::build(settings),
            speed_per_count: (unit_per_count / rate.period_s()) as f32,
            periods: PERIODS / rate.per_ms(),
            per_ms: rate.per_ms(),
        })
    }
}

/// The supply of the bridges that the converter read last, mV, if bridges are driven: with amplifiers its pin is open.
pub(crate) fn supply_mv(drive: MotorDrive) -> Option<u32> {
    (drive == MotorDrive::CurrentLoop).then(|| millivolts(pac::ADC1.jdr(AXES).read().jdata()))
}

/// 65535 · 36300 < 2³²: to the nearest mV, of which a step of the converter is half.
#[inline(always)]
fn millivolts(supply_read: u32) -> u32 {
    (supply_read * SUPPLY_MV + (1 << (BITS - 1))) >> BITS
}

/// What a record tells of it.
pub(crate) fn reported(measured: Option<&Measured>) -> Option<&Measured> {
    measured
}

/// The tick's side of the power stage.
pub(crate) struct Stage {
    orders: Writer<'static, Order>,
    sums: Reader<'static, Sums>,
    before: Sums,
    zeros: [Zero; AXES],
    counts: [Counts; AXES],
    supply_mv: u32,
    /// Ticks until the sensors' zeros are looked at again.
    until: u32,
    /// The interrupt runs.
    runs: bool,
}

impl Stage {
    pub(crate) fn new(orders: Writer<'static, Order>, sums: Reader<'static, Sums>) -> Self {
        Self {
            orders,
            sums,
            before: Sums::default(),
            zeros: [Zero::default(); AXES],
            counts: [Counts(0); AXES],
            supply_mv: 0,
            until: 0,
            runs: false,
        }
    }

    /// What was measured since the last tick. None, of a loop that is to run: it does not.
    #[inline(always)]
    pub(crate) fn measured(&mut self, power: &Power) -> Option<Measured> {
        if !self.runs {
            return Some(self.at_rest(power));
        }
        self.sums.fetch();
        let (now, before) = (*self.sums.get(), self.before);
        self.before = now;
        let periods = now.runs.wrapping_sub(before.runs);
        if periods < power.periods {
            return None;
        }
        let since = |now: i32, before: i32| now.wrapping_sub(before);
        let mut motors = [Flow::default(); AXES];
        for (joint, flow) in motors.iter_mut().enumerate() {
            let currents = since(now.codes[joint], before.codes[joint]);
            let voltages = since(now.voltages[joint], before.voltages[joint]);
            *flow = Flow::of(currents, voltages, now.last[joint], periods.cast_signed());
        }
        let read = now.supply.wrapping_sub(before.supply).checked_div(periods).unwrap_or(0);
        Some(self.said(power, motors, read))
    }

    /// With the bridges off: what the converter read last.
    #[inline(never)]
    #[unsafe(link_section = ".itcm.current")]
    fn at_rest(&mut self, power: &Power) -> Measured {
        let mut motors = [Flow::default(); AXES];
        let looks = self.until == 0;
        self.until = if looks { power.per_ms } else { self.until } - 1;
        for (joint, (flow, zero)) in motors.iter_mut().zip(&mut self.zeros).enumerate() {
            let read = pac::ADC1.jdr(joint).read().jdata() as u16;
            if looks {
                zero.see(read);
            }
            let codes = power.sensor.codes(read);
            *flow = Flow::of(codes, 0, codes, 1);
        }
        self.said(power, motors, pac::ADC1.jdr(AXES).read().jdata())
    }

    #[inline(always)]
    fn said(&mut self, power: &Power, motors: [Flow; AXES], supply_read: u32) -> Measured {
        self.supply_mv = millivolts(supply_read);
        let read = || pac::ADC2.jdr(AXES).read().jdata() as u16;
        let thermistor = power.thermistor.map_or(0, |thermistor| thermistor.code(read()));
        Measured { motors, supply_mv: self.supply_mv as u16, supply_counts: legs::COUNTS, thermistor }
    }

    /// What the bridges are to do, from the next period on; the interrupt runs, if it did not.
    #[inline(always)]
    pub(crate) fn act(&mut self, power: &Power, actuators: &Actuators, counts: [Counts; AXES]) {
        let mut wanted = [MotorRequest::Voltage(0); AXES];
        for (joint, wanted) in wanted.iter_mut().enumerate() {
            let duty = actuators.duties[joint];
            *wanted = if actuators.open {
                MotorRequest::Voltage(legs::counts(duty, legs::COUNTS))
            } else {
                let moved = counts[joint].0.wrapping_sub(self.counts[joint].0).cast_signed();
                MotorRequest::Current(
                    duty,
                    power.design.forward(f32::from(moved) * power.speed_per_count, self.supply_mv),
                )
            };
        }
        self.counts = counts;
        self.orders.fill(|order| {
            order.gains = power.design.gains(self.supply_mv);
            for (sensor, zero) in order.sensors.iter_mut().zip(&self.zeros) {
                *sensor = power.sensor;
                sensor.zero = zero.is;
            }
            order.wanted = wanted;
            true
        });
        if !self.runs {
            self.runs = true;
            self.sums.fetch();
            put(&mut self.before, self.sums.get());
            start();
        }
    }

    /// The bridges are off: the interrupt need not run.
    #[inline(always)]
    pub(crate) fn rest(&mut self, counts: [Counts; AXES]) {
        self.counts = counts;
        if self.runs {
            self.runs = false;
            pac::ADC1.ier().write(|_| {});
            self.zeros.iter_mut().for_each(Zero::wait);
        }
    }
}

/// The zero of one sensor: the mean of [`Zero::READS`] milliseconds with the bridges off, [`Zero::REST`] after they went.
#[derive(Clone, Copy, Debug)]
struct Zero {
    is: i32,
    /// Looks to go, one a millisecond, and the sum so far.
    left: u32,
    sum: i32,
}

impl Default for Zero {
    fn default() -> Self {
        Self { is: Self::MIDDLE, left: Self::READS + Self::REST, sum: 0 }
    }
}

impl Zero {
    const MIDDLE: i32 = 1 << (BITS - 1);
    const READS: u32 = 64;
    const REST: u32 = 16;
    /// Farthest from the middle that it may be, 3 % of the range: resistors and amplifier stay within 1. Beyond that the sensor is broken
    /// and the middle is what counts, as it does for the peer, which says so (fault 18).
    const MOST: i32 = Self::MIDDLE * 3 / 100;

    /// What was before says nothing.
    fn wait(&mut self) {
        (self.left, self.sum) = (Self::READS + Self::REST, 0);
    }

    #[inline(always)]
    fn see(&mut self, read: u16) {
        if self.left <= Self::READS {
            self.sum += i32::from(read);
        }
        self.left -= 1;
        if self.left == 0 {
            // To the nearest.
            let mean = (self.sum + Self::READS as i32 / 2) / Self::READS as i32;
            self.is = if (mean - Self::MIDDLE).abs() <= Self::MOST { mean } else { Self::MIDDLE };
            (self.left, self.sum) = (Self::READS, 0);
        }
    }
}
