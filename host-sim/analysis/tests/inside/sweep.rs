//! Tests of `src/sweep.rs` from inside.

use super::*;

fn sweep(key: &str, from: f64, to: f64) -> Result<Sweep, Error> {
    Sweep::new(&Scene::default(), Range { key: key.to_owned(), from, to })
}

#[test]
fn what_cannot_be_swept_is_named() {
    let says = |key, from, to| sweep(key, from, to).unwrap_err().to_string();
    assert!(says("coordination.comm", 0.0, 1.0).contains("coordination.comm is no number"));
    assert!(says("coordination.stifness_n_per_m", 0.0, 1.0).contains("did you mean coordination.stiffness_n_per_m?"));
    assert!(says("coordination.stiffness_n_per_m", 5.0, 5.0).contains("from 5 to 5"));
    assert!(says("coordination.stiffness_n_per_m", -1.0, 5.0).contains("= -1 is not allowed"));
    assert!(says("network.one_way_delay_packets", 0.0, 2000.0).contains("= 2000 is not allowed"));
}

#[test]
fn points_are_ascending_and_hold_both_ends() {
    let points = sweep("coordination.stiffness_n_per_m", 0.0, 12000.0).unwrap().points(40);
    assert!(points.len() > 35 && points[0] == 0.0 && points.last() == Some(&12000.0));
    assert!(points.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(sweep("network.one_way_delay_packets", 0.0, 3.0).unwrap().points(400), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(sweep("timing.ticks_per_packet", 1.0, 1000.0).unwrap().points(10).len(), 11);
}
