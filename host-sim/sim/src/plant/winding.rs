//! The winding of one motor behind an H-bridge: L·di/dt = u − R·i − emf over one PWM period, exactly, from edge to edge.
//!
//! Unipolar, centre-aligned: a period begins and ends in the middle of a zero vector, has another in its middle, and the supply is
//! on in between, twice, for the share of the period that is asked for. The back-EMF is constant through a period.
//!
//! **Dead time**, in which both switches of a leg are off and the current chooses its diode, takes 2·supply·t_dead from what drives
//! the current, whichever way it flows, and no more than stops it: as friction does, and computed like it, once a period.
//!
//! Units: A, V, s. Left out: saturation of the iron, what switches drop and how long they take, a supply that gives way.

use cohold_core::device::current::PWM_PERIOD_S;

/// A winding and its supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// Resistance R of the winding, Ω.
    pub resistance_ohm: f64,
    /// Inductance L of the winding, H.
    pub inductance_h: f64,
    /// Voltage of the bridge, V.
    pub supply_v: f64,
    /// Time in which neither switch of a leg is on, at each edge, s.
    pub dead_time_s: f64,
}

/// The current of one PWM period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flow {
    /// Current at the instant of sampling, A.
    pub sampled_a: f64,
    /// Mean current, which is what makes force, A.
    pub mean_a: f64,
    /// Current at the end of the period, A.
    pub end_a: f64,
}

impl Winding {
    /// One PWM period from a current on: `share` of the supply (−1 to 1) against a back-EMF (V), sampled `sample_s` after its start.
    pub fn period(&self, current_a: f64, share: f64, emf_v: f64, sample_s: f64) -> Flow {
        let on = share.abs().min(1.0) * PWM_PERIOD_S;
        let (outer, pulse) = (self.stretch(0.25 * (PWM_PERIOD_S - on)), self.stretch(0.5 * on));
        let middle = outer.then(outer);
        let volts = self.supply_v.copysign(share);
        let (mut now, mut at_s, mut charge, mut sampled_a) = (current_a, 0.0, 0.0, current_a);
        for (volts, stretch) in [(0.0, outer), (volts, pulse), (0.0, middle), (volts, pulse), (0.0, outer)] {
            let drive = volts - emf_v;
            if sample_s > 0.0 && (at_s..at_s + stretch.lasts_s).contains(&sample_s) {
                sampled_a = self.after(now, drive, self.stretch(sample_s - at_s)).0;
            }
            let (end, passed) = self.after(now, drive, stretch);
            (now, charge, at_s) = (end, charge + passed, at_s + stretch.lasts_s);
        }
        if self.dead_time_s == 0.0 {
            return Flow { sampled_a, mean_a: charge / PWM_PERIOD_S, end_a: now };
        }
        let lost_v = 2.0 * self.supply_v * self.dead_time_s / PWM_PERIOD_S;
        let whole = middle.then(middle).then(pulse).then(pulse);
        let (brake_a, braked) = self.after(0.0, lost_v, whole);
        let braking = (now / brake_a).clamp(-1.0, 1.0);
        let before_a = if sample_s > 0.0 { self.after(0.0, lost_v, self.stretch(sample_s)).0 } else { 0.0 };
        Flow {
            sampled_a: sampled_a - braking * before_a,
            mean_a: (charge - braking * braked) / PWM_PERIOD_S,
            end_a: now - braking * brake_a,
        }
    }

    fn stretch(&self, lasts_s: f64) -> Stretch {
        Stretch { lasts_s, gone: -libm::expm1(-lasts_s * self.resistance_ohm / self.inductance_h) }
    }

    /// The current after a stretch under a constant voltage, and the charge that has passed.
    fn after(&self, current_a: f64, volts: f64, Stretch { lasts_s, gone }: Stretch) -> (f64, f64) {
        let (toward, time_s) = (volts / self.resistance_ohm, self.inductance_h / self.resistance_ohm);
        (current_a + (toward - current_a) * gone, toward * lasts_s + (current_a - toward) * time_s * gone)
    }
}

/// A time under a constant voltage, s, and the share of the way to where that leads which is gone by its end.
#[derive(Clone, Copy)]
struct Stretch {
    lasts_s: f64,
    gone: f64,
}

impl Stretch {
    /// This one and then the other.
    fn then(self, other: Self) -> Self {
        Self { lasts_s: self.lasts_s + other.lasts_s, gone: self.gone + other.gone - self.gone * other.gone }
    }
}
