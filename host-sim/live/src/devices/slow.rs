//! A device that is asked in plain calls, slowly: what a program in another language gives for its device.
//!
//! At most [`MOST_HZ`] times a second, in a thread of its own: it is asked where it is, and two ticks later, when a peer at 1 kHz has answered
//! that, given the force. A call that takes longer makes the readings older, and one that fails or does not come back ends as with any other
//! device ([`super::Attached`]): the force fades from half of the allowed silence on, then the motors are off, and they stay off. What then
//! stands at the device itself is up to whoever wrote it, and to how long it says that it holds a force.
//!
//! **Limits.** A force stands for a period, 5 ms: the stiffest wall that is passive is 2·b/T, so 200 N/m by each 0.5 N·s/m of the device's own
//! damping, and less by what the calls take. A live peer's verdict counts how old its readings are, and not for how long a force stands.

use std::time::{Duration, Instant};

use super::threaded::{Acts, Desk, Line, Threaded, stopped};
use super::{AXES, Abilities, Gone, Sensed};
use crate::Error;

/// Asked at most so often, Hz.
pub const MOST_HZ: f64 = 200.0;
const PERIOD: Duration = Duration::from_millis(5);
/// From its place to the force that answers it: two ticks of 1 ms.
const ANSWER: Duration = Duration::from_millis(2);

/// Along each axis of a device.
pub type Row = [f64; AXES];

/// What is asked of a device in plain calls, which may wait.
pub trait Asked: Send + 'static {
    /// Where it is along each axis, m, and how fast it moves, m/s; without that it is reckoned from one place to the next.
    ///
    /// # Errors
    /// It cannot say, and must not be driven any more.
    fn read(&mut self) -> Result<(Row, Option<Row>), String>;

    /// Takes the force along each axis, N; zeros let go.
    ///
    /// # Errors
    /// It did not take it, and must not be driven any more.
    fn write(&mut self, force_n: Row) -> Result<(), String>;
}

/// Begins to ask this device. An order that is not renewed for `silent` is no longer given.
///
/// # Errors
/// The system gives no thread.
pub fn open(abilities: Abilities, silent: Duration, device: impl Asked) -> Result<Threaded, Error> {
    Threaded::start(abilities, silent, Slow { device, due: Instant::now(), last: None })
}

struct Slow<A> {
    device: A,
    /// When it is asked next.
    due: Instant,
    /// Where it was, and when.
    last: Option<(Row, Instant)>,
}

impl<A: Asked> Line for Slow<A> {
    // Nobody knows what is called, nor for how long it computes.
    const PROMPT: bool = false;

    fn exchange(&mut self, desk: &Desk) -> Result<(), Gone> {
        sleep_until(self.due);
        let asked = Instant::now();
        self.due = asked + PERIOD;
        let (position_m, velocity) = self.device.read().map_err(stopped)?;
        let between = [asked, Instant::now()];
        let middle = asked + (between[1] - asked) / 2;
        let reckoned = self.last.map(|(last_m, then)| {
            let took_s = (middle - then).as_secs_f64();
            std::array::from_fn(|axis| (position_m[axis] - last_m[axis]) / took_s)
        });
        self.last = Some((position_m, middle));
        let velocity_m_per_s = velocity.or(reckoned).unwrap_or_default();
        desk.tell(Ok(Some(Sensed { position_m, velocity_m_per_s, between, buttons: 0 })));
        if !desk.ends() {
            sleep_until(between[1] + ANSWER);
            self.device.write(desk.wanted().unwrap_or_default()).map_err(stopped)?;
        }
        Ok(())
    }

    fn let_go(&mut self) {
        // Whoever does not take even this has been told why it is driven no more, or is going anyway.
        let _ = self.device.write(Row::default());
    }

    fn acts(&mut self) -> Acts {
        Ok(None)
    }
}

fn sleep_until(then: Instant) {
    std::thread::sleep(then.saturating_duration_since(Instant::now()));
}

#[cfg(test)]
#[path = "../../tests/inside/slow.rs"]
mod tests;
