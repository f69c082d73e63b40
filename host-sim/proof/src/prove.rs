//! What is claimed of a tick, in which scenes and from which states, and whether it holds.
//!
//! **Claims**, of `hear`, `exchange` and `tick` after whatever came before: every force is a number within ±`safety.max_force_n` and by no more
//! than `safety.max_slew_n_per_s`·T_c (and the rounding of that sum) farther from zero than the one before was on that side, or the motors are
//! off and every force is 0; every duty is within `motor.max_duty`; what is sent is finite. Since a tick begins where these hold, and ends where they hold,
//! they hold for ever.
//!
//! **For every number**: readings are any bits; counts any there are; packets any finite numbers. Of the state, last forces are
//! anything within the limit, what limits the next ones too, the copy's motion anything finite (both are checked before they are stored), and every other number that
//! has changed since the peer was built is any bits at all, also of what nobody can visit: sums, accounts, filters, warmth.
//!
//! **Not for every whole number**: modes, counters and phases are those of runs to begin with ([`STATES`] of them for each scene), which
//! take the turns that chance takes. [`crate::whatever::Whatever`] is without that: no law's state is in it. **Scenes** are the defaults with a
//! law's own gains, as they are and moved by ports, and each of these with any one key that is a choice set otherwise, or with two of
//! which one asks for the other. Limits of settings are not intervals: each scene has its own.

use cohold_core::device::encoder::Counts;
use cohold_core::device::kinematics::{AnyKinematics, Kinematics};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::{AnyLaw, Law, LawInfo, Packet};
use cohold_core::num::{Motion, Scalar as _, StateVector};
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::schema::Schema;
use cohold_core::settings::{Allowed, Settings, Value};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use crate::graph::{self, MOST_PATHS, Place};
use crate::range::{Float, Range};
use crate::unknown::{Number, Unknown};
use crate::whatever::{Whatever, motion};

/// States of whole numbers that each scene is looked at in, half of them with encoders; of two axes, the first two.
pub const STATES: u64 = 4;
/// Ticks that lead to the first of them; the others are one packet period and a tick longer each.
const TICKS: u64 = 20;
/// Ticks more for one that leaves it armed.
const MORE: u64 = 50;
/// Tries of a tick that leaves the peer armed.
const TRIES: usize = 100;
/// Live ticks of packets, which wrap.
const LIVE: [u32; 3] = [1, 1 << 31, u32::MAX];

/// The tick that something is claimed of: [`Peer::tick`], unless a test puts another in its place.
pub type Tick<L, const SHARED: usize = 1, const N: usize = AXES, K = AnyKinematics<Number>> =
    fn(&mut Peer<Number, L, SHARED, N, K>, &Sensors<Number, N>) -> Actuators<Number, N>;

/// What does not hold.
#[derive(Clone, Debug, PartialEq)]
pub enum Broken {
    /// A force beyond its limit, or none that is a number.
    Force(Range),
    /// A growth of force beyond its limit: by how much it changed.
    Slew(Range),
    /// A force while the motors are off.
    Off,
    /// A duty beyond its limit.
    Duty(Range),
    /// A packet that is not finite.
    Sent,
    /// A number was taken out of its type: nothing is known of what came of it.
    Escaped,
    /// More ways to go than were tried.
    Paths,
    /// No tick left it armed: nothing was looked at.
    NeverArmed,
}

impl std::fmt::Display for Broken {
    fn fmt(&self, text: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let range =
            |Range { lo, hi, nan }: &Range| format!("{lo} to {hi} N{}", if *nan { " or no number" } else { "" });
        match self {
            Self::Force(force) => write!(text, "a force of {}", range(force)),
            Self::Slew(change) => write!(text, "a change of force by {} in a tick", range(change)),
            Self::Off => write!(text, "a force while the motors are off"),
            Self::Duty(codes) => write!(text, "a duty of {} to {} codes", codes.lo, codes.hi),
            Self::Sent => write!(text, "a packet that is not finite"),
            Self::Escaped => write!(text, "not shown: it takes numbers out of their type"),
            Self::Paths => write!(text, "not shown: more than {MOST_PATHS} paths"),
            Self::NeverArmed => write!(text, "not shown: it was never armed"),
        }
    }
}

/// What came of a proof.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Proved {
    /// Scenes that could be built.
    pub scenes: usize,
    /// States of whole numbers.
    pub states: usize,
    /// Ways through a tick, from all of them.
    pub paths: usize,
    /// Largest force on any, N.
    pub widest_n: f64,
    /// Largest growth of a force away from zero, N.
    pub widest_step_n: f64,
    /// The first scene in which something does not hold, as it differs from the defaults, and what.
    pub broken: Option<(String, Broken)>,
}

impl Proved {
    fn and(self, other: Self) -> Self {
        Self {
            scenes: self.scenes + other.scenes,
            states: self.states + other.states,
            paths: self.paths + other.paths,
            widest_n: self.widest_n.max(other.widest_n),
            widest_step_n: self.widest_step_n.max(other.widest_step_n),
            broken: self.broken.or(other.broken),
        }
    }
}

/// Proves the claims for one of core's laws, or for [`Whatever`], by its name. This function is not generic, so the proofs are compiled here
/// once, optimised, and not in each program that asks for one.
pub fn prove_named(name: &str) -> Option<(&'static str, Proved)> {
    let named = |laws: &'static [LawInfo]| laws.iter().find(|law| law.name == name);
    let built_in = |law: &'static LawInfo| (law.name, prove::<AnyLaw<Number>>(law, Peer::tick));
    let any = |law: &'static LawInfo| (law.name, prove::<Whatever>(law, Peer::tick));
    named(AnyLaw::<Number>::LAWS).map(built_in).or_else(|| named(Whatever::LAWS).map(any))
}

/// Proves the claims for one kind of law, one of those that `L` is, with one shared axis of a device in the plane.
pub fn prove<L: Law<Number>>(law: &'static LawInfo, tick: Tick<L>) -> Proved {
    prove_in(&scenes::<L, 1, AXES, AnyKinematics<Number>>(law, &[], true), tick)
}

/// [`prove`] in these scenes of it ([`scenes`]), with any axes.
pub fn prove_in<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    scenes: &[(String, Settings)],
    tick: Tick<L, SHARED, N, K>,
) -> Proved {
    let each = scenes.par_iter().map(|(name, settings)| scene(name, settings, tick));
    each.collect::<Vec<_>>().into_iter().fold(Proved::default(), Proved::and)
}

/// A key, and what it is set to.
pub type Change = (&'static str, Value<'static>);

/// The scenes of a law with these changes, by what they differ in; with choices only if they are asked for.
pub fn scenes<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    law: &'static LawInfo,
    changes: &[Change],
    choose: bool,
) -> Vec<(String, Settings)> {
    let schema = Schema::new(L::LAWS);
    let gains = law.gains.iter().filter_map(|gain| gain.split_once('='));
    let mut gained = Settings::default();
    gained.coordination.comm = law.name;
    for (key, value) in gains {
        // Those of networks and the like are no peer's.
        let _ = schema.set(&mut gained, key, Value::of_text(value));
    }
    let with = |settings: &Settings, changes: &[Change]| {
        let mut settings = *settings;
        changes.iter().all(|(key, value)| schema.set(&mut settings, key, *value).is_ok()).then_some(settings)
    };
    graph::begin();
    let builds = |settings: &Settings| Peer::<Number, L, SHARED, N, K>::build(settings, [Motion::REST; N]).is_ok();
    let ports: [Change; 3] = [
        ("object.integrator", Value::Text("midpoint")),
        ("coordination.decode", Value::Text("implicit")),
        ("object.force_delay_ticks", Value::Number(0.0)),
    ];
    let bases = [("", with(&gained, changes)), ("moved by ports", with(&gained, &[&ports, changes].concat()))];
    let choices: Vec<Change> = schema.keys().flat_map(|key| choices(key.name, key.allowed)).collect();
    let mut scenes: Vec<(String, Settings)> = Vec::new();
    for (name, base) in bases {
        let Some(base) = base.filter(builds) else { continue };
        let mut add = |settings: Settings, changed: &[Change]| {
            let changed = changed.iter().map(|(key, value)| format!("{key} = {value}"));
            let changed: Vec<String> =
                [name.to_owned()].into_iter().filter(|name| !name.is_empty()).chain(changed).collect();
            if scenes.iter().all(|(_, other)| *other != settings) {
                scenes.push((changed.join(", "), settings));
            }
        };
        add(base, &[]);
        for choice in choices.iter().filter(|_| choose) {
            let Some(one) = with(&base, &[*choice]) else { continue };
            if builds(&one) {
                add(one, &[*choice]);
                continue;
            }
            // It may ask for another.
            let pair = choices.iter().find_map(|other| {
                let two = with(&one, &[*other]).filter(builds)?;
                Some((two, [*choice, *other]))
            });
            if let Some((two, changed)) = pair {
                add(two, &changed);
            }
        }
    }
    scenes
}

/// Every value of a key that is a choice.
fn choices(key: &'static str, allowed: Allowed) -> Vec<Change> {
    let values: Vec<Value<'static>> = match allowed {
        Allowed::Flag => [false, true].map(Value::Flag).to_vec(),
        Allowed::Names(names) => names.iter().map(|name| Value::Text(name)).collect(),
        Allowed::Whole { min, max } if max - min < 3 => {
            (min..=max).map(|value| Value::Number(f64::from(value))).collect()
        }
        _ => Vec::new(),
    };
    values.into_iter().map(|value| (key, value)).collect()
}

/// What comes to a peer before and in a tick.
#[derive(Clone, Copy, Debug)]
struct Outside {
    /// Live ticks of a packet that is heard.
    heard: Option<u32>,
    /// Readings are counts.
    counts: bool,
}

/// One tick with what is due before it: the forces, and what was sent.
fn step<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    peer: &mut Peer<Number, L, SHARED, N, K>,
    tick: Tick<L, SHARED, N, K>,
    outside: Outside,
) -> (Actuators<Number, N>, Option<[Packet<Number>; SHARED]>) {
    if let Some(live_ticks) = outside.heard {
        let finite = || Motion::new(Number::any_finite(), Number::any_finite());
        peer.hear(&[(); SHARED].map(|()| Packet {
            motion: finite(),
            wave: Number::any_finite(),
            energy_j: Unknown::any_finite(),
            wave_integral: Unknown::any_finite(),
            live_ticks,
        }));
    }
    let sent = if peer.packet_due() { peer.exchange() } else { None };
    let reading = if outside.counts {
        Reading::Counts([Counts::default(); N])
    } else {
        Reading::Exact([(); N].map(|()| motion()))
    };
    (tick(peer, &Sensors::of(reading)), sent)
}

fn scene<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    name: &str,
    settings: &Settings,
    tick: Tick<L, SHARED, N, K>,
) -> Proved {
    let mut proved = Proved { scenes: 1, ..Proved::default() };
    // An axis that is held multiplies the paths, and neither packets nor their phases reach it.
    let (states, live) = if settings.axis.count > 1 { (2, &LIVE[..1]) } else { (STATES, &LIVE[..]) };
    for state in 0..states {
        let counts = state % 2 == 1;
        let broken = match armed(settings, tick, state, counts) {
            Some((peer, last)) => {
                proved.states += 1;
                let heard = live.iter().copied().map(Some).chain([None]);
                heard.fold(None, |broken, heard| {
                    let outside = Outside { heard, counts };
                    broken.or_else(|| one_tick(settings, &peer, last, tick, outside, &mut proved))
                })
            }
            None => Some(Broken::NeverArmed),
        };
        proved.broken = proved.broken.or_else(|| Some((name.to_owned(), broken?)));
    }
    proved
}

/// An armed peer of which nothing is known but its whole numbers, and the forces that it commanded last.
fn armed<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    settings: &Settings,
    tick: Tick<L, SHARED, N, K>,
    state: u64,
    counts: bool,
) -> Option<(Peer<Number, L, SHARED, N, K>, [Number; N])> {
    graph::begin();
    graph::any_whole(false);
    let home = [(); N].map(|()| Motion::at(Number::any_finite()));
    let mut peer = Peer::<Number, L, SHARED, N, K>::build(settings, home).ok()?;
    graph::any_whole(true);
    let mut chance = Xoshiro256PlusPlus::seed_from_u64(state);
    let ticks = TICKS + state * u64::from(settings.timing.ticks_per_packet + 1);
    let mut last = None;
    for tick_at in 0..ticks + MORE {
        if tick_at >= ticks && last.is_some() {
            break;
        }
        let draw = chance.next_u64();
        if peer.mode() != Mode::Armed {
            peer.command(Command::Clear);
            peer.command(Command::Arm);
        }
        let heard = (draw % 4 == 0).then(|| LIVE[(draw >> 8) as usize % LIVE.len()]);
        let run = || {
            let mut next = peer;
            let (actuators, _) = step(&mut next, tick, Outside { heard, counts });
            (next, actuators)
        };
        last = graph::one_way(draw, TRIES, run, |(next, _)| next.mode() == Mode::Armed);
        match last {
            Some((next, _)) => peer = next,
            None => peer.trip(cohold_core::safety::Fault::Diverged),
        }
    }
    let (mut peer, Actuators { forces, .. }) = last?;
    let most = f64::from(settings.safety.max_force_n as f32);
    let mut known: Vec<(Place, Range)> = forces.iter().map(|force| (force.place(), Range::of(-most, most))).collect();
    // What a force may be falls with its mean and never rises above the scene's limit, which is claimed of each tick.
    let (limits, step) = (peer.limits(), peer.limits().step.range().hi);
    known.extend([(limits.most.place(), Range::of(0.0, most)), (limits.free.place(), Range::of(0.0, most.min(step)))]);
    let mut visited = 0;
    peer.visit(&mut |number: &mut Number| {
        if SHARED == 1 && visited < 2 {
            known.push((number.place(), Range::finite::<f32>()));
        } else if number.range().is_point() {
            *number = Number::any();
        }
        visited += 1;
    });
    graph::forget(&known);
    Some((peer, forces))
}

/// Every way through one tick.
fn one_tick<L: Law<Number>, const SHARED: usize, const N: usize, K: Kinematics<Number, N>>(
    settings: &Settings,
    before: &Peer<Number, L, SHARED, N, K>,
    last: [Number; N],
    tick: Tick<L, SHARED, N, K>,
    outside: Outside,
    proved: &mut Proved,
) -> Option<Broken> {
    let safety = &settings.safety;
    let most = f64::from(safety.max_force_n as f32);
    let step_n = f64::from((safety.max_slew_n_per_s * settings.timing.control_period_s) as f32);
    // Of the sum that the guard takes, and of the difference that is taken of it here.
    let rounding = 4.0 * <f32 as Float>::EPSILON * most;
    let code = (settings.motor.max_duty * 32767.0).floor();
    let mut broken = None;
    let whole = graph::explore(
        || {
            let mut peer = *before;
            let (actuators, sent) = step(&mut peer, tick, outside);
            (peer.mode(), actuators, sent, peer.limits())
        },
        |path| {
            proved.paths += 1;
            let (mode, actuators, sent, limits) = path.gave;
            let mut claim = |holds: bool, what: Broken| {
                if !holds && broken.is_none() {
                    broken = Some(what);
                }
            };
            claim(!path.escaped, Broken::Escaped);
            for (limit, most) in [(limits.most.range(), most), (limits.free.range(), most.min(step_n))] {
                claim(!limit.nan && (0.0..=most).contains(&limit.lo) && limit.hi <= most, Broken::Force(limit));
            }
            for (force, last) in actuators.forces.into_iter().zip(last) {
                let range = force.range();
                if mode == Mode::Armed {
                    claim(!range.nan && range.most() <= most, Broken::Force(range));
                    let change = (force - last).range();
                    // What changes little grows little; of the rest each side of zero has its own.
                    let [up, down] =
                        [last.max(Number::ZERO), last.min(Number::ZERO)].map(|from| (force - from).range());
                    let grew_n = change.most().min(up.hi.max(-down.lo));
                    let known = !(change.nan || up.nan || down.nan);
                    claim(known && grew_n <= step_n + rounding, Broken::Slew(change));
                    proved.widest_n = proved.widest_n.max(range.most());
                    proved.widest_step_n = proved.widest_step_n.max(grew_n);
                } else {
                    claim(range == Range::point(0.0) && !actuators.enable, Broken::Off);
                }
            }
            claim(!path.codes.nan && path.codes.most() <= code, Broken::Duty(path.codes));
            // Of several shared axes the copies' motions are not distinguished from the rest of the state: they may be any bits there.
            let finite = sent.into_iter().flatten().filter(|_| SHARED == 1).all(|packet| {
                let numbers = [packet.motion.position, packet.motion.velocity, packet.wave].map(Number::range);
                let counters = [packet.energy_j, packet.wave_integral].map(Unknown::range);
                numbers.iter().chain(&counters).all(|range| range.is_finite())
            });
            claim(finite, Broken::Sent);
        },
    );
    broken.or_else(|| (!whole).then_some(Broken::Paths))
}
