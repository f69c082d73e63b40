//! Lawrence's hybrid matrix, entry by entry, and what spoils it.

use cohold_core::num::Motion;

use crate::two_copies::{Copies, PERIOD, Phasor, settings, swing};

const CONTACT_N_PER_M: f64 = 400.0;
const CONTACT_N_S_PER_M: f64 = 3.0;
const MASS_KG: f64 = 0.3;

/// Hand 1 swings, hand 2 stays: what hand 1 feels, F_LC1/ẋ_1, and how copy 2 moves beside copy 1, ẋ_2/ẋ_1.
fn felt(omega: f64, remote_force: f64, local_force: f64, delay: usize) -> [Phasor; 2] {
    let settings = settings(
        "four-channel",
        &[
            ("coordination.stiffness_n_per_m", 2000.0),
            ("contact.stiffness_n_per_m", CONTACT_N_PER_M),
            ("contact.damping_n_s_per_m", CONTACT_N_S_PER_M),
            ("object.mass_kg", MASS_KG),
            ("four_channel.remote_force", remote_force),
            ("four_channel.local_force", local_force),
        ],
    );
    let mut copies = Copies::<f64>::new(&settings, delay);
    let per_period = (std::f64::consts::TAU / omega / PERIOD).round() as u32;
    let omega = std::f64::consts::TAU / (f64::from(per_period) * PERIOD);
    let mut seen = [Phasor::default(); 3];
    for tick in 0..60 * per_period {
        let time = f64::from(tick) * PERIOD;
        let [one, two] = copies.tick([swing(omega, time), Motion::REST]);
        if tick >= 40 * per_period {
            for (phasor, value) in seen.iter_mut().zip([one.contact_force, one.object.velocity, two.object.velocity]) {
                phasor.see(value, omega * time);
            }
        }
    }
    [seen[0].over(seen[1]), seen[2].over(seen[1])]
}

/// h11·… + Z_e: the shared mass over λ, once, and the other hand's contact, which stands.
fn wanted(omega: f64, remote_force: f64) -> Phasor {
    Phasor { re: CONTACT_N_S_PER_M, im: MASS_KG * omega / remote_force - CONTACT_N_PER_M / omega }
}

/// h11 = m_O·s/λ and h12 = 1 (the felt impedance), h21 = −1 (copy 2 moves as copy 1), h22 = 0 (no stiffness of the link is felt).
#[test]
fn without_delay_the_impedance_of_the_other_hand_is_felt() {
    for omega in [5.0, 15.0, 40.0] {
        for (remote, local) in [(1.0, 0.0), (2.0, 1.0), (0.5, -0.5)] {
            let [impedance, tracking] = felt(omega, remote, local, 0);
            let wanted = wanted(omega, remote);
            // Forces act up to three ticks late: a stiffness that is late by τ is a damping K·τ.
            let allowed = 3.0 * CONTACT_N_PER_M * PERIOD / remote + 0.03 * MASS_KG * omega / remote;
            let off = (impedance.re - wanted.re).hypot(impedance.im - wanted.im);
            assert!(off < allowed, "{omega} rad/s, λ = {remote}: {impedance:?}, {wanted:?} in the paper");
            let off = tracking.off(Phasor { re: 1.0, im: 0.0 });
            assert!(off < 0.01 + omega * PERIOD, "{omega} rad/s, λ = {remote}: {tracking:?}");
        }
    }
}

/// The oracle can fail: with the force of the other hand left out it is another system.
#[test]
fn without_the_force_channel_the_link_is_felt() {
    let [impedance, _] = felt(15.0, 0.0, 0.0, 0);
    assert!(impedance.off(wanted(15.0, 1.0)) > 0.2, "{impedance:?}");
}

/// With delay the promise is gone: 40 ms each way, and what is felt is something else.
#[test]
fn with_delay_it_is_not() {
    let [impedance, _] = felt(15.0, 1.0, 0.0, 40);
    let off = impedance.off(wanted(15.0, 1.0));
    // No number where a peer has stopped with a fault.
    assert!(off.is_nan() || off > 0.3, "{impedance:?}");
}

/// (1 + μ − λ)·ΔF/(2K_T) apart when two hands stand pressing against the copies, nothing at λ = 1 + μ.
#[test]
fn copies_stand_apart_by_what_is_not_told() {
    for (remote, local) in [(1.0, 0.0), (1.5, 0.5), (0.6, 0.0), (1.0, 0.3)] {
        let settings = settings(
            "four-channel",
            &[
                ("coordination.stiffness_n_per_m", 1000.0),
                ("coordination.damping_n_s_per_m", 20.0),
                ("contact.damping_n_s_per_m", 20.0),
                ("four_channel.remote_force", remote),
                ("four_channel.local_force", local),
            ],
        );
        let mut copies = Copies::<f64>::new(&settings, 0);
        let hands = [Motion::at(0.01), Motion::at(-0.01)];
        let [one, two] = (0..20_000).map(|_| copies.tick(hands)).last().expect("ticks");
        let distance_m = (1.0 + local - remote) * (one.contact_force - two.contact_force) / 2000.0;
        let got = one.object.position - two.object.position;
        assert!(
            (got - distance_m).abs() < 1e-9,
            "λ {remote}, μ {local}: {got} m apart, {distance_m} by the closed form"
        );
        assert!(one.contact_force > 1.0 && two.contact_force < -1.0, "hands press");
    }
}
