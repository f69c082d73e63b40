//! No coordination: the scene has one peer, or two that do not feel each other. Also the least a law can be.

use super::{Law, LawInfo, Packet, Sends};
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// The law that does nothing.
#[derive(Clone, Copy, Debug)]
pub struct Free;

configured!([] Free {});

impl<S: Scalar> Law<S> for Free {
    const LAWS: &'static [LawInfo] = &[LawInfo { name: "none", sends: Sends::Nothing, ..LawInfo::MOTION }];
    type State = ();

    fn build(_: &Settings) -> Result<Self, Refused<'static>> {
        Ok(Self)
    }
    fn start(&self, _: Motion<S>) {}
    fn receive(&self, (): &mut (), _: Packet<S>) {}
    fn send(&self, (): &(), _: Motion<S>) -> Packet<S> {
        Packet::default()
    }
}
