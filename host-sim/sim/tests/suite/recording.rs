//! Gaps in recordings, and boards that started anew in the middle of one.

use haptic_sim::board::recording::{longest_gap, started_anew, table};
use haptic_sim::report::Columns;

fn recorded(ticks: &[u32]) -> Columns {
    let records: Vec<[u8; 108]> = (ticks.iter())
        .map(|tick| {
            let mut record = [0; 108];
            record[..4].copy_from_slice(&tick.to_le_bytes());
            record
        })
        .collect();
    table(records.iter().map(|record| &record[..]), 0.001)
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
