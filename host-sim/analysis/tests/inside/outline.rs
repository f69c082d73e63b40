//! Tests of `src/outline.rs` from inside.

use super::*;
use crate::limit::Limit;
use crate::map::{Axis, Column};
use crate::sweep::Range;

fn map(columns: &[(bool, &[f64])]) -> Map {
    let axis = |to: f64, count: usize| Axis { range: Range { key: "k".to_owned(), from: 0.0, to }, count };
    let column = |(at, (stable_at_start, crossings)): (usize, &(bool, &[f64]))| Column {
        x: at as f64,
        limit: Limit { stable_at_start: *stable_at_start, crossings: crossings.to_vec(), evaluations: 0, step: 0.0 },
    };
    Map {
        units: [""; 2],
        axes: [axis(columns.len() as f64 - 1.0, columns.len()), axis(10.0, 2)],
        columns: columns.iter().enumerate().map(column).collect(),
    }
}

#[test]
fn a_plain_limit_is_one_line() {
    let paths = outline(&map(&[(true, &[5.0]), (true, &[4.0]), (true, &[4.5])]));
    assert_eq!(paths, [[(0.0, 5.0), (1.0, 4.0), (2.0, 4.5)]]);
}

#[test]
fn a_pocket_is_joined_where_it_opens() {
    let paths = outline(&map(&[(true, &[9.0]), (true, &[3.0, 4.0, 9.0]), (true, &[2.0, 5.0, 9.0])]));
    assert_eq!(paths.len(), 2);
    assert!(paths.contains(&vec![(0.0, 9.0), (1.0, 9.0), (2.0, 9.0)]));
    let pocket = [(2.0, 2.0), (1.0, 3.0), (1.0, 4.0), (2.0, 5.0)];
    assert!(paths.iter().any(|path| path == &pocket || path.iter().rev().eq(pocket.iter())), "{paths:?}");
}

#[test]
fn an_island_is_closed() {
    let paths = outline(&map(&[(false, &[]), (false, &[4.0, 5.0]), (false, &[3.0, 6.0]), (false, &[])]));
    let around = [(1.0, 4.0), (2.0, 3.0), (2.0, 6.0), (1.0, 5.0), (1.0, 4.0)];
    assert_eq!(paths.len(), 1);
    assert!(paths[0].len() == 5 && around.iter().all(|point| paths[0].contains(point)), "{paths:?}");
}

#[test]
fn a_region_that_ends_goes_down_to_the_rim() {
    let paths = outline(&map(&[(true, &[2.0]), (true, &[1.0]), (false, &[])]));
    assert_eq!(paths, [[(0.0, 2.0), (1.0, 1.0), (1.0, 0.0)]]);
    let paths = outline(&map(&[(true, &[8.0]), (true, &[9.0]), (true, &[])]));
    assert_eq!(paths, [[(0.0, 8.0), (1.0, 9.0), (1.0, 10.0)]]);
}
