//! How fast spectral radii come: radii per second and core, matrix included, at a given number of states.
//!
//! The scene is Figure 4's passive wave at K_LC = 500 N/m with a one-way delay of 3 packets: 26 states. Every radius is of another scene (K_T
//! runs through its range), so nothing can be kept from one to the next. `tests/oracle/numpy_speed.py` does the same work
//! in NumPy.

use std::time::Instant;

use super::error::Error;
use super::figure4;
use super::sweep::{Range, Sweep};
use super::verdict::Analyser;

/// The speed that was measured.
#[derive(Clone, Copy, Debug)]
pub struct Speed {
    /// States of the pair.
    pub states: usize,
    /// Threads that worked at the same time.
    pub threads: usize,
    /// Radii per second, all threads together.
    pub radii_per_s: f64,
    /// Radii per second and thread.
    pub radii_per_s_and_core: f64,
    /// Sum of all radii: what `numpy_speed.py` must find too.
    pub checksum: f64,
}

/// Computes `radii` radii on each of `threads` threads.
///
/// # Errors
/// A scene that the analyser cannot judge.
pub fn measure(radii: usize, threads: usize) -> Result<Speed, Error> {
    let range = Range { key: "coordination.stiffness_n_per_m".to_owned(), from: 0.0, to: 12_000.0 };
    let mut scene = figure4::scene("passive-wave", 3);
    scene.peer.contact.stiffness_n_per_m = 500.0;
    let sweep = Sweep::new(&scene, range)?;
    let work = || {
        let mut analyser = Analyser::default();
        let (mut sum, mut states) = (0.0, 0);
        for at in 0..radii {
            let verdict = sweep.verdict(&mut analyser, 12_000.0 * (at + 1) as f64 / radii as f64)?;
            sum += verdict.spectral_radius;
            states = verdict.states;
        }
        Ok::<_, Error>((sum, states))
    };
    let start = Instant::now();
    let results: Vec<_> = std::thread::scope(|scope| {
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let joined = handles.into_iter().map(|handle| handle.join());
        joined.map(|result| result.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    });
    let wall_s = start.elapsed().as_secs_f64();
    let (mut checksum, mut states) = (0.0, 0);
    for result in results {
        (checksum, states) = result?;
    }
    let radii_per_s = (radii * threads) as f64 / wall_s;
    Ok(Speed { states, threads, radii_per_s, radii_per_s_and_core: radii_per_s / threads as f64, checksum })
}
