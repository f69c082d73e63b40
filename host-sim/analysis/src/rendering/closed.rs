//! The largest stable stiffness in closed form, for oscillations that are slow against every delay.
//!
//! Device and object on the contact spring swing against each other: of the relative motion the device does the share
//! μ = m_o/(m + m_o), the object μ_o = m/(m + m_o). A force that is late by θ does the work K·θ·ẋ² on what moves by ẋ, so it
//! takes away damping; a held sample is late by half a period. The mode grows where that exceeds what is there:
//!
//! > K = (b·μ² + b_o·μ_o² + B)/(θ·μ + θ_o·μ_o),  θ = delay1 + delay2 + (½ + c)·T,  θ_o = delay3 + delay4 + (½ + c)·T
//!
//! Against a wall (μ = 1, μ_o = 0) that is b/delay, and 2b/T with no computing delay (THEORY §6, row 2.3).
//!
//! An undamped object has a second limit, which no softness mends: on a soft spring the device's damper b holds the
//! device nearly still, the object swings at √(K/m_o), and the little that the device gives way damps it by K·m_o/b, while
//! its own delay drives it by K·θ_o. Unstable for θ_o > m_o/b ([`longest_object_delay_s`]).
//!
//! **Limits**: first order in θ·ω: good to a few per cent where m ≥ 4·b·θ; a massless device comes to π/2 times b/delay
//! (K·delay/b < π/2 for ẋ = −(K/b)·x(t − delay)).

use super::{Body, Rendering};

/// Largest stable stiffness to first order, N/m; infinite without any delay.
pub fn largest_stiffness(rendering: &Rendering) -> f64 {
    let Rendering { device, object, contact_damping_n_s_per_m, period_s, .. } = rendering;
    let [late, late_object] = rendering.loops_s().map(|loop_s| loop_s + 0.5 * period_s);
    let (share, object_share, object_damping) = match object {
        None => (1.0, 0.0, 0.0),
        Some(object) => {
            let total = device.mass_kg + object.mass_kg;
            (object.mass_kg / total, device.mass_kg / total, object.damping_n_s_per_m)
        }
    };
    let damping = device.damping_n_s_per_m * share * share
        + object_damping * object_share * object_share
        + contact_damping_n_s_per_m;
    damping / (late * share + late_object * object_share)
}

/// The delay θ_o around the object, s, sampling included, beyond which an undamped object behind an undamped contact is
/// unstable however soft the contact is.
pub fn longest_object_delay_s(device: Body, object: Body) -> f64 {
    object.mass_kg / device.damping_n_s_per_m
}
