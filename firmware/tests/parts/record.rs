//! Records: bytes and back, and a digest that misses nothing.

use firmware_parts::record::{ENABLED, Record, SENT, digest};
use haptic_core::device::AXES;
use haptic_core::device::encoder::Counts;
use haptic_core::num::{Motion, StateVector};
use haptic_core::peer::{Actuators, Observed, State};
use haptic_core::safety::Mode;
use haptic_core::scene::{Any, Scene};

#[test]
fn bytes_lead_back_to_the_record() {
    let scene = Scene::<Any<f32>>::build(&Default::default()).unwrap();
    let mut state = State::new(&scene, [Motion::at(0.25); AXES]);
    let counts = [Counts(0x1234), Counts(0xABCD)];
    let record = Record::new(7, counts, None, ENABLED | SENT, &mut state, &Actuators::default());
    let back = Record::from_bytes(&record.bytes());
    assert_eq!(back, record);
    assert_eq!((back.tick(), back.counts(), back.mode(), back.flags()), (7, counts, Mode::Disarmed, ENABLED | SENT));
    assert_eq!(back.digest(), digest(&mut state));
    // Words 7 to 14 are what was seen, in the order of the table.
    let mut told = Record::default();
    told.0[7..15].copy_from_slice(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0].map(f32::to_bits));
    let [device, object, desired] =
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)].map(|(position, velocity)| Motion { position, velocity });
    let seen = Observed { device, object, desired, contact_force: 7.0, coordination_force: 8.0 };
    assert_eq!(told.observed(), seen);
}

#[test]
fn any_bit_of_the_state_changes_the_digest() {
    let scene = Scene::<Any<f32>>::build(&Default::default()).unwrap();
    let state = State::new(&scene, [Motion::REST; AXES]);
    let mut numbers = 0;
    state.clone().visit(&mut |_| numbers += 1);
    for at in 0..numbers {
        let mut changed = state;
        let mut n = 0;
        changed.visit(&mut |number: &mut f32| {
            if n == at {
                *number = f32::from_bits(number.to_bits() ^ 1);
            }
            n += 1;
        });
        assert_ne!(digest(&mut changed), digest(&mut state.clone()), "number {at}");
    }
}
