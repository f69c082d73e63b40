//! MIT's frame, byte for byte as LeRobot packs it for a DM4310, but for the rounding, and what answers mean.

use super::*;

fn model(name: &str) -> Model {
    MODELS.into_iter().find(|model| model.name == name).expect("a type")
}

fn motors(name: &str) -> Mit {
    Mit::new(model(name), &[3], false)
}

/// Zero is between two steps of each range: 0x7fff and 0x8000. The gains begin at zero.
#[test]
fn a_torque_is_eight_bytes() {
    let damiao = model("dm4310");
    assert_eq!(damiao.torque(0.0), [0x80, 0x00, 0x80, 0x00, 0x00, 0x00, 0x08, 0x00]);
    // 3 N·m of ±10 is 0xa65.7 steps.
    assert_eq!(damiao.torque(3.0), [0x80, 0x00, 0x80, 0x00, 0x00, 0x00, 0x0a, 0x66]);
    assert_eq!(damiao.torque(-99.0)[6..], [0x00, 0x00], "no more than the range");
    for torque_nm in [-10.0, -0.3, 0.0, 0.0024, 7.7, 10.0] {
        for model in MODELS.into_iter().filter(|model| model.ends[0].is_finite()) {
            let word = u64::from_be_bytes(model.torque(torque_nm)) & 0xfff;
            let off_nm = (number(word, model.ends[2], 12) - torque_nm).abs();
            assert!(off_nm <= 0.501 * model.step_nm(), "{}: {off_nm} N·m off at {torque_nm}", model.name);
        }
    }
}

/// A motor is enabled before its first torque, and disabled to let go.
#[test]
fn whoever_lets_go_disables() {
    let mut motors = motors("dm4310");
    let mut frames = Vec::new();
    for torque_nm in [Some(0.5), Some(0.5), None, Some(f64::NAN)] {
        motors.command(0, torque_nm, &mut frames);
    }
    let last: Vec<u8> = frames.iter().map(|frame| frame.payload()[7]).collect();
    assert_eq!(last, [ENABLE, 0x66, 0x66, DISABLE, DISABLE]);
    assert!(frames.iter().all(|frame| frame.arbitration_id == 3 && frame.size == 8 && !frame.fdcan_enabled()));
}

#[test]
fn a_state_is_a_cause() {
    // The middle of position and speed, 0.5 N·m; 40 and 45 °C.
    let answer = |state: u8| can::frame(0x13, &[state << 4 | 3, 0x80, 0x00, 0x80, 0x08, 0x66, 40, 45], false);
    let mut motor = motors("dm4310");
    let (at, told, wrong) = motor.hear(&answer(1)).expect("of motor 3");
    assert_eq!((at, wrong, told.temperature_c), (0, None, 45.0));
    assert!(told.angle_rad.abs() < 3e-4 && (told.torque_nm - 0.5).abs() < 2.5e-3, "{told:?}");
    for (state, fault) in [
        (8, DeviceFault::Supply),
        (9, DeviceFault::Supply),
        (0xa, DeviceFault::Motor),
        (0xb, DeviceFault::TooWarm),
        (0xc, DeviceFault::TooWarm),
        (0xd, DeviceFault::LetGo),
    ] {
        let (_, _, wrong) = motor.hear(&answer(state)).expect("of motor 3");
        assert_eq!(wrong.map(|wrong| wrong.fault), Some(fault), "{state:x}");
    }
    // What is disabled after it was enabled let go by itself.
    let mut frames = Vec::new();
    motor.command(0, Some(0.1), &mut frames);
    assert_eq!(motor.hear(&answer(0)).expect("of motor 3").2, None, "it is not enabled yet");
    motor.hear(&answer(1));
    let (_, _, wrong) = motor.hear(&answer(0)).expect("of motor 3");
    assert_eq!(wrong.map(|wrong| wrong.fault), Some(DeviceFault::LetGo));
    // A T-Motor's answer begins with its identifier, and goes to the host's, 0.
    let mut other = motors("ak80-9");
    let answer = |code: u8| can::frame(0, &[3, 0x80, 0x00, 0x80, 0x08, 0x66, 30, code], false);
    assert_eq!(other.hear(&answer(0)).expect("of motor 3").2, None);
    assert!(other.hear(&answer(4)).expect("of motor 3").2.is_some_and(|wrong| wrong.cause.contains("error 4")));
}
