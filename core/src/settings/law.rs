//! A coordination law, as settings and reports know it, and values of the keys that it declares itself.

use super::{Allowed, Key, Refused, Setting, Value};

/// The packets of a law, by what they carry and so what the law acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sends {
    /// It sends no packets.
    Nothing,
    /// Position and velocity of its copy of the object (power-domain).
    Motion,
    /// Waves, or sums of them: the ends of a line of `coordination.wave_impedance_n_s_per_m`.
    Waves,
}

/// What a coordination law promises, with the decode and the integrator that it asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Promise {
    /// No more energy leaves the link than came in, as long as nothing is lost and the delay stays what it is.
    PassiveOnConstantDelay,
    /// No more energy leaves the link than came in, and was stored when it began, whatever the network does.
    Passive,
    /// Once the network has recovered and nobody pushes, the copies come back to where they began beside each other.
    NoDrift,
}

impl Promise {
    /// The promise in words, for reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PassiveOnConstantDelay => "passive on a constant delay",
            Self::Passive => "passive on any network",
            Self::NoDrift => "no drift",
        }
    }
}

/// A coordination law, as settings and reports know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LawInfo {
    /// Name of the law: the value of `coordination.comm` that selects it.
    pub name: &'static str,
    /// The kind of packet it sends.
    pub sends: Sends,
    /// Keys that only this law has.
    pub keys: &'static [Key],
    /// Settings (`key=value`) with which campaigns and figures run the law: gains that are worth trying.
    pub gains: &'static [&'static str],
    /// Source of the law: authors, year, equation; or the section of docs/reference/theory.md (THEORY). Empty if there is none.
    pub source: &'static str,
    /// Promises of the law, which tests hold it to.
    pub promises: &'static [Promise],
    /// Each of its waves has all of its energy with it: a ledger can pay for it, and lines of such waves can meet in a node.
    pub scatters: bool,
    /// Its line has a time of its own, in ticks that the other end brings: it learns its length, stands while nothing comes, loses
    /// nothing by that, and meets others in a copy at a hub.
    pub own_time: bool,
    /// Both ends compute the same.
    pub ends_alike: bool,
    /// It learns from how the other copy moves; a linear scene of it does not.
    pub learns: bool,
    /// A name that it had before, so that who uses it is told the new one.
    pub formerly: &'static str,
}

/// Energy that no run exhausts, J: the largest value of a law's own key that limits how much energy it may spend.
pub const PLENTY_J: f64 = 1e9;

impl LawInfo {
    /// What a law that sends motion leaves out of its own: `LawInfo { name: "predict", ..LawInfo::MOTION }`.
    pub const MOTION: Self = Self {
        name: "",
        sends: Sends::Motion,
        keys: &[],
        gains: &[],
        source: "",
        promises: &[],
        scatters: false,
        own_time: false,
        ends_alike: true,
        learns: false,
        formerly: "",
    };
    /// The same for a law that sends waves as they are.
    pub const WAVES: Self = Self { sends: Sends::Waves, scatters: true, ..Self::MOTION };

    /// Its keys that limit how much energy it may spend. At [`PLENTY_J`] they limit nothing (linear analysis).
    pub fn budgets(&self) -> impl Iterator<Item = &'static Key> {
        let is_budget = |key: &&Key| matches!(key.allowed, Allowed::Number { max, .. } if max == PLENTY_J);
        self.keys.iter().filter(is_budget)
    }
}

/// Most keys of laws that may differ from their defaults at once.
pub const MOST_OWN_KEYS: usize = 11;

/// Values of laws' own keys where they are not the default, by name; numbers in bytes, which need no place of eight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnValues([Option<(&'static Key, [u8; 8])>; MOST_OWN_KEYS]);

impl OwnValues {
    pub(super) fn iter(&self) -> impl Iterator<Item = (&'static Key, f64)> {
        self.0.iter().flatten().map(|(key, number)| (*key, f64::from_ne_bytes(*number)))
    }

    pub(super) fn get(&self, key: &Key) -> f64 {
        self.iter().find(|(known, _)| known.name == key.name).map_or(key.default, |(_, number)| number)
    }

    /// Keeps a value, if the key accepts it and there is room.
    pub(crate) fn set<'a>(&mut self, key: &'static Key, value: Value<'a>) -> Result<(), Refused<'a>> {
        let number = match key.allowed {
            Allowed::Flag => bool::parse(value, key.allowed).map(|flag| f64::from(u8::from(flag))),
            Allowed::Whole { .. } => u32::parse(value, key.allowed).map(f64::from),
            _ => f64::parse(value, key.allowed),
        }
        .ok_or(key.refuses(value))?;
        // One order and no defaults: settings that say the same are the same.
        for slot in &mut self.0 {
            slot.take_if(|(known, _)| known.name == key.name);
        }
        if number != key.default {
            let full = Allowed::Only("left alone, for as many of laws' own keys are set as there is room for");
            let free = self.0.iter_mut().find(|slot| slot.is_none());
            *free.ok_or(Refused { allowed: full, ..key.refuses(value) })? = Some((key, number.to_ne_bytes()));
        }
        self.0.sort_unstable_by_key(|slot| slot.map_or((true, ""), |(known, _)| (false, known.name)));
        Ok(())
    }
}
