//! The same scene in cohold, in f32, and one tick of a board on this PC: what a board must equal, bit for bit.
//!
//! Three comparisons that fail for different reasons. [`closed_loop`]: cohold runs the scene on its own, and every tick of
//! both peers must give the state that the boards had. [`closed_loop_given`]: the same on a bad line, where the boards say
//! which packets arrived when, and nothing else: every one must be, to the bit, one that cohold's other peer had sent by
//! then. [`replay`]: one board's recorded inputs go through the same code here, and the whole record must come out again,
//! motor duties included.

use std::array::from_fn;
use std::collections::BTreeMap;

use cohold_core::contact::Contact;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::{AnyLaw, Packet};
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::{Observed, Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::sample::OfAxis;
use cohold_core::settings::Settings;
use cohold_protocol::peer::{flow_of, packets_of};
use cohold_sim::pair::Pair;
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;
use firmware_parts::record::{self, Record, digest};

/// How far two runs are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Equal {
    /// Ticks whose bits are the same, from the start on.
    pub ticks: u64,
    /// The first tick that differs, if any.
    pub first_difference: Option<u64>,
}

/// What a board reported from the tick that armed it on.
#[derive(Clone, Copy, Debug)]
pub struct Armed<'a> {
    /// Records of every armed tick.
    pub records: &'a [Record],
    /// How many of them passed before the devices began to move.
    pub standing: usize,
}

fn compare(mut same: impl FnMut(u64) -> bool, ticks: u64) -> Equal {
    let first_difference = (0..ticks).find(|tick| !same(*tick));
    Equal { ticks: first_difference.unwrap_or(ticks), first_difference }
}

/// cohold's run of the scene against both boards' ticks since arming.
///
/// # Panics
/// cohold refuses the scene.
pub fn closed_loop(scene: &Scene, boards: [&[Record]; 2]) -> Equal {
    let mut pair = Pair::<f32>::new(scene).expect("the boards took it");
    let ticks = boards.iter().map(|records| records.len()).min().unwrap_or(0) as u64;
    let bits = |seen: Observed<f32>| [seen.object.position, seen.desired.position].map(f32::to_bits);
    compare(
        |tick| {
            let counts = pair.sides().map(|side| side.plant.sensors::<f32>().reading);
            pair.step();
            pair.sides_mut().zip(boards).zip(counts).all(|((side, records), reading)| {
                let board = &records[tick as usize];
                let seen = *side.peer.observed()[0];
                reading == Reading::Counts(board.counts())
                    && digest(&mut *side.peer) == board.digest()
                    && bits(seen) == bits(board.observed())
            })
        },
        ticks,
    )
}

/// How far back a packet may come from, packet periods.
const LATEST: usize = 64;

/// cohold's peers and devices, given the arrivals that the boards had, against both boards' ticks since the first of them
/// was armed; the devices begin to move where the boards' did.
///
/// # Panics
/// cohold refuses the scene.
pub fn closed_loop_given(scene: &Scene, boards: [Armed<'_>; 2]) -> Equal {
    closed_loop_ordered(scene, boards, &[])
}

/// [`closed_loop_given`] of boards that were given orders: which board (0 or 1), before which tick of this
/// comparison, and which. When an order reached its tick a record does not say: what it changes does.
///
/// # Panics
/// cohold refuses the scene.
pub fn closed_loop_ordered(scene: &Scene, boards: [Armed<'_>; 2], orders: &[(usize, u64, Command)]) -> Equal {
    closed_loop_along::<1, AXES>([scene; 2], boards, [&[]; 2], orders, [false; 2])
}

/// [`closed_loop_given`] of boards with devices of their own, a scene each, of which some hear from a motor's controller where the joint was a
/// tick ago (`late`).
///
/// # Panics
/// cohold refuses a scene.
pub fn closed_loop_late(scenes: [&Scene; 2], boards: [Armed<'_>; 2], late: [bool; 2]) -> Equal {
    closed_loop_along::<1, AXES>(scenes, boards, [&[]; 2], &[], late)
}

/// [`closed_loop_given`] of an object that is shared along three axes: `further` are the boards' ticks along the second and the third.
///
/// # Panics
/// cohold refuses the scene.
pub fn closed_loop_shared(scene: &Scene, boards: [Armed<'_>; 2], further: [&[Record]; 2]) -> Equal {
    closed_loop_along::<3, 3>([scene; 2], boards, further, &[], [false; 2])
}

fn closed_loop_along<const SHARED: usize, const N: usize>(
    scenes: [&Scene; 2],
    boards: [Armed<'_>; 2],
    further: [&[Record]; 2],
    orders: &[(usize, u64, Command)],
    late: [bool; 2],
) -> Equal
where
    f32: Builds<SHARED, N>,
{
    let built = |scene| Pair::<f32, Plant<N>, SHARED, N>::build(scene).expect("the boards took it");
    let mut pairs = scenes.map(built);
    let mut sides = pairs.each_mut().map(Pair::sides_mut);
    let mut sides = [0, 1].map(|at| sides[at].nth(at).expect("two sides"));
    // Nobody is there until he is heard.
    sides.iter_mut().for_each(|side| side.peer.part());
    let told: [BTreeMap<(u32, u8), &Record>; 2] =
        further.map(|records| records.iter().map(|record| ((record.tick(), record.axis()), record)).collect());
    let mut before_last = sides.each_ref().map(|side| side.plant.sensors::<f32>());
    let begin = boards.iter().map(|board| board.standing).max().unwrap_or(0) as u64;
    let before = boards.map(|board| begin - board.standing as u64);
    let ticks = boards.iter().zip(before).map(|(board, before)| board.records.len() as u64 + before).min().unwrap_or(0);
    let mut sent: [Vec<[Packet<f32>; SHARED]>; 2] = Default::default();
    compare(
        |tick| {
            let mut same = true;
            for (at, (side, (board, before))) in sides.iter_mut().zip(boards.iter().zip(before)).enumerate() {
                // One board is armed some ticks before the other.
                let Some(at_board) = tick.checked_sub(before) else { continue };
                let first = &board.records[at_board as usize];
                let along = |axis: usize| {
                    if axis == 0 { Some(first) } else { told[at].get(&(first.tick(), axis as u8)).copied() }
                };
                if (0..SHARED).any(|axis| along(axis).is_none()) {
                    return false;
                }
                let board: [&Record; SHARED] = from_fn(|axis| along(axis).unwrap_or(first));
                if first.flags() & record::PARTED != 0 {
                    side.peer.part();
                }
                let incoming = board.map(Record::incoming);
                if incoming.iter().all(Option::is_some) {
                    let packets = incoming.map(Option::unwrap_or_default);
                    same &= sent[1 - at].iter().rev().take(LATEST).any(|sent| *sent == packets);
                    side.peer.hear(&packets);
                }
                if side.peer.packet_due() {
                    sent[at].extend(side.peer.exchange());
                }
                for (_, _, order) in orders.iter().filter(|(board, before, _)| (*board, *before) == (at, tick)) {
                    side.peer.command(*order);
                }
                let mut sensors = side.plant.sensors::<f32>();
                if late[at] {
                    std::mem::swap(&mut sensors, &mut before_last[at]);
                }
                let actuators = side.peer.tick(&sensors);
                if let Some(moving) = tick.checked_sub(begin) {
                    side.plant.step(moving as f64 * scenes[at].peer.timing.control_period_s, &actuators);
                }
                // Along one axis a record has all joints; of several it has its own.
                let joint = |joint: usize| if SHARED == 1 { (first, joint) } else { (board[joint], 0) };
                let counts = from_fn(|nth| joint(nth).0.counts()[joint(nth).1]);
                let duties = from_fn(|nth| joint(nth).0.duties()[joint(nth).1]);
                same &= sensors.reading == Reading::Counts(counts)
                    && digest(&mut *side.peer) == first.digest()
                    && actuators.duties == duties
                    && side.peer.observed().into_iter().zip(board).all(|(seen, record)| *seen == record.observed());
            }
            same
        },
        ticks,
    )
}

/// One board's recorded inputs through the code here, from the tick that armed it.
///
/// # Panics
/// The settings are refused.
pub fn replay(settings: &Settings, records: &[Record]) -> Equal {
    replay_in::<f32>(settings, records)
}

/// [`replay`] for a board that computes in these numbers, of which a record has the nearest f32.
///
/// # Panics
/// The settings are refused.
pub fn replay_in<S: Scalar>(settings: &Settings, records: &[Record]) -> Equal {
    replay_from::<S>(settings, records, |_| {})
}

/// [`replay`] for a board that had not yet heard anybody when the records begin.
///
/// # Panics
/// The settings are refused.
pub fn replay_alone(settings: &Settings, records: &[Record]) -> Equal {
    replay_from::<f32>(settings, records, Peer::part)
}

fn replay_from<S: Scalar>(settings: &Settings, records: &[Record], begin: impl Fn(&mut Peer<S, AnyLaw<S>>)) -> Equal {
    let home = Motion::at(-Contact::build(settings).clear_of(S::ZERO));
    let mut peer = Peer::new(settings, [home, Motion::REST]).expect("the board took it");
    peer.command(Command::Arm);
    begin(&mut peer);
    compare(
        |tick| {
            let board = &records[tick as usize];
            let incoming = board.incoming().map(|packet| packets_of::<S, 1>(&flow_of([packet], true, 0)));
            if board.flags() & record::PARTED != 0 {
                peer.part();
            }
            if let Some(packets) = &incoming {
                peer.hear(packets);
            }
            if board.flags() & record::SENT != 0 {
                peer.exchange();
            }
            let counts = board.counts();
            let overrun = board.flags() & record::OVERRUN != 0;
            let stage = board.stage();
            let actuators = peer.tick(&Sensors { overrun, stage, ..Sensors::of(Reading::Counts(counts)) });
            let (mut record, digest) = (Record::default(), digest(&mut peer));
            let (tick, flags, duties) = (board.tick(), board.flags(), actuators.duties);
            let mode = record::mode_code(peer.mode());
            let of = record::Tick { tick, axis: 0, counts, duties, stage: stage.as_ref(), mode, flags, digest };
            record.fill(
                &of,
                incoming.as_ref().map(|[packet]| packet),
                &OfAxis::new(peer.observed()[0], peer.ledger()[0]),
            );
            record == *board
        },
        records.len() as u64,
    )
}
