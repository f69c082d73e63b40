//! The law that says anything: each number it gives may be any, infinite or none, each time another. What is proved with it holds for
//! every law there could be, whatever is in its state and whole numbers.

use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet};
use cohold_core::num::{Configured, Motion, Scalar};
use cohold_core::object::{Port, Solve};
use cohold_core::settings::{Refused, Settings};

use crate::unknown::{Number, Unknown};

/// A law that may answer anything.
#[derive(Clone, Copy, Debug)]
pub struct Whatever;

pub(crate) fn motion() -> Motion<Number> {
    Motion::new(Number::any(), Number::any())
}

impl Configured for Whatever {}

impl Law<Number> for Whatever {
    const LAWS: &'static [LawInfo] = &[LawInfo { name: "(any law)", ..LawInfo::WAVES }];
    type State = ();

    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
    fn start(&self, _: Motion<Number>) {}
    fn receive(&self, (): &mut (), _: Packet<Number>) {}
    fn couple(&self, (): &mut (), _: &Observation<Number>, solve: impl Solve<Number>) -> Coupled<Number> {
        // It may ask for the copy's velocity, or not; where that is known, it makes no difference.
        if !solve.is_staged() && Number::any() > Number::ZERO {
            solve.velocity(Port::new(Number::any(), Number::any()));
        }
        Coupled { desired: motion(), force: Number::any(), power_in: Number::any(), power_out: Number::any() }
    }
    fn send(&self, (): &(), _: Motion<Number>) -> Packet<Number> {
        Packet {
            motion: motion(),
            wave: Number::any(),
            energy_j: Unknown::any(),
            wave_integral: Unknown::any(),
            live_ticks: 0,
        }
    }
}
