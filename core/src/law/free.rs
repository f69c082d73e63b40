//! No coordination: the scene has one peer, or two that do not feel each other. Also the least a law can be.

use super::{Coupled, Law, Packet, Sends};
use crate::model::Model;
use crate::num::{Motion, Scalar};
use crate::settings::Settings;

/// The law that does nothing.
#[derive(Clone, Copy, Debug)]
pub struct Free;

impl<S: Scalar> Model<S> for Free {
    type State = ();
    fn build(_: &Settings) -> Self {
        Self
    }
}

impl<S: Scalar> Law<S> for Free {
    fn sends(&self) -> Sends {
        Sends::Nothing
    }
    fn start(&self, (): &mut (), _: Motion<S>) {}
    fn receive(&self, (): &mut (), _: Packet<S>) {}
    fn couple(&self, (): &mut (), local: Motion<S>) -> Coupled<S> {
        Coupled { desired: local, ..Coupled::default() }
    }
    fn send(&self, (): &(), _: Motion<S>) -> Packet<S> {
        Packet::default()
    }
}
