//! A recording, replayed without the scene around it, computes what the peer computed there.

use cohold_cases::replay;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;
use cohold_studies::record::record;

fn replayed(bytes: &[u8]) -> Result<(u64, u64), replay::Unreadable> {
    let mut left = bytes;
    let read = |into: &mut [u8]| {
        let (Some(front), Some(rest)) = (left.get(..into.len()), left.get(into.len()..)) else { return false };
        into.copy_from_slice(front);
        left = rest;
        true
    };
    replay::run(read, |_, _| ())
}

/// Either peer: alone with the recording it computes what it did in the scene.
fn assert_replayed(scene: &Scene, name: &str) {
    for number in [1, 2] {
        let recording = record(scene, number, 500).expect("a good scene");
        assert_eq!(replayed(&recording.bytes), Ok((500, recording.hash)), "{name}, peer {number}");
    }
}

#[test]
fn a_replay_is_the_scene_again() {
    for (name, _) in scenes::ALL {
        let scene = scenes::load(cohold_guest_laws::laws(), name).expect("a built-in scene");
        assert_replayed(&scene, name);
    }
}

/// What its packets count in ticks is in the recording, too.
#[test]
fn a_replay_of_a_line_with_a_time_of_its_own() {
    let mut scene = scenes::load(cohold_guest_laws::laws(), "any-network").expect("a built-in scene");
    for text in [
        "coordination.comm=self-timed",
        "coordination.ledger=false",
        "coordination.drift_correction=false",
        "network.loss=0.2",
        "user.1.push_n=1",
    ] {
        scene.apply_override(text).expect("a good override");
    }
    assert_replayed(&scene, "self-timed");
}

#[test]
fn one_count_in_one_tick_changes_the_hash() {
    let scene = scenes::load(cohold_guest_laws::laws(), "real-device").expect("a built-in scene");
    let recording = record(&scene, 1, 20).expect("a good scene");
    let mut broken = recording.bytes.clone();
    // Settings, home, and the first tick: flags and counts.
    let second = 4 + u32::from_le_bytes(std::array::from_fn(|at| broken[at])) as usize + 8 + 5;
    broken[second + 1] ^= 1;
    let (ticks, hash) = replayed(&broken).expect("a recording all the same");
    assert!(ticks == 20 && hash != recording.hash);
    assert_eq!(replayed(&recording.bytes[..3]), Err(replay::Unreadable::Short));
    assert_eq!(replayed(&recording.bytes[..second + 3]), Err(replay::Unreadable::Short));
}
