//! Stability regions over two keys of a scene: for every value of x, all crossings along y.
//!
//! Columns of the map are independent, and are found in parallel. Along y a crossing is as exact as
//! [`super::limit::Effort`] says; along x the region is known at the values of x only.

use cohold_report::Columns;
use cohold_sim::scene::Scene;
use rayon::prelude::*;
use serde::Serialize;

use super::limit::{Effort, Limit, along};
use super::sweep::{Range, Sweep};
use crate::error::Error;

/// A range and how many values of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The key and the ends of its range.
    pub range: Range,
    /// Values, both ends included; 2 or more.
    pub count: usize,
}

impl Axis {
    /// The values, equally spaced, in the key's unit.
    pub fn values(&self) -> Vec<f64> {
        let Range { from, to, .. } = self.range;
        (0..self.count).map(|at| from + (to - from) * at as f64 / (self.count - 1).max(1) as f64).collect()
    }
}

/// Reads an axis from `key=A..B:N`.
impl std::str::FromStr for Axis {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let form = "write it as table.key=A..B:N, for example coordination.stiffness_n_per_m=0..12000:100";
        let wrong = || cohold_sim::Error::at(text, form);
        let (key, rest) = text.split_once('=').ok_or_else(wrong)?;
        let (range, count) = rest.rsplit_once(':').ok_or_else(wrong)?;
        let (from, to) = range.split_once("..").ok_or_else(wrong)?;
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
        let range = Range { key: key.trim().to_owned(), from: number(from)?, to: number(to)? };
        let count = count.trim().parse::<usize>().map_err(|_| wrong())?;
        if !(2..=10_000).contains(&count) {
            let said = format!("{count} values are not allowed: it must be a whole number from 2 to 10000");
            return Err(cohold_sim::Error::at(text, said).into());
        }
        Ok(Self { range, count })
    }
}

/// One column of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Value of the x key.
    pub x: f64,
    /// All crossings along the y key.
    #[serde(flatten)]
    pub limit: Limit,
}

/// A region in two keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// What x and y are.
    pub axes: [Axis; 2],
    /// Units of both axes.
    pub units: [&'static str; 2],
    /// One for every value of x.
    pub columns: Vec<Column>,
}

/// Maps the scene. `done` is called once for every column, in any order, from any thread.
///
/// # Errors
/// A key that takes no numbers, a scene that cannot be judged, or eigenvalues that do not converge.
pub fn map(scene: &Scene, axes: [Axis; 2], effort: Effort, done: impl Fn() + Sync) -> Result<Map, Error> {
    let [x, y] = &axes;
    let across = Sweep::new(scene, x.range.clone())?;
    // The range of y must be possible whatever x is: better said before the work than in the middle of it.
    Sweep::new(scene, y.range.clone())?;
    let column = |x: &f64| {
        let limit = along(&Sweep::new(&across.at(*x)?, y.range.clone())?, effort)?;
        done();
        Ok(Column { x: *x, limit })
    };
    let keys = scene.keys();
    let units =
        [x, y].map(|axis| keys.iter().find(|(name, _)| *name == axis.range.key).map_or("", |(_, key)| key.unit));
    let columns = x.values().par_iter().map(column).collect::<Result<_, Error>>()?;
    Ok(Map { units, axes, columns })
}

impl Map {
    /// One row for every crossing: x, y, and whether the scene is stable just below and just above it. A column without
    /// crossings is one row with nothing for y.
    pub fn table(&self) -> Columns {
        let crossings = |column: &Column| -> Vec<(f64, Option<f64>, bool, bool)> {
            let (x, start) = (column.x, column.limit.stable_at_start);
            let crossing = |(at, y): (usize, &f64)| (x, Some(*y), start == (at % 2 == 0), start != (at % 2 == 0));
            let found: Vec<_> = column.limit.crossings.iter().enumerate().map(crossing).collect();
            if found.is_empty() { vec![(x, None, start, start)] } else { found }
        };
        let rows: Vec<_> = self.columns.iter().flat_map(crossings).collect();
        let [x, y] = self.axes.each_ref().map(|axis| axis.range.key.as_str());
        Columns::of(&rows)
            .value(x, |row| row.0)
            .means("value of the key of x")
            .value(y, |row| row.1)
            .means("value of the key of y at which stability ends or begins; nothing where it does neither")
            .value("stable_below", |row| row.2)
            .means("whether the scene is stable just below")
            .value("stable_above", |row| row.3)
            .means("whether the scene is stable just above")
            .done()
    }

    /// Spectral radii that were computed.
    pub fn evaluations(&self) -> usize {
        self.columns.iter().map(|column| column.limit.evaluations).sum()
    }
}

#[cfg(test)]
#[path = "../tests/inside/map.rs"]
mod tests;
