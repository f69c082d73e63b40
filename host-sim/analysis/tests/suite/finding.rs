//! What is found in haste is what is found at leisure, at the delays that a live end measures.

use std::path::Path;

use cohold_analysis::{Question, change, find, is_linear, judge, measured};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

/// What a live peer asks.
const QUESTION: Question = Question { hand: None, most_packets: 40 };

fn scene(name: &str, overrides: &[&str]) -> Scene {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    scenes::find(cohold_guest_laws::laws(), Some(Path::new(name)), &overrides).expect("a scene")
}

/// This scene on a network whose packets take so many ticks there and back, whichever.
fn of_round_trip(scene: &Scene, ticks: u32) -> Scene {
    let mut scene = scene.clone();
    let period_s = scene.peer.timing.control_period_s;
    scene.world.network.one_way_delay_packets = 0;
    scene.world.network.extra_delay_s = f64::from(ticks / 2) * period_s;
    scene.world.network.asymmetry_s = f64::from(ticks % 2) * period_s;
    scene
}

/// The verdict in every mode.
fn is_stable(scene: &Scene) -> bool {
    judge(scene).unwrap().worst.stable
}

/// One delay each way, measured exactly: the round trips of it, a tick more, which where the ticks lie may make of it, and one less, by which
/// both ways vary alike. The old default scene holds at 0 to 1 ms and is torn apart at 2 to 7 ms.
#[test]
fn at_measured_delays_it_is_what_the_whole_judgement_says() {
    for (scene, holds_at_ms) in [
        (Scene::default(), &[0, 1][..]),
        (scene("any-network", &[]), &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
        (scene("hub", &[]), &[0, 1, 2, 3, 4, 5, 6, 7, 8]),
    ] {
        for ms in 0..=8_u32 {
            let one_way_s = 1e-3 * f64::from(ms);
            let there = measured(&scene, [one_way_s; 2]);
            let found = find(&there, QUESTION);
            assert_eq!(found.stable, Some(is_stable(&there)), "{ms} ms: {found:?}");
            let round_trips = (2 * ms).saturating_sub(1)..=2 * ms + 1;
            let mut each = round_trips.map(|ticks| is_stable(&of_round_trip(&scene, ticks)));
            assert_eq!(found.stable, Some(each.all(|stable| stable)), "{ms} ms: {found:?}");
            assert_eq!(found.stable, Some(holds_at_ms.contains(&ms)), "{ms} ms: {found:?}");
        }
    }
}

/// A range of delays is judged within, not at its ends alone.
#[test]
fn what_lies_between_two_delays_is_judged_too() {
    let scene = scene("paper-5.2-passive-wave-16ms", &[]);
    let at = |one_way_s: [f64; 2]| find(&measured(&scene, one_way_s), QUESTION).stable;
    assert_eq!(at([0.0, 0.0005]), Some(true));
    assert_eq!(at([0.0, 0.008]), Some(false));
}

/// The key, and about the value, of the advice that scans the whole range; what is proposed holds.
#[test]
fn what_to_lower_is_what_the_advice_says() {
    for ms in [2, 3, 5, 6] {
        let there = measured(&Scene::default(), [1e-3 * f64::from(ms); 2]);
        let (found, wanted) = (find(&there, QUESTION), change(&there).unwrap().expect("one gain does"));
        let instead = found.instead.expect("one gain does");
        let (key, to) = instead.split_once('=').expect("a key and a value");
        let to: f64 = to.parse().expect("a number");
        assert!(key == wanted.key && (to / wanted.to - 1.0).abs() < 0.02, "{ms} ms: {instead}, {wanted:?}");
        assert!(found.text.contains(&format!("Lower {key} from 10620 to {to} N/m")), "{}", found.text);
        let mut better = there.clone();
        better.set_number(key, to).unwrap();
        assert_eq!(find(&better, QUESTION).stable, Some(true), "{instead}");
    }
}

/// The paper's power-domain gain holds at 8 ms in contact and not released: whatever the contact, it is unstable.
#[test]
fn every_mode_counts_whatever_the_contact() {
    for contact in ["contact.one_sided=false", "contact.one_sided=true", "contact.gap_m=0.001"] {
        assert_eq!(find(&scene("paper-5.2-power-16ms", &[contact]), QUESTION).stable, Some(false), "{contact}");
    }
}

/// What takes too long, and a law that no matrix says all of, are not judged, and say so.
#[test]
fn what_is_not_judged_says_why() {
    let not_judged = |scene: &Scene, why: &str| {
        let found = find(scene, QUESTION);
        assert!(found.stable.is_none() && found.text.contains(why), "{found:?}");
    };
    not_judged(&measured(&scene("any-network", &[]), [0.04, 0.045]), "more than 40 packets in flight");
    not_judged(&measured(&scene("plane", &[]), [0.02, 0.021]), "more than 10 packets in flight");
    // An energy tank may hold back what grows: that is left out, and no reason to arm.
    let tank = find(&scene("any-network", &["coordination.comm=two-layer"]), QUESTION);
    assert_eq!(tank.stable, Some(false), "{tank:?}");
    assert!(tank.not_judged.iter().any(|left_out| left_out.contains("energy tank")), "{tank:?}");
    // Of a hub's scene what only waves have is off.
    let of_law = |name: &str| {
        let waves = ["coordination.ledger=false", "coordination.drift_correction=false"].map(str::to_owned);
        let overrides = [&waves[..], &[format!("coordination.comm={name}")]].concat();
        scenes::find(cohold_guest_laws::laws(), Some(Path::new("hub")), &overrides).map_err(|why| why.to_string())
    };
    let laws = cohold_guest_laws::laws().all();
    let scenes: Vec<Scene> = laws.iter().filter_map(|law| of_law(law.name).ok()).collect();
    let refused: Vec<_> = laws.iter().filter_map(|law| of_law(law.name).err()).collect();
    assert!(scenes.len() > laws.len() / 2, "{refused:#?}");
    for scene in scenes {
        let found = find(&scene, QUESTION);
        assert_eq!(found.text.contains("the law is not linear"), !is_linear(&scene).unwrap(), "{found:?}");
    }
}
