//! What is counted and replayed on every processor: every numerical choice as a [`Case`], a number of calls that can be
//! replayed, and ticks of whole peers.
//!
//! Leans on `cohold_core`, `libm` and `alloc` alone, so that the same lines are counted on a PC (callgrind) and on the
//! microcontroller's processor (`tests/count`, QEMU). How instructions are counted there is the [`Meter`]'s business.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod contact;
pub mod filters;
pub mod line;
pub mod reach;
pub mod replay;
pub mod scenes;
pub mod ticks;
pub mod workspace;

use alloc::boxed::Box;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::hint::black_box;

use cohold_core::device::kinematics::{AnyKinematics, KinematicsName, Maths};
use cohold_core::device::velocity::{AnyVelocity, VelocityName};
use cohold_core::law::wave::{Decode, PassiveWave};
use cohold_core::law::{AnyLaw, Law, LawInfo, Observation};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::{AnyIntegrator, IntegratorName, Staged};
use cohold_core::settings::{Choice, Settings};

use filters::{Bilinear, Exact, Filter, ForwardEuler};
use ticks::{Recording, TICKS, step};

/// Why a model of this package's own settings can be built.
const GOOD: &str = "settings that are counted are good";

/// Counts the instructions of a call.
pub trait Meter {
    /// Calls `body`, counted: loading parameters, storing state and the call itself included.
    fn call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O;
}

/// Something whose instructions are counted.
pub struct Case {
    /// Name of the case, as the tables spell it.
    pub name: String,
    /// Counted calls of one replay.
    pub calls: usize,
    /// Prepares, then makes all the calls.
    pub replay: Box<dyn Fn()>,
}

/// A case that calls a body, made anew by `prepare`, once for every input.
fn case<M: Meter, I: Copy + 'static, O, B: FnMut(I) -> O>(
    name: String,
    inputs: Vec<I>,
    prepare: impl Fn() -> B + 'static,
) -> Case {
    let calls = inputs.len();
    let replay = move || {
        let mut body = prepare();
        for input in &inputs {
            black_box(M::call(&mut body, *input));
        }
    };
    Case { name, calls, replay: Box::new(replay) }
}

/// Every case in one number type, with each of the laws of `L`, in the order of the tables; each is made when its turn comes.
pub fn all<S: Scalar, L: Law<S>, M: Meter>() -> impl Iterator<Item = Case> {
    let ticks = scenes::SCENES.iter().map(|scene| tick::<S, AnyLaw<S>, M>(scene));
    let named = core::iter::once_with(|| tick::<S, PassiveWave<S>, M>(&scenes::NAMED));
    let filters = [filter::<S, Exact<S>, M>, filter::<S, ForwardEuler<S>, M>, filter::<S, Bilinear<S>, M>];
    let velocities = reach::RESOLUTIONS
        .iter()
        .flat_map(|&counts_per_m| VelocityName::ALL.iter().map(move |&name| estimator::<S, M>(name, counts_per_m)));
    let laws = L::LAWS.iter().map(|info| law::<S, L, M>(info));
    ticks
        .chain(named)
        .chain(laws)
        .chain(IntegratorName::ALL.iter().map(|&name| integrator::<S, M>(name)))
        .chain(Decode::ALL.iter().map(|&name| decode::<S, M>(name)))
        .chain(filters.into_iter().map(|case| case()))
        .chain(workspace::CHOICES.iter().map(|&(model, maths)| mechanism::<S, M>(model, maths)))
        .chain(velocities)
}

/// The ticks of a scene.
fn tick<S: Scalar, L: Law<S>, M: Meter>(scene: &scenes::Scene) -> Case {
    ticks_of::<S, L, M>(format!("tick/{}", scene.name), scene.settings())
}

/// The ticks of a law at the gains that it declares: every law of the list, in the scene in which they are compared.
fn law<S: Scalar, L: Law<S>, M: Meter>(law: &LawInfo) -> Case {
    ticks_of::<S, L, M>(format!("law/{}", law.name), scenes::of_law(law, L::LAWS))
}

fn ticks_of<S: Scalar, L: Law<S>, M: Meter>(name: String, settings: Settings) -> Case {
    let replay = move || {
        let recording = Recording::<S, L>::new(&settings);
        recording.replay(|peer, input| M::call(&mut |input| step(peer, input), input));
    };
    Case { name, calls: TICKS, replay: Box::new(replay) }
}

fn integrator<S: Scalar, M: Meter>(name: IntegratorName) -> Case {
    let settings = contact::settings(contact::Test::Contact, name, 1e-3);
    let stiffness = S::from_f64(-settings.contact.stiffness_n_per_m);
    let motions = contact::run::<S>(contact::Test::Contact, &settings);
    let inputs = motions.into_iter().map(|motion| (motion, stiffness * motion.position)).collect();
    case::<M, _, _, _>(format!("integrator/{}", name.name()), inputs, move || {
        let mut integrator = black_box(AnyIntegrator::<S>::build(&settings).expect(GOOD));
        move |(motion, force)| integrator.step(motion, force)
    })
}

fn decode<S: Scalar, M: Meter>(decode: Decode) -> Case {
    let settings = line::settings(decode, Settings::default().coordination.stiffness_n_per_m);
    let inputs = (0..line::ticks(&settings)).map(|tick| line::input::<S>(&settings, tick).0).collect();
    case::<M, _, _, _>(format!("decode/{}", decode.name()), inputs, move || {
        let law = black_box(AnyLaw::<S>::build(&settings).expect(GOOD));
        let mut state = black_box(law.start(Motion::REST));
        move |local| law.couple(&mut state, &Observation { local, ..Observation::default() }, Staged(local.velocity))
    })
}

fn filter<S: Scalar, F: Filter<S>, M: Meter>() -> Case {
    let inputs = (0..1000).map(|tick| S::from_f64(0.01 * f64::from(tick % 100))).collect();
    case::<M, _, _, _>(format!("filter/{}", F::NAME), inputs, || {
        let mut filter = black_box(F::build(&Settings::default()));
        move |wave| filter.push(wave)
    })
}

fn mechanism<S: Scalar, M: Meter>(model: KinematicsName, maths: Maths) -> Case {
    let settings = workspace::settings(model, maths);
    let joint = |at: f64| Motion::new(S::from_f64(at), S::from_f64(at));
    let inputs = workspace::joints(model).into_iter().map(|joints| joints.map(joint)).collect();
    case::<M, _, _, _>(workspace::case(model, maths), inputs, move || {
        let kinematics = black_box(AnyKinematics::<S>::build(&settings).expect(GOOD));
        move |joints| kinematics.forward(joints)
    })
}

fn estimator<S: Scalar, M: Meter>(name: VelocityName, counts_per_m: f64) -> Case {
    let settings = reach::settings(name, counts_per_m);
    let inputs = reach::readings::<S>(&settings).into_iter().map(|(reading, _)| reading).collect();
    case::<M, _, _, _>(reach::case(name, counts_per_m), inputs, move || {
        let mut estimator = black_box(AnyVelocity::<S>::build(&settings).expect(GOOD));
        move |reading| estimator.step(reading)
    })
}
