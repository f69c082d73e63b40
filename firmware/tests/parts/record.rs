//! Records: bytes and back, and a digest that misses nothing.

use cohold_core::device::AXES;
use cohold_core::device::stage::{Flow, Measured};
use cohold_core::device::{encoder::Counts, motor::Duty};
use cohold_core::law::{AnyLaw, Packet};
use cohold_core::num::{Motion, StateVector};
use cohold_core::peer::{Observed, Peer};
use cohold_core::safety::{Fault, Mode};
use cohold_core::sample::OfAxis;
use cohold_core::settings::Settings;
use firmware_parts::record::{ENABLED, RECEIVED, Record, SENT, Tick, digest, joints, mode_code};

fn peer(position: f32) -> Peer<f32, AnyLaw<f32>> {
    Peer::new(&Settings::default(), [Motion::at(position); AXES]).unwrap()
}

/// A tick of a peer that is disarmed, with nothing in it but these.
fn tick(peer: &mut Peer<f32, AnyLaw<f32>>, tick: u32, flags: u8) -> Tick<'static> {
    let (counts, duties, digest) = ([Counts(0x1234), Counts(0xABCD)], [Duty::OFF; 2], digest(peer));
    Tick { tick, axis: 0, counts, duties, stage: None, mode: mode_code(peer.mode()), flags, digest }
}

#[test]
fn bytes_lead_back_to_the_record() {
    let mut peer = peer(0.25);
    let of = Tick { axis: 2, duties: [Duty(-3), Duty(4)], ..tick(&mut peer, 7, ENABLED | SENT) };
    let mut record = Record::default();
    record.fill(&of, None, &OfAxis::new(peer.observed()[0], peer.ledger()[0]));
    let back = Record::from_bytes(&record.bytes()).unwrap();
    assert_eq!(back, record);
    assert_eq!((back.tick(), back.axis(), back.mode(), back.flags()), (7, 2, Mode::Disarmed, ENABLED | SENT));
    assert_eq!((back.counts(), back.duties()), (of.counts, of.duties));
    assert_eq!(back.digest(), digest(&mut peer));
    // Words 7 to 14 are what was seen, in the order of the table.
    let mut decoded: Record = Record::default();
    decoded.0[7..15].copy_from_slice(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0].map(f32::to_bits));
    let [device, object, desired] =
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)].map(|(position, velocity)| Motion { position, velocity });
    let seen = Observed { device, object, desired, contact_force: 7.0, coordination_force: 8.0 };
    assert_eq!(decoded.observed(), seen);
    decoded.0[16..18].copy_from_slice(&[9.0, 10.0].map(f32::to_bits));
    assert_eq!(decoded.energy_j(), [9.0, 10.0]);
    let mut again = Record::default();
    again.fill(&of, None, &OfAxis { observed: &seen, received_j: 9.0, sent_j: 10.0 });
    assert_eq!([&again.0[7..15], &again.0[16..18]], [&decoded.0[7..15], &decoded.0[16..18]]);
}

#[test]
fn records_of_three_axes_tell_of_three_joints() {
    assert_eq!([0, 1, 2].map(|axis| joints([7, 8, 9], axis)), [[7, 8], [8, 9], [9, 7]]);
    assert_eq!(joints([7, 8], 0), [7, 8]);
}

#[test]
fn a_packet_that_came_in_comes_out_whole() {
    let packet = Packet::<f32> {
        motion: Motion { position: 0.25, velocity: -1.5 },
        wave: 2.0,
        energy_j: 1.0 / 3.0,
        wave_integral: -1.0 / 7.0,
        live_ticks: 0xFEDC_BA98,
    };
    let decoded = |flags, incoming: Option<Packet<f32>>| {
        let mut peer = peer(0.0);
        let mut record = Record::default();
        record.fill(&tick(&mut peer, 8, flags), incoming.as_ref(), &OfAxis::new(peer.observed()[0], peer.ledger()[0]));
        Record::from_bytes(&record.bytes()).unwrap().incoming()
    };
    assert_eq!(decoded(SENT | RECEIVED, Some(packet)), Some(packet));
    assert_eq!(decoded(SENT, None), None);
}

#[test]
fn what_the_stage_measured_comes_out_whole() {
    let motors = [Flow { mean: -1, last: 2, voltage: -3 }, Flow { mean: 4, last: -5, voltage: i16::MIN }];
    let stage = Measured { motors, supply_mv: 24_000, supply_counts: 6000, thermistor: 62 };
    for stage in [Some(&stage), None] {
        let mut peer = peer(0.0);
        let mut record = Record::default();
        record.fill(
            &Tick { stage, ..tick(&mut peer, 9, ENABLED) },
            None,
            &OfAxis::new(peer.observed()[0], peer.ledger()[0]),
        );
        assert_eq!(Record::from_bytes(&record.bytes()).unwrap().stage().as_ref(), stage);
    }
}

/// Offsets of protocol/FORMAT.md.
#[test]
fn the_bytes_lie_where_the_format_says() {
    let [device, object, desired] =
        [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)].map(|(position, velocity)| Motion { position, velocity });
    let seen = Observed { device, object, desired, contact_force: 7.0, coordination_force: 8.0 };
    let motion = Motion { position: 11.0, velocity: 12.0 };
    let packet = Packet::<f32> { motion, wave: 13.0, energy_j: 14.0, wave_integral: 15.0, live_ticks: 0x1716_1514 };
    let motors = [Flow { mean: 21, last: 22, voltage: 23 }, Flow { mean: -24, last: 25, voltage: 26 }];
    let stage = Measured { motors, supply_mv: 24_000, supply_counts: 6000, thermistor: 62 };
    let mode = mode_code(Mode::Faulted(Fault::PeerLost));
    let of = Tick {
        tick: 0x0403_0201,
        axis: 2,
        counts: [Counts(0x0605), Counts(0x0807)],
        duties: [Duty(-2), Duty(3)],
        stage: Some(&stage),
        mode,
        flags: ENABLED | RECEIVED,
        digest: 0x0D0C_0B0A,
    };
    let mut record = Record::default();
    record.fill(&of, Some(&packet), &OfAxis { observed: &seen, received_j: 9.0, sent_j: 10.0 });
    let bytes = record.bytes();
    assert_eq!(bytes[..16], [1, 2, 3, 4, 5, 6, 7, 8, 0xFE, 0xFF, 3, 0, 2, Fault::PeerLost.number(), 5, 2 | 62 << 2]);
    let floats = |at: usize, count: usize| {
        let words = bytes[at..at + 4 * count].as_chunks().0;
        words.iter().map(|word| f32::from_le_bytes(*word)).collect::<Vec<_>>()
    };
    assert_eq!(floats(16, 3), [11.0, 12.0, 13.0]);
    assert_eq!(floats(28, 8), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert_eq!(bytes[60..64], [0x0A, 0x0B, 0x0C, 0x0D]);
    assert_eq!(floats(64, 2), [9.0, 10.0]);
    assert_eq!(
        [&bytes[72..80], &bytes[80..88]],
        [14.0_f64, 15.0].map(f64::to_le_bytes).each_ref().map(|eight| &eight[..])
    );
    assert_eq!(bytes[88..92], [0x14, 0x15, 0x16, 0x17]);
    let halves: Vec<_> = bytes[92..].as_chunks().0.iter().map(|half| i16::from_le_bytes(*half)).collect();
    assert_eq!(halves, [21, 22, 23, -24, 25, 26, 24_000, 6000]);
}

#[test]
fn any_bit_of_the_state_changes_the_digest() {
    let peer = peer(0.0);
    let mut numbers = 0;
    peer.clone().visit(&mut |_| numbers += 1);
    for at in 0..numbers {
        let mut changed = peer;
        let mut n = 0;
        changed.visit(&mut |number: &mut f32| {
            if n == at {
                *number = f32::from_bits(number.to_bits() ^ 1);
            }
            n += 1;
        });
        assert_ne!(digest(&mut changed), digest(&mut peer.clone()), "number {at}");
    }
}
