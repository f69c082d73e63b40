//! The outline of a region: which crossing of one column of a map goes on as which crossing of the next.
//!
//! Crossings of a column alternate between leaving and entering the region. From column to column they move, and they
//! appear and vanish in neighbouring pairs (a pocket opens or closes) or across the lower or upper end of the range. Of all
//! ways to explain one column by the next, the one with the least movement is taken. Every crossing then has at most one
//! continuation to the left and one to the right, so the outline is a set of paths, and what lies between two columns is strips
//! with the same edges.

use cohold_plot::Strip;

use super::map::Map;

/// What a crossing is joined to on one side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Link {
    /// Nothing: the map ends there.
    #[default]
    End,
    /// Another crossing, by its number, at its left (0) or right (1).
    To(usize, usize),
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
    /// The last crossing of the left (0) or right (1) column goes over the upper rim.
    Over(usize),
}

/// How two columns are joined: total movement, and the steps with the crossings before which they stand.
type Plan = (f64, Vec<(Step, usize, usize)>);

/// Paths along the outline of a map's region, as (x, y).
pub(crate) fn outline(map: &Map) -> Vec<Vec<(f64, f64)>> {
    paths(&joined(map).0)
}

/// The region itself, between the lines of its outline.
pub(crate) fn strips(map: &Map) -> Vec<Strip> {
    let (low, high) = (map.axes[1].range.from, map.axes[1].range.to);
    let (nodes, columns) = joined(map);
    let mut strips = Vec::new();
    for (pair, sides) in columns.windows(2).zip(map.columns.windows(2)) {
        let left = pair[0].clone();
        let on = |at: usize| match nodes[at].links[1] {
            Link::To(next, 0) => Some((nodes[at].y, nodes[next].y, nodes[at].leaves)),
            _ => None,
        };
        let lines: Vec<(f64, f64, bool)> = left.clone().filter_map(on).collect();
        // At the lower end a side decides whose own lowest crossing does not go over the rim.
        let ends_left = left.clone().any(|at| nodes[at].links[1] == Link::Rim(low));
        let at_left = if ends_left { &sides[1] } else { &sides[0] };
        let mut inside = lines.first().map_or(at_left.limit.stable_at_start, |(_, _, leaves)| *leaves);
        let mut below = (low, low);
        for (from, to, _) in lines.into_iter().chain([(high, high, true)]) {
            if inside {
                strips.push(Strip { left: (sides[0].x, below.0, from), right: (sides[1].x, below.1, to) });
            }
            (below, inside) = ((from, to), !inside);
        }
    }
    strips
}

/// The crossings of a map, joined, and those of each column.
fn joined(map: &Map) -> (Vec<Node>, Vec<std::ops::Range<usize>>) {
    let (low, high) = (map.axes[1].range.from, map.axes[1].range.to);
    let mut nodes: Vec<Node> = Vec::new();
    let mut columns: Vec<std::ops::Range<usize>> = Vec::new();
    for (at, column) in map.columns.iter().enumerate() {
        let first = nodes.len();
        for (at, &y) in column.limit.crossings.iter().enumerate() {
            let leaves = column.limit.stable_at_start == (at % 2 == 0);
            nodes.push(Node { x: column.x, y, leaves, links: [Link::End; 2] });
        }
        columns.push(first..nodes.len());
        if at > 0 {
            let turned = column.limit.stable_at_start != map.columns[at - 1].limit.stable_at_start;
            join(&mut nodes, [columns[at - 1].clone(), columns[at].clone()], turned, [low, high]);
        }
    }
    (nodes, columns)
}

/// Links two neighbouring columns; `turned` where the lower end of the range is inside in only one of them, so that the
/// lowest crossing of either goes over the lower rim.
fn join(nodes: &mut [Node], columns: [std::ops::Range<usize>; 2], turned: bool, [low, high]: [f64; 2]) {
    let [mut left, mut right] = columns;
    if turned {
        let over = |side: usize, from: &std::ops::Range<usize>, rest: [&std::ops::Range<usize>; 2]| {
            let first = from.clone().next()?;
            let trimmed = [0, 1].map(|at| if at == side { rest[at].start + 1..rest[at].end } else { rest[at].clone() });
            let (movement, _) = plan(nodes, &trimmed, high);
            Some((movement + nodes[first].y - low, side, first))
        };
        let choices = [over(0, &left, [&left, &right]), over(1, &right, [&left, &right])];
        let Some((_, side, first)) = choices.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0)) else { return };
        nodes[first].links[1 - side] = Link::Rim(low);
        if side == 0 { left.start += 1 } else { right.start += 1 }
    }
    let columns = [left, right];
    for (step, i, j) in plan(nodes, &columns, high).1 {
        let last = |side: usize, back: usize| columns[side].start + [i, j][side] - back;
        match step {
            Step::Match => {
                let (a, b) = (last(0, 1), last(1, 1));
                nodes[a].links[1] = Link::To(b, 0);
                nodes[b].links[0] = Link::To(a, 1);
            }
            Step::Pair(side) => {
                let (a, b) = (last(side, 2), last(side, 1));
                nodes[a].links[1 - side] = Link::To(b, 1 - side);
                nodes[b].links[1 - side] = Link::To(a, 1 - side);
            }
            Step::Over(side) => nodes[last(side, 1)].links[1 - side] = Link::Rim(high),
        }
    }
}

/// The least movement that explains one column by the next (dynamic programming over how many crossings are explained).
fn plan(nodes: &[Node], columns: &[std::ops::Range<usize>; 2], high: f64) -> Plan {
    let [left, right] = columns.each_ref().map(|column| &nodes[column.clone()]);
    let (rows, across) = (left.len(), right.len());
    let mut best = vec![vec![(f64::INFINITY, Step::Match); across + 1]; rows + 1];
    best[0][0].0 = 0.0;
    for i in 0..=rows {
        for j in 0..=across {
            let mut offers = Vec::new();
            if i > 0 && j > 0 && left[i - 1].leaves == right[j - 1].leaves {
                offers.push((best[i - 1][j - 1].0, (left[i - 1].y - right[j - 1].y).abs(), Step::Match));
            }
            for (side, column, at) in [(0, left, i), (1, right, j)] {
                let before = |steps: usize| if side == 0 { best[i - steps][j].0 } else { best[i][j - steps].0 };
                if at > 1 {
                    offers.push((before(2), column[at - 1].y - column[at - 2].y, Step::Pair(side)));
                }
                if at > 0 && (i, j) == (rows, across) {
                    offers.push((before(1), high - column[at - 1].y, Step::Over(side)));
                }
            }
            for (so_far, movement, step) in offers {
                if so_far + movement < best[i][j].0 {
                    best[i][j] = (so_far + movement, step);
                }
            }
        }
    }
    let (mut i, mut j) = (rows, across);
    let movement = best[i][j].0;
    let mut steps = Vec::new();
    while (i, j) != (0, 0) && best[i][j].0.is_finite() {
        let step = best[i][j].1;
        steps.push((step, i, j));
        match step {
            Step::Match => (i, j) = (i - 1, j - 1),
            Step::Pair(0) => i -= 2,
            Step::Pair(_) => j -= 2,
            Step::Over(0) => i -= 1,
            Step::Over(_) => j -= 1,
        }
    }
    (movement, steps)
}

/// The paths that linked nodes make, as points of the map.
fn paths(nodes: &[Node]) -> Vec<Vec<(f64, f64)>> {
    let mut done = vec![false; nodes.len()];
    let mut paths = Vec::new();
    let loose = |node: &Node| node.links.iter().position(|link| !matches!(link, Link::To(..)));
    // Paths with an end first, then what is left: closed ones.
    let starts = (0..nodes.len()).filter(|at| loose(&nodes[*at]).is_some()).chain(0..nodes.len());
    for start in starts {
        if done[start] {
            continue;
        }
        let mut path = Vec::new();
        let (mut at, mut side) = (start, loose(&nodes[start]).unwrap_or(0));
        if let Link::Rim(y) = nodes[at].links[side] {
            path.push((nodes[at].x, y));
        }
        loop {
            path.push((nodes[at].x, nodes[at].y));
            if std::mem::replace(&mut done[at], true) {
                break;
            }
            match nodes[at].links[1 - side] {
                Link::To(next, entered) => (at, side) = (next, entered),
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
#[path = "../tests/inside/outline.rs"]
mod tests;
