//! What stands at the inputs of bridges and amplifiers, and what these make of it.

use rigless::mcu::Operate;
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use serde::{Deserialize, Serialize};

use super::{MOTORS, Part};

/// What the wiring has for a gate between PF3, PE14 and the amplifiers' enable, whose output goes back to PD15.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gate {
    /// An AND of both, as docs/guides/board/assembly.md wants it.
    #[default]
    Both,
    /// PF3 alone: there is no gate.
    EnableAlone,
    /// PE14 alone.
    TimerAlone,
    /// It never opens, or the wire back is off.
    NeverOpens,
    /// Its output is at 3.3 V, whatever its inputs are.
    AlwaysOpen,
}

/// What stands at the inputs of bridges or amplifiers, and at their enable line, at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bridges {
    /// Compare values of the timer's channels: the legs of bridge 1, and those of bridge 2; or the first legs of three, and the gate.
    pub compare: [u16; 4],
    /// The channels' complements are there, too: the second legs of three bridges.
    pub three: bool,
    /// Counts from the bottom of the timer's period to its top.
    pub top: u16,
    /// The timer runs, its outputs are enabled.
    pub outputs: bool,
    /// The enable line is high.
    pub enable: bool,
    /// The timer's fourth channel is on its pin, PE14.
    pub fourth: bool,
    /// What the amplifiers' enable goes through.
    pub gate: Gate,
    /// There is a motor with a controller of its own instead: it was spoken to.
    pub by_controller: bool,
    /// Its torque, N·m; none while its windings are free.
    pub torque_nm: Option<f64>,
}

impl Bridges {
    /// Voltage of each of two bridges in steps of which [`Bridges::top`] are all of the supply.
    pub fn voltages(&self) -> [i32; 2] {
        let [one, two, three, four] = self.compare.map(i32::from);
        [one - two, three - four]
    }

    /// What amplifiers are commanded, as shares of their full current; nothing while they are not enabled.
    pub fn currents(&self) -> Option<[f64; MOTORS]> {
        self.gate_passes().then(|| self.commands())
    }

    /// The same of amplifiers that the enable line alone enables.
    pub fn currents_without_gate(&self) -> Option<[f64; MOTORS]> {
        self.enable.then(|| self.commands())
    }

    /// Whether the gate's output is high.
    pub fn gate_passes(&self) -> bool {
        let timer = self.fourth && self.outputs && self.compare[3] > self.top;
        match self.gate {
            Gate::Both => self.enable && timer,
            Gate::EnableAlone => self.enable,
            Gate::TimerAlone => timer,
            Gate::NeverOpens => false,
            Gate::AlwaysOpen => true,
        }
    }

    /// What stands at amplifiers' inputs, as shares of their full current: while the timer's outputs are off these are low, which is all of
    /// the current backwards.
    fn commands(&self) -> [f64; MOTORS] {
        let [one, two, three, _] = self.compare;
        let legs = if self.three { [one, two, three] } else { [one, three, self.top / 2] };
        let middle = f64::from(self.top / 2);
        legs.map(|leg| if self.outputs { (f64::from(leg) - middle) / middle } else { -1.0 })
    }

    /// Whether current can flow at all.
    pub fn on(&self) -> bool {
        if self.by_controller { self.torque_nm.is_some() } else { self.outputs && self.enable }
    }
}

impl Part {
    /// What the bridges are commanded now.
    pub fn bridges(&mut self, at: VirtualNanos) -> Bridges {
        let (by_controller, torque_nm) = (self.can.frames != [0; 2], self.can.controller.torque_nm(at.0));
        let mut peek = |address| self.peek(at, address, Width::W32).unwrap_or(0);
        let (mode, output) = (peek(0x5802_1400), peek(0x5802_1414));
        // Port E: mode and alternate function of pin 14.
        let (pins, function) = (peek(0x5802_1000), peek(0x5802_1024));
        // CC1NE, CC2NE, CC3NE, and CC4E.
        const COMPLEMENTS: u64 = 1 << 2 | 1 << 6 | 1 << 10;
        const FOURTH: u64 = 1 << 12;
        let channels = peek(0x4001_0020);
        Bridges {
            compare: [0x34, 0x38, 0x3C, 0x40].map(|register| peek(0x4001_0000 + register) as u16),
            three: channels & COMPLEMENTS == COMPLEMENTS,
            top: peek(0x4001_002C) as u16,
            outputs: peek(0x4001_0000) & 1 != 0 && peek(0x4001_0044) & 1 << 15 != 0,
            enable: mode >> 6 & 3 == 1 && output & 1 << 3 != 0,
            fourth: pins >> 28 & 3 == 2 && function >> 24 & 15 == 1 && channels & FOURTH != 0,
            gate: self.gate,
            by_controller,
            torque_nm,
        }
    }
}
