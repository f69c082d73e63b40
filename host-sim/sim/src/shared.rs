//! Two peers that share the object along several axes: stepped as [`crate::pair`] steps those of one, with packets of all axes together.
//!
//! What came of it is told axis by axis, with the figures of merit of a run of one ([`Outcome`]): where nothing couples the axes each is
//! that run, to the bit. What is of all axes at once is the distance of the copies. Laws of core only, and devices all of whose axes are
//! shared.

use haptic_core::device::kinematics::{AnyKinematics, AnySpatial, Kinematics};
use haptic_core::law::{AnyLaw, Packet};
use haptic_core::num::{Fixed, Motion, Scalar, StateVector};
use haptic_core::peer::Peer;
use haptic_core::safety::Command;
use haptic_core::settings::Refused;

use crate::engine::{Actor, Engine, Out, Seat, Turn};
use crate::network::link::{Inbox, Numbered, Route};
use crate::network::rule::Direction;
use crate::pair::HASH_SEED;
use crate::peers::mixed;
use crate::plant::Plant;
use crate::run::{Account, GoOn, Options, Outcome, Ticked};
use crate::scene::Scene;

/// What the axes are called, the first one first.
pub const NAMES: [&str; 3] = ["x", "y", "z"];

/// What a run gave.
#[derive(Clone, Debug)]
pub struct Shared {
    /// Of every shared axis; no hash.
    pub axes: Vec<Outcome>,
    /// Mean distance of the two copies over the last half, mm.
    pub true_discrepancy_mm: f64,
    /// Of both peers' states over every tick.
    pub hash: u64,
}

impl Shared {
    /// Every axis is.
    pub fn is_stable(&self) -> bool {
        self.axes.iter().all(Outcome::is_stable)
    }
}

/// Sees rows, each with its axis, from 0.
pub type EachRow<'a> = &'a dyn Fn(usize, &[f64]);

/// A number type in which such scenes are run.
pub trait Run: Scalar<Counter = f64> {
    /// [`run`] in this type. Compiled here, once and optimised.
    #[doc(hidden)]
    fn run(
        scene: &Scene,
        options: Options,
        go_on: GoOn<'_>,
        each: Option<EachRow<'_>>,
    ) -> Result<Shared, Refused<'static>>;
}

macro_rules! runs {
    ($($Number:ty),+) => {
        $(impl Run for $Number {
            fn run(
                scene: &Scene,
                options: Options,
                go_on: GoOn<'_>,
                each: Option<EachRow<'_>>,
            ) -> Result<Shared, Refused<'static>> {
                match scene.peer.axis.shared {
                    3 => run_in::<Self, 3, AnySpatial<Self>>(scene, options, go_on, each),
                    _ => run_in::<Self, 2, AnyKinematics<Self>>(scene, options, go_on, each),
                }
            }
        })+
    };
}
runs!(f32, f64, Fixed);

/// Runs the scene with peers that compute in `S`, for as long as `go_on`, which is asked every 10,000 ticks, says so.
///
/// # Errors
/// What a peer refuses.
pub fn run<S: Run>(scene: &Scene, options: Options, go_on: GoOn<'_>) -> Result<Shared, Refused<'static>> {
    S::run(scene, options, go_on, None)
}

/// The same; `each` sees every tick of every axis as a row of [`Account::columns`], whatever is kept in the tables.
///
/// # Errors
/// What a peer refuses.
pub fn run_seen<S: Run>(
    scene: &Scene,
    options: Options,
    go_on: GoOn<'_>,
    each: EachRow<'_>,
) -> Result<Shared, Refused<'static>> {
    S::run(scene, options, go_on, Some(each))
}

/// One peer with its device.
struct Side<S: Scalar, const N: usize, K> {
    peer: Peer<S, AnyLaw<S>, N, N, K>,
    plant: Plant<N>,
    inbox: Inbox<[Packet<S>; N]>,
    /// The seat that its packets are for.
    to: usize,
    /// Packet periods so far.
    number: u64,
    period_s: f64,
    period_ns: u64,
}

/// Peer `index` (0 or 1) of this device, disarmed and at rest.
pub(crate) fn peer<S: Scalar, const N: usize, K: Kinematics<S, N>>(
    scene: &Scene,
    index: usize,
    plant: &Plant<N>,
) -> Result<Peer<S, AnyLaw<S>, N, N, K>, Refused<'static>> {
    let settings = &scene.peers()[index];
    let in_the_world = |axis: Motion<f64>| Motion::at(S::from_f64(settings.scale.position * axis.position));
    Peer::build(settings, plant.motions().map(in_the_world))
}

impl<S: Scalar, const N: usize, K: Kinematics<S, N>> Side<S, N, K> {
    /// Peer `index` (0 or 1), armed and at rest, which writes to the other one.
    fn new(scene: &Scene, index: usize) -> Result<Self, Refused<'static>> {
        let plant = Plant::build(scene, index);
        let mut peer = peer(scene, index, &plant)?;
        peer.command(Command::Arm);
        let timing = &scene.peer.timing;
        Ok(Self {
            peer,
            plant,
            inbox: Inbox::new(scene, 1),
            to: 1 - index,
            number: 0,
            period_s: timing.control_period_s,
            period_ns: timing.control_period_ns(),
        })
    }
}

/// Both peers' packets are made before either's are taken in, as those of a pair.
impl<S: Scalar, const N: usize, K: Kinematics<S, N>> Actor<usize> for Side<S, N, K> {
    type Packet = Numbered<[Packet<S>; N]>;

    fn hear(&mut self, now_ns: u64, _: usize, packets: &mut Self::Packet, _: &mut Out<'_, usize, Self::Packet>) {
        self.inbox.put(now_ns, *packets);
    }

    fn speak(&mut self, _: u64, out: &mut Out<'_, usize, Self::Packet>) {
        if self.peer.packet_due() {
            if let Some(what) = self.peer.speak_each() {
                out(self.to, &Numbered { number: self.number, what });
            }
            self.number += 1;
        }
    }

    fn act(&mut self, now_ns: u64, _: &mut Out<'_, usize, Self::Packet>) {
        if let Some(packets) = self.inbox.take(now_ns) {
            self.peer.hear_each(&packets);
        }
        if self.peer.packet_due() {
            self.peer.listen();
        }
        let actuators = self.peer.tick(&self.plant.sensors());
        self.plant.step((now_ns / self.period_ns) as f64 * self.period_s, &actuators);
    }
}

fn run_in<S: Run, const N: usize, K: Kinematics<S, N>>(
    scene: &Scene,
    options: Options,
    go_on: GoOn<'_>,
    each: Option<EachRow<'_>>,
) -> Result<Shared, Refused<'static>> {
    let [first, mut second] = [Side::<S, N, K>::new(scene, 0)?, Side::new(scene, 1)?].map(Seat::new);
    second.period = 1.0 + 1e-6 * scene.world.network.clock_drift_ppm;
    let direction = |from| if from == 0 { Direction::OneToTwo } else { Direction::TwoToOne };
    let route = |from, _| Route::of_scene(scene, direction(from), 0);
    let mut engine = Engine::new(scene.peer.timing.control_period_ns(), vec![first, second], route);
    let ticks = options.ticks(scene);
    let mut accounts = vec![Account::new(scene, ticks, options); N];
    let (mut hash, mut apart_m) = (HASH_SEED, 0.0);
    for tick in 0..ticks {
        engine.step(&mut |turn| {
            if turn.turn == Turn::Acted {
                let peer = &turn.seats[turn.seat].actor.peer;
                let seen = peer.observed_each().into_iter().zip(peer.ledger_each());
                for (account, (observed, ledger)) in accounts.iter_mut().zip(seen) {
                    let energy = [ledger.received_j(), ledger.sent_j()];
                    account.ticked(turn.seat, Ticked::new(observed, energy, peer.mode(), peer.is_engaged()));
                }
            }
        });
        for seat in &mut engine.seats {
            seat.actor.peer.visit(&mut |number: &mut S| hash = mixed(hash, number.bits()));
        }
        for (axis, account) in accounts.iter_mut().enumerate() {
            account.period();
            if let Some(each) = each {
                each(axis, &account.row());
            }
        }
        if 2 * tick >= ticks {
            let squared = accounts.iter().map(|account| account.true_m() * account.true_m()).sum::<f64>();
            apart_m += squared.sqrt() / (ticks - ticks.div_ceil(2)) as f64;
        }
        if tick % 10_000 == 0 && !go_on(tick) {
            break;
        }
    }
    let axes = accounts.into_iter().map(Account::outcome).collect();
    Ok(Shared { axes, true_discrepancy_mm: 1e3 * apart_m, hash })
}
