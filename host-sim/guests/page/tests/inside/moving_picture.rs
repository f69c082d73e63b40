use cohold_sim::scenes;

use super::super::kinds::EnvironmentKind;
use super::*;

fn picture() -> String {
    let scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    moving_picture(&EnvironmentKind::BadNetwork.fitting(scene).expect("a scene")).expect("a picture")
}

/// Values of the animations of an attribute, in the order of the picture.
fn values(picture: &str, attribute: &str) -> Vec<Vec<f64>> {
    let begins = format!("<animate attributeName=\"{attribute}\"");
    let of = |part: &str| {
        let list = part.split_once("values=\"").and_then(|(_, rest)| rest.split_once('"')).expect("values").0;
        list.split(';').map(|value| value.parse().expect("a number")).collect()
    };
    picture.split(&begins).skip(1).map(of).collect()
}

/// What moves in the picture says what its words say: two laws tear, one holds, and everything stays inside.
#[test]
fn the_picture_shows_two_laws_that_tear_and_one_that_holds() {
    let picture = picture();
    assert!(picture.len() < 300_000, "{} bytes", picture.len());
    let copies = values(&picture, "x");
    assert_eq!(copies.len(), 6);
    let frames = (LASTS_S * FRAMES_PER_S) as usize;
    let apart_mm = |lane: usize| {
        let pairs = copies[2 * lane].iter().zip(&copies[2 * lane + 1]);
        pairs.map(|(one, two)| 1e3 * (one - two).abs() / UNITS_PER_M).fold(0.0, f64::max)
    };
    assert!(apart_mm(0) > 40.0 && apart_mm(1) > 40.0 && apart_mm(2) < 10.0, "{:?}", [0, 1, 2].map(apart_mm));
    for track in copies.iter().chain(&values(&picture, "cx")) {
        assert_eq!(track.len(), frames);
        assert!(track.iter().all(|x| (0.0..WIDTH - 2.0 * HALF).contains(x)), "{track:?}");
    }
    assert_eq!((picture.matches('✗').count(), picture.matches('✓').count()), (2, 1));
}

/// The same file in every run: a page of the repository is compared with it.
#[test]
fn the_picture_is_the_same_in_every_run() {
    assert_eq!(picture(), picture());
}
