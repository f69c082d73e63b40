//! The first minutes with a device, in ten steps, as the bring-up of a board: the smallest force first, none over a step that failed.
//!
//! | step | passes if |
//! |---|---|
//! | answers | it tells new places, at least [`LEAST_RATE`] of them a second, none older than readings may be |
//! | fit | it is homed, has the axes, gives the force of these steps, and lets go by itself |
//! | still | held still, it tells a place within [`CREEP_M`], at rest |
//! | scale | moved by a known distance along an axis, it tells that, along that axis, that way |
//! | speed | the speeds that it told meanwhile add up to that distance |
//! | watchdog | pushed with [`PUSH_N`] and then not spoken to at all, it has let go, by its own word |
//! | sign | pushed along each axis, both ways, the hand goes that way |
//! | lets go | told to, it has let go, by its own word |
//! | tick | with a peer that hangs, the adapter makes it let go |
//! | hold | on a soft spring where it is, it stays there |
//!
//! The forces are [`PUSH_N`] at most, and a hand that is further than [`TRAVEL_M`] from where a push began ends the step with the motors off.

use std::time::{Duration, Instant};

pub use cohold_board_tools::bringup::Passed;

use super::{AXES, Port, Sensed};
use crate::Error;
use crate::endpoint::realtime;

/// What the steps push with, N.
pub const PUSH_N: f64 = 0.3;
/// Fewest new places in a second.
pub const LEAST_RATE: f64 = 100.0;
/// How far a hand that holds still may be from where it began, m.
pub const CREEP_M: f64 = 0.002;
/// How far a push may move it, m.
pub const TRAVEL_M: f64 = 0.02;
const TICK: Duration = Duration::from_millis(1);
/// How long it is let go of between two pushes, and how long it may take to tell where it is then.
const REST: Duration = Duration::from_millis(200);
const RETURNS: Duration = Duration::from_secs(2);
/// How far off the distance may be that is told, and the sum of its speeds, as a share.
const SCALE_OFF: f64 = 0.2;
const SPEED_OFF: f64 = 0.1;
/// A push both ways has to move the hand at least so far, m.
const MOVES_M: f64 = 1e-4;
/// Of the spring of the last step: N/m, N·s/m.
const SPRING: [f64; 2] = [100.0, 1.0];
/// What is left of a torque or a force that has let go, as a share of what acted.
const LEFT: f64 = 0.05;
const NAMES: [&str; AXES] = ["x", "y", "z"];

/// Asks the person at the device for something, and returns when it is done.
pub type Please<'a> = &'a (dyn Fn(&str) -> Result<(), Error> + Sync);

/// What is tried.
pub struct Trial<'a> {
    /// The device.
    pub port: &'a mut dyn Port,
    /// The person.
    pub please: Please<'a>,
    /// How many of its axes are used.
    pub axes: usize,
    /// A reading may be this old.
    pub silent: Duration,
    /// By how much the person moves it, m.
    pub distance_m: f64,
    /// What the person's move told, m: along each axis, and by its speeds.
    moved: [f64; 2],
    /// Slowest answer of the first step.
    slowest: Duration,
}

/// Whether a number is one, and no further from 0 than this.
fn within(number: f64, most: f64) -> bool {
    number.is_finite() && number.abs() <= most
}

type Step<'a> = (&'static str, fn(&mut Trial<'a>) -> Result<String, Error>);

impl<'a> Trial<'a> {
    /// A trial of this device.
    pub fn new(port: &'a mut dyn Port, please: Please<'a>, axes: usize, silent: Duration, distance_m: f64) -> Self {
        Self { port, please, axes, silent, distance_m, moved: [0.0; 2], slowest: Duration::ZERO }
    }

    /// The ticks that an answer takes, 1 at least: what a tick sends, the next one reads.
    pub fn delay_ticks(&self) -> f64 {
        (self.slowest.as_secs_f64() / TICK.as_secs_f64()).ceil().max(1.0)
    }

    /// Goes through the steps, and tells `each` that passes. The thread gets a real-time priority where the system gives one.
    ///
    /// # Errors
    /// The first that does not pass, and what was seen; the motors are off then.
    pub fn run(&mut self, mut each: impl FnMut(&Passed)) -> Result<Vec<Passed>, Error> {
        let steps: [Step<'a>; 10] = [
            ("answers", Self::answers),
            ("fit", Self::fit),
            ("still", Self::still),
            ("scale", Self::scale),
            ("speed", Self::speed),
            ("watchdog", Self::watchdog),
            ("sign", Self::sign),
            ("lets go", Self::lets_go),
            ("tick", Self::hangs),
            ("hold", Self::hold),
        ];
        // It drives the device once a millisecond, as a peer's tick does.
        realtime();
        let mut passed = Vec::new();
        for (number, (step, does)) in (1..).zip(steps) {
            let seen = does(self).map_err(|why| {
                self.port.write(None);
                Error::from(format!("step {number}, {step}: {why}"))
            })?;
            self.port.write(None);
            let row = Passed { step, seen };
            each(&row);
            passed.push(row);
        }
        Ok(passed)
    }

    /// A tick with this force: the newest reading, which has to be there.
    fn tick(&mut self, force_n: Option<[f64; AXES]>) -> Result<Sensed, Error> {
        self.port.write(force_n);
        std::thread::sleep(TICK);
        let sensed = self.port.read().map_err(|gone| gone.to_string())?.ok_or("it has told no place")?;
        let age = sensed.between[0].elapsed();
        cohold_sim::refuse_if!(age > self.silent, "its newest place is {:.0} ms old", 1e3 * age.as_secs_f64());
        Ok(sensed)
    }

    /// Ticks for so long with the force that `force` makes of the way from where it began (m) and of the speed (m/s): all readings.
    fn ticks(
        &mut self,
        time: Duration,
        mut force: impl FnMut([f64; AXES], [f64; AXES]) -> Option<[f64; AXES]>,
    ) -> Result<Vec<Sensed>, Error> {
        let first = self.tick(None)?;
        let (until, mut seen) = (Instant::now() + time, vec![first]);
        while Instant::now() < until {
            let newest = seen[seen.len() - 1];
            let way_m = std::array::from_fn(|axis| newest.position_m[axis] - first.position_m[axis]);
            let order = force(way_m, newest.velocity_m_per_s);
            if let Some(far_m) = way_m.into_iter().find(|way_m| order.is_some() && !within(*way_m, TRAVEL_M)) {
                return Err(format!("a push of {PUSH_N} N moved it by {:.1} mm", 1e3 * far_m).into());
            }
            seen.push(self.tick(order)?);
        }
        Ok(seen)
    }

    /// A push along an axis, for so long.
    fn push(&mut self, axis: usize, force_n: f64, time: Duration) -> Result<Vec<Sensed>, Error> {
        let order = std::array::from_fn(|at| if at == axis { force_n } else { 0.0 });
        self.ticks(time, |_, _| Some(order))
    }

    fn answers(&mut self) -> Result<String, Error> {
        let by = Instant::now() + Duration::from_secs(2);
        // The first may take a while.
        while self.port.read().map_err(|gone| gone.to_string())?.is_none() && Instant::now() < by {
            self.port.write(None);
            std::thread::sleep(TICK);
        }
        let seen = self.ticks(Duration::from_secs(1), |_, _| None)?;
        let news: Vec<_> = seen.windows(2).filter(|two| two[0].between != two[1].between).map(|two| two[1]).collect();
        let mut trips: Vec<_> =
            news.iter().map(|news| news.between[1].saturating_duration_since(news.between[0])).collect();
        trips.sort_unstable();
        let (count, middle) = (trips.len(), trips.get(trips.len() / 2).copied().unwrap_or_default());
        self.slowest = trips.get(trips.len() * 99 / 100).copied().unwrap_or_default();
        cohold_sim::refuse_if!((count as f64) < LEAST_RATE, "{count} new places in a second, of {LEAST_RATE} at least");
        let [middle_us, slow_us] = [middle, self.slowest].map(|trip| 1e6 * trip.as_secs_f64());
        Ok(format!("{count} new places in a second; an answer takes {middle_us:.0} µs, and one in 100 {slow_us:.0} µs"))
    }

    fn fit(&mut self) -> Result<String, Error> {
        let can = self.port.abilities();
        let name = &can.name;
        cohold_sim::refuse_if!(can.axes < self.axes, "{name} has {} axes, and {} are used", can.axes, self.axes);
        cohold_sim::refuse_if!(!can.is_homed, "{name} is not homed");
        cohold_sim::refuse_if!(
            can.max_force_n.is_some_and(|most_n| most_n < PUSH_N),
            "{name} gives less than {PUSH_N} N"
        );
        let lets_go_s = can
            .lets_go_s
            .ok_or_else(|| format!("nobody knows how long {name} holds a force after the last command"))?;
        let most = can
            .max_force_n
            .map_or_else(|| "does not say how much force it gives".to_owned(), |n| format!("gives {n:.1} N"));
        Ok(format!("{name}: {} axes, {most}, lets go within {:.0} ms", can.axes, 1e3 * lets_go_s))
    }

    fn still(&mut self) -> Result<String, Error> {
        (self.please)("hold the hand still, loosely")?;
        let seen = self.ticks(Duration::from_millis(500), |_, _| None)?;
        let spread = |of: fn(&Sensed) -> [f64; AXES]| {
            let along = |axis: usize| seen.iter().map(move |sensed| of(sensed)[axis]);
            let ends = |axis: usize| {
                [along(axis).fold(f64::INFINITY, f64::min), along(axis).fold(f64::NEG_INFINITY, f64::max)]
            };
            (0..self.axes).map(ends).fold(0.0, |most: f64, [least, largest]| most.max(largest - least))
        };
        let (place_m, speed) = (spread(|sensed| sensed.position_m), spread(|sensed| sensed.velocity_m_per_s));
        cohold_sim::refuse_if!(!within(place_m, CREEP_M), "its place goes to and fro by {:.2} mm", 1e3 * place_m);
        Ok(format!("its place goes to and fro by {:.3} mm, its speed by {speed:.3} m/s", 1e3 * place_m))
    }

    fn scale(&mut self) -> Result<String, Error> {
        let (asked_mm, please) = (1e3 * self.distance_m, self.please);
        let seen = std::thread::scope(|scope| {
            let task = format!("move the hand by {asked_mm:.0} mm toward +x of the device, and hold it there");
            let asks = scope.spawn(move || please(&task));
            let mut seen = vec![self.tick(None)?];
            while !asks.is_finished() {
                seen.push(self.tick(None)?);
            }
            asks.join().map_err(|_| Error::from("nobody answers".to_owned()))??;
            Ok::<_, Error>(seen)
        })?;
        let way = |axis: usize| seen[seen.len() - 1].position_m[axis] - seen[0].position_m[axis];
        // The speed that is told holds until the next one is.
        let sum = seen.windows(2).map(|two| {
            let took = two[1].between[1].saturating_duration_since(two[0].between[1]).as_secs_f64();
            0.5 * took * (two[0].velocity_m_per_s[0] + two[1].velocity_m_per_s[0])
        });
        self.moved = [way(0), sum.sum()];
        let aside_m = (1..self.axes).map(|axis| way(axis).abs()).fold(0.0, f64::max);
        let told_mm = 1e3 * self.moved[0];
        cohold_sim::refuse_if!(
            (told_mm / asked_mm + 1.0).abs() <= SCALE_OFF,
            "moved toward +x it reported {told_mm:.1} mm: its x points the other way"
        );
        cohold_sim::refuse_if!(
            !within(told_mm / asked_mm - 1.0, SCALE_OFF) || aside_m > 0.5 * self.distance_m,
            "moved by {asked_mm:.0} mm along x it reported {told_mm:.1} mm, and {:.1} mm aside",
            1e3 * aside_m
        );
        Ok(format!("moved by {asked_mm:.0} mm it reported {told_mm:.1} mm, and {:.1} mm aside", 1e3 * aside_m))
    }

    fn speed(&mut self) -> Result<String, Error> {
        let [way_mm, sum_mm] = self.moved.map(|moved| 1e3 * moved);
        let seen = format!("its speeds add up to {sum_mm:.1} mm, its places to {way_mm:.1} mm");
        if within(sum_mm / way_mm - 1.0, SPEED_OFF) { Ok(seen) } else { Err(seen.into()) }
    }

    /// What acts now, by its own word, after so long a silence.
    fn acts(&mut self, silence: Duration) -> Result<f64, Error> {
        let acts = self.port.stay_silent(silence).map_err(|gone| gone.to_string())?;
        acts.ok_or_else(|| "it does not say what force acts".into())
    }

    /// Pushes, and has the device say that it does; then `end`, after which it must not any more.
    fn no_more(&mut self, end: impl FnOnce(&mut Self) -> Result<f64, Error>) -> Result<[f64; 2], Error> {
        self.push(0, PUSH_N, Duration::from_millis(50))?;
        let pushes = self.acts(Duration::ZERO)?;
        self.push(0, PUSH_N, Duration::from_millis(50))?;
        let left = end(self)?;
        cohold_sim::refuse_if!(
            pushes == 0.0 || left > LEFT * pushes,
            "pushing, {pushes:.4} acted by its own word; {left:.4} still acts"
        );
        Ok([pushes, left])
    }

    fn watchdog(&mut self) -> Result<String, Error> {
        let silence = Duration::from_secs_f64(self.port.abilities().lets_go_s.unwrap_or_default()) + 20 * TICK;
        let silence_ms = 1e3 * silence.as_secs_f64();
        let task = format!(
            "the device pushes from here on, with up to {PUSH_N} N. Keep the switch of its supply within reach. Hold its hand loosely, or release it"
        );
        (self.please)(&task)?;
        self.rest()?;
        let [pushes, left] = self
            .no_more(|this| this.acts(silence))
            .map_err(|why| format!("{why}, {silence_ms:.0} ms after the last word to it"))?;
        // What it was silent for is over: it has to come back without a force.
        self.rest()?;
        Ok(format!("of {pushes:.4}, {left:.4} was left after {silence_ms:.0} ms of silence"))
    }

    /// Lets go for a while, whatever was before, and for as long as it takes until the device tells a place again: a line that was silent may have
    /// to come up first.
    fn rest(&mut self) -> Result<(), Error> {
        let begun = Instant::now();
        loop {
            self.port.write(None);
            std::thread::sleep(TICK);
            let told = self.port.read().map_err(|gone| gone.to_string())?;
            if begun.elapsed() >= REST && told.is_some_and(|told| told.between[0] >= begun) {
                return Ok(());
            }
            cohold_sim::refuse_if!(
                begun.elapsed() >= RETURNS,
                "after its release it reported no new position for {} s",
                RETURNS.as_secs()
            );
        }
    }

    fn sign(&mut self) -> Result<String, Error> {
        let mut seen = Vec::new();
        for (axis, name) in NAMES.into_iter().enumerate().take(self.axes) {
            let mut ends = [0.0; 2];
            for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                let pushed = self.push(axis, sign * PUSH_N, Duration::from_millis(150))?;
                *end = pushed[pushed.len() - 1].position_m[axis] - pushed[0].position_m[axis];
                self.rest()?;
            }
            let by_mm = 0.5e3 * (ends[0] - ends[1]);
            cohold_sim::refuse_if!(
                by_mm < -0.5e3 * MOVES_M,
                "pushed toward +{name} it went toward −{name}, by {:.2} mm: the sign of its force is wrong",
                -by_mm
            );
            cohold_sim::refuse_if!(
                within(by_mm, 0.5e3 * MOVES_M),
                "pushed along {name} with {PUSH_N} N it did not move"
            );
            seen.push(format!("{name} by {by_mm:.2} mm"));
        }
        Ok(format!("{PUSH_N} N move it along {}", seen.join(", ")))
    }

    fn lets_go(&mut self) -> Result<String, Error> {
        let [pushes, left] = self.no_more(|this| {
            this.port.write(None);
            std::thread::sleep(20 * TICK);
            this.acts(Duration::ZERO)
        })?;
        Ok(format!("of {pushes:.4}, {left:.4} was left 20 ms after the order to release"))
    }

    fn hangs(&mut self) -> Result<String, Error> {
        let hung = self.silent + 20 * TICK;
        let [pushes, left] = self.no_more(|this| {
            std::thread::sleep(hung);
            this.acts(Duration::ZERO)
        })?;
        let hung_ms = 1e3 * hung.as_secs_f64();
        Ok(format!("of {pushes:.4}, {left:.4} was left after {hung_ms:.0} ms without a tick"))
    }

    fn hold(&mut self) -> Result<String, Error> {
        let axes = self.axes;
        let [stiffness, damping] = SPRING;
        let seen = self.ticks(Duration::from_secs(1), |way_m, speed| {
            let force = |axis: usize| (-stiffness * way_m[axis] - damping * speed[axis]).clamp(-PUSH_N, PUSH_N);
            Some(std::array::from_fn(|axis| if axis < axes { force(axis) } else { 0.0 }))
        })?;
        let first = seen[0].position_m;
        let far =
            |sensed: &Sensed| (0..axes).map(|axis| (sensed.position_m[axis] - first[axis]).abs()).fold(0.0, f64::max);
        let far_mm = 1e3 * seen.iter().map(far).fold(0.0, f64::max);
        cohold_sim::refuse_if!(far_mm > 1e3 * CREEP_M, "on a spring of {stiffness} N/m it went {far_mm:.2} mm away");
        Ok(format!("on a spring of {stiffness} N/m it stayed within {far_mm:.2} mm"))
    }
}

#[cfg(test)]
#[path = "../../tests/inside/steps.rs"]
mod tests;
