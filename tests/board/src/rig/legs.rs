//! PE9 and PE14 of the board under test, edge by edge, from its timer's registers.
//!
//! The timer counts up and down; its pins are high while it is below their compare values, which it takes where it turns below. There the
//! board's node stops, so that a period's edges are known when it begins; what turns the outputs off in between is seen at the next stop.

use std::collections::VecDeque;

use crate::part::Bridges;
use crate::part::pins::{Edge, Place};

/// PE9 and PE14 where they end: at the rig.
const FIRST_LEG: Place = Place::of("PA5");
const GATE: Place = Place::of("PB10");

/// The two pins.
#[derive(Debug, Default)]
pub(super) struct Legs {
    /// Edges of PE9 that are still to come in this period: when (ns), and to which level.
    planned: VecDeque<(u64, bool)>,
    first: bool,
    gate: bool,
}

impl Legs {
    /// The board stands at `now`, and its timer updates there, or not. Edges since the last stop.
    pub(super) fn see(&mut self, now: u64, bridges: &Bridges, updates: bool) -> Vec<Edge> {
        let mut edges = Vec::new();
        while let Some((at, high)) = self.planned.pop_front_if(|(at, _)| *at <= now) {
            self.first = high;
            edges.push(Edge { at, place: FIRST_LEG, high });
        }
        let [compare, .., gate] = bridges.compare;
        if !bridges.outputs {
            self.planned.clear();
        } else if updates {
            let ns = |counts: u32| now + u64::from(counts) * 25 / 6;
            let (top, compare) = (u32::from(bridges.top), u32::from(compare));
            if compare < top {
                self.planned.extend([(ns(compare), false), (ns(2 * top - compare), true)]);
            }
        }
        let first = bridges.outputs && (self.first || updates && compare > 0);
        if first != core::mem::replace(&mut self.first, first) {
            edges.push(Edge { at: now, place: FIRST_LEG, high: first });
        }
        let gate = bridges.fourth && bridges.outputs && gate > bridges.top;
        if gate != core::mem::replace(&mut self.gate, gate) {
            edges.push(Edge { at: now, place: GATE, high: gate });
        }
        edges
    }
}
