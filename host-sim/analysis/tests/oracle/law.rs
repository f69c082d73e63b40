//! The coordination laws as feedback rows: what F_T, ẋ_d and u_out of a tick depend on.
//!
//! Equations: THEORY §2, §7; cooperation paper (1), (2), (4)–(7), (13), (14).

use cohold_core::law::wave::Decode;
use cohold_core::settings::Value;
use cohold_sim::scene::Scene;

use super::peer::Input::{Coordination, Decoded, Emitted, Wave};
use super::peer::State::{
    CoordinationForce, DesiredPosition, DesiredVelocity, Outgoing, Outstanding, TautForce, TautSooner, TautWay,
};
use super::peer::{ConstructedPeer, decay};
use crate::lifted::delay::delays_ticks;

/// ρ of a line of stated credit d₀ whose mass b·d₀·T_c is not to exceed `coordination.most_line_mass_kg` (THEORY §11); 1 for any other law.
fn light_share(scene: &Scene) -> f64 {
    if scene.peer.coordination.comm != "self-timed" {
        return 1.0;
    }
    let [credit, most_kg] =
        ["coordination.credit_ticks", "coordination.most_line_mass_kg"].map(|key| number(scene, key));
    let mass_kg = credit * scene.peer.timing.control_period_s * scene.peer.coordination.wave_impedance_n_s_per_m;
    // In steps of 1/1024, no less than a quarter.
    let share = || ((1024.0 * most_kg / mass_kg).round() / 1024.0).max(0.25);
    if most_kg > 0.0 && mass_kg > most_kg { share() } else { 1.0 }
}

/// Key of what makes a line taut.
pub(super) const TAUTNESS: &str = "coordination.tautness";

/// A number of a scene; 0 where there is none.
pub(super) fn number(scene: &Scene, key: &str) -> f64 {
    match scene.get(key) {
        Some(Value::Number(number)) => number,
        _ => 0.0,
    }
}

impl ConstructedPeer {
    /// F_T = K_T·(x_d − x_o) + B_T·(ẋ_d − ẋ_o) with x_d, ẋ_d as received.
    pub(super) fn power(&mut self, scene: &Scene) {
        let (k, b) = (scene.peer.coordination.stiffness_n_per_m, scene.peer.coordination.damping_n_s_per_m);
        for (held, gain) in [k, b].into_iter().enumerate() {
            self.h[(Coordination as usize, held)] = gain;
        }
        self.resist(Coordination, k, b, scene.peer.timing.control_period_s);
    }

    /// The mean of k samples that are outstanding comes out, u_in = (R + r)/(k·T_c) with r what this tick's packet brought, and
    /// R ← R + r − T_c·u_in (THEORY §8). A packet each tick, the same delay both ways and a credit d₀ that is stated: then
    /// k = d₀ − n_t at every tick. `None` for others.
    pub(super) fn emitted(&mut self, scene: &Scene) -> Option<()> {
        let (period, [there, back]) = (scene.peer.timing.control_period_s, delays_ticks(scene));
        let credit = number(scene, "coordination.credit_ticks");
        if credit <= 0.0 || scene.peer.timing.ticks_per_packet != 1 || there != back {
            return None;
        }
        let samples = credit - there as f64;
        if samples < 1.0 {
            return None;
        }
        let (outstanding, emitted) = (self.at(Outstanding), Emitted as usize);
        self.f[(emitted, outstanding)] = 1.0 / (samples * period);
        self.h[(emitted, 0)] = 1.0 / (samples * period);
        self.b[(outstanding, emitted)] = (samples - 1.0) * period;
        Some(())
    }

    pub(super) fn wave(&mut self, scene: &Scene) {
        let (coordination, period) = (&scene.peer.coordination, scene.peer.timing.control_period_s);
        // A long self-timed line is of ρ·b, for which waves keep the unit of b: ρ·b·w + F_T = ρ·√(2b)·u_in, u_out = √(2b)·w − u_in.
        let (whole, share) = (coordination.wave_impedance_n_s_per_m, light_share(scene));
        let impedance = share * whole;
        // A live end that can carry on has a damper D = 200·κ in a row with its spring, which the force before drives (THEORY §11):
        // F_T = σ·(K_T·(s − F₋·T_c/D) + κ·(w − v)) + (1 − σ)·F₋ with σ = D/(D + κ).
        let own = number(scene, "coordination.carry_damping_n_s_per_m") > 0.0;
        let softer = if own && coordination.comm == "self-timed" { 200.0 / 201.0 } else { 1.0 };
        let [k, damping] = [coordination.stiffness_n_per_m, coordination.damping_n_s_per_m].map(|gain| softer * gain);
        let root = (2.0 * whole).sqrt();
        let [x_d, v_d, force, out] =
            [DesiredPosition, DesiredVelocity, CoordinationForce, Outgoing].map(|state| self.at(state));
        let [coordination_row, decoded, wave] = [Coordination, Decoded, Wave].map(|input| input as usize);

        // ẋ_d = (√(2b)·u_in − F_T)/b with F_T of the tick before, or of this one.
        match scene.peer.coordination.comm {
            "self-timed" => self.g[(decoded, Emitted as usize)] = root / whole,
            _ => self.h[(decoded, 0)] = root / whole,
        }
        self.a[(x_d, x_d)] = 1.0;
        self.f[(coordination_row, x_d)] = k;
        if softer < 1.0 {
            let kappa = self.within().unwrap_or(1.0) * k * period + damping;
            self.f[(coordination_row, force)] = 1.0 - softer - k * period * softer / (200.0 * kappa);
            self.taut(scene, share, [k, kappa]);
        }
        match coordination.decode {
            Decode::Delayed => {
                self.f[(decoded, force)] = -1.0 / impedance;
                self.a[(x_d, v_d)] = period;
                self.f[(coordination_row, v_d)] = k * period;
                self.g[(coordination_row, decoded)] = damping;
            }
            Decode::Implicit => {
                self.g[(decoded, coordination_row)] = -1.0 / impedance;
                self.b[(x_d, decoded)] = period;
                // The spring as it is at the tick's end, or midway.
                let through = self.within().unwrap_or(1.0) * period;
                self.g[(coordination_row, decoded)] = damping + k * through;
            }
        }
        self.resist(Coordination, k, damping, period);
        self.b[(v_d, decoded)] = 1.0;
        self.b[(force, coordination_row)] = 1.0;

        // u_out = (b·ẋ_d − F_T)/√(2b), straight out, through ẋ_f = −Ω·x_f + u_out, y = Ω·x_f, or as the mean of M.
        self.g[(wave, decoded)] = whole / root;
        self.g[(wave, coordination_row)] = -1.0 / (share * root);
        let (keep, take) = match scene.peer.coordination.comm {
            "passive-wave" => {
                let keep = decay(coordination.cutoff_hz, period);
                (keep, 1.0 - keep)
            }
            "passive-mean" => (1.0, 1.0 / f64::from(scene.peer.timing.ticks_per_packet)),
            "self-timed" => (1.0, period),
            _ => (0.0, 1.0),
        };
        self.a[(out, out)] = keep;
        self.b[(out, wave)] = take;
    }

    /// What a taut line takes back of its compliance goes beside x_d, as far as the series of spring and damper lets it:
    /// ġ = (α·C·f₂ − g)/τ with C/2 of each end (THEORY §15), of a line with this ρ, whose spring in series has `[k, kappa]`.
    fn taut(&mut self, scene: &Scene, share: f64, [k, kappa]: [f64; 2]) {
        let tautness = number(scene, TAUTNESS);
        if tautness == 0.0 {
            return;
        }
        let (coordination, period) = (&scene.peer.coordination, scene.peer.timing.control_period_s);
        let line_s = number(scene, "coordination.credit_ticks") * period;
        // The series is softer by 200/201; T_c/D of it is with the whole κ.
        let own = 1.0 / coordination.stiffness_n_per_m + period / (201.0 * kappa);
        let half = own + 0.5 * line_s / (share * coordination.wave_impedance_n_s_per_m);
        let slow_s = number(scene, "coordination.taut_s").max(1.8 * line_s);
        let soon = period / slow_s;
        let [force, sooner, filtered, way] =
            [CoordinationForce, TautSooner, TautForce, TautWay].map(|state| self.at(state));
        let after = [(force, soon * soon), (sooner, soon * (1.0 - soon)), (filtered, 1.0 - soon * soon)];
        for (state, part) in [(force, soon), (sooner, 1.0 - soon), (filtered, -soon)] {
            self.a[(sooner, state)] = part;
        }
        for (state, part) in after {
            self.a[(filtered, state)] = part;
        }
        self.a[(way, way)] = 1.0;
        self.f[(Coordination as usize, way)] = k;
        let rate = after.map(|(state, part)| (state, tautness * half / slow_s * part));
        for (state, part) in rate.into_iter().chain([(way, -1.0 / slow_s)]) {
            self.a[(way, state)] += period * part;
            self.f[(Coordination as usize, state)] += kappa * part;
        }
    }
}
