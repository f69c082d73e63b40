//! What adapters of devices that have to be waited for share: a thread of its own for each, and what it and the peer's tick exchange.
//!
//! The tick leaves an order and takes the newest reading; both locks are held for a copy, and the tick only tries them. The thread asks the
//! device once a tick, or after `BEAT` without one, by its [`Line`], at a real-time priority beneath the tick's where the system gives one.
//!
//! **Letting go.** An order that is older than readings may be is none. Whoever is dropped lets go first; a device that keeps its thread
//! waiting for longer than `PATIENCE` is left to it, and let go of when it answers. A process that is killed says
//! nothing more: that the device then lets go by itself is what [`Port::stay_silent`] tries.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, TryLockError};
use std::thread::{JoinHandle, park_timeout};
use std::time::{Duration, Instant};

use cohold_protocol::aged::Aged;
use cohold_sim::device::{DeviceFault, Gone};

use super::{AXES, Abilities, Health, Port, Sensed};
use crate::Error;
use crate::endpoint::realtime_beneath;

/// After so long without a tick of the peer the device is asked nevertheless.
const BEAT: Duration = Duration::from_millis(5);
/// How long whoever ends waits for the device to be let go of.
const PATIENCE: Duration = Duration::from_secs(1);
/// How long the line may take to say what acts after a silence.
const ANSWER: Duration = Duration::from_secs(2);

/// The device is driven no more, for this reason.
pub fn stopped(cause: impl ToString) -> Gone {
    Gone::new(DeviceFault::Stopped, cause)
}

/// What is asked of the device; none lets go.
type Order = Option<Aged<[f64; AXES], Instant>>;

/// What the thread and the peer's tick exchange.
pub struct Desk {
    order: Mutex<Order>,
    told: Mutex<Result<Option<Sensed>, Gone>>,
    health: Mutex<Health>,
    /// Until when nothing at all is said, and who wants to know what acts then.
    silence: Mutex<Option<(Instant, Sender<Acts>)>>,
    ends: AtomicBool,
    /// An order may be this old.
    silent: Duration,
}

/// The largest force or torque that the device itself says acts, N or N·m; none if it does not say.
pub type Acts = Result<Option<f64>, Gone>;

/// Leaves a value, unless whoever held the place has panicked.
fn put<T>(place: &Mutex<T>, value: T) {
    if let Ok(mut place) = place.lock() {
        *place = value;
    }
}

impl Desk {
    /// The force that is wanted now; none lets go.
    pub fn wanted(&self) -> Option<[f64; AXES]> {
        self.order.lock().ok()?.as_ref()?.within(Instant::now(), self.silent).copied()
    }

    /// An order of before then is none.
    fn forget(&self, then: Instant) {
        if let Ok(mut order) = self.order.lock() {
            *order = order.filter(|order| order.at >= then);
        }
    }

    /// Keeps what the device told.
    pub fn tell(&self, told: Result<Option<Sensed>, Gone>) {
        put(&self.told, told);
    }

    /// Keeps how the device is.
    pub fn note(&self, health: Health) {
        put(&self.health, health);
    }

    /// The peer has ended.
    pub fn ends(&self) -> bool {
        self.ends.load(Ordering::Relaxed)
    }

    /// Who wants to know what acts, once nothing has been said for as long as was asked for.
    fn silenced(&self) -> Option<(Instant, Sender<Acts>)> {
        self.silence.lock().ok().and_then(|mut silence| silence.take())
    }
}

/// The thread's end of the line to a device.
pub trait Line: Send + 'static {
    /// Whether what it runs is short and our own, so that the thread may have a real-time priority.
    const PROMPT: bool = true;

    /// Says the force of now, and hears where the device was.
    ///
    /// # Errors
    /// The device must not be driven any more.
    fn exchange(&mut self, desk: &Desk) -> Result<(), Gone>;

    /// Lets go, without waiting for an answer.
    fn let_go(&mut self);

    /// Asks what acts without commanding anything.
    ///
    /// # Errors
    /// The device has gone.
    fn acts(&mut self) -> Acts;
}

/// A device with a thread of its own.
pub struct Threaded {
    abilities: Abilities,
    desk: Arc<Desk>,
    newest: Result<Option<Sensed>, Gone>,
    thread: Option<JoinHandle<()>>,
}

impl Threaded {
    /// Begins to ask the device. An order that is not renewed for `silent` is no longer given.
    pub fn start(abilities: Abilities, silent: Duration, line: impl Line) -> Result<Self, Error> {
        let desk = Arc::new(Desk {
            order: Mutex::new(None),
            told: Mutex::new(Ok(None)),
            health: Mutex::new(Health::default()),
            silence: Mutex::new(None),
            ends: AtomicBool::new(false),
            silent,
        });
        let (of_thread, name) = (desk.clone(), abilities.name.clone());
        let thread = std::thread::Builder::new().name("device".to_owned()).spawn(move || run(line, &of_thread));
        let thread = thread.map_err(|cause| format!("{name}: no thread: {cause}"))?;
        Ok(Self { abilities, desk, newest: Ok(None), thread: Some(thread) })
    }

    fn wake(&self) {
        if let Some(thread) = &self.thread {
            thread.thread().unpark();
        }
    }
}

fn run<L: Line>(mut line: L, desk: &Desk) {
    if L::PROMPT {
        realtime_beneath();
    }
    while !desk.ends() {
        park_timeout(BEAT);
        if let Some((until, asks)) = desk.silenced() {
            std::thread::sleep(until.saturating_duration_since(Instant::now()));
            let acts = line.acts();
            // What was wanted before a silence is not wanted after it.
            desk.forget(until);
            let _ = asks.send(acts);
        }
        if let Err(gone) = line.exchange(desk) {
            desk.tell(Err(gone));
            break;
        }
    }
    // Whoever has gone is asked to let go as well.
    line.let_go();
}

impl Port for Threaded {
    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn read(&mut self) -> Result<Option<Sensed>, Gone> {
        match self.desk.told.try_lock() {
            Ok(told) => self.newest.clone_from(&told),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Poisoned(_)) => self.newest = Err(stopped("its thread has failed")),
        }
        self.newest.clone()
    }

    fn write(&mut self, force_n: Option<[f64; AXES]>) {
        // Where the thread is just reading the order, it takes the next one, a tick later.
        if let Ok(mut order) = self.desk.order.try_lock() {
            *order = force_n.map(|force_n| Aged::new(force_n, Instant::now()));
        }
        self.wake();
    }

    fn health(&self) -> Option<Health> {
        self.desk.health.try_lock().ok().map(|health| *health)
    }

    fn stay_silent(&mut self, time: Duration) -> Result<Option<f64>, Gone> {
        let (asks, answer): (_, Receiver<Acts>) = channel();
        put(&self.desk.silence, Some((Instant::now() + time, asks)));
        let acts = answer.recv_timeout(time + ANSWER);
        acts.map_err(|_| stopped("it did not answer after it was not spoken to"))?
    }
}

impl Drop for Threaded {
    fn drop(&mut self) {
        self.desk.ends.store(true, Ordering::Relaxed);
        self.wake();
        let Some(thread) = self.thread.take() else { return };
        let by = Instant::now() + PATIENCE;
        while !thread.is_finished() && Instant::now() < by {
            std::thread::sleep(Duration::from_millis(1));
        }
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}
