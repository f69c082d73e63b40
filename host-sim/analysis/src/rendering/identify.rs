//! The device behind the architectures paper's statement: "to simulate objects with 1000 N/m stiffness, the sampling rate
//! must be at least 200 Hz, and the delay less than 5 ms" (§2.3).
//!
//! Two statements, two unknowns: for a given mass, the damping b of the device and the time c·T its computer needs, such
//! that 1000 N/m against a wall is the largest stable stiffness both when sampled at 200 Hz without delay and when delayed
//! by 5 ms and sampled much faster. To first order b = 1000 N/m · 5 ms and (½ + c)·5 ms = 5 ms ([`super::closed`]): 5 N·s/m
//! and half a period; the exact limits move that by a few per cent, and the mass moves it hardly at all.
//!
//! Solved by scaling b and ½ + c with what each limit is short of; each step takes an order off the error.

use serde::Serialize;

use super::maps::{Sweep, at, largest};
use super::{Body, Place, Renderer, Rendering};
use crate::error::Error;
use crate::search::crossings;

/// The paper's stiffness, N/m.
pub const STIFFNESS_N_PER_M: f64 = 1000.0;
/// The paper's slowest sampling, as a period, s: 200 Hz.
pub const PERIOD_S: f64 = 1.0 / 200.0;
/// The paper's longest delay, s.
pub const DELAY_S: f64 = 5e-3;

/// A device for which both statements hold at once.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Identified {
    /// Its mass, kg, as given.
    pub mass_kg: f64,
    /// Its viscous damping, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Its computing delay c, as a fraction of a period.
    pub computing_ticks: f64,
    /// Largest stable stiffness at 200 Hz without delay, N/m.
    pub at_200_hz_n_per_m: f64,
    /// Largest stable stiffness with a delay of 5 ms, sampled fast, N/m.
    pub at_5_ms_n_per_m: f64,
}

/// Where a delay is put: between device and CDE, where the paper's network is.
pub const NETWORK: Sweep = Sweep::Delay(Place::CollisionToDevice);

/// The wall in front of a device with this damping (N·s/m) and computing delay (fraction of a period).
pub fn wall(mass_kg: f64, damping_n_s_per_m: f64, computing_ticks: f64) -> Rendering {
    Rendering {
        device: Body { mass_kg, damping_n_s_per_m },
        object: None,
        contact_damping_n_s_per_m: 0.0,
        period_s: PERIOD_S,
        computing_ticks,
        delays_s: [0.0; 4],
    }
}

/// The device of this mass (kg) in front of an undamped object of that mass, sampled at 1 kHz.
///
/// # Errors
/// As [`identify`].
pub fn device(mass_kg: f64, object_mass_kg: f64) -> Result<Rendering, Error> {
    let found = identify(mass_kg)?;
    let object = Some(Body { mass_kg: object_mass_kg, damping_n_s_per_m: 0.0 });
    Ok(Rendering { object, period_s: 1e-3, ..wall(mass_kg, found.damping_n_s_per_m, found.computing_ticks) })
}

/// Finds damping and computing delay for a mass (kg).
///
/// # Errors
/// A mass for which no device fits the statement, or eigenvalues that do not converge.
pub fn identify(mass_kg: f64) -> Result<Identified, Error> {
    let (mut damping, mut late) = (STIFFNESS_N_PER_M * DELAY_S, 1.0);
    for _ in 0..20 {
        let wall = wall(mass_kg, damping, late - 0.5);
        let sampled = largest(&wall)?;
        let delayed = largest(&at(&wall, NETWORK, DELAY_S, None))?;
        let (short, short_sampled) = (STIFFNESS_N_PER_M / delayed, STIFFNESS_N_PER_M / sampled);
        if (short - 1.0).abs().max((short_sampled - 1.0).abs()) < 2e-3 {
            return Ok(Identified {
                mass_kg,
                damping_n_s_per_m: damping,
                computing_ticks: late - 0.5,
                at_200_hz_n_per_m: sampled,
                at_5_ms_n_per_m: delayed,
            });
        }
        damping *= short;
        // What more damping gives, sampling must take.
        late = (late * short / short_sampled).max(0.5);
    }
    Err(Error::NoConvergence)
}

/// What the stiffness of the statement asks of a device in front of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Needs {
    /// Slowest sampling without delay, Hz; absent where no rate looked at is enough.
    pub sampling_hz: Option<f64>,
    /// Longest delay between device and CDE, s; absent where none looked at is short enough.
    pub delay_s: Option<f64>,
}

/// Slowest sampling and longest delay at which 1000 N/m is stable, looked for from 10 µs to 1 s.
///
/// # Errors
/// Eigenvalues that do not converge.
pub fn needs(base: &Rendering) -> Result<Needs, Error> {
    let wall = Rendering { object: None, ..*base };
    wall.check()?;
    let times: Vec<f64> = (0..=60).map(|step| 1e-5 * 10_f64.powf(f64::from(step) / 12.0)).collect();
    let longest = |sweep| -> Result<Option<f64>, Error> {
        let found = crossings(&times, false, 1e-4, |renderer: &mut Renderer, time_s, radii| {
            radii.push(renderer.polar(&at(&wall, sweep, time_s, None), STIFFNESS_N_PER_M)?);
            Ok(())
        })?;
        Ok(if found.stable_at_start { found.crossings.first().copied() } else { None })
    };
    Ok(Needs { sampling_hz: longest(Sweep::Period)?.map(|period_s| 1.0 / period_s), delay_s: longest(NETWORK)? })
}
