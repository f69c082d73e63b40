//! Tests of `src/python.rs` from inside.

use super::*;

#[test]
fn a_wheel_of_one_machine_is_refused() {
    assert!(is_for_others("cohold_sim-0.1.0-cp311-abi3-manylinux_2_35_x86_64.whl").is_ok());
    assert!(is_for_others("cohold_sim-0.1.0-cp311-abi3-macosx_11_0_arm64.whl").is_ok());
    let said = is_for_others("cohold_sim-0.1.0-cp311-abi3-linux_x86_64.whl").expect_err("refused").to_string();
    assert!(said.contains("linux_x86_64.whl is for this machine alone"), "{said}");
}
