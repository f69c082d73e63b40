//! What encoders show beside their counts, and where zero is: edges of both channels, the index, and an operator who says "here".

use cohold_core::device::AXES;
use cohold_core::device::Reading;
use cohold_core::device::encoder::{Counts, INDEX_COUNTS, LONE_TICKS, Marks, Shown};
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::velocity::VelocityName;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::peer::Sensors;
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

use super::Bench;

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    settings.encoder.index = true;
    settings
}

fn bench(settings: &Settings) -> Bench<f32> {
    Bench::at_rest(settings, Motion::REST)
}

/// A tick of the first joint; the second's encoder says the same of its edges.
fn tick<S: Scalar>(bench: &mut Bench<S>, counts: i32, edges: [u8; 2], index: Option<i32>) -> Mode {
    let wrapped = |counts: i32| Counts(counts as u16);
    let [once, again] = [0, 1].map(|rises| edges.map(|edges| edges > rises));
    let marks = [index.map(wrapped), None].map(|index| Marks::of(once, again, index));
    let reading = Reading::Counts([wrapped(counts), Counts(0)]);
    if marks == [Marks::default(); AXES] {
        // As a board says it.
        bench.peer.tick_in_place(reading, false, &None, Shown::Nothing);
    } else {
        bench.peer.tick(&Sensors { marks: Some(marks), ..Sensors::of(reading) });
    }
    bench.peer.mode()
}

/// Two edges of one channel and none of the other, in four ticks more than not; whatever the mode.
#[test]
fn a_channel_that_is_dead() {
    let wire = Mode::Faulted(Fault::EncoderWire);
    for command in [Command::Disarm, Command::Arm] {
        for lone in [[2, 0], [0, 2]] {
            let mut bench = bench(&settings());
            bench.command(command);
            let mode = bench.peer.mode();
            for nth in 1..LONE_TICKS {
                assert_eq!(tick(&mut bench, nth as i32 % 2, lone, None), mode, "{nth}");
            }
            assert_eq!(tick(&mut bench, 0, lone, None), wire);
            bench.command(Command::Clear);
            assert_eq!(tick(&mut bench, 0, lone, None), Mode::Disarmed, "forgotten with the fault");
        }
    }
    // One edge may be a device that hums on it; both are motion; none is rest.
    for usual in [[1, 0], [0, 1], [1, 1], [2, 1], [1, 2], [2, 2], [0, 0]] {
        let mut bench = bench(&settings());
        assert!((0..50).all(|_| tick(&mut bench, 0, usual, None) == Mode::Disarmed), "{usual:?}");
    }
    // As often as not is not reported, more often is.
    let mut bench = bench(&settings());
    assert!((0..50).all(|nth| tick(&mut bench, 0, [2, nth % 2 * 2], None) == Mode::Disarmed));
    let reported = (0..50).find(|nth| tick(&mut bench, 0, [u8::from(nth % 3 > 0) * 2, 0], None) == wire);
    assert_eq!(reported, Some(8), "+1, +1, −1 from nothing");
}

/// Where the axis is, m.
fn position<S: Scalar>(bench: &Bench<S>) -> f64 {
    bench.peer.observed()[0].device.position.to_f64()
}

fn an_index_says_where_the_joint_is<S: Scalar>() {
    for reversed in [false, true] {
        let mut settings = settings();
        settings.encoder.reversed = reversed;
        settings.encoder.index_at_m_or_rad = 0.05;
        let along = if reversed { -1 } else { 1 };
        let mut bench = Bench::<S>::at_rest(&settings, Motion::REST);
        tick(&mut bench, 7000, [0; 2], None);
        assert_eq!(position(&bench), 0.0);
        // 300 counts on, 100 past the index.
        tick(&mut bench, 7000 + along * 300, [2; 2], Some(7000 + along * 200));
        tick(&mut bench, 7000 + along * 300, [0; 2], None);
        assert!((position(&bench) - 0.0505).abs() < 1e-6, "{}: {}", S::NAME, position(&bench));
        assert_eq!(bench.peer.observed()[0].device.velocity.to_f64(), 0.0, "it did not jump there");
        // Again, from either side: fine. Further off than an index is wide: counts are lost.
        for off in [0, INDEX_COUNTS, -INDEX_COUNTS] {
            assert_eq!(tick(&mut bench, 7000 + along * 300, [0; 2], Some(7000 + along * 200 + off)), Mode::Disarmed);
        }
        for off in [INDEX_COUNTS + 1, -INDEX_COUNTS - 1] {
            let mode = tick(&mut bench, 7000 + along * 300, [0; 2], Some(7000 + along * 200 + off));
            assert_eq!(mode, Mode::Faulted(Fault::LostCounts), "{}: {off}", S::NAME);
            // Cleared, the position stands, and the next index says where it is.
            bench.command(Command::Clear);
            tick(&mut bench, 7000 + along * 300, [0; 2], None);
            assert!((position(&bench) - 0.0505).abs() < 1e-6);
            tick(&mut bench, 7000 + along * 300, [0; 2], Some(7000 + along * 200));
        }
    }
}

#[test]
fn an_index_says_where_the_joint_is_in_every_number() {
    an_index_says_where_the_joint_is::<f32>();
    an_index_says_where_the_joint_is::<f64>();
    an_index_says_where_the_joint_is::<Fixed>();
}

/// While the motors are on nothing moves the position; the first index is what the others are compared with.
#[test]
fn an_index_moves_nothing_that_is_armed() {
    let mut settings = settings();
    settings.encoder.index_at_m_or_rad = 0.05;
    let mut bench = bench(&settings);
    tick(&mut bench, 0, [0; 2], None);
    bench.command(Command::Arm);
    assert_eq!(tick(&mut bench, 100, [2; 2], Some(50)), Mode::Armed);
    assert_eq!(tick(&mut bench, 100, [0; 2], None), Mode::Armed);
    assert!((position(&bench) - 0.0005).abs() < 1e-7);
    assert_eq!(tick(&mut bench, 100, [0; 2], Some(56)), Mode::Faulted(Fault::LostCounts));
}

/// A joint that turns may meet its index a whole number of turns away; of a slide there is one.
#[test]
fn turns_are_no_lost_counts() {
    let found = |model: KinematicsName, off: i32| {
        let mut settings = settings();
        settings.kinematics.model = model;
        let mut bench = bench(&settings);
        tick(&mut bench, 0, [0; 2], Some(0));
        let steps = off.abs() / 500 + 1;
        (1..=steps).map(|step| tick(&mut bench, off * step / steps, [2; 2], (step == steps).then_some(off))).last()
    };
    let lost = Some(Mode::Faulted(Fault::LostCounts));
    for turns in [1, -1, 2, 5] {
        assert_eq!(found(KinematicsName::Capstan, 8192 * turns), Some(Mode::Disarmed), "{turns} turns");
        assert_eq!(found(KinematicsName::Capstan, 8192 * turns + 5), lost, "{turns} turns");
        assert_eq!(found(KinematicsName::Capstan, 8192 * turns - 40), lost, "{turns} turns");
        assert_eq!(found(KinematicsName::Direct, 8192 * turns), lost);
    }
}

/// Without the key nobody heeds an index.
#[test]
fn an_index_is_not_there_unless_told() {
    let mut settings = settings();
    settings.encoder.index = false;
    let mut bench = bench(&settings);
    for index in [0, 500, -300, 77] {
        assert_eq!(tick(&mut bench, 10, [2; 2], Some(index)), Mode::Disarmed);
    }
    assert_eq!(position(&bench), 0.0);
}

/// "Home here" is for a device whose motors are off.
#[test]
fn an_operator_says_where_zero_is() {
    let mut bench = bench(&settings());
    tick(&mut bench, 100, [0; 2], None);
    tick(&mut bench, 500, [2; 2], None);
    assert!((position(&bench) - 0.002).abs() < 1e-7);
    bench.command(Command::Home);
    assert_eq!(tick(&mut bench, 500, [0; 2], None), Mode::Disarmed);
    assert_eq!((position(&bench), bench.peer.observed()[0].device.velocity), (0.0, 0.0));
    bench.command(Command::Arm);
    assert_eq!(tick(&mut bench, 600, [2; 2], None), Mode::Armed);
    bench.command(Command::Home);
    tick(&mut bench, 600, [0; 2], None);
    assert!((position(&bench) - 0.0005).abs() < 1e-7, "armed it changes nothing");
    // An index that was found is forgotten with it.
    bench.command(Command::Disarm);
    tick(&mut bench, 600, [0; 2], Some(600));
    bench.command(Command::Home);
    tick(&mut bench, 700, [0; 2], None);
    assert_eq!(tick(&mut bench, 700, [0; 2], Some(650)), Mode::Disarmed);
    assert_eq!(AXES, 2);
}
