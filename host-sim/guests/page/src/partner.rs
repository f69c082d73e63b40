//! Who holds the other hand while nobody else does: a model that says each tick where it wants its hand, as a person's pointer does.
//!
//! Its force is then that of any hand, a spring and a damper ([`super::hand`]).

use cohold_core::names::Choice;
use cohold_sim::user::minimum_jerk;

/// A kind of partner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Model {
    /// Gives way: its hand comes after the device with a time constant of 50 ms.
    #[default]
    Follows,
    /// Holds still where it took the device.
    Resists,
    /// Carries the device 40 mm to the right and back, each way a minimum-jerk reach of 1.5 s with a second of rest after it.
    CarriesOn,
    /// Has let go of the device.
    Absent,
}

impl Model {
    /// Index of this model in the list.
    pub(super) fn number(self) -> u8 {
        Self::ALL.iter().position(|model| *model == self).unwrap_or_default() as u8
    }
}

impl Choice for Model {
    const NAMES: &'static [&'static str] = &["follows", "resists", "carries-on", "absent"];
    const ALL: &'static [Self] = &[Self::Follows, Self::Resists, Self::CarriesOn, Self::Absent];
}

/// How fast a partner who follows gives way, s.
const GIVES_WAY_S: f64 = 0.05;
/// How far one who carries on goes, m; how long it takes for that, and from the beginning of one way to that of the next, s.
const FAR_M: f64 = 0.04;
const REACH_S: f64 = 1.5;
const EVERY_S: f64 = 2.5;

/// A partner at work, whose hand goes along `N` axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Partner<const N: usize = 1> {
    pub(super) model: Model,
    /// Where it took the device, m, and how long ago, s.
    took: Option<([f64; N], f64)>,
}

impl<const N: usize> Partner<N> {
    pub(super) fn new(model: Model) -> Self {
        Self { model, took: None }
    }

    /// It lets go; what it does next begins anew.
    pub(super) fn rest(&mut self) {
        self.took = None;
    }

    /// Where it wants its hand in a tick of `period` (s), m, if it holds, with its device at `device` (m).
    pub(super) fn wants(&mut self, device: [f64; N], period: f64) -> Option<[f64; N]> {
        let (from, since) = self.took.get_or_insert((device, 0.0));
        *since += period;
        match self.model {
            Model::Absent => None,
            Model::Resists => Some(*from),
            Model::Follows => {
                for (from, device) in from.iter_mut().zip(device) {
                    *from += (device - *from) * period / GIVES_WAY_S;
                }
                Some(*from)
            }
            Model::CarriesOn => {
                let (turn, within) = ((*since / EVERY_S) as u64, *since % EVERY_S);
                let (gone, _) = minimum_jerk(FAR_M, REACH_S, within);
                let mut wanted = *from;
                wanted[0] += if turn.is_multiple_of(2) { gone } else { FAR_M - gone };
                Some(wanted)
            }
        }
    }
}
