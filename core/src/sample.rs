//! The quantities that can be recorded of a peer after a tick: each declared once, with name, unit and meaning.
//!
//! [`SAMPLE`] is the list. A board's record, recordings of every tick, tables of runs and what a step gives to Python
//! are views of it: none names a quantity again. To add one, add one line to `quantities!`, below.

use crate::law::ledger::Ledger;
use crate::num::Scalar;
use crate::peer::Observed;
use crate::safety::Mode;

/// The quantities of a peer as a whole after a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OfPeer {
    /// Control periods since the peer started, or since its recording began.
    pub tick: u64,
    /// Number of the mode ([`Mode::number`]): 0 disarmed, 1 armed, 2 faulted, 3 probing.
    pub mode: u8,
    /// Number of the latched fault ([`Mode::fault_number`]); 0 if there is none.
    pub fault: u8,
}

impl OfPeer {
    /// The quantities of a peer after `tick` control periods, in this mode.
    pub fn new(tick: u64, mode: Mode) -> Self {
        Self { tick, mode: mode.number(), fault: mode.fault_number() }
    }
}

/// The quantities of one shared axis of a peer after a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfAxis<'a, S> {
    /// Motions and forces of the tick.
    pub observed: &'a Observed<S>,
    /// Energy that came in from the network since arming, J.
    pub received_j: S,
    /// Energy that went out to the network since arming, J.
    pub sent_j: S,
}

impl<'a, S: Scalar> OfAxis<'a, S> {
    /// What a tick saw and did, with the energy account after it.
    #[inline(always)]
    pub fn new(observed: &'a Observed<S>, ledger: &Ledger<S>) -> Self {
        Self { observed, received_j: ledger.received_j(), sent_j: ledger.sent_j() }
    }
}

/// Where a quantity appears. The levels are nested: a quantity of a later level also appears in all those before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reach {
    /// In records of boards and in recordings, which keep every tick of one peer.
    Records,
    /// Also in tables of runs, which have both peers in a row.
    Runs,
    /// Also in what a step of two peers gives to Python.
    Steps,
}

/// One quantity of a peer or of an axis; `G` is the function that reads it.
#[derive(Clone, Copy, Debug)]
pub struct Quantity<G> {
    /// Name of the quantity, which ends in its unit; also the name of its column.
    pub name: &'static str,
    /// Unit in symbols; empty if the quantity has none.
    pub unit: &'static str,
    /// What the quantity means, as the description of its column.
    pub meaning: &'static str,
    /// Index of the word of a board's record that holds it; mode and fault share one. Records are in this order.
    pub word: usize,
    /// Where the quantity appears.
    pub reach: Reach,
    /// The function that reads the quantity, in its unit.
    pub get: G,
}

/// A quantity of the peer as a whole.
pub type PeerQuantity = Quantity<fn(&OfPeer) -> f64>;

/// A quantity of each shared axis.
pub type AxisQuantity = Quantity<fn(&OfAxis<'_, f64>) -> f64>;

impl<G> Quantity<G> {
    /// Name and meaning, as a column has them.
    pub const fn named(&self) -> (&'static str, &'static str) {
        (self.name, self.meaning)
    }
}

/// A list of quantities.
#[derive(Clone, Copy, Debug)]
pub struct Quantities {
    /// Quantities of the peer as a whole.
    pub peer: &'static [PeerQuantity],
    /// Quantities of each shared axis, in the column order of tables of runs.
    pub axis: &'static [AxisQuantity],
    /// The same quantities of an axis, in the order of a board's record.
    pub recorded: &'static [AxisQuantity],
}

impl Quantities {
    /// Quantities of an axis that appear at this level, in the column order of tables of runs.
    pub fn reaching(&self, reach: Reach) -> impl Iterator<Item = &'static AxisQuantity> + Clone + use<> {
        self.axis.iter().filter(move |quantity| quantity.reach >= reach)
    }

    /// Number of the quantities of an axis that appear at this level.
    pub const fn count(&self, reach: Reach) -> usize {
        let (mut rest, mut count) = (self.axis, 0);
        while let [first, others @ ..] = rest {
            (rest, count) = (others, count + (first.reach as usize >= reach as usize) as usize);
        }
        count
    }

    /// Word of the axis quantity with this name; panics, in a constant when it is compiled, if there is none.
    pub const fn word(&self, name: &str) -> usize {
        let mut rest = self.axis;
        while let [first, others @ ..] = rest {
            if same(first.name, name) {
                return first.word;
            }
            rest = others;
        }
        panic!("no quantity has this name")
    }

    /// Number of columns of a recording of one axis: quantities of the peer, and of that axis.
    pub const fn columns(&self) -> usize {
        self.peer.len() + self.axis.len()
    }

    /// Values of the quantities of the peer as a whole, in their order.
    pub fn of_peer(&self, peer: OfPeer) -> impl Iterator<Item = f64> + use<> {
        self.peer.iter().map(move |quantity| (quantity.get)(&peer))
    }
}

/// Whether two names are equal; usable in constants, where `==` of text is not.
pub const fn same(one: &str, other: &str) -> bool {
    let (mut one, mut other) = (one.as_bytes(), other.as_bytes());
    while let ([first, rest @ ..], [second, others @ ..]) = (one, other) {
        if *first != *second {
            return false;
        }
        (one, other) = (rest, others);
    }
    one.is_empty() && other.is_empty()
}

/// The quantities in the order of a board's record; for `quantities_of!`, at compile time.
#[doc(hidden)]
pub const fn by_word<const N: usize>(mut list: [AxisQuantity; N]) -> [AxisQuantity; N] {
    let mut at = 1;
    while at < N {
        let mut to = at;
        while to > 0 && list[to].word < list[to - 1].word {
            (list[to - 1], list[to]) = (list[to], list[to - 1]);
            to -= 1;
        }
        at += 1;
    }
    list
}

/// Every quantity: word of the record, name, unit, how far it goes, meaning, where it is read. `more` are lines for the end of the list.
#[doc(hidden)]
#[macro_export]
macro_rules! quantities {
    ($($more:tt)*) => {
        $crate::quantities_of! {
            peer {
                0 tick "" Records: "control periods since the recording began; of a board since it started", |peer| peer.tick as f64;
                3 mode "" Records: "0 disarmed, 1 armed, 2 faulted, 3 a board that probes its motors", |peer| peer.mode as f64;
                3 fault "" Records: "number of the fault, 0 none", |peer| peer.fault as f64;
            }
            axis {
                7 device_m "m" Steps: "position of the device", |axis| axis.observed.device.position;
                9 object_m "m" Steps: "position of this peer's copy of the object", |axis| axis.observed.object.position;
                11 decoded_m "m" Steps: "where the peer believes the other copy to be, x_d", |axis| axis.observed.desired.position;
                8 device_m_per_s "m/s" Records: "velocity of the device, as the peer measures it", |axis| axis.observed.device.velocity;
                10 object_m_per_s "m/s" Steps: "velocity of this copy", |axis| axis.observed.object.velocity;
                12 decoded_m_per_s "m/s" Records: "how fast the peer believes the other copy to move", |axis| axis.observed.desired.velocity;
                13 contact_n "N" Steps: "contact force F_LC on the copy", |axis| axis.observed.contact_force;
                14 coordination_n "N" Steps: "coordination force F_T on the copy", |axis| axis.observed.coordination_force;
                16 energy_received_j "J" Runs: "energy that came in from the network, since arming", |axis| axis.received_j;
                17 energy_sent_j "J" Runs: "energy that went out to the network, since arming", |axis| axis.sent_j;
                $($more)*
            }
        }
    };
}

/// Makes a list of quantities, and what walks over it in any number type.
#[doc(hidden)]
#[macro_export]
macro_rules! quantities_of {
    (
        peer { $($in:literal $whole:ident $of:literal $far:ident: $means:literal, |$peer:ident| $read:expr;)+ }
        axis { $($word:literal $name:ident $unit:literal $reach:ident: $meaning:literal, |$axis:ident| $get:expr;)+ }
    ) => {
        /// Every quantity of a peer after a tick.
        pub const SAMPLE: $crate::sample::Quantities = {
            static PEER: [$crate::sample::PeerQuantity; [$($in),+].len()] = [$($crate::sample::Quantity {
                name: stringify!($whole),
                unit: $of,
                meaning: $means,
                word: $in,
                reach: $crate::sample::Reach::$far,
                get: |$peer: &$crate::sample::OfPeer| $read,
            }),+];
            static AXIS: [$crate::sample::AxisQuantity; [$($word),+].len()] = [$($crate::sample::Quantity {
                name: stringify!($name),
                unit: $unit,
                meaning: $meaning,
                word: $word,
                reach: $crate::sample::Reach::$reach,
                get: |$axis: &$crate::sample::OfAxis<'_, f64>| $get,
            }),+];
            static RECORDED: [$crate::sample::AxisQuantity; [$($word),+].len()] = $crate::sample::by_word(AXIS);
            $crate::sample::Quantities { peer: &PEER, axis: &AXIS, recorded: &RECORDED }
        };

        /// Gives `put` every quantity of an axis, with its word of a board's record. It is called by the interrupt: nothing is looked up.
        #[inline(always)]
        pub fn each<S: $crate::num::Scalar>(axis: &$crate::sample::OfAxis<'_, S>, mut put: impl FnMut(usize, S)) {
            $({
                let $axis = axis;
                put($word, $get);
            })+
        }
    };
}

quantities! {}
