//! A copy of the object that is the hub's own, and nobody's hand touches: where lines meet that are ports of what they pull at.
//!
//! Every line ends in the coordination law that flies, and all of them push on one more mass m_O, which is solved for once a tick
//! (THEORY §7): each law gives its port, and gets the mean velocity that all ports together lead to. So a line that stands holds
//! the copy by its spring, as it holds a peer's, and lets go as it does there, by a force that falls ([`Remnant`]); what the copy does to one
//! line, the others take.
//! Energy: each end of a line emits no more than it was given (THEORY §8), the copy and the springs start at rest, so that what goes
//! back into all lines never is more than what came out of them. Of several shared axes each has a copy of its own.

use cohold_core::law::degradation::Remnant;
use cohold_core::law::{AnyLaw, AnyLawState, Coupled, Law, Observation, Packet, Spring};
use cohold_core::model::Model as _;
use cohold_core::num::Motion;
use cohold_core::object::{Port, midpoint::Carries, midpoint::Midpoint};
use cohold_core::settings::{Refused, Settings};

/// The copy, and the hub's ends of its lines.
#[derive(Clone, Debug)]
pub(super) struct SharedCopy {
    law: AnyLaw<f64>,
    spring: Spring<f64>,
    /// What is left of a force is no more than a device may show, N.
    most_n: f64,
    midpoint: Midpoint<f64>,
    carries: Carries<f64>,
    ends: Vec<End>,
}

/// The hub's end of a line, and what it did in the last tick.
#[derive(Clone, Copy, Debug)]
struct End {
    state: AnyLawState<f64>,
    coupled: Coupled<f64>,
    /// What is left of its force when the line has let go.
    remnant: Remnant<f64>,
}

impl SharedCopy {
    /// At rest at 0, with so many lines.
    pub(super) fn build(settings: &Settings, lines: usize) -> Result<Self, Refused<'static>> {
        let law = AnyLaw::build(settings)?;
        Ok(Self {
            ends: vec![
                End { state: law.start(Motion::REST), coupled: Coupled::default(), remnant: Remnant::default() };
                lines
            ],
            law,
            spring: Spring::build(settings),
            most_n: settings.safety.max_force_n,
            midpoint: Midpoint::build(settings)?,
            carries: Carries::default(),
        })
    }

    /// Begins a line anew, where the copy is.
    pub(super) fn restart(&mut self, line: usize, at: Motion<f64>) {
        self.law.restart(&mut self.ends[line].state, at);
    }

    /// Takes in a packet on a line.
    pub(super) fn hear(&mut self, line: usize, packet: Packet<f64>) {
        self.law.receive(&mut self.ends[line].state, packet);
    }

    /// What goes back into a line now.
    pub(super) fn back(&self, line: usize, at: Motion<f64>) -> Packet<f64> {
        self.law.send(&self.ends[line].state, at)
    }

    /// What a line did in the last tick.
    pub(super) fn coupled(&self, line: usize) -> Coupled<f64> {
        self.ends[line].coupled
    }

    /// Lets go of a line, with the copy there.
    pub(super) fn let_go(&mut self, line: usize, at: Motion<f64>) {
        let end = &mut self.ends[line];
        end.remnant = Remnant::of(end.coupled.force.clamp(-self.most_n, self.most_n), at, &self.spring);
    }

    /// One tick of the copy from `at`, under all lines that are engaged, and what is left of the others; where it is then.
    pub(super) fn tick(&mut self, engaged: impl Fn(usize) -> bool, at: Motion<f64>) -> Motion<f64> {
        let seen = Observation { local: at, contact_force: 0.0, age_ticks: 0 };
        let mut half_change = 0.0;
        let mut solve = |all: Port<f64>| {
            half_change = self.midpoint.half_change(at.velocity, all);
            at.velocity + half_change
        };
        let mut left = Port::default();
        for end in &mut self.ends {
            end.coupled = Coupled::default();
            left = left + end.remnant.port(at, &self.spring);
            end.remnant.fall();
        }
        let mut lines = self.ends.iter_mut().enumerate().filter(|(line, _)| engaged(*line)).map(|(_, end)| end);
        meet(&self.law, &mut lines, &seen, left, &mut solve);
        self.midpoint.advance(&mut self.carries, at, half_change)
    }
}

/// The next line says what its port is and waits for what the lines after it come to; the last asks for the velocity, m/s.
fn meet(
    law: &AnyLaw<f64>,
    lines: &mut dyn Iterator<Item = &mut End>,
    seen: &Observation<f64>,
    before: Port<f64>,
    solve: &mut dyn FnMut(Port<f64>) -> f64,
) -> f64 {
    let Some(End { state, coupled, .. }) = lines.next() else { return solve(before) };
    let mut velocity = 0.0;
    *coupled = law.couple(state, seen, |own: Port<f64>| {
        velocity = meet(law, lines, seen, before + own, solve);
        velocity
    });
    velocity
}
