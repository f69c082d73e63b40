//! The choice made visible: the same task in every architecture of both papers, over delays from 0 to 200 ms.
//!
//! **Task**: two people carry and place a body of 0.3 kg, [`Task`]. User 1 carries it 100 mm, user 2 helps with a weaker arm
//! and thinks that it belongs at 90 mm. Where only one at a time may move it, user 1 carries it half of the way and user 2
//! the rest; who waits keeps its hand at where it sees the body. Arms are the impedances of `scenes/person-reach.toml`,
//! reaches are minimum-jerk. Every device, contact, law and role is the one that flies or is sent; only the network is
//! modelled, without loss.
//!
//! **Delay** is one way from user to user; a server stands half-way. Packets leave every 8 ms.
//!
//! | architecture | who moves the body | what is sent |
//! |---|---|---|
//! | static | everybody its own copy | where hands are |
//! | collaborative lock, token ring | the owner; released states are copied | role events, where hands are |
//! | cooperative, engine at server or client | one dynamics engine | pushes and states; with the bounder and without |
//! | distributed power, wave, passive wave, passive mean | both, copies held together by a law | flow |
//!
//! **Measured**: coherency, the distance between the body as the two users feel it, at one instant; force felt; stability;
//! bytes a second, headers and tags of the sealed datagrams included. Not counted: addresses, sessions being set up, and a
//! world that is downloaded once.

pub mod picture;
pub mod together;
pub mod turns;

use haptic_core::settings::Refused;
use haptic_protocol::roles::collaborative::OutOfRange;
use haptic_protocol::wire::{Ack, Event, Header, Presence, Sighting, TAG_LEN};
use rayon::prelude::*;
use serde::Serialize;

use crate::analysis::AnalysisError;
use crate::cooperative::world::WorldError;
use crate::experiment::run::Growth;
use crate::scene::{SceneError, SceneFile};

/// Delays from user to user, one way, ms.
pub const DELAYS_MS: [f64; 8] = [0.0, 4.0, 10.0, 20.0, 40.0, 80.0, 120.0, 200.0];

/// What is to be done.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    /// Where each user wants the body, m.
    pub goals_m: [f64; 2],
    /// How long a reach takes, s.
    pub reach_s: f64,
    /// Time of the whole, s.
    pub duration_s: f64,
    /// Stiffness of both arms, N/m.
    pub arm_stiffness_n_per_m: [f64; 2],
    /// Their damping, N·s/m.
    pub arm_damping_n_s_per_m: [f64; 2],
    /// Their mass, kg.
    pub arm_mass_kg: f64,
}

/// The task of the report.
pub const TASK: Task = Task {
    goals_m: [0.1, 0.09],
    reach_s: 1.0,
    duration_s: 6.0,
    arm_stiffness_n_per_m: [150.0, 50.0],
    arm_damping_n_s_per_m: [8.0, 5.0],
    arm_mass_kg: 0.4,
};

/// An architecture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[allow(missing_docs)]
pub enum Architecture {
    Static,
    CollaborativeLock,
    CollaborativeRing,
    CooperativeServer,
    CooperativeServerUnbounded,
    CooperativeClient,
    DistributedPower,
    DistributedWave,
    DistributedPassiveWave,
    DistributedPassiveMean,
}

impl Architecture {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Static,
        Self::CollaborativeLock,
        Self::CollaborativeRing,
        Self::CooperativeServer,
        Self::CooperativeServerUnbounded,
        Self::CooperativeClient,
        Self::DistributedPower,
        Self::DistributedWave,
        Self::DistributedPassiveWave,
        Self::DistributedPassiveMean,
    ];

    /// For tables and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::CollaborativeLock => "collaborative, lock",
            Self::CollaborativeRing => "collaborative, ring",
            Self::CooperativeServer => "cooperative, engine at server",
            Self::CooperativeServerUnbounded => "the same without bounder",
            Self::CooperativeClient => "cooperative, engine at client",
            Self::DistributedPower => "distributed, power",
            Self::DistributedWave => "distributed, wave",
            Self::DistributedPassiveWave => "distributed, passive wave",
            Self::DistributedPassiveMean => "distributed, passive mean",
        }
    }
}

/// One architecture at one delay.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// Which.
    pub architecture: Architecture,
    /// From user to user, one way, ms.
    pub delay_ms: f64,
    /// Nobody stopped, nothing grew, no eigenvalue of two coupled peers lies outside the unit circle, every turn was taken.
    pub stable: bool,
    /// Mean distance between the body as the two feel it, mm.
    pub true_discrepancy_mm: f64,
    /// Largest, mm.
    pub peak_discrepancy_mm: f64,
    /// Mean |contact force| of both, N.
    pub felt_n: f64,
    /// Largest |contact force|, N.
    pub peak_n: f64,
    /// Where the body ends for either user, mm.
    pub rests_mm: [f64; 2],
    /// After what time it stays within 2 mm of that for both, s.
    pub placed_s: f64,
    /// Bytes that a user sends each second, mean of both.
    pub user_bytes_per_s: f64,
    /// Bytes that a server sends each second; 0 without one.
    pub server_bytes_per_s: f64,
}

/// Bytes around a sealed message.
pub(crate) const SEAL: usize = Header::LEN + TAG_LEN;

/// Bytes of a sealed event of this length and of its acknowledgement.
pub(crate) fn event_bytes(event: &Event) -> usize {
    let mut out = [0; Event::MAX_LEN];
    SEAL + event.emit(&mut out).unwrap_or(Event::MAX_LEN) + SEAL + Ack::LEN
}

/// Bytes a second of telling where a hand is, each 50 ms as in the architectures paper.
pub(crate) fn presence_bytes_per_s() -> f64 {
    let mut out = [0; Presence::MAX_LEN];
    let len = Presence::new(0, [Sighting::default()]).emit(&mut out).unwrap_or(Presence::MAX_LEN);
    20.0 * (SEAL + len) as f64
}

/// Keeps account of a run.
pub(crate) struct Account {
    growth: Growth,
    before: [f64; 2],
    views: Vec<[f64; 2]>,
    discrepancy: f64,
    peak_m: f64,
    felt: f64,
    peak_n: f64,
}

impl Account {
    pub(crate) fn new(ticks: u64) -> Self {
        Self {
            growth: Growth::new(ticks),
            before: [0.0; 2],
            views: Vec::with_capacity(ticks as usize),
            discrepancy: 0.0,
            peak_m: 0.0,
            felt: 0.0,
            peak_n: 0.0,
        }
    }

    /// One tick: the body as both users feel it, m, and what they push it with, N.
    pub(crate) fn see(&mut self, views: [f64; 2], forces: [f64; 2]) {
        let change = forces.iter().zip(self.before).map(|(now, before)| (now - before).abs());
        let change = change.fold(0.0, |a: f64, b| if b.is_finite() { a.max(b) } else { f64::INFINITY });
        self.growth.see_change(self.views.len() as u64, change);
        self.before = forces;
        let apart = (views[0] - views[1]).abs();
        self.discrepancy += apart;
        self.peak_m = self.peak_m.max(apart);
        self.felt += 0.5 * (forces[0].abs() + forces[1].abs());
        self.peak_n = forces.iter().fold(self.peak_n, |peak, force| peak.max(force.abs()));
        self.views.push(views);
    }

    /// What it comes to; `bytes` by both users and by the server, in all.
    pub(crate) fn row(self, architecture: Architecture, delay_ms: f64, running: bool, bytes: [f64; 2]) -> Row {
        let count = self.views.len().max(1) as f64;
        let duration_s = TASK.duration_s;
        let rests = self.views.last().copied().unwrap_or_default();
        let moving = |view: &[f64; 2]| view.iter().zip(rests).any(|(at, rest)| (at - rest).abs() > 2e-3);
        let placed = self.views.iter().rposition(moving).map_or(0, |at| at + 1);
        Row {
            architecture,
            delay_ms,
            stable: running && !self.growth.grew(),
            true_discrepancy_mm: 1e3 * self.discrepancy / count,
            peak_discrepancy_mm: 1e3 * self.peak_m,
            felt_n: self.felt / count,
            peak_n: self.peak_n,
            rests_mm: rests.map(|at| 1e3 * at),
            placed_s: placed as f64 / count * duration_s,
            user_bytes_per_s: bytes[0] / duration_s / 2.0,
            server_bytes_per_s: bytes[1] / duration_s,
        }
    }
}

/// What may go wrong.
#[derive(Debug, thiserror::Error)]
pub enum ArchitectureError {
    /// In a scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// In a peer.
    #[error(transparent)]
    Refused(#[from] Refused<'static>),
    /// In a cooperative world.
    #[error(transparent)]
    World(#[from] WorldError),
    /// In the analysis.
    #[error(transparent)]
    Analysis(#[from] AnalysisError),
    /// In a collaborative role.
    #[error(transparent)]
    Lease(#[from] OutOfRange),
}

/// The scene of the task with these keys: both users reach together, from the left and from the right.
///
/// # Errors
/// A key or value that the scene refuses.
pub(crate) fn scene(keys: &[String]) -> Result<SceneFile, SceneError> {
    let user = |index: usize| {
        // Toward the other peer is toward positive x for user 1, and away from it for user 2.
        let sign = if index == 0 { 1.0 } else { -1.0 };
        let number = index + 1;
        [
            format!("user.{number}.reach_m={}", sign * TASK.goals_m[index]),
            format!("user.{number}.reach_s={}", TASK.reach_s),
            format!("user.{number}.arm_stiffness_n_per_m={}", TASK.arm_stiffness_n_per_m[index]),
            format!("user.{number}.arm_damping_n_s_per_m={}", TASK.arm_damping_n_s_per_m[index]),
            format!("user.{number}.arm_mass_kg={}", TASK.arm_mass_kg),
        ]
    };
    let base = ["object.integrator=semi-implicit", "object.force_delay_ticks=0", "network.one_way_delay_packets=0"];
    let base = base.map(str::to_owned);
    let all: Vec<String> = base.into_iter().chain(user(0)).chain(user(1)).chain(keys.iter().cloned()).collect();
    SceneFile::load(None, &all)
}

/// One architecture at one delay.
///
/// # Errors
/// A mistake in the task itself, or a delay that the network refuses.
pub fn row(architecture: Architecture, delay_ms: f64) -> Result<Row, ArchitectureError> {
    match architecture {
        Architecture::CollaborativeLock | Architecture::CollaborativeRing => turns::row(architecture, delay_ms),
        Architecture::CooperativeServer
        | Architecture::CooperativeServerUnbounded
        | Architecture::CooperativeClient => together::cooperative(architecture, delay_ms),
        _ => together::distributed(architecture, delay_ms),
    }
}

/// Every architecture at every delay, in parallel; the same on any number of threads.
///
/// # Errors
/// As [`row`].
pub fn rows(done: &(impl Fn() + Sync)) -> Result<Vec<Row>, ArchitectureError> {
    let points: Vec<_> =
        Architecture::ALL.iter().flat_map(|architecture| DELAYS_MS.map(|delay| (*architecture, delay))).collect();
    points
        .into_par_iter()
        .map(|(architecture, delay_ms)| {
            let row = row(architecture, delay_ms);
            done();
            row
        })
        .collect()
}
