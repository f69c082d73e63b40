//! Tests of `src/map.rs` from inside.

use super::*;

#[test]
fn an_axis_is_written_as_key_range_count() {
    let axis: Axis = "contact.stiffness_n_per_m=0..2.5e3:6".parse().unwrap();
    assert_eq!(axis.range, Range { key: "contact.stiffness_n_per_m".to_owned(), from: 0.0, to: 2500.0 });
    assert_eq!(axis.values(), [0.0, 500.0, 1000.0, 1500.0, 2000.0, 2500.0]);
    for wrong in ["a.b", "a.b=1..2", "a.b=1-2:3", "a.b=x..2:3", "a.b=1..2:x"] {
        let message = wrong.parse::<Axis>().unwrap_err().to_string();
        assert!(message.starts_with(wrong) && message.contains("table.key=A..B:N"), "{message}");
    }
    assert!("a.b=1..2:1".parse::<Axis>().unwrap_err().to_string().contains("from 2 to 10000"));
}
