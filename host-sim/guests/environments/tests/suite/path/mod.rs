//! Somebody on the path without a key, who drops, holds back, reorders and repeats what two peers, or a hub and two peers, say to each
//! other, from their first hello on. At every millisecond of virtual time:
//!
//! 1. what an end says of the other one's clock is true within the error that it states, wherever the clocks began and though each
//!    runs 100 ppm fast or slow;
//! 2. nobody's hand moves before all ends were live, and when the path is clean again the copies are as far apart as after a start
//!    that nobody disturbed, within 1 mm; where an end's coordination was not complete after hands began they may be further apart, and
//!    then a notice at an end says that the other one fell silent or went, or motors are off;
//! 3. an end engages only by what the other one said within the age of flow that is taken, and when the other one's motors go off
//!    it lets go within that age and the time for which its law bears silence.
//!
//! `COHOLD_STRATEGIES` sets how many strategies each large trial plays.

mod end;
mod hub;
mod peers;
mod world;

use cohold_sim::scene::Scene;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::hostile::{asked, scene};
use crate::on_path::{self, Fate, Path};
use end::Clock;
use world::{WAYS, World};

/// What may be wrong, to see that the search finds it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Planted {
    Nothing,
    /// A hand begins when its own end is live.
    OwnEndIsEnough,
    /// The stated error is half of the smallest round trip: it forgets the time since.
    HalfTheRoundTrip,
    /// Flow is taken whatever its age, but for that of all messages.
    AnyAge,
}

/// Who meets whom.
#[derive(Clone, Copy, Debug)]
struct Setup {
    scene: &'static str,
    keys: &'static [&'static str],
    hub: bool,
    /// The line makes good what is lost, and so somebody is on the path also after hands began to move.
    lossless: bool,
    planted: Planted,
}

/// A push of each toward the other, 1 N for half a second, by arms that hold them.
const PEOPLE: [&str; 10] = [
    "user.1.push_n=0",
    "user.2.push_n=0",
    "user.1.pulse_n=1",
    "user.2.pulse_n=1",
    "user.1.pulse_s=0.5",
    "user.2.pulse_s=0.5",
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=5",
    "user.2.arm_stiffness_n_per_m=100",
    "user.2.arm_damping_n_s_per_m=8",
];

/// Phases of the start end here, ms; somebody is on the path until the last.
const START_MS: [u64; 5] = [100, 300, 600, 1000, 1500];
/// Phases of the halt, ms: long before it, soon before, soon after; and then later.
const HALT_MS: [u64; 3] = [200, 150, 150];
const PHASES: usize = START_MS.len() + HALT_MS.len() + 1;
/// How long both hands move until the copies are compared, and over how long, ms.
const SETTLE_MS: u64 = 2_000;
const COMPARED_MS: u64 = 200;
/// From a clean path on they begin within this, ms.
const MEET_MS: u64 = 5_000;
/// What the copies may be apart by, more or less than undisturbed ones, m.
const WITHIN_M: f64 = 1e-3;
/// A clean path takes 4 ms.
const CLEAN: Fate = Fate([Some(5), None]);

/// With which the search begins.
const SEED: u64 = 37;

type Strategy = on_path::Strategy<PHASES, WAYS>;

/// Plays strategies in one setup.
struct Table {
    setup: Setup,
    scene: Scene,
    path: Path<WAYS>,
    rng: Xoshiro256PlusPlus,
    /// How far undisturbed copies are apart, m.
    undisturbed_m: f64,
    /// Strategies under which hands began before the path was clean by itself, and under which an end faded, or was let go of, after that.
    met: usize,
    faded: usize,
    /// What remained then at the most, m.
    faded_m: f64,
    /// When hands began at the latest, ms, and the largest clock error stated, s.
    latest_ms: u64,
    stated_s: f64,
}

impl Table {
    fn new(setup: Setup) -> Self {
        let mut table = Self {
            setup,
            scene: scene(setup.scene, &[&PEOPLE, setup.keys].concat()),
            path: Path::default(),
            rng: Xoshiro256PlusPlus::seed_from_u64(31),
            undisturbed_m: 0.0,
            met: 0,
            faded: 0,
            faded_m: 0.0,
            latest_ms: 0,
            stated_s: 0.0,
        };
        // Nobody disturbs, and nothing is planted.
        table.setup.planted = Planted::Nothing;
        let mut world = table.world();
        table.undisturbed_m = table.start(&mut world, &Strategy::NOTHING).expect("nobody disturbs");
        assert!(!world.faded && table.undisturbed_m.abs() < 1e-5, "{} m apart undisturbed", table.undisturbed_m);
        table.path = world.path;
        table.setup = setup;
        table
    }

    /// Ends with clocks that began anywhere and run up to 100 ppm fast or slow.
    fn world(&mut self) -> World {
        let clocks = [(); 3].map(|()| Clock {
            from_us: 1_000_000 + self.rng.next_u64() % 10_000_000_000,
            fast_ppm: (self.rng.next_u32() % 201) as i64 - 100,
        });
        let mut path = std::mem::take(&mut self.path);
        path.clear();
        World::new(&self.setup, &self.scene, clocks, path)
    }

    /// They meet, begin and settle under a strategy; how far the copies then are apart, m.
    fn start(&self, world: &mut World, strategy: &Strategy) -> Result<f64, String> {
        let [.., acts_ms] = START_MS;
        let (mut sum_m, mut compared) = (0.0, 0);
        while compared < COMPARED_MS {
            let now = world.now_ms;
            let acts = now < acts_ms && (self.setup.lossless || world.moved_ms.is_none());
            let phase = START_MS.iter().position(|end| now < *end).unwrap_or_default();
            world.step(|way, place| if acts { strategy.0[phase][way][place] } else { CLEAN })?;
            let moved_ms = world.nodes.iter().map(|node| node.armed_ticks).min().unwrap_or_default();
            if moved_ms > SETTLE_MS - COMPARED_MS {
                sum_m += world.apart_m();
                compared += 1;
            } else if now > acts_ms + MEET_MS + SETTLE_MS {
                let modes = world.nodes.each_ref().map(|node| (node.peer.mode(), node.is_moving()));
                return Err(format!("the path is clean, and they do not begin: {modes:?} after {moved_ms} ms"));
            }
        }
        Ok(sum_m / COMPARED_MS as f64)
    }

    /// What a strategy comes to: by how much the copies are further apart than undisturbed ones, m; the largest share of a stated
    /// clock error; how long ago the other end last said yes when one engaged, ms; and how long an end stayed engaged after the other one's motors went off, ms.
    fn play(&mut self, strategy: &Strategy) -> Result<[f64; 4], String> {
        let mut world = self.world();
        let played = self.play_in(&mut world, strategy);
        self.path = world.path;
        played
    }

    fn play_in(&mut self, world: &mut World, strategy: &Strategy) -> Result<[f64; 4], String> {
        let apart_m = self.start(world, strategy)?;
        let more_m = (apart_m - self.undisturbed_m).abs();
        self.latest_ms = self.latest_ms.max(world.moved_ms.unwrap_or_default());
        self.met += usize::from(world.moved_ms.is_some_and(|ms| ms < START_MS[4]));
        let harm_m = if world.faded { 0.0 } else { more_m };
        if world.faded {
            self.faded += 1;
            self.faded_m = self.faded_m.max(more_m);
            if more_m > WITHIN_M && !world.tells() {
                return Err(format!("{more_m} m more apart than undisturbed, and nobody is told"));
            }
        } else if more_m > WITHIN_M {
            return Err(format!("{more_m} m more apart than undisturbed"));
        }
        let [.., long_before, before, soon, later] = &strategy.0;
        for (phase, ms) in [(long_before, HALT_MS[0]), (before, HALT_MS[1])] {
            for _ in 0..ms {
                world.step(|way, place| phase[way][place])?;
            }
        }
        world.halt((self.rng.next_u32() % 2) as usize);
        let halted = world.now_ms;
        let is_engaged = |world: &World| {
            let halted = |end: usize| world.ends[end].said.halted_ms.is_some();
            world.ends.iter().any(|end| halted(end.partner) && end.is_engaged())
        };
        while is_engaged(world) || world.now_ms < halted + 500 {
            let phase = if world.now_ms < halted + HALT_MS[2] { soon } else { later };
            world.step(|way, place| phase[way][place])?;
        }
        let most = |of: fn(&end::End) -> f64| world.ends.iter().map(of).fold(0.0, f64::max);
        self.stated_s = self.stated_s.max(most(|end| end.stated_s));
        let [oldest_ms, after_ms] = [most(|end| end.oldest_ms as f64), most(|end| end.engaged_after_ms as f64)];
        Ok([harm_m, most(|end| end.share), oldest_ms, after_ms])
    }
}

/// As many strategies as are asked for, or so many: the largest of what [`Table::play`] gives, or what was broken.
fn search(setup: Setup, strategies: usize) -> Result<[f64; 4], (usize, String)> {
    let mut table = Table::new(setup);
    let most = on_path::search(SEED, strategies, |strategy| table.play(strategy))?;
    let Table { met, faded, faded_m, latest_ms, stated_s, undisturbed_m, .. } = table;
    println!(
        "{}, hub {}: {strategies} strategies, {met} met under them, {faded} with an end that faded ({faded_m} m at the most), hands began at \
         {latest_ms} ms at the latest, clocks' errors were {stated_s} s at the most, copies \
         {undisturbed_m} m apart undisturbed; further apart, m; share of a clock's error; age of a yes, ms; engaged after the halt, ms: {most:?}",
        setup.scene, setup.hub
    );
    assert!(met > strategies / 8 && faded < strategies / 2, "{met} met, {faded} faded, of {strategies}");
    Ok(most)
}

/// The search that is asked for by the environment, or this many; panics where a promise is broken.
fn holds(setup: Setup, strategies: u64) -> [f64; 4] {
    let strategies = asked("COHOLD_STRATEGIES", strategies) as usize;
    search(setup, strategies).unwrap_or_else(|(tried, why)| panic!("strategy {tried}: {why}"))
}

/// What is planted is found, and by a promise whose breach says this.
fn finds(setup: Setup, says: &str) {
    let (tried, why) = search(setup, 3_000).expect_err("what is planted");
    let (breach, _) = why.split_once(": Strategy").unwrap_or((&why, ""));
    println!("{}, {:?}: strategy {tried}: {breach}", setup.scene, setup.planted);
    assert!(breach.contains(says), "{:?}: strategy {tried}: {why}", setup.planted);
}
