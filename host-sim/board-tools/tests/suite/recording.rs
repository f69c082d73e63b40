//! Gaps in recordings, and boards that started anew in the middle of one.

use cohold_board_tools::recording::{longest_gap, started_anew, tables};
use cohold_report::Columns;

fn recorded(ticks: &[u32]) -> Columns {
    let records: Vec<[u8; 108]> = (ticks.iter())
        .map(|tick| {
            let mut record = [0; 108];
            record[..4].copy_from_slice(&tick.to_le_bytes());
            record
        })
        .collect();
    tables(records.iter().map(|record| &record[..]), 0.001, 1).remove(0)
}

/// Three records a tick, as a board with three motors tells them: each axis has a table, with the joints that its records tell.
#[test]
fn every_shared_axis_has_a_table() {
    let record = |tick: u32, axis: u8| {
        let mut record = [0; 108];
        record[..4].copy_from_slice(&tick.to_le_bytes());
        // Counts and duties of this joint and the next, the force of this axis and tick.
        let joints = [u16::from(axis), (u16::from(axis) + 1) % 3];
        for (at, joint) in joints.into_iter().enumerate() {
            record[4 + 2 * at..][..2].copy_from_slice(&(100 * (joint + 1)).to_le_bytes());
            record[8 + 2 * at..][..2].copy_from_slice(&(1000 * (joint + 1)).to_le_bytes());
        }
        record[15] = axis;
        record[56..60].copy_from_slice(&(tick as f32 + 0.25 * f32::from(axis)).to_le_bytes());
        record
    };
    let records: Vec<_> = (50..53).flat_map(|tick| (0..3).map(move |axis| record(tick, axis))).collect();
    let tables = tables(records.iter().map(|record| &record[..]), 0.001, 3);
    for (axis, table) in tables.iter().enumerate() {
        let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("{name} of axis {axis}")).to_vec();
        let seconds = column("time_s");
        assert!(
            seconds.iter().zip([0.0, 0.001, 0.002]).all(|(came, wanted)| (came - wanted).abs() < 1e-12),
            "{seconds:?}"
        );
        assert_eq!(column("coordination_n"), [50.0, 51.0, 52.0].map(|tick| tick + 0.25 * axis as f64));
        for joint in [axis + 1, (axis + 1) % 3 + 1] {
            assert_eq!(column(&format!("encoder_{joint}_counts")), [100.0 * joint as f64; 3]);
            assert_eq!(column(&format!("duty_{joint}")), [1000.0 * joint as f64 / 32767.0; 3]);
        }
        let other = (axis + 2) % 3 + 1;
        assert!(table.column(&format!("duty_{other}")).is_none(), "joint {other} in axis {axis}");
    }
}

#[test]
fn a_gap_is_found_where_it_is() {
    assert_eq!(longest_gap(&recorded(&[])), None);
    assert_eq!(longest_gap(&recorded(&[7])), None);
    assert_eq!(longest_gap(&recorded(&[4, 8, 12, 24, 28])), None);
    let (from_s, gap_s) = longest_gap(&recorded(&[100, 104, 108, 708, 712, 732, 736])).unwrap();
    assert!((from_s - 0.008).abs() < 1e-12 && (gap_s - 0.6).abs() < 1e-12, "{from_s} {gap_s}");
}

#[test]
fn ticks_that_go_back_are_no_gap() {
    let late = recorded(&[9000, 9008, 9004, 9012, 9016]);
    assert_eq!((longest_gap(&late), started_anew(&late)), (None, None));
    let anew = recorded(&[9000, 9004, 9008, 120, 124, 724, 728]);
    assert_eq!(started_anew(&anew), Some(4));
    assert!((longest_gap(&anew).unwrap().1 - 0.6).abs() < 1e-12);
}
