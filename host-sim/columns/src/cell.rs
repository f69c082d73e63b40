//! What stands at one place of a table, and what a column is filled with.

use serde::Serialize;
use serde_json::Value;

/// What stands at one place of a table.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "Value")]
pub enum Cell {
    /// No value: it was not measured, or there is none.
    Empty,
    /// A switch: true or false.
    Flag(bool),
    /// A whole number, such as a count.
    Whole(i64),
    /// A number, in the column's unit.
    Number(f64),
    /// Several numbers, in the column's unit.
    List(Vec<f64>),
    /// Text, such as a name.
    Text(String),
}

/// What the filled cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Yes or no.
    Flags,
    /// Whole numbers.
    Counts,
    /// Numbers.
    Numbers,
    /// Several numbers each.
    Lists,
    /// Texts.
    Texts,
}

impl Cell {
    /// What a column of such cells holds; nothing of an empty one.
    pub fn is(&self) -> Option<Holds> {
        match self {
            Self::Empty => None,
            Self::Flag(_) => Some(Holds::Flags),
            Self::Whole(_) => Some(Holds::Counts),
            Self::Number(_) => Some(Holds::Numbers),
            Self::List(_) => Some(Holds::Lists),
            Self::Text(_) => Some(Holds::Texts),
        }
    }

    /// As CSV and texts of Parquet have it.
    pub fn csv(self) -> String {
        match self {
            Self::Empty => String::new(),
            Self::Flag(flag) => u8::from(flag).to_string(),
            Self::Whole(count) => count.to_string(),
            // `{:?}` is the shortest text that parses back to the same value; `{}` would spell out 1e300.
            Self::Number(number) => format!("{number:?}"),
            Self::List(numbers) => numbers.iter().map(|number| format!("{number:?}")).collect::<Vec<_>>().join(" "),
            Self::Text(text) => text,
        }
    }
}

/// What makes cells that are all of one sort.
pub trait Typed: Into<Cell> {
    /// Which that is.
    const HOLDS: Holds;
}

macro_rules! cell_from {
    ($($from:ty => $holds:ident $cell:expr),+ $(,)?) => {
        $(impl From<$from> for Cell {
            fn from(value: $from) -> Self {
                $cell(value)
            }
        }

        impl Typed for $from {
            const HOLDS: Holds = Holds::$holds;
        })+
    };
}

cell_from! {
    bool => Flags Cell::Flag,
    f64 => Numbers Cell::Number,
    f32 => Numbers |value| Cell::Number(f64::from(value)),
    u8 => Counts |value| Cell::Whole(i64::from(value)),
    u16 => Counts |value| Cell::Whole(i64::from(value)),
    u32 => Counts |value| Cell::Whole(i64::from(value)),
    i32 => Counts |value| Cell::Whole(i64::from(value)),
    i64 => Counts Cell::Whole,
    u64 => Counts |value| i64::try_from(value).map_or(Cell::Number(value as f64), Cell::Whole),
    usize => Counts |value| Cell::from(value as u64),
    Vec<f64> => Lists Cell::List,
    String => Texts Cell::Text,
    &str => Texts |value: &str| Cell::Text(value.to_owned()),
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Empty, Into::into)
    }
}

impl<T: Typed> Typed for Option<T> {
    const HOLDS: Holds = T::HOLDS;
}

impl From<Cell> for Value {
    fn from(cell: Cell) -> Self {
        match cell {
            Cell::Empty => Self::Null,
            Cell::Flag(flag) => flag.into(),
            Cell::Whole(count) => count.into(),
            Cell::Number(number) => number.into(),
            Cell::List(numbers) => numbers.into(),
            Cell::Text(text) => text.into(),
        }
    }
}
