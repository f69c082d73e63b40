//! What incremental encoders say: counts, edges of both channels, and where the index was; and how one of them fails.
//!
//! Gray code: A is high in the second and third quarter of a period of four counts, B in the third and fourth. Within a tick an
//! encoder goes the shortest way. Units: counts, from where the device was built.

use std::array::from_fn;

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::settings::Settings;

use crate::scene::PlantFault;

/// Steps after which either channel has had two edges.
const ENOUGH: u64 = 16;

/// The encoders of a device.
#[derive(Clone, Debug)]
pub(super) struct Encoders<const N: usize> {
    /// Counts from one index to the next, and where one is; none without.
    index: Option<(i64, i64)>,
    /// Where they are, and were at the tick before.
    at: [i64; N],
    before: [i64; N],
    /// Of the first: how it fails, and where it was when it began to.
    fault: Option<(PlantFault, i64)>,
    ticks: u32,
}

fn high(count: i64) -> [bool; 2] {
    let phase = count.rem_euclid(4);
    [phase == 1 || phase == 2, phase >= 2]
}

impl<const N: usize> Encoders<N> {
    /// At these counts, with as many of them to the metre or radian.
    pub(super) fn new(settings: &Settings, counts_per_unit: f64, at: [i64; N]) -> Self {
        let turn = match settings.kinematics.model {
            KinematicsName::Direct => i64::MAX,
            _ => settings.encoder.counts_per_rev.round() as i64,
        };
        let place = (settings.encoder.index_at_m_or_rad * counts_per_unit).round() as i64;
        Self { index: settings.encoder.index.then_some((turn, place)), at, before: at, fault: None, ticks: 0 }
    }

    /// The first one fails, from where it is.
    pub(super) fn fail(&mut self, fault: PlantFault) {
        self.fault = Some((fault, self.at[0]));
    }

    /// Takes the joints' positions (counts) at the end of the next tick.
    pub(super) fn turn(&mut self, at: [i64; N]) {
        (self.before, self.at) = (self.at, at);
        self.ticks = self.ticks.wrapping_add(1);
    }

    /// What the counter of one says when it is there.
    fn counter(&self, joint: usize, at: i64) -> i64 {
        let Some((fault, from)) = self.fault.filter(|_| joint == 0) else { return at };
        let [a, b] = [0, 1].map(|channel: usize| i64::from(high(at)[channel] != high(from)[channel]));
        match fault {
            PlantFault::EncoderStuck => from,
            PlantFault::EncoderWithoutA => from + b,
            PlantFault::EncoderWithoutB => from + a,
            PlantFault::EncoderDithers => from + i64::from(self.ticks % 2),
            PlantFault::EncoderReversed => 2 * from - at,
            PlantFault::EncoderHalved => from + (at - from).div_euclid(2),
            PlantFault::EncoderLoses => at - 40,
            _ => at,
        }
    }

    /// What the counters say.
    pub(super) fn counts(&self) -> [Counts; N] {
        from_fn(|joint| Counts(self.counter(joint, self.at[joint]) as u16))
    }

    /// What they showed beside it since the tick before.
    pub(super) fn marks(&self) -> [Marks; N] {
        from_fn(|joint| {
            let (before, at) = (self.before[joint], self.at[joint]);
            let (direction, steps) = ((at - before).signum(), (at - before).unsigned_abs().min(ENOUGH));
            let mut edges = [0_u8; 2];
            for step in 0..steps as i64 {
                let [from, to] = [before + direction * step, before + direction * (step + 1)].map(high);
                for (edges, (from, to)) in edges.iter_mut().zip(from.into_iter().zip(to)) {
                    *edges = (*edges + u8::from(!from && to)).min(2);
                }
            }
            let fault = self.fault.filter(|_| joint == 0).map(|(fault, _)| fault);
            match fault {
                Some(PlantFault::EncoderStuck) => edges = [0; 2],
                Some(PlantFault::EncoderWithoutA) => edges[0] = 0,
                Some(PlantFault::EncoderWithoutB) => edges[1] = 0,
                Some(PlantFault::EncoderDithers) => edges = [(self.ticks % 2) as u8, 0],
                _ => {}
            }
            let index = self.index.and_then(|(turn, place)| {
                let [was, is] = [before, at].map(|at| (at - place).div_euclid(turn));
                (was != is).then(|| Counts(self.counter(joint, was.max(is) * turn + place) as u16))
            });
            let [once, again] = [0, 1].map(|rises| edges.map(|edges| edges > rises));
            Marks::of(once, again, index)
        })
    }
}
