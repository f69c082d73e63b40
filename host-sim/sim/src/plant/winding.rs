//! The winding of one motor behind an H-bridge: L·di/dt = u − R·i − emf over one PWM period, exactly, from edge to edge.
//!
//! Unipolar, centre-aligned: a period begins and ends in the middle of a zero vector, has another in its middle, and the supply is
//! on in between, twice, for the share of the period that is asked for. The back-EMF is constant through a period.
//!
//! **Dead time**, in which both switches of a leg are off and the current chooses its diode, takes 2·supply·t_dead from what drives
//! the current, whichever way it flows, and no more than stops it: as friction does, and computed like it, once a period.
//!
//! Units: A, V, s. Left out: saturation of the iron, what switches drop and how long they take, a supply that gives way.

use haptic_core::device::current::PWM_PERIOD_S;

/// A winding and its supply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Winding {
    /// R, Ω.
    pub resistance_ohm: f64,
    /// L, H.
    pub inductance_h: f64,
    /// Voltage of the bridge, V.
    pub supply_v: f64,
    /// Time in which neither switch of a leg is on, at each edge, s.
    pub dead_time_s: f64,
}

/// The current of one PWM period.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flow {
    /// When it was sampled, A.
    pub sampled_a: f64,
    /// Its mean, which is what makes force, A.
    pub mean_a: f64,
    /// At the end, A.
    pub end_a: f64,
}

impl Winding {
    /// One PWM period from a current on: `share` of the supply (−1 to 1) against a back-EMF (V), sampled `sample_s` after its start.
    pub fn period(&self, current_a: f64, share: f64, emf_v: f64, sample_s: f64) -> Flow {
        let on = share.abs().min(1.0) * PWM_PERIOD_S;
        let off = PWM_PERIOD_S - on;
        let volts = self.supply_v.copysign(share);
        let (mut now, mut at_s, mut charge, mut sampled_a) = (current_a, 0.0, 0.0, current_a);
        for (volts, lasts_s) in
            [(0.0, 0.25 * off), (volts, 0.5 * on), (0.0, 0.5 * off), (volts, 0.5 * on), (0.0, 0.25 * off)]
        {
            let drive = volts - emf_v;
            if (at_s..at_s + lasts_s).contains(&sample_s) {
                sampled_a = self.after(now, drive, sample_s - at_s).0;
            }
            let (end, passed) = self.after(now, drive, lasts_s);
            (now, charge, at_s) = (end, charge + passed, at_s + lasts_s);
        }
        let lost_v = 2.0 * self.supply_v * self.dead_time_s / PWM_PERIOD_S;
        let (brake_a, braked) = self.after(0.0, lost_v, PWM_PERIOD_S);
        let braking = if brake_a > 0.0 { (now / brake_a).clamp(-1.0, 1.0) } else { 0.0 };
        Flow {
            sampled_a: sampled_a - braking * self.after(0.0, lost_v, sample_s).0,
            mean_a: (charge - braking * braked) / PWM_PERIOD_S,
            end_a: now - braking * brake_a,
        }
    }

    /// The current after a time under a constant voltage, and the charge that has passed.
    fn after(&self, current_a: f64, volts: f64, lasts_s: f64) -> (f64, f64) {
        let (toward, time_s) = (volts / self.resistance_ohm, self.inductance_h / self.resistance_ohm);
        let gone = -libm::expm1(-lasts_s / time_s);
        (current_a + (toward - current_a) * gone, toward * lasts_s + (current_a - toward) * time_s * gone)
    }
}
