//! Where long sums are kept: a self-timed line in f32 with its sums in f64, as it flies, and with everything in f32.
//!
//! Two peers of the scene `any-network` hold an object for a minute over 8 ms each way, their hands pushing with forces (§5.2), so that nothing but the
//! line keeps the copies where they are. Devices are simulated in f64 and packets cross as they are: the only difference is what a peer
//! computes in. Reference: the same in double-double, whose sums are f64. Unit: m.

use cohold_core::device::{AXES, Reading};
use cohold_core::law::{AnyLaw, Packet};
use cohold_core::names::Side;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::settings::{Refused, Settings};
use cohold_sim::double_double::DoubleDouble;
use std::collections::VecDeque;
use std::ops::{Add, Mul, Neg, Sub};

use super::{largest, pair};

/// How long, s.
const DURATION_S: f64 = 60.0;
/// A device, kg and N·s/m.
const MASS_KG: f64 = 0.1;
const DAMPING_N_S_PER_M: f64 = 1.0;
/// Packets on their way, at one a tick.
const DELAY: u32 = 8;

/// What a line is computed in, as reports call it.
pub const MIX: &str = "f32, sums in f64";
/// What it would be without doubles.
pub const SINGLE: &str = "f32, sums in f32";

/// f32 that keeps its long sums in f32, too.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
struct Single(f32);

macro_rules! of_both {
    ($($Operation:ident $name:ident),+) => { $(
        impl $Operation for Single {
            type Output = Self;
            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(other.0))
            }
        }
    )+ };
}
of_both!(Add add, Sub sub, Mul mul);

impl Neg for Single {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Single {
    type Counter = Self;
    const NAME: &'static str = SINGLE;
    const ZERO: Self = Self(0.0);
    const ONE: Self = Self(1.0);

    fn from_f64(value: f64) -> Self {
        Self(value as f32)
    }
    fn to_f64(self) -> f64 {
        self.0.into()
    }
    fn from_i32(value: i32) -> Self {
        Self(value as f32)
    }
    fn round_to_i32(self) -> i32 {
        Scalar::round_to_i32(self.0)
    }
    fn to_counter(self) -> Self {
        self
    }
    fn of_counter(counter: Self) -> Self {
        counter
    }
    fn is_finite(self) -> bool {
        self.0.is_finite()
    }
    fn bits(self) -> u64 {
        self.0.bits()
    }
    fn sqrt(self) -> Self {
        Self(Scalar::sqrt(self.0))
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = Scalar::sin_cos(self.0);
        (Self(sine), Self(cosine))
    }
    fn ratio(self, divisor: Self) -> Self {
        Self(self.0.ratio(divisor.0))
    }
}

/// Where both copies are, m, tick by tick.
fn run<S: Scalar>(settings: &Settings) -> Result<Vec<[f64; 2]>, Refused<'static>> {
    let period_s = settings.timing.control_period_s;
    let peer = |side| {
        let mut settings = *settings;
        settings.contact.side = side;
        let mut peer = Peer::<S, AnyLaw<S>>::new(&settings, [Motion::REST; AXES])?;
        peer.command(Command::Arm);
        Ok(peer)
    };
    let (mut peers, mut devices) = ([peer(Side::Left)?, peer(Side::Right)?], [Motion::<f64>::REST; 2]);
    let mut on_the_way: VecDeque<[Option<Packet<S>>; 2]> = VecDeque::from([[None; 2]; DELAY as usize]);
    let tick = |tick: usize| {
        on_the_way.push_back(peers.each_mut().map(|peer| peer.exchange().map(|[packet]| packet)));
        let [first, second] = on_the_way.pop_front().unwrap_or_default();
        let push_n = [1.0, -1.0 - 0.25 * (3.0 * tick as f64 * period_s).sin()];
        let heard = [second, first];
        for (((peer, device), packet), push_n) in peers.iter_mut().zip(&mut devices).zip(heard).zip(push_n) {
            if let Some(packet) = packet {
                peer.hear(&[packet]);
            }
            let seen = Motion::new(S::from_f64(device.position), S::from_f64(device.velocity));
            let force = peer.tick(&Sensors::of(Reading::Exact([seen, Motion::REST]))).forces[0].to_f64();
            let acceleration = (push_n + force - DAMPING_N_S_PER_M * device.velocity) / MASS_KG;
            device.velocity += period_s * acceleration;
            device.position += period_s * device.velocity;
        }
        peers.each_ref().map(|peer| peer.observed()[0].object.position.to_f64())
    };
    Ok((0..(DURATION_S / period_s).round() as usize).map(tick).collect())
}

/// What is computed in, the number type whose ticks are counted, and largest errors of x_o1 − x_o2 and of the mean of both, m.
type Errors = (&'static str, &'static str, [f64; 2]);

/// The errors of each mix.
pub fn errors() -> Result<Vec<Errors>, Refused<'static>> {
    // A line that follows the network would do so in each row in another way: its credit is stated.
    let settings = pair::any_network(2 * DELAY).peer;
    let exact = run::<DoubleDouble>(&settings)?;
    let of = |run: Vec<[f64; 2]>| {
        let differences =
            |pick: fn(&[f64; 2]) -> f64| largest(run.iter().zip(&exact).map(|(got, wanted)| pick(got) - pick(wanted)));
        [differences(|[one, other]| one - other), differences(|[one, other]| 0.5 * (one + other))]
    };
    Ok(vec![
        (MIX, f32::NAME, of(run::<f32>(&settings)?)),
        (SINGLE, SINGLE, of(run::<Single>(&settings)?)),
        (f64::NAME, f64::NAME, of(run::<f64>(&settings)?)),
        (Fixed::NAME, Fixed::NAME, of(run::<Fixed>(&settings)?)),
    ])
}
