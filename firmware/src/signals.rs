//! Every word that the 1 kHz interrupt and the tasks share, typed. What does not fit in a word goes through [`crate::exchange`].
//!
//! A word is loaded and stored whole: nobody sees half a value, and nothing here waits. Each is written from one priority only,
//! named beside it; where two are named, the tasks ask by it and the tick answers, or the other way round.
//!
//! Limit: order. Whoever reads by [`Word::acquire`] what was stored by [`Word::release`] also sees all that was done before it;
//! [`Word::get`] and [`Word::set`] say nothing about other memory.

use core::marker::PhantomData;
use core::sync::atomic::{AtomicU32, Ordering};

use cohold_core::safety::{Command, Mode};
use cohold_protocol::{link::Stage, record};

use crate::image::Trouble;
use crate::order::{ACQUIRE, RELEASE, kept};

/// What fits in a word.
pub trait Coded: Copy {
    /// As a number; a word that nothing was stored in is 0.
    fn code(self) -> u32;
    /// From such a number; any other means the same as one of them.
    fn decode(code: u32) -> Self;
}

/// As in a record.
impl Coded for Mode {
    #[inline]
    fn code(self) -> u32 {
        record::mode_code(self)
    }
    fn decode(code: u32) -> Self {
        record::mode_of_code(code)
    }
}

/// An order of the operator; its number tells it from the same command given again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order {
    number: u32,
    /// The command that was given.
    pub command: Command,
}

impl Order {
    /// The order after this one.
    pub fn next(self, command: Command) -> Self {
        Self { number: self.number.wrapping_add(1) & 0xFF_FFFF, command }
    }
}

/// Command in bits 0–7, number in bits 8–31.
impl Coded for Order {
    #[inline]
    fn code(self) -> u32 {
        self.number << 8 | self.command.code()
    }
    #[inline]
    fn decode(code: u32) -> Self {
        Self { number: code >> 8, command: Command::decode(code & 0xFF) }
    }
}

/// How the last save of settings stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saving {
    /// There was none, or it succeeded.
    Done,
    /// It is under way.
    Busy,
    /// It failed; what was saved before stands.
    Failed,
}

/// What the blue button says ([`crate::button`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// The button is released.
    Up,
    /// Somebody at the board holds it.
    Held,
    /// It has been down since before the board started.
    Stuck,
}

/// Numbers as they are, then enums by the numbers of their variants; any other number means the first.
macro_rules! coded {
    ($($number:ty: $decode:expr;)* $(enum $type:ty: $first:ident 0 $(, $other:ident $code:literal)*;)*) => {
        $(impl Coded for $number {
            #[inline]
            fn code(self) -> u32 {
                self.into()
            }
            #[inline]
            fn decode(code: u32) -> Self {
                $decode(code)
            }
        })*
        $(impl Coded for $type {
            #[inline]
            fn code(self) -> u32 {
                match self {
                    Self::$first => 0,
                    $(Self::$other => $code,)*
                }
            }
            #[inline]
            fn decode(code: u32) -> Self {
                match code {
                    $($code => Self::$other,)*
                    _ => Self::$first,
                }
            }
        })*
    };
}

coded! {
    u32: |code| code;
    bool: |code| code != 0;
    // A word that nobody ordered anything by could only disarm.
    enum Command: Disarm 0, Arm 1, Clear 2, Home 3, Clutch 4, Release 5;
    enum Saving: Done 0, Busy 1, Failed 2;
    enum Button: Up 0, Held 1, Stuck 2;
    enum Stage: Calling 0, Joining 1, Idle 2, Running 3, Fading 4, Refused 5;
}

/// A word that holds a `T`.
#[derive(Debug)]
pub struct Word<T>(AtomicU32, PhantomData<fn(T) -> T>);

impl<T: Coded> Word<T> {
    pub(crate) const fn zero() -> Self {
        Self(AtomicU32::new(0), PhantomData)
    }

    /// The value that it holds.
    pub fn get(&self) -> T {
        T::decode(self.0.load(Ordering::Relaxed))
    }

    /// Holds this from now on.
    pub fn set(&self, value: T) {
        self.0.store(value.code(), Ordering::Relaxed);
    }

    /// The value that it holds, loaded before anything that follows (acquire).
    pub fn acquire(&self) -> T {
        let code = self.0.load(ACQUIRE);
        kept();
        T::decode(code)
    }

    /// Whether it holds something else than another, before anything that follows is done.
    #[inline]
    pub fn differs(&self, other: &Self) -> bool {
        let code = self.0.load(ACQUIRE);
        kept();
        code != other.0.load(Ordering::Relaxed)
    }

    /// Holds this from now on, after all that came before is done.
    pub fn release(&self, value: T) {
        kept();
        self.0.store(value.code(), RELEASE);
    }
}

impl Word<Mode> {
    /// [`Word::set`] of the mode that has this code ([`record::mode_code`]).
    #[inline]
    pub fn set_code(&self, code: u32) {
        self.0.store(code, Ordering::Relaxed);
    }
}

impl Word<u32> {
    /// Adds one; wraps at 2³².
    #[inline]
    pub fn count(&self) {
        self.release(self.get().wrapping_add(1));
    }
}

/// Declares the words; all begin at 0.
macro_rules! signals {
    ($($name:ident: $type:ty, $meaning:literal;)*) => {
        /// All words that the interrupt and the tasks share.
        #[derive(Debug)]
        #[repr(C)]
        pub struct Signals {
            $(#[doc = $meaning] pub $name: Word<$type>,)*
        }

        impl Signals {
            /// As they are when power comes on.
            pub const fn at_power_on() -> Self {
                Self { $($name: Word::zero(),)* }
            }
        }
    };
}

signals! {
    saves: u32,
        "How often settings were saved; 0: nothing is there. By storage; the first word, where debuggers and \
         tests/board look.";
    saving: Saving, "By console and storage.";
    disarm: bool, "Motors off at the next tick, whatever else is going on. Set by tasks, cleared by the tick.";
    order: Order, "For the next packet boundary. By the console.";
    done: Order, "The last order carried out or withdrawn. By the tick.";
    begun: u32, "Number of the last probe begun. By the tick.";
    checked: bool, "The signs of every joint in use were checked and agree. By the tick.";
    emergency: bool, "The bridges went off by the emergency stop. Set by the tick, cleared by tasks.";
    life: u32,
        "How often the link has let go of the other peer: the tick lets go too, and takes nothing that came before. By \
         the network.";
    old: bool, "Flow comes, and is too old to be taken. By the network.";
    button: Button, "What the blue button said when it was last looked at. By the supervisor.";
    mode: Mode, "By the tick.";
    ticks: u32, "Ticks since boot. By the tick.";
    overruns: u32, "Ticks that were due before the one before them had ended. By the tick.";
    record_every: u32, "Every how-many-th tick leaves a record; 0: none. By telemetry.";
    drive: Trouble, "What stands against driving, of a drive that says so. By the tick.";
    drive_last: Trouble, "What such a drive was turned off for since it was last on. By the tick.";
    stage: Stage, "How far the link to the other peer is. By the network.";
    sent: u32, "Datagrams handed to the driver. By the network.";
    dropped: u32, "Datagrams dropped because the driver could not take them. By the network.";
    received: u32, "Datagrams taken in. By the network.";
    refused: u32, "Datagrams refused: not authentic, or of no use; on the operator's port too. By the network.";
    by_switch: bool, "Motors run only while the hold-to-run switch is held. By the console.";
    held: bool, "It is held. By the bell, after every tick.";
    released: bool, "The motors went off because it was released. Set by the bell, cleared by the console.";
}
