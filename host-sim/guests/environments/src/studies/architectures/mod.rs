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
//! **Measured**: coherency, the distance between the body as the two users are shown it, at one instant; force and stiffness
//! felt; stability, in the run and by the eigenvalues of one packet period; bytes a second, headers and tags of the sealed
//! datagrams included. Not counted: addresses, sessions being set up, and a world that is downloaded once.

mod account;
pub mod hand;
pub mod picture;
pub mod together;
pub mod turns;

use cohold_core::names::Choice;
use cohold_report::Columns;
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use cohold_studies::Error;

/// Delays from user to user, one way, ms.
pub const DELAYS_MS: [f64; 8] = [0.0, 4.0, 10.0, 20.0, 40.0, 80.0, 120.0, 200.0];

/// The task that two users share.
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
    /// Damping of both arms, N·s/m.
    pub arm_damping_n_s_per_m: [f64; 2],
    /// Mass of each arm, kg.
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

cohold_sim::choices! {
    /// An architecture of a shared haptic environment, in the report's order.
    Architecture {
        "static" => Static, "A copy each.";
        "collaborative-lock" => CollaborativeLock, "One at a time, by a lock at a server.";
        "collaborative-ring" => CollaborativeRing, "One at a time, by a token that goes round.";
        "cooperative-server" => CooperativeServer, "One dynamics engine at a server.";
        "cooperative-server-unbounded" => CooperativeServerUnbounded,
            "The same, with the scene's contact whatever the round trip.";
        "cooperative-client" => CooperativeClient, "The dynamics engine at user 1, with the bounder.";
        "distributed-power" => DistributedPower, "Two copies, coordinated by positions and velocities.";
        "distributed-wave" => DistributedWave, "Two copies, coordinated by waves.";
        "distributed-passive-wave" => DistributedPassiveWave, "Two copies, by waves with the paper's filter.";
        "distributed-passive-mean" => DistributedPassiveMean, "Two copies, by waves of which the mean is sent.";
    }
}

impl Architecture {
    /// For tables and legends.
    pub fn title(self) -> &'static str {
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
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The architecture of this row.
    pub architecture: Architecture,
    /// From user to user, one way, ms.
    pub delay_ms: f64,
    /// Nobody stopped, nothing grew, no eigenvalue lies outside the unit circle, every turn was taken.
    pub stable: bool,
    /// The first of these that failed.
    pub reason: Option<&'static str>,
    /// Largest |eigenvalue| of one packet period, with the gains at the end of the run; where turns are taken, of one hand at
    /// the body.
    pub spectral_radius: f64,
    /// Stiffness of either user's contact at the end, N/m: what a bounder has left of it.
    pub contact_n_per_m: [f64; 2],
    /// Mean distance between the body as the two are shown it, mm. Where turns are taken this is the way of a turn times its
    /// share of the time: it says how long the task is.
    pub true_discrepancy_mm: f64,
    /// Largest distance between the two bodies, mm.
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

/// The scene of the task with these keys: both users reach together, from the left and from the right.
pub(crate) fn scene(keys: &[String]) -> Result<Scene, Error> {
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
    Ok(Scene::load(cohold_sim::Laws::built_in(), None, &all)?)
}

/// One architecture at one delay.
///
/// # Errors
/// A scene that cannot be built or run.
pub fn row(architecture: Architecture, delay_ms: f64) -> Result<Row, Error> {
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
/// A scene that cannot be built or run.
pub fn rows(done: &(impl Fn() + Sync)) -> Result<Vec<Row>, Error> {
    let points: Vec<_> =
        Architecture::ALL.iter().flat_map(|architecture| DELAYS_MS.map(|delay| (*architecture, delay))).collect();
    let of = |(architecture, delay_ms)| row(architecture, delay_ms);
    points.into_par_iter().map(of).inspect(|_| done()).collect()
}

impl Row {
    /// A figure of merit; none of what is not stable.
    fn metric(&self, of: impl Fn(&Self) -> f64) -> Option<f64> {
        self.stable.then(|| of(self))
    }
}

/// All of it, a row for each architecture at each delay.
pub fn columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("architecture", |row| row.architecture.name())
        .means("which architecture")
        .value("delay_ms", |row| row.delay_ms)
        .means("from user to user, one way")
        .value("stable", |row| row.stable)
        .means("whether nobody stopped, nothing grew, no eigenvalue lies outside the unit circle, every turn was taken")
        .value("reason", |row| row.reason)
        .means("the first of these that failed")
        .value("spectral_radius", |row| row.spectral_radius)
        .means("largest |eigenvalue| of one packet period, with the gains at the end; where turns are taken, of one hand at the body")
        .value("contact_n_per_m.0", |row| row.contact_n_per_m[0])
        .means("stiffness of user 1's contact at the end: what a bounder has left of it")
        .value("contact_n_per_m.1", |row| row.contact_n_per_m[1])
        .means("stiffness of user 2's contact at the end")
        .value("true_discrepancy_mm", |row| row.metric(|row| row.true_discrepancy_mm))
        .means("mean distance between the body as the two are shown it")
        .value("peak_discrepancy_mm", |row| row.metric(|row| row.peak_discrepancy_mm))
        .means("the largest of it")
        .value("felt_n", |row| row.metric(|row| row.felt_n))
        .means("mean |contact force| of both users")
        .value("peak_n", |row| row.metric(|row| row.peak_n))
        .means("largest |contact force|")
        .value("rests_mm.0", |row| row.metric(|row| row.rests_mm[0]))
        .means("where the body ends for user 1")
        .value("rests_mm.1", |row| row.metric(|row| row.rests_mm[1]))
        .means("where the body ends for user 2")
        .value("placed_s", |row| row.metric(|row| row.placed_s))
        .means("after what time it stays within 2 mm of that for both")
        .value("user_bytes_per_s", |row| row.user_bytes_per_s)
        .means("what a user sends, mean of both")
        .value("server_bytes_per_s", |row| row.server_bytes_per_s)
        .means("what a server sends; 0 without one")
        .done()
}

/// One text of every row that is asked for: architectures down, delays across.
pub fn across(rows: &[Row], architectures: &[Architecture], cell: impl Fn(&Row) -> String) -> Columns {
    let of = |architecture: Architecture, delay: f64| {
        rows.iter().find(|row| row.architecture == architecture && row.delay_ms == delay).map(&cell)
    };
    let names = Columns::of(architectures).value("", |architecture| architecture.title());
    DELAYS_MS.iter().fold(names, |table, delay| table.value(delay.to_string(), |one| of(*one, *delay))).done()
}
