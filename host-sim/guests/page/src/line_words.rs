//! What a person reads of a line before anybody pushes: which path it takes, what it can hold, and the code of a link.

use cohold_sim::scene::Scene;
use serde_json::{Value, json};

use cohold_live::road::Way;
use cohold_live::tell::PathSecond;
use cohold_live::verdict::Judging;

/// A line with this round trip, µs: `says` which path, or how long; `holds` what it can hold, behind the code that both ends of a link show;
/// `bad` if that is nothing; `held` if this end is kept from arming. None while nothing is known.
pub(super) fn line_words(
    scene: &Scene,
    round_trip_us: Option<u32>,
    path: Option<PathSecond>,
    judging: Option<&Judging>,
    code: Option<&str>,
) -> Option<Value> {
    let most_s = scene.peer.safety.max_delay_s;
    let one_way_s = round_trip_us.map(|us| 0.5e-6 * f64::from(us));
    let too_far = one_way_s.is_some_and(|one_way_s| one_way_s > most_s);
    let nowhere = path.is_some_and(|path| path.way == Way::Nowhere);
    let holds = match one_way_s {
        _ if nowhere => Some("nothing gets through".to_owned()),
        None => None,
        Some(one_way_s) if too_far => Some(format!(
            "{:.0} ms one way is too far: what is older than {:.0} ms is not taken (safety.max_delay_s)",
            1e3 * one_way_s,
            1e3 * most_s
        )),
        // Two springs, and the line between them (docs/concepts.md).
        Some(one_way_s) if scene.law().own_time => {
            let mm = 1e3 * scene.laws.compliance(&scene.peer, one_way_s)[0];
            Some(format!("each newton between the hands holds the copies {mm:.2} mm apart or more"))
        }
        Some(one_way_s) => Some(format!("{:.0} ms one way", 1e3 * one_way_s)),
    };
    let judged = judging.and_then(|judging| judging.verdict.as_ref());
    // If nothing reaches an end, there is nothing else to report.
    let verdict = judged.filter(|_| !nowhere).map(|verdict| {
        let [least, most] = verdict.one_way_ms;
        format!("at {least:.1} to {most:.1} ms one way this scene is {}", verdict.text)
    });
    let code = code.map(|code| format!("code {code}: compare it aloud, the other end must show the same"));
    let round_trip = || one_way_s.map(|one_way_s| format!("round trip {:.1} ms", 2e3 * one_way_s));
    let says = path.map(|path| path.words()).or_else(round_trip)?;
    let holds = code.into_iter().chain(verdict).chain(holds).collect::<Vec<_>>().join("; ");
    let bad = too_far || nowhere || judged.is_some_and(|verdict| verdict.stable == Some(false));
    // A peer that is not to arm says why.
    let held = judging.is_some_and(|judging| judging.refuses().is_some());
    Some(json!({ "says": says, "holds": holds, "bad": bad, "held": held }))
}
