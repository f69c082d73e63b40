use super::super::judge::edge;
use super::super::kinds::Kinds;
use super::super::{environment::MOST, pair_columns::columns};
use super::*;

fn column(sample: &Sample, name: &str) -> f64 {
    f64::from(sample[columns(1).iter().position(|(known, ..)| *known == name).expect("a column")])
}

fn told(story: &Told, keys: &[String]) -> Scene {
    let mut scene = scene(Laws::built_in(), story).expect("a scene");
    keys.iter().for_each(|text| scene.apply_override(text).expect("a key"));
    scene
}

/// So many seconds with nobody's hand: how far the copies are apart at the most in the second half, m, and the last sample.
fn run(story: &mut Story, seconds: f64) -> (f64, Sample) {
    let (mut most, mut last) = (0.0_f64, [f32::NAN; MOST]);
    let ticks = (1000.0 * seconds) as u64;
    for tick in 0..ticks {
        if story.stands() {
            break;
        }
        (0..2).for_each(|hand| story.play(hand));
        last = story.step().expect("a tick");
        if 2 * tick > ticks {
            most = most.max((column(&last, "object_1") - column(&last, "object_2")).abs());
        }
    }
    (most, last)
}

/// At every delay of the slider the hands pull one object, whose copies are the farther apart the later the packets come: by the hands' force
/// over the line's impedance, millimetres of it, which a lens shows.
#[test]
fn the_gap_grows_with_the_delay() {
    let gap = |delay_ms: f64| {
        let mut story =
            Story::new(&told(&DELAY, &[format!("network.extra_delay_s={}", 1e-3 * delay_ms)])).expect("a story");
        let (apart_m, last) = run(&mut story, 12.0);
        assert!(story.session.fault().is_none() && apart_m < 0.012, "{delay_ms}: {apart_m}");
        assert!((column(&last, "push_1") + 1.5).abs() < 1.0, "{last:?}");
        apart_m
    };
    let gaps = [0.0, 10.0, 40.0, 80.0, 150.0].map(gap);
    assert!(gaps.is_sorted() && gaps[0] > 1e-4, "{gaps:?}");
    // F/b of the mean pull, for each second that a packet takes longer; the pull comes and goes by a quarter, and so does the gap.
    let slope = (gaps[2] - gaps[1]) / 0.03 / (1.5 / 60.0);
    assert!((0.75..1.4).contains(&slope), "{slope} {gaps:?}");
    // Where b·T would be more than 4 kg, b falls, and the gap is F·T²/4 kg.
    let share = gaps[4] / (1.5 * 0.15 * 0.15 / 4.0);
    assert!((0.75..1.4).contains(&share), "{share} {gaps:?}");
}

/// Below the edge that the analyser finds they hold, above it a peer faults within seconds; it then stands, and another gain starts anew.
#[test]
fn past_the_edge_a_peer_faults() {
    let stiffness = |n_per_m: f64| told(&TOO_STIFF, &[format!("coordination.stiffness_n_per_m={n_per_m}")]);
    let edge = edge(&stiffness(310.0)).expect("there is an edge");
    assert!((320.0..3000.0).contains(&edge), "{edge}");
    let mut story = Story::new(&stiffness(0.9 * edge)).expect("a story");
    let (apart_m, _) = run(&mut story, 20.0);
    assert!(story.session.fault().is_none() && apart_m < 0.01, "{apart_m}");
    for beyond in [1.3, 2.0] {
        story.set(stiffness(beyond * edge)).expect("a good scene");
        let (_, last) = run(&mut story, 30.0);
        let faulted = story.session.fault();
        let apart_m = (column(&last, "object_1") - column(&last, "object_2")).abs();
        assert!(story.stands() && faulted.is_some(), "{beyond}: {apart_m}");
        assert!(apart_m < 2.0, "{beyond}: it stands where it faulted, {apart_m} m apart");
    }
    story.set(stiffness(310.0)).expect("a good scene");
    assert!(!story.stands() && story.standing().modes == [crate::environment::ARMED; 2]);
}

/// A picture has its own scene, whatever the workshop's is.
#[test]
fn a_story_has_its_own_scene() {
    let mut workshop = Scene::new(Laws::built_in());
    workshop.apply_override("network.loss=0.5").expect("a key");
    for kind in Kinds::default().all() {
        let name = kind.name();
        let fitting = kind.fitting(workshop.clone()).expect(name);
        let own = matches!(name, "delay" | "too-stiff");
        assert_eq!(fitting.world.network.loss == 0.0, own, "{name}");
        assert_eq!(kind.is_story(), own || name == "bad-network", "{name}");
    }
}
