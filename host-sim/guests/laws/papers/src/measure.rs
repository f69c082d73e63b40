//! The measurements behind [`super::NUMBERS`].
//!
//! Errors: every function fails where its scene or its law cannot be built, run or judged.

use cohold_analysis::tune::CONTACT;
use cohold_analysis::{Effort, Hands, Range, limit};
use cohold_sim::pair::Pair;
use cohold_sim::scene::Scene;

use cohold_studies::Error;
use cohold_studies::campaign::laws::{asked_for, law_scene};
use cohold_studies::reproduce::paper;

/// Control period of the bench, s.
pub(crate) const PERIOD_S: f64 = 1e-3;

/// A packet a tick.
pub(crate) const EACH_TICK: &str = "timing.ticks_per_packet=1";

/// The scene in which the bench tries a law, at the gains that it declares, then with these settings.
pub(crate) fn scene(law: &str, set: &[&str]) -> Result<Scene, Error> {
    let laws = cohold_guest_laws::laws();
    let law = asked_for(laws, law)?[0];
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    law_scene(laws, law, None, &set)
}

/// Decoded discrepancy in the cooperation paper's §5.2, mm.
pub(crate) fn discrepancy_mm(law: &str) -> Result<f64, Error> {
    let outcome = paper::run_at(law, 1.0)?;
    Ok(outcome.metric(|outcome| outcome.whole.decoded_discrepancy_mm).unwrap_or(f64::NAN))
}

/// b/(K·T) at the first unstable stiffness of a wall that does not move, forces acting `late` ticks late.
pub(crate) fn wall(late: f64) -> Result<f64, Error> {
    const DAMPING: f64 = 5.0;
    let late = format!("device.force_delay_ticks={late}");
    let set =
        ["device.mass_kg=1", "device.damping_n_s_per_m=5", "object.mass_kg=1000", "contact.damping_n_s_per_m=0", &late];
    let range = Range { key: CONTACT.to_owned(), from: 1.0, to: 20_000.0 };
    let found = limit(&scene("none", &set)?, range, Effort { hands: Some(Hands::Both), ..Effort::default() })?;
    Ok(DAMPING / (PERIOD_S * found.crossings.first().copied().unwrap_or(f64::NAN)))
}

/// Packets saved of 1000 a second, by a pair of which one hand goes to and fro by 5 cm once a second, %.
pub(crate) fn packets_saved_percent() -> Result<f64, Error> {
    let set = [
        EACH_TICK,
        "network.one_way_delay_packets=0",
        "user.1.push_n=0",
        "user.2.push_n=0",
        "user.2.sine_n=0",
        "user.1.sine_n=4",
        "user.1.sine_rad_per_s=6.2832",
    ];
    let mut pair = Pair::<f64>::new(&scene("deadband", &set)?)?;
    (0..20_000).for_each(|_| pair.step());
    Ok(100.0 * (1.0 - PERIOD_S * pair.packets_per_s()))
}
