//! Settings by name: finds, reads and sets the keys of the tables and those that coordination laws declare, alike.
//!
//! The laws are given as a list of [`LawInfo`]s, so that a crate outside can add its own; [`Schema::BUILT_IN`] knows
//! those of this crate, and is what [`Settings`] itself goes by.

use crate::law::{AnyLaw, Law};
use crate::settings::{Allowed, Key, LawInfo, Refused, SetError, Setting, Settings, Tables, Value};

/// All keys that a peer has with a list of laws: those of the tables, and those that the laws declare themselves.
#[derive(Clone, Copy, Debug)]
pub struct Schema {
    laws: &'static [LawInfo],
}

impl Schema {
    /// The schema with the laws of this crate.
    pub const BUILT_IN: Self = Self::new(AnyLaw::<f64>::LAWS);

    /// The schema of the tables and of the keys of these laws.
    pub const fn new(laws: &'static [LawInfo]) -> Self {
        Self { laws }
    }

    /// The laws whose keys it knows.
    pub fn laws(self) -> &'static [LawInfo] {
        self.laws
    }

    /// The law that the settings name.
    pub fn law(self, settings: &Settings) -> Option<&'static LawInfo> {
        crate::law::named(settings, self.laws)
    }

    /// Every key: those of the tables in the order of declaration, then laws' own.
    pub fn keys(self) -> impl Iterator<Item = Key> {
        let tables = <Settings as Tables>::KEYS.iter().map(move |key| {
            let mut key = *key;
            if let Allowed::Laws(laws) = &mut key.allowed {
                *laws = self.laws;
            }
            key
        });
        // A key that several laws have is listed once.
        let before = move |at: usize, key: &Key| {
            self.laws.iter().take(at).any(|law| law.keys.iter().any(|own| own.name == key.name))
        };
        let own = self
            .laws
            .iter()
            .enumerate()
            .flat_map(move |(at, law)| law.keys.iter().filter(move |key| !before(at, key)).copied());
        tables.chain(own)
    }

    /// The value of the key called `name`.
    pub fn get(self, settings: &Settings, name: &str) -> Option<Value<'static>> {
        Tables::get(settings, name).or_else(|| self.own(name).map(|key| settings.own_value(key)))
    }

    /// Sets the key called `name`, if it accepts `value`; otherwise nothing changes.
    ///
    /// # Errors
    /// A name that no key has, or a value that the key does not accept.
    pub fn set<'a>(self, settings: &mut Settings, name: &str, value: Value<'a>) -> Result<(), SetError<'a>> {
        match Tables::set(settings, name, value) {
            // The tables know no law.
            Err(SetError::Refused(Refused { key, allowed: Allowed::Laws(_), .. })) => {
                let allowed = Allowed::Laws(self.laws);
                let refused = SetError::Refused(Refused { key, value, allowed, unit: "" });
                settings.coordination.comm = Setting::parse(value, allowed).ok_or(refused)?;
                Ok(())
            }
            Err(SetError::Unknown) => {
                let key = self.own(name).ok_or(SetError::Unknown)?;
                settings.own.set(key, value).map_err(SetError::Refused)
            }
            done => done,
        }
    }

    fn own(self, name: &str) -> Option<&'static Key> {
        self.laws.iter().flat_map(|law| law.keys).find(|key| key.name == name)
    }
}

/// By name, with the laws of this crate.
impl Settings {
    /// Every key of the tables and of this crate's laws ([`Schema::keys`]).
    pub fn keys() -> impl Iterator<Item = Key> {
        Schema::BUILT_IN.keys()
    }

    /// The value of the key called `name`, with this crate's laws; `None` if there is none ([`Schema::get`]).
    pub fn get(&self, name: &str) -> Option<Value<'static>> {
        Schema::BUILT_IN.get(self, name)
    }

    /// Sets the key called `name` ([`Schema::set`]).
    ///
    /// # Errors
    /// A name that no key has, or a value that the key does not accept.
    pub fn set<'a>(&mut self, name: &str, value: Value<'a>) -> Result<(), SetError<'a>> {
        Schema::BUILT_IN.set(self, name, value)
    }
}
