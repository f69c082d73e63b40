//! Watches motors, their power stage and their encoders by what the stage measured ([`super::stage`]), every second
//! tick, over both ticks together.
//!
//! **Warm** ([`Fault::MotorTooWarm`]): [`super::thermal`]. Its thermistor at the limit, and one that is open or shorted
//! ([`Fault::Thermistor`]), each for [`LASTS_S`], whether the motors are on or off.
//!
//! **Supply** ([`Fault::SupplyOutOfRange`]): outside `motor.min_supply_v` to `motor.max_supply_v` for [`LASTS_S`] while the motors are
//! on; while they are off it only keeps them from being turned on.
//!
//! **Sensor** ([`Fault::CurrentSensor`]): at the end of what it measures ([`current::REACHED`]), or at `motor.full_scale_a`, at the end of two ticks running; or, while the motors are off, further
//! than 4 % of `motor.sense_a` from zero for [`LASTS_S`], be it the sensor or a bridge that conducts although it is off.
//!
//! **Current** ([`Fault::CurrentNotFollowed`]): e = i − i_ref, codes, beside what is tolerated of it: 1.6 % of `motor.sense_a`, ⅛ of the
//! reference, and its changes times half a tick and the loop's lag.
//!
//! **Encoder** ([`Fault::EncoderImplausible`]): a motor that turns is a second speed sensor. r = u − R·i − L·Δi/T − k·Δq/T, V, where
//! Δq is what the encoder moved in T, beside what is tolerated of it: `motor.emf_tolerance_v` and one count, ¼ of |R·i| (copper that is
//! 60 K warmer), ½ of |L·Δi/T| (iron that saturates) and ⅛ of |k·Δq/T|. So an encoder that is stuck is detected from a joint speed of
//! (tolerated r)/k on, one that counts the wrong way from half of that.
//!
//! Both e and r are leaky means ([`super::leaky`]) over [`MEAN_S`], from [`SETTLES_S`] after the motors went on; what is tolerated of
//! each grows at once and is forgotten like them. Where r is too large, it is the current's fault if that misses half of its reference
//! now, else the encoder's. Where only e is too large, it is the current's. While the voltage is at its limit toward the reference, e
//! is not counted: r shows that the voltage goes into speed, so the supply is at its end, which is no fault. An e or r that stays at x
//! times its tolerance trips after the first n pairs of ticks for which 1 − (1 − 2·T_c/[`MEAN_S`])ⁿ > 1/x: at 1 kHz 1.2 times after 14
//! ms, twice after 6 ms, five times after 2 ms; up to 2 ms more if it begins within a pair, and later where more was tolerated just
//! before.
//!
//! While a probe runs ([`super::probe`]), e and r are not judged: the probe is there to find scales and signs, and has a watch of
//! its own. Where positions are exact, r is not judged either.
//!
//! Limits: an open motor that no force is asked of is reported as an encoder fault as soon as it moves, and not at all while it
//! rests. A supply that is measured wrongly raises r. Encoder faults below the tolerated speed are not seen.

use crate::device::current::{self, PWM_PERIOD_S};
use crate::device::envelope;
use crate::device::kinematics::Joints;
use crate::device::leaky::Leaky;
use crate::device::motor::Duty;
use crate::device::stage::Measured;
use crate::device::thermal::{self, Heat, Thermal};
use crate::safety::{Fault, Patience};
use crate::settings::{Allowed, Refused, Settings};
use crate::{device::AXES, num::Scalar};

/// Time constant of the means of currents and voltages, s.
pub const MEAN_S: f64 = 0.008;
/// How long a supply, or a current of motors that are off, must be wrong before it is a fault, s.
pub const LASTS_S: f64 = 0.01;
/// How long after the motors went on currents and encoders are not judged, s: the bridges need it to wake up.
pub const SETTLES_S: f64 = 0.004;

/// Parts of `motor.sense_a` that a current may be off its reference by, and off zero.
const STRAYS: f64 = 0.016;
const ZERO: f64 = 0.04;

/// Codes of two means that are no noise: 0.2 % of full scale.
const NOISE: i32 = 128;

/// What the watch of all motors goes by.
#[derive(Clone, Copy, Debug)]
pub struct StageWatch<S> {
    thermal: Thermal<S>,
    /// The current that a winding near its limit is left, codes.
    lasting: S,
    leaky: Leaky<S>,
    supply_mv: (u16, u16),
    /// Pairs of ticks.
    lasts: u32,
    settles: u32,
    /// Codes at which a sensor is at its end, and that it may be off zero by.
    end: i32,
    zero: i32,
    /// Codes that two means may be off their references by, and 1/16 of what they may be of a change of the reference.
    strays: i32,
    lags: i32,
    /// A per code, of the sum of two means.
    amperes: S,
    /// R, Ω.
    ohms: S,
    /// L/T, V per code.
    inductive: S,
    /// k/T, V per count.
    emf: S,
    /// V.
    tolerance: S,
    half: S,
    eighth: S,
    axes: usize,
}

configured!([S: Scalar] StageWatch<S> {
    thermal, lasting, leaky, supply_mv, lasts, settles, end, zero, strays, lags, amperes, ohms, inductive, emf, tolerance,
    half, eighth, axes
});

/// What the watch remembers from tick to tick, of all motors.
#[derive(Clone, Copy, Debug)]
pub struct StageState<S, const N: usize = AXES> {
    /// The first of a pair of ticks, with the references of its time.
    first: Option<(Measured<N>, [Duty; N])>,
    /// Pairs since the motors went on.
    on: u32,
    conducts: Patience,
    supply: Patience,
    /// Whether the last supply measured is out of range.
    pub supply_is_wrong: bool,
    /// Share of its limit that the mean square of the warmest motor's current is.
    pub warmth: S,
    /// What the thermistor shows ([`thermal::Thermistor::code`]).
    pub thermistor: u8,
    hot: Patience,
    motors: [Motor<S>; N],
}

impl<S: Scalar, const N: usize> Default for StageState<S, N> {
    fn default() -> Self {
        Self {
            first: None,
            on: 0,
            conducts: Patience::default(),
            supply: Patience::default(),
            supply_is_wrong: false,
            warmth: S::ZERO,
            thermistor: 0,
            hot: Patience::default(),
            motors: [Motor::default(); N],
        }
    }
}

/// What the watch remembers of one motor.
#[derive(Clone, Copy, Debug, Default)]
struct Motor<S> {
    heat: Heat<S>,
    /// At the end of the last pair: current (codes), reference, counts.
    last: i16,
    asked: i16,
    counts: i32,
    /// Means of e and of what is tolerated of it, codes of two ticks.
    error: S,
    error_borne: S,
    /// Means of r and of what is tolerated of it, V.
    residual: S,
    residual_borne: S,
}

/// How the motors are driven, which decides what can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driven {
    /// Motors are off: only supply, sensors and warmth are judged.
    Off,
    /// A probe drives one motor and judges it itself: only warmth, supply and the end of the sensor's range are
    /// judged here.
    Probed,
    /// Motors are on, and positions are exact: there is no encoder to judge.
    Alone,
    /// Motors are on, with encoders: current, voltage and motion are judged against each other.
    Whole,
}

impl<S: Scalar> StageWatch<S> {
    /// From the tables `motor`, `encoder` and `timing`.
    ///
    /// # Errors
    /// A `motor.min_supply_v` above `motor.max_supply_v`.
    pub fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        settings.within("motor.min_supply_v", Allowed::Number { min: 0.0, max: settings.motor.max_supply_v })?;
        let motor = &settings.motor;
        let pair_s = 2.0 * settings.timing.control_period_s;
        let ampere = f64::from(Duty::FULL_SCALE) / motor.full_scale_a;
        // Far beyond all codes there are, and sums of it still fit.
        let codes = |amperes: f64| (amperes * ampere + 0.5).min(1e6) as i32;
        // A cast saturates.
        let pairs = |time_s: f64| ((time_s / pair_s + 0.5) as u32).max(1);
        let millivolts = |volts: f64| (1e3 * volts + 0.5) as u16;
        let along = if motor.reversed { -1.0 } else { 1.0 };
        let volts_per_count = motor.newton_or_newton_metre_per_a / (Joints::of(settings).counts_per_unit * pair_s);
        let late = 0.5 + (current::lag_s(settings) + PWM_PERIOD_S) / settings.timing.control_period_s;
        Ok(Self {
            thermal: Thermal::build(settings, pair_s),
            lasting: S::from_f64(thermal::LASTS * motor.continuous_a * ampere),
            leaky: Leaky::new(pair_s, MEAN_S),
            supply_mv: (millivolts(motor.min_supply_v), millivolts(motor.max_supply_v)),
            lasts: pairs(LASTS_S),
            settles: pairs(SETTLES_S),
            end: codes(current::REACHED * motor.sense_a).min(i32::from(i16::MAX)),
            zero: codes(ZERO * motor.sense_a),
            strays: codes(2.0 * STRAYS * motor.sense_a),
            lags: (16.0 * late).min(1024.0) as i32,
            amperes: S::from_f64(0.5 / ampere),
            ohms: S::from_f64(motor.resistance_ohm),
            inductive: S::from_f64(motor.inductance_h / (ampere * pair_s)),
            emf: S::from_f64(along * volts_per_count),
            tolerance: S::from_f64(motor.emf_tolerance_v + volts_per_count),
            half: S::from_f64(0.5),
            eighth: S::from_f64(0.125),
            axes: settings.axis.count as usize,
        })
    }

    /// Takes a tick's measurements, with the references that stood for it and the counts of every joint at its end;
    /// gives the fault, if any.
    #[inline]
    pub fn step<const N: usize>(
        &self,
        state: &mut StageState<S, N>,
        measured: &Measured<N>,
        asked: [Duty; N],
        driven: Driven,
        counts: impl FnOnce() -> [i32; N],
    ) -> Option<Fault> {
        match state.first.take() {
            Some(first) => self.judge(state, [first, (*measured, asked)], driven, counts()),
            None => {
                state.first = Some((*measured, asked));
                None
            }
        }
    }

    /// The largest force (N) of every axis that windings this warm bear, of `full` (N) at most, if now they carry this (codes) for that (N).
    #[inline(always)]
    pub fn most<const N: usize>(&self, state: &StageState<S, N>, full: S, asked: [Duty; N], forces: [S; N]) -> S {
        let largest = |each: [S; N]| each.into_iter().fold(S::ZERO, |largest, one| largest.max(one.abs()));
        let codes = largest(asked.map(|duty| S::from_i32(duty.0.into())));
        let lasting = if codes >= S::ONE { self.lasting.ratio(codes.max(S::ONE)) * largest(forces) } else { full };
        // A 64th less for each code of the thermistor. Whatever an integer is there, it is a share, which the proofs look for.
        let left = S::from_i32(64_u8.saturating_sub(state.thermistor).into());
        let cool = (left * S::from_f64(1.0 / 64.0)).limit(S::ONE).max(S::ZERO);
        (full * envelope::left(state.warmth) + lasting).min(full * cool)
    }

    /// Forgets past current references and errors, as the motors go on; the thermal state stays.
    pub fn start<const N: usize>(&self, state: &mut StageState<S, N>) {
        (state.first, state.on) = (None, 0);
        (state.conducts, state.supply, state.hot) = Default::default();
    }

    #[inline(never)]
    fn judge<const N: usize>(
        &self,
        state: &mut StageState<S, N>,
        [(one, asked_one), (two, asked_two)]: [(Measured<N>, [Duty; N]); 2],
        driven: Driven,
        counts: [i32; N],
    ) -> Option<Fault> {
        let (least, most) = self.supply_mv;
        state.supply_is_wrong = two.supply_mv < least || two.supply_mv > most;
        let lasts = state.supply.spent(state.supply_is_wrong, self.lasts);
        state.thermistor = two.thermistor;
        let hot = state.hot.spent(two.thermistor >= thermal::HOT, self.lasts);
        let hot = hot.then_some(if two.thermistor > thermal::HOT { Fault::Thermistor } else { Fault::MotorTooWarm });
        state.on = if driven == Driven::Off { 0 } else { state.on.saturating_add(1) };
        let compared = if driven != Driven::Probed && state.on > self.settles { driven } else { Driven::Off };
        // V per count of the sum of two means of voltages: half of the mean supply over all of its counts.
        let supply = S::from_i32(i32::from(one.supply_mv) + i32::from(two.supply_mv));
        let volts = supply.ratio(S::from_i32(4000 * i32::from(two.supply_counts)));
        // Nine tenths of the most, which is 0.95 of the supply.
        let limit = (7 * i32::from(two.supply_counts)) >> 3;
        let (mut conducts, mut warmth, mut fault) = (false, S::ZERO, None);
        let flows = one.motors.iter().zip(&two.motors);
        let asked = asked_one.iter().zip(&asked_two).map(|(one, two)| [one.0, two.0]);
        for ((motor, (one, two)), (asked, counts)) in
            state.motors.iter_mut().zip(flows).zip(asked.zip(counts)).take(self.axes)
        {
            conducts |= i32::from(one.mean).abs().min(i32::from(two.mean).abs()) > self.zero;
            let moved = counts.wrapping_sub(core::mem::replace(&mut motor.counts, counts));
            let voltage = i32::from(one.voltage) + i32::from(two.voltage);
            let pair = Pair {
                codes: i32::from(one.mean) + i32::from(two.mean),
                ends: [one, two].map(|flow| i32::from(flow.last).abs() >= self.end),
                last: two.last,
                asked,
                volts: S::from_i32(voltage) * volts,
                pushes: [one, two]
                    .map(|flow| i32::from(flow.voltage))
                    .into_iter()
                    .filter(|volts| volts.abs() >= limit)
                    .sum(),
                emf: S::from_i32(moved) * self.emf,
            };
            fault = fault.or(self.motor(motor, &pair, compared));
            warmth = warmth.max(motor.heat.mean);
        }
        state.warmth = warmth;
        if driven == Driven::Off {
            state.supply = Patience::default();
            return state.conducts.spent(conducts, self.lasts).then_some(Fault::CurrentSensor).or(hot);
        }
        state.conducts = Patience::default();
        fault.or(hot).or(lasts.then_some(Fault::SupplyOutOfRange))
    }

    /// What is wrong with one motor that is on.
    #[inline(always)]
    fn motor(&self, motor: &mut Motor<S>, pair: &Pair<S>, driven: Driven) -> Option<Fault> {
        let current = S::from_i32(pair.codes) * self.amperes;
        let warm = self.thermal.is_too_warm(&mut motor.heat, current);
        let [one, two] = pair.asked.map(i32::from);
        let changes = (two - one).abs() + (one - i32::from(motor.asked)).abs();
        let ohmic = current * self.ohms;
        let inductive = S::from_i32(i32::from(pair.last) - i32::from(motor.last)) * self.inductive;
        (motor.asked, motor.last) = (pair.asked[1], pair.last);
        if driven == Driven::Off {
            [motor.error, motor.error_borne, motor.residual, motor.residual_borne] = [S::ZERO; 4];
        } else {
            let error = pair.codes - one - two;
            let slew = (changes * self.lags) >> 4;
            let borne = self.strays + ((one.abs() + two.abs()) >> 3) + slew;
            // At its limit against what is missing: the supply has no more, if the voltage goes into speed, which r says.
            let whole = driven == Driven::Whole;
            let missed = if whole && pair.pushes.signum() == -error.signum() { 0 } else { error };
            motor.error = self.leaky.after(motor.error, S::from_i32(missed));
            motor.error_borne = self.peak(motor.error_borne, S::from_i32(borne));
            let residual = pair.volts - ohmic - inductive - pair.emf;
            let borne_v = self.tolerance
                + (ohmic.abs() + ohmic.abs() + pair.emf.abs()) * self.eighth
                + inductive.abs() * self.half;
            motor.residual = self.leaky.after(motor.residual, residual);
            motor.residual_borne = self.peak(motor.residual_borne, borne_v);
            let astray = whole && motor.residual.abs() > motor.residual_borne;
            let late = motor.error.abs() > motor.error_borne;
            if astray || late {
                return Some(if pair.ends[1] {
                    Fault::CurrentSensor
                } else if late || (error.abs() > NOISE + slew && 2 * error.abs() > (one + two).abs()) {
                    Fault::CurrentNotFollowed
                } else {
                    Fault::EncoderImplausible
                });
            }
        }
        if pair.ends == [true; 2] { Some(Fault::CurrentSensor) } else { warm.then_some(Fault::MotorTooWarm) }
    }

    /// What is tolerated grows at once, and is forgotten as the means are.
    #[inline(always)]
    fn peak(&self, before: S, now: S) -> S {
        now.max(self.leaky.after(before, now))
    }
}

/// Two ticks of one motor.
struct Pair<S> {
    /// Sum of both means.
    codes: i32,
    /// The ticks that ended with the sensor at its end.
    ends: [bool; 2],
    last: i16,
    asked: [i16; 2],
    /// Mean voltage, and the back-EMF that the encoder shows, V.
    volts: S,
    emf: S,
    /// The voltages that are at their limit.
    pushes: i32,
}
