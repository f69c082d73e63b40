//! [`DynPeer`], one trait for peers of every law and mechanism, which everything that runs scenes on a PC holds; and
//! the list of laws.
//!
//! Behind [`DynPeer`] is the peer that runs on the board; one virtual call a tick is little beside what a tick
//! computes. [`Laws`] lists the laws that a scene may name: a program with a law of its own adds it once, as a
//! [`Family`], and every scene that is loaded with these laws takes its name, its keys, and builds its peers. How many
//! axes share the object is a type; [`of_axes!`](crate::of_axes) goes from a scene's number to it.

use std::fmt::Debug;

use cohold_core::device::kinematics::{AnyKinematics, AnySpatial, Kinematics};
use cohold_core::device::probe::{Outcome, Probe};
use cohold_core::law::bounds::Bounds;
use cohold_core::law::{AnyLaw, Law, Packet};
use cohold_core::num::{Configured, Fixed, Motion, Scalar, StateVector};
use cohold_core::peer::{Actuators, Arrived, Observed, Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::{LawInfo, Refused, Settings};
use cohold_core::{contact::Impacts, device::AXES, law::ledger::Ledger, schema::Schema};

use crate::double_double::DoubleDouble;
use crate::lanes::number::F64s;

/// A hash (FNV-1a over 64-bit words) continued by one word.
#[inline]
pub(crate) fn mixed(hash: u64, word: u64) -> u64 {
    let hash = (hash ^ word).wrapping_mul(0x100_0000_01b3);
    // The fold brings the high bits down, where the next product spreads them again.
    hash ^ hash >> 32
}

/// Declares [`DynPeer`] once: methods that [`Peer`] has under the same names, and those that are the trait's own.
macro_rules! dyn_peer {
    ($( $(#[$doc:meta])* fn $name:ident($self:ident: $receiver:ty $(, $argument:ident: $type:ty)*) $(-> $out:ty)?; )+) => {
        /// One haptic peer, configuration and state, that shares the object along `SHARED` axes of a device of `N`, whatever its law and
        /// mechanism: the methods of `cohold_core::peer`.
        pub trait DynPeer<S: Scalar, const SHARED: usize = 1, const N: usize = AXES>: Configured + Debug + Send + Sync {
            $( $(#[$doc])* fn $name($self: $receiver $(, $argument: $type)*) $(-> $out)?; )+
            /// A control period whole, for who brings devices and network himself: takes in what has come of the other peer since the
            /// period before; gives what the actuators do, and what to send, if anything. A clone is a saved state.
            fn step(
                &mut self,
                heard: Option<&[Packet<S>; SHARED]>,
                sensors: &Sensors<S, N>,
            ) -> (Actuators<S, N>, Option<[Packet<S>; SHARED]>) {
                if let Some(packets) = heard {
                    self.hear(packets);
                }
                let sent = if self.packet_due() { self.exchange() } else { None };
                (self.tick(sensors), sent)
            }
            /// Calls `each` for every number of the dynamic state, always in the same order.
            fn visit_state(&mut self, each: &mut dyn FnMut(&mut S));
            /// A hash (FNV-1a over 64-bit words) of the bits of the dynamic state, continued from `seed`.
            fn hash(&self, seed: u64) -> u64;
            /// [`DynPeer::hash`] without a copy of the peer.
            fn hash_in_place(&mut self, seed: u64) -> u64;
            /// A copy of the peer with its whole state.
            fn boxed(&self) -> Box<dyn DynPeer<S, SHARED, N>>;
        }

        impl<S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K> DynPeer<S, SHARED, N> for Peer<S, L, SHARED, N, K>
        where
            K: Kinematics<S, N>,
        {
            $( fn $name($self: $receiver $(, $argument: $type)*) $(-> $out)? { Peer::$name($self $(, $argument)*) } )+
            fn visit_state(&mut self, each: &mut dyn FnMut(&mut S)) {
                self.visit(&mut |number| each(number));
            }
            fn hash(&self, seed: u64) -> u64 {
                { *self }.hash_in_place(seed)
            }
            fn hash_in_place(&mut self, seed: u64) -> u64 {
                let mut hash = seed;
                self.visit(&mut |number: &mut S| hash = mixed(hash, number.bits()));
                hash
            }
            fn boxed(&self) -> Box<dyn DynPeer<S, SHARED, N>> {
                Box::new(*self)
            }
        }
    };
}

dyn_peer! {
    /// One control period: sensors in, forces out.
    fn tick(self: &mut Self, sensors: &Sensors<S, N>) -> Actuators<S, N>;
    /// Takes in a packet of the other peer for each shared axis: they act at the next tick.
    fn hear(self: &mut Self, packets: &[Packet<S>; SHARED]);
    /// One packet period: gives what to send, if anything.
    fn exchange(self: &mut Self) -> Option<[Packet<S>; SHARED]>;
    /// The first half of an exchange: gives what to send, if anything.
    fn speak(self: &mut Self) -> Option<[Packet<S>; SHARED]>;
    /// The second half of an exchange: counts silence.
    fn listen(self: &mut Self);
    /// Whether the law only holds packets.
    fn only_holds(self: &Self) -> bool;
    /// These packets as the law would receive them if only this share of them counted.
    fn faded(self: &Self, share: S, packets: &[Packet<S>; SHARED]) -> [Packet<S>; SHARED];
    /// The packets that the peer would send now.
    fn outgoing(self: &Self) -> [Packet<S>; SHARED];
    /// Whether an exchange is due before the next tick.
    fn packet_due(self: &Self) -> bool;
    /// Carries out an operator's command.
    fn command(self: &mut Self, command: Command);
    /// Takes what has come since the last tick.
    fn arrive(self: &mut Self, arrived: Arrived<'_, S, SHARED>);
    /// Reports that packets of the other peer come but are too old to be used.
    fn delayed(self: &mut Self);
    /// Disengages from the other peer until a packet comes.
    fn part(self: &mut Self);
    /// Begins a probe, if disarmed.
    fn probe(self: &mut Self, probe: Probe<S>);
    /// Outcome of the last probe.
    fn probed(self: &Self) -> Outcome;
    /// The mode, with the fault that latched.
    fn mode(self: &Self) -> Mode;
    /// Whether the coordination acts.
    fn is_engaged(self: &Self) -> bool;
    /// Whether the coordination acts in full on what the other peer says.
    fn is_whole(self: &Self) -> bool;
    /// Motions and forces of the last tick along each shared axis.
    fn observed(self: &Self) -> [&Observed<S>; SHARED];
    /// Energy that crossed the network port of each shared axis since arming.
    fn ledger(self: &Self) -> [&Ledger<S>; SHARED];
    /// Impacts along each shared axis since arming, where contact is impulsive.
    fn impacts(self: &Self) -> [Impacts<S>; SHARED];
}

impl<S: Scalar, const SHARED: usize, const N: usize> Clone for Box<dyn DynPeer<S, SHARED, N>> {
    fn clone(&self) -> Self {
        (**self).boxed()
    }
}

impl<S: Scalar, const SHARED: usize, const N: usize> StateVector<S> for dyn DynPeer<S, SHARED, N> + '_ {
    fn visit(&mut self, each: &mut impl FnMut(&mut S)) {
        self.visit_state(each);
    }
}

/// One law, or list of laws, in every number type: what a crate outside hands to [`Laws::with`].
pub trait Family: 'static {
    /// The law that computes in `S`.
    type Of<S: Scalar>: Law<S>;
}

struct BuiltIn;

impl Family for BuiltIn {
    type Of<S: Scalar> = AnyLaw<S>;
}

/// Builds a peer with the laws of one family, from settings and where its device is.
type Make<S, const SHARED: usize, const N: usize> =
    fn(&Settings, [Motion<S>; N]) -> Result<Box<dyn DynPeer<S, SHARED, N>>, Refused<'static>>;

fn make<S: Scalar, L: Law<S>, const SHARED: usize, const N: usize, K: Kinematics<S, N>>(
    settings: &Settings,
    device: [Motion<S>; N],
) -> Result<Box<dyn DynPeer<S, SHARED, N>>, Refused<'static>> {
    Ok(Box::new(Peer::<S, L, SHARED, N, K>::build(settings, device)?))
}

/// How a family makes peers that compute in one number type, by the axes along which they share the object.
#[derive(Clone, Copy, Debug)]
struct Makes<S: Scalar> {
    one: Make<S, 1, AXES>,
    two: Make<S, 2, 2>,
    three: Make<S, 3, 3>,
}

impl<S: Scalar> Makes<S> {
    const fn of<L: Law<S>>() -> Self {
        Self {
            one: make::<S, L, 1, AXES, AnyKinematics<S>>,
            two: make::<S, L, 2, 2, AnyKinematics<S>>,
            three: make::<S, L, 3, 3, AnySpatial<S>>,
        }
    }
}

/// Constructors of the peers of one family of laws, one for each number type that a command computes in.
#[derive(Clone, Copy, Debug)]
pub struct Maker {
    laws: &'static [LawInfo],
    bounds: fn(&Settings) -> Bounds,
    compliance: fn(&Settings, f64) -> [f64; 2],
    f32: Makes<f32>,
    f64: Makes<f64>,
    fixed: Makes<Fixed>,
    f64s: Makes<F64s>,
}

impl Maker {
    const fn of<F: Family>() -> Self {
        Self {
            laws: <F::Of<f64> as Law<f64>>::LAWS,
            bounds: <F::Of<f64> as Law<f64>>::bounds,
            compliance: <F::Of<f64> as Law<f64>>::compliance,
            f32: Makes::of::<F::Of<f32>>(),
            f64: Makes::of::<F::Of<f64>>(),
            fixed: Makes::of::<F::Of<Fixed>>(),
            f64s: Makes::of::<F::Of<F64s>>(),
        }
    }
}

/// A number type in which peers that share `SHARED` axes of a device of `N` can be built.
pub trait Builds<const SHARED: usize, const N: usize>: Scalar {
    /// The constructor of such peers in a family of laws.
    #[doc(hidden)]
    fn make(maker: &Maker) -> Make<Self, SHARED, N>;
}

/// A number type that a peer can be asked for at run time: `f32`, as the board, `f64`, [`Fixed`], [`DoubleDouble`], or lanes of
/// `f64` ([`crate::lanes`]). A peer shares one axis of a device in the plane, both of them, or all three of a device in space.
pub trait Number: Builds<1, AXES> + Builds<2, 2> + Builds<3, 3> {}

/// Implements [`Builds`] for a number type. The first form takes the constructor from a field of [`Maker`], so every law of every family is
/// compiled in this type, here and once. The second form is for types that no command computes in: a program that uses one compiles its peers
/// itself (`#[inline]`), for the axes that it uses, and for core's laws alone.
macro_rules! numbers {
    ($($Number:ty: $field:ident),+) => {
        $(
            numbers!($Number, 1, AXES, |maker| maker.$field.one);
            numbers!($Number, 2, 2, |maker| maker.$field.two);
            numbers!($Number, 3, 3, |maker| maker.$field.three);
            impl Number for $Number {}
        )+
    };
    ($($Number:ty),+) => {
        $(
            numbers!(#[inline] $Number, 1, AXES, |_maker| make::<Self, AnyLaw<Self>, 1, AXES, AnyKinematics<Self>>);
            numbers!(#[inline] $Number, 2, 2, |_maker| make::<Self, AnyLaw<Self>, 2, 2, AnyKinematics<Self>>);
            numbers!(#[inline] $Number, 3, 3, |_maker| make::<Self, AnyLaw<Self>, 3, 3, AnySpatial<Self>>);
            impl Number for $Number {}
        )+
    };
    ($(#[$inline:meta])? $Number:ty, $SHARED:literal, $N:expr, |$maker:ident| $make:expr) => {
        impl Builds<$SHARED, $N> for $Number {
            $(#[$inline])?
            fn make($maker: &Maker) -> Make<Self, $SHARED, $N> {
                $make
            }
        }
    };
}
numbers!(f32: f32, f64: f64, Fixed: fixed, F64s: f64s);
numbers!(DoubleDouble);

/// Calls a function that is generic over the axes along which the object is shared, and those of the devices, for as many as a scene
/// says: `of_axes!(scene, run::<f64>(scene, seconds))` is `run::<f64, 1, AXES>`, `run::<f64, 2, 2>` or `run::<f64, 3, 3>`.
#[macro_export]
macro_rules! of_axes {
    ($scene:expr, $function:ident ($($argument:expr),* $(,)?)) => {
        $crate::of_axes!($scene, $function::<>($($argument),*))
    };
    ($scene:expr, $($function:ident)::+ ::<$($of:ty),*> ($($argument:expr),* $(,)?)) => {
        match $scene.peer.axis.shared {
            2 => $($function)::+ ::<$($of,)* 2, 2>($($argument),*),
            3.. => $($function)::+ ::<$($of,)* 3, 3>($($argument),*),
            _ => $($function)::+ ::<$($of,)* 1, { $crate::AXES }>($($argument),*),
        }
    };
}

/// Those of core. A static: peers of every law and number type are compiled here, and not in every program that names it.
static BUILT_IN: [Maker; 1] = [Maker::of::<BuiltIn>()];

/// The laws that a scene may name: those of core, and those that a program adds at its start.
#[derive(Clone, Copy, Debug)]
pub struct Laws {
    schema: Schema,
    makers: &'static [Maker],
    /// How many of the makers are the program's own.
    own: usize,
}

impl Default for Laws {
    fn default() -> Self {
        Self::built_in()
    }
}

impl Laws {
    /// The laws of cohold-core.
    pub const fn built_in() -> Self {
        Self { schema: Schema::BUILT_IN, makers: &BUILT_IN, own: 1 }
    }

    /// These laws and those of one more family. The list stays in memory for the life of the program.
    ///
    /// # Panics
    /// A law, or a key of its own, has a name that is taken.
    #[must_use]
    pub fn with<F: Family>(self) -> Self {
        self.with_laws::<F>(<F::Of<f64> as Law<f64>>::LAWS)
    }

    /// These laws and a family whose laws are known only when the program runs.
    ///
    /// # Panics
    /// As [`Laws::with`].
    #[must_use]
    pub fn with_laws<F: Family>(self, laws: &'static [LawInfo]) -> Self {
        let maker = Maker { laws, ..Maker::of::<F>() };
        for law in maker.laws {
            assert!(self.all().iter().all(|known| known.name != law.name), "there is a law {} already", law.name);
            let taken =
                law.keys.iter().find(|key| self.schema.keys().any(|known| known.name == key.name && known != **key));
            assert!(taken.is_none(), "{}: there is a key {} already", law.name, taken.map_or("", |key| key.name));
        }
        let laws = [self.all(), maker.laws].concat();
        let makers = [self.makers, &[maker]].concat();
        Self { schema: Schema::new(Box::leak(laws.into())), makers: Box::leak(makers.into()), ..self }
    }

    /// Every key of a peer with these laws.
    pub fn schema(&self) -> Schema {
        self.schema
    }

    /// Every law, in the order in which they were added.
    pub fn all(&self) -> &'static [LawInfo] {
        self.schema.laws()
    }

    /// These laws, all of them the program's own: [`Laws::outside`] are those that are added later.
    #[must_use]
    pub fn as_own(self) -> Self {
        Self { own: self.makers.len(), ..self }
    }

    /// Names of the laws that are not the program's own, but were brought by whoever extends it.
    pub fn outside(&self) -> impl Iterator<Item = &'static str> {
        self.makers[self.own..].iter().flat_map(|maker| maker.laws).map(|law| law.name)
    }

    /// A peer with these settings, disarmed. `device` is where the device is when its encoders are first read.
    ///
    /// # Errors
    /// The first key whose value is out of range, or impossible beside the others.
    pub fn peer<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
        &self,
        settings: &Settings,
        device: [Motion<S>; N],
    ) -> Result<Box<dyn DynPeer<S, SHARED, N>>, Refused<'static>> {
        S::make(self.maker(settings))(settings, device)
    }

    /// Bounds on what a peer with the limits of these settings sends ([`Law::bounds`]).
    pub fn bounds(&self, settings: &Settings) -> Bounds {
        (self.maker(settings).bounds)(settings)
    }

    /// How far a newton takes two copies at rest from each other, m/N ([`Law::compliance`]).
    pub fn compliance(&self, settings: &Settings, delay_s: f64) -> [f64; 2] {
        (self.maker(settings).compliance)(settings, delay_s)
    }

    fn maker(&self, settings: &Settings) -> &Maker {
        let named = |maker: &&Maker| maker.laws.iter().any(|law| law.name == settings.coordination.comm);
        self.makers.iter().find(named).unwrap_or(&self.makers[0])
    }
}
