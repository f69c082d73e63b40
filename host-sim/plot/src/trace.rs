//! Traces: what a long line looks like in pixels.
//!
//! [`polylines`] takes points in pixels through three steps, each of which keeps the picture: split at gaps, thin out
//! to the lowest and highest point of each run inside one column of pixels, cut at the frame. [`steps`] and [`dashes`]
//! turn a held signal and a broken line into plain ones.

use super::sheet::{Frame, Point};

/// Positions further out than this many pixels are moved to it: cutting stays exact where it matters.
const FAR: f64 = 1e7;

/// The visible pieces of the line through these pixels; NaN leaves a gap, an infinite height leaves through the edge.
pub(crate) fn polylines(points: &[Point], frame: &Frame) -> Vec<Vec<Point>> {
    let runs = points.split(|(x, y)| x.is_nan() || y.is_nan() || x.is_infinite());
    runs.filter(|run| run.len() > 1).flat_map(|run| cut(&thinned(run), frame)).collect()
}

/// The points in reach of a sheet, thinned out by columns of pixels.
pub(crate) fn thinned(points: &[Point]) -> Vec<Point> {
    let near = |(x, y): &Point| (x.clamp(-FAR, FAR), y.clamp(-FAR, FAR));
    extremes(&points.iter().map(near).collect::<Vec<_>>(), |(x, _)| x.floor())
}

/// At most two points (the lowest and the highest, in their order) of each run of points in one column, and always the first and the
/// last point.
pub(crate) fn extremes(points: &[Point], column: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut kept = Vec::new();
    kept.extend(points.first());
    for run in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &&Point, b: &&Point| a.1.total_cmp(&b.1);
        let (low, high) = (run.iter().min_by(by_height), run.iter().max_by(by_height));
        let first = run.iter().find(|p| Some(*p) == low || Some(*p) == high);
        let second = if first == low { high } else { low };
        kept.extend(first);
        kept.extend(second.filter(|p| Some(*p) != first));
    }
    kept.extend(points.last());
    kept.dedup();
    kept
}

/// The pieces of a line that lie inside the frame.
fn cut(points: &[Point], frame: &Frame) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in points.windows(2) {
        let [from, to] = pair else { continue };
        let Some((start, end)) = segment_inside(*from, *to, frame) else { continue };
        match pieces.last_mut().filter(|piece| piece.last() == Some(&start)) {
            Some(piece) => piece.push(end),
            None => pieces.push(vec![start, end]),
        }
    }
    pieces
}

/// Liang and Barsky's clipping: the part of a segment inside the frame.
fn segment_inside(from: Point, to: Point, frame: &Frame) -> Option<(Point, Point)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let sides = [
        (-dx, from.0 - frame.left),
        (dx, frame.right - from.0),
        (-dy, from.1 - frame.top),
        (dy, frame.bottom - from.1),
    ];
    for (direction, distance) in sides {
        if direction == 0.0 && distance < 0.0 {
            return None;
        } else if direction < 0.0 {
            enter = enter.max(distance / direction);
        } else if direction > 0.0 {
            leave = leave.min(distance / direction);
        }
    }
    let at = |t: f64| match t {
        0.0 => from,
        1.0 => to,
        t => (from.0 + t * dx, from.1 + t * dy),
    };
    (enter <= leave).then(|| (at(enter), at(leave)))
}

/// The strokes of a line that is broken by a pattern of stroke and gap lengths; the line itself if there is no pattern.
pub(crate) fn dashes(points: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    if pattern.is_empty() || pattern.iter().any(|length| *length <= 0.0) {
        return vec![points.to_vec()];
    }
    let mut lengths = pattern.iter().enumerate().cycle();
    let mut next = || lengths.next().map_or((true, f64::INFINITY), |(i, length)| (i % 2 == 0, *length));
    let (mut drawing, mut left) = next();
    let mut strokes: Vec<Vec<Point>> = vec![points.iter().take(1).copied().collect()];
    for pair in points.windows(2) {
        let [mut from, to] = [pair[0], pair[1]];
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            let part = if length > left { left / length } else { 1.0 };
            let reached =
                if part < 1.0 { (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)) } else { to };
            if let Some(stroke) = strokes.last_mut().filter(|_| drawing) {
                stroke.push(reached);
            }
            if part == 1.0 {
                left -= length;
                break;
            }
            from = reached;
            (drawing, left) = next();
            if drawing {
                strokes.push(vec![reached]);
            }
        }
    }
    strokes.retain(|stroke| stroke.len() > 1);
    strokes
}

#[cfg(test)]
#[path = "../tests/inside/trace.rs"]
mod tests;
