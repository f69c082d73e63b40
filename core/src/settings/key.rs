//! What a key is: its name, what it accepts, and how a value goes in and comes out; and tables of such keys, as they are declared.

use core::fmt;

use crate::names::Choice;

use super::LawInfo;

/// A value on its way into or out of a setting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value<'a> {
    /// A number, in the key's unit.
    Number(f64),
    /// A switch: true or false.
    Flag(bool),
    /// A name, or text that stands for none.
    Text(&'a str),
}

impl<'a> Value<'a> {
    /// The value that a text stands for: `true`, `false`, a number, else a name.
    pub fn of_text(text: &'a str) -> Self {
        match text {
            "true" => Self::Flag(true),
            "false" => Self::Flag(false),
            _ => text.parse().map_or(Self::Text(text), Self::Number),
        }
    }
}

impl fmt::Display for Value<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Text(text) => write!(f, "\"{text}\""),
        }
    }
}

/// What a key accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// A finite number, both ends included.
    Number {
        /// Smallest value allowed, in the key's unit.
        min: f64,
        /// Largest value allowed, in the key's unit.
        max: f64,
    },
    /// A whole number, both ends included.
    Whole {
        /// Smallest whole number that is accepted, in the key's unit.
        min: u32,
        /// Largest whole number that is accepted, in the key's unit.
        max: u32,
    },
    /// A switch: `true` or `false`.
    Flag,
    /// One of these names.
    Names(&'static [&'static str]),
    /// The name of one of these laws; empty where the table is declared, because crates may add laws.
    Laws(&'static [LawInfo]),
    /// Values that depend on other keys, described in words.
    Only(&'static str),
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number { min, max } => write!(f, "a number from {min} to {max}"),
            Self::Whole { min, max } => write!(f, "a whole number from {min} to {max}"),
            Self::Flag => write!(f, "true or false"),
            Self::Only(words) => write!(f, "{words}"),
            Self::Names(names) => one_of(f, names.iter().copied()),
            Self::Laws(kinds) => one_of(f, kinds.iter().map(|kind| kind.name)),
        }
    }
}

fn one_of(f: &mut fmt::Formatter<'_>, names: impl Iterator<Item = &'static str>) -> fmt::Result {
    write!(f, "one of")?;
    for (at, name) in names.enumerate() {
        write!(f, "{} \"{name}\"", if at == 0 { "" } else { "," })?;
    }
    Ok(())
}

/// One key: what it is called, what it accepts, what it means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// `table.key`, as scene files and `--set` spell it.
    pub name: &'static str,
    /// The values it accepts.
    pub allowed: Allowed,
    /// Unit, empty for a pure number, a flag or a name.
    pub unit: &'static str,
    /// One line of meaning; empty in an image without an operating system, which shows none.
    pub doc: &'static str,
    /// What a law's own key is while it is not set; the tables have their own defaults.
    pub(super) default: f64,
}

/// Keys that a law declares beside itself: `const AHEAD: Key = Key::number("predict.ahead_s", 0.008, [0.0, 0.2], "s").means("…")`.
impl Key {
    /// A finite number between two ends, both included.
    pub const fn number(name: &'static str, default: f64, [min, max]: [f64; 2], unit: &'static str) -> Self {
        assert!(min <= default && default <= max, "the default of a key lies outside its range");
        Self { name, allowed: Allowed::Number { min, max }, unit, doc: "", default }
    }

    /// A whole number between two ends, both included.
    pub const fn whole(name: &'static str, default: u32, [min, max]: [u32; 2], unit: &'static str) -> Self {
        assert!(min <= default && default <= max, "the default of a key lies outside its range");
        Self { name, allowed: Allowed::Whole { min, max }, unit, doc: "", default: default as f64 }
    }

    /// A switch, `true` or `false`; [`Settings::own`](super::Settings::own) gives 1 or 0.
    pub const fn flag(name: &'static str, default: bool) -> Self {
        let default = if default { 1.0 } else { 0.0 };
        Self { name, allowed: Allowed::Flag, unit: "", doc: "", default }
    }

    /// The same key, with one line of meaning.
    pub const fn means(self, doc: &'static str) -> Self {
        let doc = if cfg!(target_os = "none") { "" } else { doc };
        Self { doc, ..self }
    }

    /// A key of a table, for [`settings!`](crate::settings!).
    #[doc(hidden)]
    pub const fn of_table(name: &'static str, allowed: Allowed, unit: &'static str, doc: &'static str) -> Self {
        Self { name, allowed, unit, doc: "", default: f64::NAN }.means(doc)
    }

    /// That it does not accept this value.
    pub(super) fn refuses<'a>(&self, value: Value<'a>) -> Refused<'a> {
        Refused { key: self.name, value, allowed: self.allowed, unit: self.unit }
    }
}

/// A value that a key does not accept; displays as `key = value is not allowed: …`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refused<'a> {
    /// Name of the key.
    pub key: &'static str,
    /// The value that was offered.
    pub value: Value<'a>,
    /// The values that the key accepts.
    pub allowed: Allowed,
    /// Unit of the key; empty for a pure number.
    pub unit: &'static str,
}

impl fmt::Display for Refused<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} is not allowed: it must be {}", self.key, self.value, self.allowed)?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

impl core::error::Error for Refused<'_> {}

/// Why a key could not be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetError<'a> {
    /// There is no such key.
    Unknown,
    /// The key exists, but it does not accept the value.
    Refused(Refused<'a>),
}

/// A type a setting can have.
pub trait Setting: Copy + PartialEq {
    /// Takes the value if it is allowed.
    fn parse(value: Value<'_>, allowed: Allowed) -> Option<Self>;
    /// The value, for reports and hashes.
    fn value(&self) -> Value<'static>;
}

impl Setting for f64 {
    fn parse(value: Value<'_>, allowed: Allowed) -> Option<Self> {
        match (value, allowed) {
            (Value::Number(number), Allowed::Number { min, max }) if number >= min && number <= max => Some(number),
            _ => None,
        }
    }
    fn value(&self) -> Value<'static> {
        Value::Number(*self)
    }
}

impl Setting for u32 {
    fn parse(value: Value<'_>, allowed: Allowed) -> Option<Self> {
        match (value, allowed) {
            (Value::Number(number), Allowed::Whole { min, max })
                if number >= f64::from(min) && number <= f64::from(max) && f64::from(number as u32) == number =>
            {
                Some(number as u32)
            }
            _ => None,
        }
    }
    fn value(&self) -> Value<'static> {
        Value::Number(f64::from(*self))
    }
}

impl Setting for bool {
    fn parse(value: Value<'_>, _: Allowed) -> Option<Self> {
        if let Value::Flag(flag) = value { Some(flag) } else { None }
    }
    fn value(&self) -> Value<'static> {
        Value::Flag(*self)
    }
}

impl<C: Choice> Setting for C {
    fn parse(value: Value<'_>, _: Allowed) -> Option<Self> {
        if let Value::Text(name) = value { C::from_name(name) } else { None }
    }
    fn value(&self) -> Value<'static> {
        Value::Text(self.name())
    }
}

/// A name from an open list; which names there are is known above these tables ([`crate::schema`]).
impl Setting for &'static str {
    fn parse(value: Value<'_>, allowed: Allowed) -> Option<Self> {
        match (value, allowed) {
            (Value::Text(text), Allowed::Laws(kinds)) => kinds.iter().map(|kind| kind.name).find(|name| *name == text),
            _ => None,
        }
    }
    fn value(&self) -> Value<'static> {
        Value::Text(self)
    }
}

/// Tables of keys, as [`settings!`](crate::settings!) declares them.
pub trait Tables: Copy {
    /// Every key, in the order of declaration.
    const KEYS: &'static [Key];

    /// The value of the key called `name`.
    fn get(&self, name: &str) -> Option<Value<'static>>;

    /// Sets the key called `name`, if it accepts `value`; otherwise says why not and changes nothing.
    fn set<'a>(&mut self, name: &str, value: Value<'a>) -> Result<(), SetError<'a>>;

    /// Refuses the first value outside its range; names from an open list are left to whoever knows that list.
    fn check_ranges(&self) -> Result<(), Refused<'static>> {
        let mut probe = *self;
        for key in Self::KEYS.iter().filter(|key| !matches!(key.allowed, Allowed::Laws(_))) {
            if let Some(value) = self.get(key.name)
                && let Err(SetError::Refused(refused)) = probe.set(key.name, value)
            {
                return Err(refused);
            }
        }
        Ok(())
    }
}

/// Declares tables of keys: the structs, and [`Tables`] by name. What is named in brackets after the struct's name is a
/// public field that no table declares.
#[macro_export]
macro_rules! settings {
    (
        $(#[$doc:meta])*
        pub struct $Settings:ident $([ $(#[$field_doc:meta])* $field:ident: $field_type:ty ])?;
        $(
            $(#[$table_doc:meta])*
            $table:ident: $Table:ident {
                $( $key:ident: $type:ty = $default:expr, $allowed:expr, $unit:literal, $key_doc:literal; )+
            }
        )+
    ) => {
        $(
            $(#[$table_doc])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub struct $Table { $( #[doc = concat!($key_doc, " Unit: ", $unit, ".")] pub $key: $type, )+ }

            impl Default for $Table {
                fn default() -> Self {
                    Self { $( $key: $default ),+ }
                }
            }
        )+

        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct $Settings {
            $( $(#[$table_doc])* pub $table: $Table, )+
            $( $(#[$field_doc])* pub $field: $field_type, )?
        }

        impl $crate::settings::Tables for $Settings {
            const KEYS: &'static [$crate::settings::Key] = {
                // A static is in an image once; a constant would be once for each part of it that names it.
                static KEYS: [$crate::settings::Key; [$($( stringify!($key) ),+),+].len()] = [
                    $($( $crate::settings::Key::of_table(
                        concat!(stringify!($table), ".", stringify!($key)), $allowed, $unit, $key_doc,
                    ), )+)+
                ];
                &KEYS
            };

            fn get(&self, name: &str) -> Option<$crate::settings::Value<'static>> {
                $($(
                    if name == concat!(stringify!($table), ".", stringify!($key)) {
                        return Some($crate::settings::Setting::value(&self.$table.$key));
                    }
                )+)+
                None
            }

            fn set<'a>(
                &mut self,
                name: &str,
                value: $crate::settings::Value<'a>,
            ) -> Result<(), $crate::settings::SetError<'a>> {
                $($(
                    if name == concat!(stringify!($table), ".", stringify!($key)) {
                        let allowed = $allowed;
                        return match <$type as $crate::settings::Setting>::parse(value, allowed) {
                            Some(accepted) => { self.$table.$key = accepted; Ok(()) }
                            None => Err($crate::settings::SetError::Refused($crate::settings::Refused {
                                key: concat!(stringify!($table), ".", stringify!($key)), value, allowed, unit: $unit,
                            })),
                        };
                    }
                )+)+
                Err($crate::settings::SetError::Unknown)
            }
        }
    };
}

/// A number from `min` to `max`.
pub const fn number(min: f64, max: f64) -> Allowed {
    Allowed::Number { min, max }
}
pub(super) const fn whole(min: u32, max: u32) -> Allowed {
    Allowed::Whole { min, max }
}
