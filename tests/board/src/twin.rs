//! The same scene in host-sim, in f32, and one tick of a board on this PC: what a board must equal, bit for bit.
//!
//! Two comparisons that fail for different reasons. [`closed_loop`]: host-sim runs the scene on its own, and every tick of
//! both peers must give the state that the boards had. [`replay`]: one board's recorded inputs go through the same code
//! here, and the whole record must come out again, motor duties included.

use firmware_parts::record::{self, Record, digest};
use haptic_core::axis::Reading;
use haptic_core::axis::encoder::Counts;
use haptic_core::motion::Motion;
use haptic_core::peer::{self, Sensors, State};
use haptic_core::render::Contact;
use haptic_core::safety::Command;
use haptic_core::scene::{Any, Scene};
use haptic_core::settings::Settings;
use host_sim::harness::Pair;
use host_sim::scene::SceneFile;

/// How far two runs are the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Equal {
    /// Ticks whose bits are the same, from the start on.
    pub ticks: u64,
    /// The first tick that differs, if any.
    pub first_difference: Option<u64>,
}

fn compare(mut same: impl FnMut(u64) -> bool, ticks: u64) -> Equal {
    let first_difference = (0..ticks).find(|tick| !same(*tick));
    Equal { ticks: first_difference.unwrap_or(ticks), first_difference }
}

/// host-sim's run of the scene against both boards' ticks since arming.
///
/// # Panics
/// host-sim refuses the scene.
pub fn closed_loop(scene: &SceneFile, boards: [&[Record]; 2]) -> Equal {
    let mut pair = Pair::<f32>::new(scene).expect("the boards took it");
    let ticks = boards.iter().map(|records| records.len()).min().unwrap_or(0) as u64;
    compare(
        |tick| {
            let counts = pair.sides.each_ref().map(|side| side.plant.sensors::<f32>().reading);
            pair.step();
            pair.sides.iter_mut().zip(boards).zip(counts).all(|((side, records), reading)| {
                let board = &records[tick as usize];
                let seen = *side.state.observed();
                reading == Reading::Counts(board.counts().map(Counts))
                    && digest(&mut side.state) == board.digest()
                    && seen.object.position.to_bits() == board.object_m().to_bits()
                    && seen.desired.position.to_bits() == board.desired_m().to_bits()
            })
        },
        ticks,
    )
}

/// One board's recorded inputs through the code here, from the tick that armed it.
///
/// # Panics
/// The settings are refused.
pub fn replay(settings: &Settings, records: &[Record]) -> Equal {
    let scene = Scene::<Any<f32>>::build(settings).expect("the board took it");
    let home = Motion::at(-Contact::<f32>::build(settings).clear_of(0.0));
    let mut state = State::new(&scene, [home, Motion::REST]);
    state.command(&scene, Command::Arm);
    compare(
        |tick| {
            let board = &records[tick as usize];
            let incoming = board.incoming();
            if board.flags() & record::PARTED != 0 {
                state.part();
            }
            if board.flags() & record::SENT != 0 {
                peer::exchange(&scene, &mut state, incoming);
            }
            let counts = board.counts().map(Counts);
            let overrun = board.flags() & record::OVERRUN != 0;
            let actuators = peer::tick(&scene, &mut state, &Sensors { reading: Reading::Counts(counts), overrun });
            Record::new(board.tick(), counts, incoming, board.flags(), &mut state, &actuators) == *board
        },
        records.len() as u64,
    )
}
