//! Frames of moteus motors, byte for byte from the public register map, and what their answers mean.

use super::*;

fn motors() -> Moteus {
    Moteus { ids: vec![1, 5], watchdog_s: 0.05, most_nm: 0.5 }
}

/// Position mode without a position; three scales of nothing; the torque, the largest one and the watchdog as floats; and what is asked in return.
#[test]
fn a_torque_is_a_position_command_without_gains() {
    let mut frames = Vec::new();
    motors().command(1, Some(-0.25), &mut frames);
    let float = |number: f32| number.to_le_bytes().to_vec();
    let wanted = [
        vec![0x01, 0x00, 0x0a, 0x02, 0x20, 0x80, 0x00, 0x0d, 0x22],
        float(-0.25),
        vec![0x02, 0x23, 0x00, 0x00, 0x0d, 0x25],
        float(0.5),
        vec![0x0d, 0x27],
        float(0.05),
        vec![0x01, 0x2b, 0x00, 0x11, 0x00, 0x1f, 0x01, 0x13, 0x0d],
    ];
    assert_eq!((frames.len(), frames[0].arbitration_id), (1, 0x8005));
    assert_eq!(frames[0].payload(), wanted.concat());
}

/// None, and what is not a number, stops the motor: mode 0, and the same questions.
#[test]
fn what_is_no_torque_lets_go() {
    for torque_nm in [None, Some(f64::NAN), Some(f64::INFINITY)] {
        let mut frames = Vec::new();
        motors().command(0, torque_nm, &mut frames);
        assert_eq!(frames[0].payload(), [0x01, 0x00, 0x00, 0x11, 0x00, 0x1f, 0x01, 0x13, 0x0d], "{torque_nm:?}");
    }
}

/// An answer of motor 5: mode, a quarter of a turn, half a turn a second, 0.1 N·m; 24 V, 31 °C and a fault.
fn answer(mode: u8, code: u8) -> CanFdFrame {
    let floats: Vec<u8> = [0.25_f32, 0.5, 0.1].into_iter().flat_map(f32::to_le_bytes).collect();
    let payload = [&[0x21, 0x00, mode, 0x2f, 0x01], &floats[..], &[0x23, 0x0d, 48, 31, code]].concat();
    can::frame(0x500, &payload, true)
}

#[test]
fn an_answer_is_radians_volts_and_a_cause() {
    let (at, told, wrong) = motors().hear(&answer(10, 0)).expect("of motor 5");
    assert_eq!((at, wrong, told.supply_v, told.temperature_c), (1, None, Some(24.0), 31.0));
    assert!((told.angle_rad - 0.25 * TAU).abs() < 1e-6 && (told.speed_rad_per_s - 0.5 * TAU).abs() < 1e-6, "{told:?}");
    assert!(!told.limited && motors().hear(&answer(10, 98)).expect("of motor 5").1.limited, "98 limits a torque");
    for (mode, code, fault) in [
        (1, 38, DeviceFault::TooWarm),
        (1, 34, DeviceFault::Supply),
        (1, 40, DeviceFault::Supply),
        (1, 35, DeviceFault::Motor),
        (11, 0, DeviceFault::LetGo),
        (12, 0, DeviceFault::Stopped),
    ] {
        let (_, _, wrong) = motors().hear(&answer(mode, code)).expect("of motor 5");
        let wrong = wrong.expect("a cause");
        assert!(wrong.fault == fault && wrong.cause.contains("motor 5"), "{mode}, {code}: {wrong}");
    }
    // To somebody else, or of a motor that is not listed.
    for id in [0x501, 0x600] {
        let mut other = answer(10, 0);
        other.arbitration_id = id;
        assert!(motors().hear(&other).is_none(), "{id:x}");
    }
}
