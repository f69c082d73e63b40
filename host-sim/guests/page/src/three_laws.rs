//! A bad network: three laws side by side, under the same pushes and the same packets.
//!
//! Each lane is two peers of its own ([`super::session`]) under one law. What a lane has of the scene is its network, in seconds; everything
//! that makes up its law is the law's own. In all else they are alike: the simulated hands at their devices are the same, a packet goes
//! out every [`TICKS_PER_PACKET`] ticks, and the random numbers that lose and delay packets are drawn from one seed.
//! A person's hand holds the devices of all lanes at once, by a spring in each.
//!
//! A lane in which a peer faults stands from then on, and says which peer and why; the others go on.

use cohold_sim::{AXES, scene::Scene};

use super::environment::{ARMED, Column, Command, Environment, MOST, OFF, Sample, Standing, joined};
use super::orders::apply;
use super::pair_columns;
use super::partner::Model;
use super::session::{PERIOD_S, Session, same_but_for_network};
use cohold_cli::Failure;

/// Number of lanes.
const LANES: usize = 3;
/// What makes up each law: the gains of the cooperation paper's §5.2 at 16 ms, and those of the scene `any-network`.
const LAWS: [&str; LANES] = [
    "law power coordination.stiffness_n_per_m=310",
    "law passive-wave coordination.stiffness_n_per_m=10620",
    "law self-timed",
];
/// A packet every 8 ms, as in the paper.
const TICKS_PER_PACKET: u32 = 8;
/// What the simulated hand at either device does: it pushes toward the other with 0.5 N and a sine of 0.25 N, and an arm of 10 N/m and
/// 0.1 N·s/m holds it about the middle. That is little damping: energy that a law adds is not taken away at once.
const HAND: [(&str, f64); 4] =
    [("push_n", 0.5), ("sine_n", 0.25), ("arm_stiffness_n_per_m", 10.0), ("arm_damping_n_s_per_m", 0.1)];
/// Of all packets, how many are lost where the scene says nothing of it, and how many in a row.
const LOSS: f64 = 0.3;
const BURST_PACKETS: f64 = 40.0;

/// Numbers of a lane, in [`COLUMNS`].
const OF_LANE: usize = 14;
/// Numbers before those of the lanes.
const OF_ALL: usize = 4;
/// What a lane shows of its two peers, by their own columns.
const SHOWN: [&str; 6] = ["device_1", "device_2", "object_1", "object_2", "delay_1", "delay_2"];

/// The columns of a lane, by what their names begin with.
macro_rules! lane {
    ($law:literal $($name:literal, $unit:literal, $means:expr;)+) => {
        [$((concat!($name, "_", $law), $unit, $means)),+]
    };
    ($law:literal) => {
        lane! { $law
            "device_1", "m", concat!("device 1 under ", $law);
            "device_2", "m", "device 2";
            "object_1", "m", "copy of the object at peer 1";
            "object_2", "m", "copy of the object at peer 2";
            "delay_1", "s", "how long the newest packet was on its way to peer 1";
            "delay_2", "s", "how long the newest packet was on its way to peer 2";
            "sent", "", "packets that both have sent";
            "lost", "", "packets of those that were lost";
            "lost_1", "", "packets of those that were lost on their way to peer 1";
            "fault", "", "number of the fault that stopped this lane, 0 for none";
            "faulted", "", "which peer it was";
            "lasted", "s", "time from the start to now, or to the fault";
            "worst", "m", "largest distance of the copies since the start";
            "worst_at", "s", "time from the start to that distance";
        }
    };
}

pub(super) const COLUMNS: [Column; OF_ALL + LANES * OF_LANE] = {
    let all: [Column; OF_ALL] = [
        ("push_1", "N", "push of simulated hand 1 in every lane, to the right"),
        ("push_2", "N", "push of simulated hand 2 in every lane, to the right"),
        ("wanted_1", "m", "hand of person 1 in every lane, no number while it holds nothing"),
        ("wanted_2", "m", "hand of person 2 in every lane"),
    ];
    joined(&[&all, &lane!("power"), &lane!("wave"), &lane!("timed")])
};

/// The scene with a network that loses, where it has none.
pub(super) fn lossy(mut scene: Scene) -> Scene {
    let network = &mut scene.world.network;
    if network.loss == 0.0 {
        (network.loss, network.loss_burst_packets) = (LOSS, BURST_PACKETS);
    }
    scene
}

/// The scene of a lane: a law, and the network that all of them have.
fn lane_scene(scene: &Scene, law: &str) -> Result<Scene, Failure> {
    let network = scene.world.network;
    let delay_s = f64::from(network.one_way_delay_packets) * scene.peer.timing.packet_period_s();
    let delay = format!("network.one_way_delay_packets=0 network.extra_delay_s={}", delay_s + network.extra_delay_s);
    let hand = |user| HAND.iter().map(move |(key, number)| format!(" user.{user}.{key}={number}"));
    let hands: String = [1, 2].into_iter().flat_map(hand).collect();
    apply(scene, &format!("{law} timing.ticks_per_packet={TICKS_PER_PACKET} {delay}{hands}"))
}

/// Two peers under one law.
struct Lane {
    session: Session<1, AXES>,
    numbers: [f32; OF_LANE],
}

impl Lane {
    fn new(scene: &Scene, law: &str) -> Result<Self, Failure> {
        let session = Session::new(lane_scene(scene, law)?, Model::Absent)?;
        Ok(Self { session, numbers: [0.0; OF_LANE] })
    }

    /// A tick of both peers, unless one has faulted: `shown` says where its numbers are in the sample.
    fn step(&mut self, lasted_s: f64, shown: [usize; SHOWN.len()]) -> Result<(), Failure> {
        if self.session.fault().is_some() {
            return Ok(());
        }
        let sample = self.session.step()?;
        let [to_2, to_1] = self.session.packets();
        let packets = [to_1.taken + to_2.taken, to_1.lost + to_2.lost, to_1.lost].map(|of| of as f32);
        let (peer, fault) = self.session.fault().map_or((0, 0), |(peer, fault)| (peer, fault.number()));
        let shown = shown.map(|at| sample[at]);
        let faulted = [f32::from(fault), peer as f32, lasted_s as f32];
        let (apart, [.., worst, worst_at]) = ((shown[2] - shown[3]).abs(), self.numbers);
        let worst = if apart > worst { [apart, lasted_s as f32] } else { [worst, worst_at] };
        let numbers = shown.into_iter().chain(packets).chain(faulted).chain(worst);
        self.numbers.iter_mut().zip(numbers).for_each(|(to, number)| *to = number);
        Ok(())
    }
}

/// Three laws side by side.
pub(super) struct ThreeLaws {
    scene: Scene,
    lanes: [Lane; LANES],
    /// Where [`SHOWN`] is in a sample of two peers.
    shown: [usize; SHOWN.len()],
    tick: u64,
    model: Model,
    /// They stand since a stop.
    still: bool,
    cut: bool,
    restarts: u32,
}

impl ThreeLaws {
    /// All at rest, on the network of this scene.
    pub(super) fn new(scene: &Scene) -> Result<Self, Failure> {
        scene.check_one_axis("three laws in the page")?;
        let place = |name: &&str| pair_columns::columns(1).iter().position(|(known, ..)| known == name);
        let shown = SHOWN.each_ref().map(|name| place(name).unwrap_or(MOST - 1));
        let (scene, lanes) = (scene.clone(), lanes(scene)?);
        Ok(Self { scene, lanes, shown, tick: 0, model: Model::Absent, still: false, cut: false, restarts: 0 })
    }

    fn anew(&mut self) -> Result<(), Failure> {
        self.lanes = lanes(&self.scene)?;
        self.tick = 0;
        self.restarts += 1;
        self.cut(self.cut);
        Ok(())
    }

    fn cut(&mut self, cut: bool) {
        self.cut = cut;
        self.lanes.iter_mut().for_each(|lane| lane.session.cut(cut));
    }

    fn sample(&self) -> Sample {
        // What is the same in every lane is that of one that goes on.
        let live = self.lanes.iter().find(|lane| lane.session.fault().is_none()).map(|lane| &lane.session);
        let [push_1, push_2] = live.map(Session::pushes).unwrap_or_default().map(|newton| newton as f32);
        let wanted = live.map(Session::holds).unwrap_or_default();
        let [wanted_1, wanted_2] = wanted.map(|at| at.map_or(f32::NAN, |[at]| at as f32));
        let all = [push_1, -push_2, wanted_1, wanted_2];
        let mut sample = [f32::NAN; MOST];
        let numbers = all.into_iter().chain(self.lanes.iter().flat_map(|lane| lane.numbers));
        sample.iter_mut().zip(numbers).for_each(|(to, number)| *to = number);
        sample[MOST - 1] = self.restarts as f32;
        sample
    }
}

fn lanes(scene: &Scene) -> Result<[Lane; LANES], Failure> {
    let [power, wave, timed] = LAWS.map(|law| Lane::new(scene, law));
    Ok([power?, wave?, timed?])
}

impl Environment for ThreeLaws {
    fn command(&mut self, command: Command) -> Result<(), Failure> {
        match command {
            Command::Stop => self.still = true,
            Command::Start => {
                self.still = false;
                self.anew()?;
            }
            Command::Cut(cut) => self.cut(cut),
            Command::Partner(model) => self.model = model,
            Command::Board(..) => {}
        }
        Ok(())
    }

    fn set(&mut self, scene: Scene) -> Result<(), Failure> {
        let before = std::mem::replace(&mut self.scene, scene);
        if !same_but_for_network(&before, &self.scene) {
            return self.anew();
        }
        for (lane, law) in self.lanes.iter_mut().zip(LAWS) {
            lane.session.set(lane_scene(&self.scene, law)?)?;
        }
        Ok(())
    }

    fn point(&mut self, hand: usize, at: Option<[f64; 3]>, restarts: u32) {
        let at = at.filter(|_| restarts == self.restarts);
        for Lane { session, .. } in &mut self.lanes {
            session.point(hand, at, session.restarts);
        }
    }

    fn step(&mut self) -> Result<Sample, Failure> {
        if !self.still {
            self.tick += 1;
            let lasted_s = self.tick as f64 * PERIOD_S;
            let shown = self.shown;
            self.lanes.iter_mut().try_for_each(|lane| lane.step(lasted_s, shown))?;
        }
        Ok(self.sample())
    }

    fn standing(&self) -> Standing {
        let modes = if self.still { [OFF; 2] } else { [ARMED; 2] };
        Standing { modes, cut: self.cut, partner: self.model.number() }
    }
}

#[cfg(test)]
#[path = "../tests/inside/three_laws.rs"]
mod tests;
