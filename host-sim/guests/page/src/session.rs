//! The two peers with devices and hands, and the network between them: what [`cohold_sim::pair::Pair`] is in a run, with hands
//! that come and go, and settings that change in flight.
//!
//! **What a change does.** Keys of the network act at once, on what is sent from then on. Everything else is what a peer is configured with
//! before it is armed: both start anew, at rest, where the middle of their devices is, and hands let go. Peers whose motors are off,
//! because they were stopped or because of a fault, stay so until they are asked to start.
//!
//! **A fault ends it.** The tick in which a peer faults is the last one: a copy that runs away tells nothing more. It stands as it was until
//! it is started anew.
//!
//! **Ends of travel.** A device can go [`REACH_M`] to either side, where a spring and a damper push back ([`end_of_travel`]).

use std::array::from_fn;

use cohold_core::num::Motion;
use cohold_core::safety::{Command as Order, Fault};
use cohold_core::settings::Refused;
use cohold_sim::measure::port::ObjectPort;
use cohold_sim::network::{link::Counts, link::Route, rule::Direction};
use cohold_sim::pair::Pair;
use cohold_sim::plant::Plant;
use cohold_sim::{DynPeer, peers::Builds, scene::Scene};

use super::environment::{ARMED, Command, Environment, Sample, Standing, number_of};
use super::pair_columns::sample;
use super::partner::{Model, Partner};
use cohold_cli::Failure;
use cohold_live::hand::{Hand, REACH_M, end_of_travel};
pub(super) use cohold_live::playable::PERIOD_S;
use cohold_live::watch::Liveness;

/// What one peer's part of a sample needs to know of the tick before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<const SHARED: usize> {
    ports: [ObjectPort; SHARED],
    /// Packets heard.
    heard: u64,
    liveness: Liveness,
}

impl<const SHARED: usize> Side<SHARED> {
    pub(super) fn new(scene: &Scene) -> Self {
        let port = ObjectPort::new(PERIOD_S, scene.peer.coordination.stiffness_n_per_m);
        Self { ports: [port; SHARED], heard: 0, liveness: Liveness::of(scene) }
    }

    /// After a tick of this peer, which has heard so many packets: energy sent and not received, and kept, J; and 1 while what it hears is
    /// fresh.
    pub(super) fn see<const N: usize>(&mut self, peer: &dyn DynPeer<f32, SHARED, N>, heard: u64) -> (f64, f64, f32) {
        let (mut sent_j, mut kept_j) = (0.0, 0.0);
        for ((port, seen), ledger) in self.ports.iter_mut().zip(peer.observed()).zip(peer.ledger()) {
            let [received, sent] = [ledger.received_j(), ledger.sent_j()].map(f64::from);
            port.see(&seen.map(f64::from), [received, sent]);
            sent_j += sent - received;
            kept_j += port.kept_j();
        }
        let heard_now = std::mem::replace(&mut self.heard, heard) != heard;
        let live = self.liveness.see(heard_now, peer.outgoing()[0].live_ticks);
        (sent_j, kept_j, f32::from(u8::from(live)))
    }
}

/// Everything that is stepped, of an object that is shared along `SHARED` axes of devices of `N`.
pub(super) struct Session<const SHARED: usize, const N: usize> {
    scene: Scene,
    pair: Pair<f32, Plant<N>, SHARED, N>,
    hands: [Hand<SHARED>; 2],
    partners: [Partner<SHARED>; 2],
    sides: [Side<SHARED>; 2],
    /// Forces of the hands in this tick, N.
    pulls: [[f64; SHARED]; 2],
    tick: u64,
    pub(super) restarts: u32,
    cut: bool,
}

impl<const SHARED: usize, const N: usize> Session<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    /// Both peers armed and at rest.
    pub(super) fn new(scene: Scene, partner: Model) -> Result<Self, Refused<'static>> {
        let pair = Pair::build(&scene)?;
        Ok(Self {
            pair,
            hands: Default::default(),
            partners: [Partner::new(partner); 2],
            sides: sides(&scene),
            pulls: [[0.0; SHARED]; 2],
            tick: 0,
            restarts: 0,
            cut: false,
            scene,
        })
    }

    /// Both peers start anew, armed, in the middle of where their devices are; hands let go.
    pub(super) fn start(&mut self) -> Result<(), Refused<'static>> {
        let [one, two] = [0, 1].map(|index| self.device(index));
        let middle = |axis: usize| (0.5 * (one[axis].position + two[axis].position)).clamp(-REACH_M, REACH_M);
        let mut by_m = [0.0; N];
        for (axis, by_m) in by_m.iter_mut().enumerate().take(SHARED) {
            // What has left the range of numbers starts from the middle of the table.
            *by_m = Some(middle(axis)).filter(|at| at.is_finite()).unwrap_or_default();
        }
        self.pair = Pair::starting_at(&self.scene, by_m)?;
        self.sides = sides(&self.scene);
        self.hands = Default::default();
        self.partners.iter_mut().for_each(Partner::rest);
        self.restarts += 1;
        self.cut(self.cut);
        Ok(())
    }

    /// Motors off, at both.
    pub(super) fn stop(&mut self) {
        self.pair.sides_mut().for_each(|side| side.peer.command(Order::Disarm));
    }

    /// Cuts the line both ways, or joins it again.
    pub(super) fn cut(&mut self, cut: bool) {
        self.cut = cut;
        for direction in [Direction::OneToTwo, Direction::TwoToOne] {
            self.pair.route(direction).cut = cut;
        }
    }

    /// Mode of either peer.
    pub(super) fn modes(&self) -> [u8; 2] {
        self.pair.sides().map(|side| number_of(side.peer.mode()))
    }

    /// The fault that stopped a peer, and its number, 1 or 2.
    pub(super) fn fault(&self) -> Option<(usize, Fault)> {
        self.pair.fault()
    }

    /// What became of the packets from peer 1 to 2, and from 2 to 1.
    pub(super) fn packets(&mut self) -> [Counts; 2] {
        [Direction::OneToTwo, Direction::TwoToOne].map(|direction| self.pair.route(direction).counts())
    }

    /// Force of each simulated user in the next tick, N toward the other peer.
    pub(super) fn pushes(&self) -> [f64; 2] {
        self.scene.users.each_ref().map(|user| user.force_n(self.pair.time_s()))
    }

    /// Force of the scene's user on a device that moves like this in the tick that is over, along an axis, N: its push, and its arm's pull.
    fn user_force(&self, index: usize, axis: usize, device: Motion<f64>) -> f32 {
        let (user, time_s) = (&self.scene.users[index], (self.pair.time_s() - PERIOD_S).max(0.0));
        let profile = &user.settings.user;
        // Its own direction is toward the other peer.
        let toward = user.direction()[axis] * if index == 0 { 1.0 } else { -1.0 };
        let (wanted, wanted_speed) = user.wanted(time_s);
        let arm = profile.arm_stiffness_n_per_m * (toward * wanted - device.position)
            + profile.arm_damping_n_s_per_m * (toward * wanted_speed - device.velocity);
        let side = if axis == 0 { 0.0 } else { profile.side_push_n };
        (toward * user.force_n(time_s) + arm + side) as f32
    }

    /// Where each hand of a person is, m, if it holds.
    pub(super) fn holds(&self) -> [Option<[f64; SHARED]>; 2] {
        self.hands.each_ref().map(Hand::holds)
    }

    /// The shared axes of a device.
    fn device(&self, index: usize) -> [Motion<f64>; SHARED] {
        first(self.pair.sides()[index].plant.motions())
    }

    fn sample(&mut self) -> Sample {
        let [one, two] = [0, 1].map(|at| {
            let side = self.pair.sides()[at];
            (self.sides[at].see(&*side.peer, side.delivered()), side.delay_ns as f32 * 1e-9)
        });
        let seen = [0, 1].map(|at| self.pair.sides()[at].peer.observed().map(|seen| *seen));
        let devices = [0, 1].map(|at| self.device(at));
        let holds = self.holds();
        let axis = |axis: usize| {
            [
                holds.map(|holds| holds.map_or(f32::NAN, |at| at[axis] as f32)),
                devices.map(|device| device[axis].position as f32),
                seen.map(|seen| seen[axis].object.position),
                seen.map(|seen| seen[axis].desired.position),
                seen.map(|seen| seen[axis].contact_force),
                seen.map(|seen| seen[axis].coordination_force),
                self.pulls.map(|pull| pull[axis] as f32),
                from_fn(|index| self.user_force(index, axis, devices[index][axis])),
            ]
        };
        let (((sent_1, kept_1, live_1), delay_1), ((sent_2, kept_2, live_2), delay_2)) = (one, two);
        let rest = [(sent_1 + sent_2) as f32, kept_1 as f32, kept_2 as f32, delay_1, delay_2, live_1, live_2];
        sample(from_fn::<_, SHARED, _>(axis), rest, self.restarts)
    }
}

impl<const SHARED: usize, const N: usize> Environment for Session<SHARED, N>
where
    f32: Builds<SHARED, N>,
{
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Stop => self.stop(),
            Command::Start => self.start()?,
            Command::Cut(cut) => self.cut(cut),
            Command::Partner(model) => self.partners = [Partner::new(model); 2],
            Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Failure> {
        let before = std::mem::replace(&mut self.scene, scene);
        // What the receivers were built with is no more the network's.
        let built = |scene: &Scene| (scene.world.network.playout_packets, scene.world.network.clock_drift_ppm);
        if built(&before) != built(&self.scene) || !same_but_for_network(&before, &self.scene) {
            let armed = self.modes() == [ARMED; 2];
            self.start()?;
            if !armed {
                self.stop();
            }
            return Ok(());
        }
        for direction in [Direction::OneToTwo, Direction::TwoToOne] {
            let Route { delay_ns, rule, .. } = Route::of_scene(&self.scene, direction, 0);
            let route = self.pair.route(direction);
            (route.delay_ns, route.rule) = (delay_ns, rule);
        }
        Ok(())
    }

    fn point(&mut self, index: usize, pointer: Option<[f64; 3]>, restarts: u32) {
        self.partners[index].rest();
        let pointer = pointer.filter(|_| restarts == self.restarts).map(first);
        self.hands[index].point(self.tick, pointer, self.device(index).map(|axis| axis.position));
    }

    fn play(&mut self, index: usize) {
        let device = self.device(index).map(|axis| axis.position);
        let wanted = self.partners[index].wants(device, PERIOD_S);
        self.hands[index].point(self.tick, wanted, device);
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        for index in 0..2 {
            self.pulls[index] = self.hands[index].pull(self.tick, self.device(index), PERIOD_S);
        }
        for (side, pull) in self.pair.sides_mut().zip(self.pulls) {
            side.plant.pull(on_device(pull, side.plant.motions()));
        }
        self.pair.step();
        self.tick += 1;
        Ok(self.sample())
    }

    fn stands(&self) -> bool {
        self.fault().is_some()
    }

    fn standing(&self) -> Standing {
        Standing { modes: self.modes(), cut: self.cut, partner: self.partners[0].model.number() }
    }
}

/// The first ones of these; where there are too few, nothing.
pub(super) fn first<T: Copy + Default, const OF: usize, const N: usize>(all: [T; OF]) -> [T; N] {
    from_fn(|axis| all.get(axis).copied().unwrap_or_default())
}

/// What a hand that pulls along the shared axes, N, and the ends of travel along them do to a device.
pub(super) fn on_device<const SHARED: usize, const N: usize>(
    pull: [f64; SHARED],
    motions: [Motion<f64>; N],
) -> [f64; N] {
    let motions: [_; SHARED] = first(motions);
    first(from_fn::<_, SHARED, _>(|axis| pull[axis] - end_of_travel(motions[axis])))
}

/// Whether two scenes are the same but for their networks.
pub(super) fn same_but_for_network(one: &Scene, other: &Scene) -> bool {
    let settings_of = |scene: &Scene| scene.settings().into_iter().filter(|(key, _)| !key.starts_with("network."));
    settings_of(one).eq(settings_of(other))
}

fn sides<const SHARED: usize>(scene: &Scene) -> [Side<SHARED>; 2] {
    [Side::new(scene); 2]
}

#[cfg(test)]
#[path = "../tests/inside/session.rs"]
mod tests;
