//! Tests of `src/outline.rs` from inside.

use super::*;
use crate::limit::Limit;
use crate::map::{Axis, Column};
use crate::sweep::Range;

fn map(columns: &[(bool, &[f64])]) -> Map {
    let axis = |to: f64, count: usize| Axis { range: Range { key: "k".to_owned(), from: 0.0, to }, count };
    let column = |(at, (stable_at_start, crossings)): (usize, &(bool, &[f64]))| Column {
        x: at as f64,
        limit: Limit {
            stable_at_start: *stable_at_start,
            crossings: crossings.to_vec(),
            evaluations: 0,
            step: 0.0,
            not_judged_because: None,
        },
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

/// The fill and the outline are one: every edge of a strip between two columns is a piece of the outline, and every such piece is the
/// edge of one strip.
#[test]
fn the_region_ends_at_its_outline() {
    let maps = [
        map(&[(true, &[5.0]), (true, &[4.0]), (true, &[4.5])]),
        map(&[(true, &[9.0]), (true, &[3.0, 4.0, 9.0]), (true, &[2.0, 5.0, 9.0])]),
        map(&[(false, &[]), (false, &[4.0, 5.0]), (false, &[3.0, 6.0]), (false, &[])]),
        map(&[(true, &[2.0]), (true, &[1.0]), (false, &[])]),
        map(&[(false, &[]), (true, &[2.0]), (true, &[])]),
        map(&[(true, &[]), (true, &[]), (false, &[])]),
    ];
    for map in maps {
        let strips = strips(&map);
        let mut edges: Vec<[(f64, f64); 2]> = Vec::new();
        for strip in &strips {
            let (left, right) = (strip.left, strip.right);
            assert!(left.0 < right.0 && left.1 <= left.2 && right.1 <= right.2, "{strip:?}");
            edges.extend([[(left.0, left.1), (right.0, right.1)], [(left.0, left.2), (right.0, right.2)]]);
        }
        edges.retain(|edge| ![0.0, 10.0].iter().any(|rim| edge.iter().all(|end| end.1 == *rim)));
        let mut pieces: Vec<[(f64, f64); 2]> = Vec::new();
        for path in outline(&map) {
            pieces.extend(
                path.windows(2)
                    .filter(|pair| pair[0].0 != pair[1].0)
                    .map(|pair| if pair[0].0 < pair[1].0 { [pair[0], pair[1]] } else { [pair[1], pair[0]] }),
            );
        }
        let key = |edge: &[(f64, f64); 2]| format!("{edge:?}");
        edges.sort_by_key(key);
        pieces.sort_by_key(key);
        assert_eq!(edges, pieces);
        // Where a column has no pair that opens or closes there, its strips are what it says.
        for (at, column) in map.columns.iter().enumerate().skip(1) {
            let links = column.limit.crossings.len() == map.columns[at - 1].limit.crossings.len();
            for y in [0.5, 2.2, 3.5, 5.5, 9.5].into_iter().filter(|_| links && !column.limit.crossings.is_empty()) {
                let inside = strips.iter().any(|strip| {
                    let (x, low, high) = strip.right;
                    x == column.x && low < y && y < high
                });
                assert_eq!(inside, column.limit.is_stable(y), "column {at} at {y}");
            }
        }
    }
}
