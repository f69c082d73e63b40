//! The outline of a region: which crossing of one column of a map goes on as which crossing of the next.
//!
//! Crossings of a column alternate between leaving and entering the region. From column to column they move, and they
//! appear and vanish in neighbouring pairs (a pocket opens or closes) or across the lower or upper end of the range. Of all
//! ways to explain one column by the next, the one with the least movement is taken. Every crossing then has at most one
//! continuation to the left and one to the right, so the outline is a set of paths.

use super::map::Map;

/// What a crossing is joined to on one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Link {
    /// Nothing: the map ends there.
    #[default]
    End,
    /// Another crossing, by its number.
    To(usize),
    /// The lower or upper end of the range.
    Rim(f64),
}

/// A crossing with its two sides.
#[derive(Clone, Copy, Debug)]
struct Node {
    x: f64,
    y: f64,
    /// The region is below it.
    leaves: bool,
    links: [Link; 2],
}

/// A step that explains a column by the next.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// Left crossing i goes on as right crossing j.
    Match,
    /// Two neighbours of the left (0) or right (1) column are joined to each other.
    Pair(usize),
    /// One crossing of the left (0) or right (1) column goes over the rim.
    Over(usize),
}

/// Paths along the outline of a map's region, as (x, y).
pub fn outline(map: &Map) -> Vec<Vec<(f64, f64)>> {
    let (low, high) = (map.axes[1].range.from, map.axes[1].range.to);
    let mut nodes = Vec::new();
    let mut columns = Vec::new();
    for column in &map.columns {
        let first = nodes.len();
        for (at, &y) in column.limit.crossings.iter().enumerate() {
            let leaves = column.limit.stable_at_start == (at % 2 == 0);
            nodes.push(Node { x: column.x, y, leaves, links: [Link::End; 2] });
        }
        columns.push(first..nodes.len());
    }
    for pair in columns.windows(2) {
        join(&mut nodes, [pair[0].clone(), pair[1].clone()], low, high);
    }
    paths(&nodes)
}

/// Links two neighbouring columns.
fn join(nodes: &mut [Node], columns: [std::ops::Range<usize>; 2], low: f64, high: f64) {
    let [left, right] = columns.each_ref().map(|column| nodes[column.clone()].to_vec());
    let (rows, across) = (left.len() + 1, right.len() + 1);
    // best[i][j]: least movement that explains the first i crossings of the left and the first j of the right column.
    let mut best = vec![vec![(f64::INFINITY, Step::Match); across]; rows];
    best[0][0].0 = 0.0;
    for i in 0..rows {
        for j in 0..across {
            let mut offer = |from: (usize, usize), cost: f64, step: Step| {
                let total = best[from.0][from.1].0 + cost;
                if total < best[i][j].0 {
                    best[i][j] = (total, step);
                }
            };
            if i > 0 && j > 0 && left[i - 1].leaves == right[j - 1].leaves {
                offer((i - 1, j - 1), (left[i - 1].y - right[j - 1].y).abs(), Step::Match);
            }
            for (side, column, at) in [(0, &left, i), (1, &right, j)] {
                let before = |steps: usize| if side == 0 { (i - steps, j) } else { (i, j - steps) };
                if at > 1 {
                    offer(before(2), column[at - 1].y - column[at - 2].y, Step::Pair(side));
                }
                // Over the lower rim only before anything else, over the upper one only after everything else.
                if at == 1 && before(1) == (0, 0) {
                    offer(before(1), column[0].y - low, Step::Over(side));
                }
                if at > 0 && i + 1 == rows && j + 1 == across {
                    offer(before(1), high - column[at - 1].y, Step::Over(side));
                }
            }
        }
    }
    let (mut i, mut j) = (left.len(), right.len());
    let node = |side: usize, at: usize| columns[side].start + at;
    while (i, j) != (0, 0) && best[i][j].0.is_finite() {
        match best[i][j].1 {
            Step::Match => {
                (i, j) = (i - 1, j - 1);
                nodes[node(0, i)].links[1] = Link::To(node(1, j));
                nodes[node(1, j)].links[0] = Link::To(node(0, i));
            }
            Step::Pair(side) => {
                let at = if side == 0 { i } else { j };
                let (a, b) = (node(side, at - 2), node(side, at - 1));
                nodes[a].links[1 - side] = Link::To(b);
                nodes[b].links[1 - side] = Link::To(a);
                if side == 0 { i -= 2 } else { j -= 2 }
            }
            Step::Over(side) => {
                let at = if side == 0 { i } else { j };
                let first = (i, j) == if side == 0 { (1, 0) } else { (0, 1) };
                let lower = first && (left.len() + right.len() > 1 || nodes[node(side, at - 1)].y - low < high - nodes[node(side, at - 1)].y);
                nodes[node(side, at - 1)].links[1 - side] = Link::Rim(if lower { low } else { high });
                if side == 0 { i -= 1 } else { j -= 1 }
            }
        }
    }
}

/// Follows the links.
fn paths(nodes: &[Node]) -> Vec<Vec<(f64, f64)>> {
    let mut done = vec![false; nodes.len()];
    let mut paths = Vec::new();
    let loose = |node: &Node| node.links.iter().position(|link| !matches!(link, Link::To(_)));
    // Paths with an end first, then what is left: closed ones.
    let starts = (0..nodes.len()).filter(|at| loose(&nodes[*at]).is_some()).chain(0..nodes.len());
    for start in starts {
        if done[start] {
            continue;
        }
        let mut side = loose(&nodes[start]).unwrap_or(0);
        let mut path = Vec::new();
        if let Link::Rim(y) = nodes[start].links[side] {
            path.push((nodes[start].x, y));
        }
        let mut at = start;
        loop {
            done[at] = true;
            path.push((nodes[at].x, nodes[at].y));
            side = 1 - side;
            match nodes[at].links[side] {
                Link::To(next) => {
                    // The side by which the next one is entered.
                    side = usize::from(nodes[next].links[1] == Link::To(at) && nodes[next].links[0] != Link::To(at) || {
                        nodes[next].x == nodes[at].x && nodes[next].links[side] == Link::To(at) && side == 1
                    });
                    at = next;
                    if done[at] {
                        path.push((nodes[at].x, nodes[at].y));
                        break;
                    }
                }
                Link::Rim(y) => {
                    path.push((nodes[at].x, y));
                    break;
                }
                Link::End => break,
            }
        }
        paths.push(path);
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::super::limit::Limit;
    use super::super::map::{Axis, Column};
    use super::super::sweep::Range;
    use super::*;

    fn map(columns: &[(bool, &[f64])]) -> Map {
        let axis = |to: f64, count: usize| Axis { range: Range { key: "k".to_owned(), from: 0.0, to }, count };
        let column = |(at, (stable_at_start, crossings)): (usize, &(bool, &[f64]))| Column {
            x: at as f64,
            limit: Limit { stable_at_start: *stable_at_start, crossings: crossings.to_vec(), evaluations: 0, step: 0.0 },
        };
        Map {
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
        assert_eq!(paths, [[(1.0, 0.0), (1.0, 1.0), (0.0, 2.0)]]);
        let paths = outline(&map(&[(true, &[8.0]), (true, &[9.0]), (true, &[])]));
        assert_eq!(paths, [[(1.0, 10.0), (1.0, 9.0), (0.0, 8.0)]]);
    }
}
