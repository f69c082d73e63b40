//! Dots: single points and the names beside them.

use super::panel::{Canvas, NAME, lattice};
use super::sheet::{Anchor, Frame, INK, Mark, Point, Text, color};
use super::{Series, Shape, font};

/// Radius of dots.
pub(crate) const DOT: f64 = 7.0;

impl Canvas<'_> {
    pub(super) fn dots(&mut self, points: &[(f64, f64)], number: usize) {
        let visible: Vec<Point> = self.pixels(points).into_iter().filter(|p| self.frame.contains(*p)).collect();
        self.out.marks.extend(visible.iter().map(|at| Mark::Disc { at: *at, radius: DOT, color: color(number) }));
        self.out.obstacles.extend(visible);
    }

    /// Writes each name beside its dot, where it covers the least.
    pub(super) fn names(&mut self, series: &[&Series]) {
        let named = series.iter().filter_map(|s| match &s.shape {
            Shape::Dots { points, names } => Some(self.pixels(points).into_iter().zip(names.clone())),
            _ => None,
        });
        let named: Vec<(Point, String)> = named.flatten().filter(|(at, _)| self.frame.contains(*at)).collect();
        let mut taken: Vec<Frame> = Vec::new();
        for (at, name) in named {
            let (width, gap) = (font::width(&name, NAME), DOT + 5.0);
            let sides =
                [(1.0, 0.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let place = |(sx, sy): (f64, f64)| {
                let (x, y) = (at.0 + sx * (width / 2.0 + gap), at.1 + sy * (NAME / 2.0 + gap));
                Frame { left: x - width / 2.0, right: x + width / 2.0, top: y - NAME / 2.0, bottom: y + NAME / 2.0 }
            };
            let cost = |area: &Frame| {
                let inside = area.corners().into_iter().all(|corner| self.frame.grown(-3.0).contains(corner));
                let names = taken.iter().filter(|other| area.overlaps(&other.grown(2.0))).count();
                let data = self.out.obstacles.iter().filter(|p| area.grown(DOT - 2.0).contains(**p)).count();
                usize::from(!inside) * 100_000 + names * 1_000 + data
            };
            if let Some(area) = sides.map(place).into_iter().min_by_key(cost) {
                taken.push(area);
                let at = (area.left, area.bottom - 4.0);
                self.out.marks.push(Mark::Text(Text {
                    at,
                    anchor: Anchor::Start,
                    size: NAME,
                    color: INK,
                    upward: false,
                    text: name,
                }));
            }
        }
        taken.iter().for_each(|area| self.out.obstacles.extend(lattice(area)));
    }
}
