//! One key of a scene and the values that a sweep gives to it.

use std::{collections::BTreeSet, str::FromStr};

use cohold_report::{Cell, Holds};
use cohold_sim::scene::value_of;

use crate::Error;

/// Most values of an axis, and points of a sample.
pub(super) const MOST: usize = 1_000_000;

/// A key and its values.
///
/// | written | values |
/// |---|---|
/// | `KEY=A..B:N` | N numbers from A to B at equal distances, both included |
/// | `KEY=A..B:N:log` | N numbers from A to B at equal ratios, both included; A and B above 0 |
/// | `KEY=X,Y,Z` | these: numbers, `true` and `false`, names |
///
/// ```
/// use cohold_studies::sweep::Axis;
/// let axis: Axis = "network.loss=0..0.2:3".parse()?;
/// assert_eq!(axis.values, ["0.0", "0.1", "0.2"]);
/// # Ok::<(), cohold_studies::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of the key, `table.key`.
    pub key: String,
    /// Its values, as a scene file writes them.
    pub values: Vec<String>,
}

/// A value that is written so, as a cell of a column that holds this.
pub(super) fn cell(text: &str, holds: Holds) -> Cell {
    let value = value_of(text);
    let whole = value.as_integer();
    match holds {
        Holds::Flags => value.as_bool().into(),
        Holds::Counts => whole.or(value.as_float().map(|number| number as i64)).into(),
        Holds::Numbers => value.as_float().or(whole.map(|whole| whole as f64)).into(),
        Holds::Lists | Holds::Texts => value.as_str().unwrap_or(text).into(),
    }
}

impl FromStr for Axis {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let form = || form("A..B:N, A..B:N:log");
        let (key, values) = text.split_once('=').ok_or_else(form)?;
        let (key, values) = (key.trim().to_owned(), values.trim());
        let values = match values.split_once("..") {
            Some((first, rest)) => range(first, rest).ok_or_else(form)??,
            None => values.split(',').map(|value| value.trim().to_owned()).collect(),
        };
        let mut seen = BTreeSet::new();
        match values.iter().find(|value| !seen.insert(*value)) {
            _ if key.is_empty() || values.iter().any(String::is_empty) => Err(form().into()),
            Some(twice) => Err(format!("the value {twice} stands there twice").into()),
            None => Ok(Self { key, values }),
        }
    }
}

/// How it is to be written: a range in one of these forms, or a list.
pub(super) fn form(ranges: &str) -> String {
    let ranges: Vec<String> = ranges.split(", ").map(|range| format!("TABLE.KEY={range}")).collect();
    format!("write it as {} or TABLE.KEY=X,Y,Z", ranges.join(", "))
}

/// The ends of a range, if these are numbers.
pub(super) fn ends(first: &str, last: &str) -> Option<(f64, f64)> {
    let number = |end: &str| end.trim().parse::<f64>().ok().filter(|end| end.is_finite());
    number(first).zip(number(last))
}

/// The numbers of `FIRST..REST`, or what is wrong with them; none where it is not written so.
fn range(first: &str, rest: &str) -> Option<Result<Vec<String>, Error>> {
    let mut parts = rest.split(':');
    let (first, last) = ends(first, parts.next()?)?;
    let count = parts.next()?.trim().parse::<usize>().ok()?;
    let log = match (parts.next().map(str::trim), parts.next()) {
        (None, _) => false,
        (Some("log"), None) => true,
        _ => return None,
    };
    if !(2..=MOST).contains(&count) || first == last {
        return Some(Err(format!("a range has two ends and 2 to {MOST} values").into()));
    }
    if log && (first <= 0.0 || last <= 0.0) {
        return Some(Err("equal ratios need ends above 0".into()));
    }
    // libm: the same bits on every machine.
    let value = |at: usize| match at as f64 / (count - 1) as f64 {
        0.0 => first,
        1.0 => last,
        share if log => first * libm::pow(last / first, share),
        share => first + (last - first) * share,
    };
    Some(Ok((0..count).map(|at| format!("{:?}", value(at))).collect()))
}
