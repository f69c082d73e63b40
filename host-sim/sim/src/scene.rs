//! A scene: what two peers, their users, their devices and the network between them have as settings before a run.
//!
//! Scene files are TOML. Every key is optional; the defaults are the cooperation paper's §5. Keys of the peer itself are
//! declared in `haptic_core::settings`, those of the world around it here, and both are read, checked and listed by the
//! same code. Whatever is wrong (unknown key, wrong unit, out of range) is one error that names the key, the value
//! and what is allowed, and where it stood.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use haptic_core::contact::{RenderingName, Side};
use haptic_core::device::AXES;
use haptic_core::device::current::{self, CurrentLoop};
use haptic_core::device::kinematics::KinematicsName;
use haptic_core::device::motor::Duty;
use haptic_core::device::velocity::VelocityName;
use haptic_core::num::Motion;
use haptic_core::settings::{Allowed, Choice, Key, LawInfo, Refused, SetError, Settings, Tables, Value, number};

use haptic_io::Most;

use crate::Error;
use crate::network::fitted::Like;
use crate::network::trace::NetworkTrace;
use crate::peers::{Builds, DynPeer, Laws};
use crate::plant::{self, Beyond};
use crate::user::{Trace, User, UserSettings};

mod linear;

/// How the delay varies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jitter {
    /// The delay does not vary.
    None,
    /// Uniformly from 0 to jitter_s.
    Uniform,
    /// Gamma-distributed with shape 2 and mean jitter_s.
    Gamma,
    /// Heavy-tailed: Pareto-distributed (Lomax) with shape 2, cut at 100 times its mean jitter_s.
    Pareto,
}

impl Choice for Jitter {
    const NAMES: &'static [&'static str] = &["none", "uniform", "gamma", "pareto"];
    const ALL: &'static [Self] = &[Self::None, Self::Uniform, Self::Gamma, Self::Pareto];
}

/// What a motor's duty means to a simulated winding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveName {
    /// A voltage, as a share of the supply.
    Voltage,
    /// A current: the reference of haptic-core's current loop.
    Current,
}

impl Choice for DriveName {
    const NAMES: &'static [&'static str] = &["voltage", "current"];
    const ALL: &'static [Self] = &[Self::Voltage, Self::Current];
}

/// A simulated failure of the first joint of the first device, its motor, power stage or encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlantFault {
    /// No failure.
    None,
    /// A wire of the motor is disconnected.
    OpenMotor,
    /// The wires of the motor are short-circuited.
    ShortedMotor,
    /// The current's sensor reads zero.
    DeadSense,
    /// The two wires of the current's sensor are swapped.
    ReversedSense,
    /// The current's sensor reads the end of its range.
    SenseAtEnd,
    /// The bridge gives a fifth of its supply while it is off.
    ConductingBridge,
    /// The bridge drives its motor whether or not it is enabled.
    IgnoredEnable,
    /// The supply voltage of the bridges falls to 0.6 of its value.
    LowSupply,
    /// The supply voltage of the bridges rises to 1.4 of its value.
    HighSupply,
    /// The device is held fast, so that it cannot move.
    Held,
    /// The encoder does not count any more.
    EncoderStuck,
    /// Channel A of the encoder is dead.
    EncoderWithoutA,
    /// Channel B of the encoder is dead.
    EncoderWithoutB,
    /// The encoder does not follow the joint, but alternates by one count from tick to tick.
    EncoderDithers,
    /// The encoder counts in the wrong direction.
    EncoderReversed,
    /// The encoder counts only half of the edges.
    EncoderHalved,
    /// The encoder loses 40 counts, once.
    EncoderLoses,
}

impl Choice for PlantFault {
    const NAMES: &'static [&'static str] = &[
        "none",
        "open-motor",
        "shorted-motor",
        "dead-sense",
        "reversed-sense",
        "sense-at-end",
        "conducting-bridge",
        "ignored-enable",
        "low-supply",
        "high-supply",
        "held",
        "encoder-stuck",
        "encoder-without-a",
        "encoder-without-b",
        "encoder-dithers",
        "encoder-reversed",
        "encoder-halved",
        "encoder-loses",
    ];
    const ALL: &'static [Self] = &[
        Self::None,
        Self::OpenMotor,
        Self::ShortedMotor,
        Self::DeadSense,
        Self::ReversedSense,
        Self::SenseAtEnd,
        Self::ConductingBridge,
        Self::IgnoredEnable,
        Self::LowSupply,
        Self::HighSupply,
        Self::Held,
        Self::EncoderStuck,
        Self::EncoderWithoutA,
        Self::EncoderWithoutB,
        Self::EncoderDithers,
        Self::EncoderReversed,
        Self::EncoderHalved,
        Self::EncoderLoses,
    ];
}

haptic_core::settings! {
    /// Settings of the world around the peers: devices and their imperfections, and the network.
    pub struct World;

    /// The haptic device, of which each user holds one, unless one end has its own.
    device: Device {
        mass_kg: f64 = 0.1, number(1e-4, 1e3), "kg", "Moving mass m_HD.";
        damping_n_s_per_m: f64 = 1.0, number(0.0, 1e4), "N·s/m", "Viscous damping b_HD.";
        force_delay_ticks: f64 = 1.0, number(0.0, Device::MOST_DELAY_TICKS), "ticks",
            "Delay from sensing to the new motor force, in control periods.";
        joint_inertia: f64 = 0.0, number(0.0, 1e3), "kg or kg·m²",
            "What slides or turns with every joint beside that, with axis.shared of 2 or 3: at the hand it weighs as the mechanism at home has it,              which couples the axes.";
    }

    /// Imperfections of the device; each is off unless asked for.
    plant: PlantSettings {
        encoder: bool = false, Allowed::Flag, "",
            "The peer reads encoder counts (tables encoder, kinematics) instead of the exact position.";
        coulomb_n: f64 = 0.0, number(0.0, 100.0), "N", "Coulomb friction; 0 is none.";
        motor: bool = false, Allowed::Flag, "",
            "The device is driven by motor duties (table motor), saturation included, instead of the exact force.";
        pwm_steps: u32 = 0, Allowed::Whole { min: 0, max: 32767 }, "",
            "PWM steps from zero to full duty, with plant.motor; 0 is as fine as the duty register.";
        winding: bool = false, Allowed::Flag, "",
            "The motors have windings (R, L and back-EMF of table motor) behind a bridge that is a voltage, with plant.motor; the delay \
             of the force is theirs then, and device.force_delay_ticks says nothing.";
        drive: DriveName = DriveName::Voltage, Allowed::Names(DriveName::NAMES), "",
            "What a duty is to a winding: a share of the supply, or the reference of the current loop.";
        supply_v: f64 = 24.0, number(6.0, 60.0), "V", "Supply of the bridges.";
        dead_time_s: f64 = 0.0, number(0.0, 5e-6), "s", "Time at each edge in which neither switch of a leg is on.";
        resistance_ratio: f64 = 1.0, number(0.5, 2.0), "",
            "Resistance of the windings over motor.resistance_ohm; 1.24 is 60 K warmer copper.";
        current_bits: u32 = 12, Allowed::Whole { min: 8, max: 16 }, "bits",
            "Converter of the current, from -motor.sense_a to motor.sense_a.";
        current_noise_a: f64 = 0.0032, number(0.0, 1.0), "A", "Noise of the current's sensor, root mean square.";
        current_zero_a: f64 = 0.0, number(-1.0, 1.0), "A", "What the current's sensor reads while none flows.";
        loop_delay_periods: f64 = 1.5, number(1.0, 1.5), "",
            "PWM periods of 50 µs from a sample of the current to the middle of the voltage that comes of it.";
        fault: PlantFault = PlantFault::None, Allowed::Names(PlantFault::NAMES), "",
            "What goes wrong with the first joint of device 1: its motor and power stage (with plant.drive = \"current\"), its encoder, or its hand.";
        fault_at_s: f64 = 1.0, number(0.0, 1e6), "s", "When it does.";
    }

    /// The network between the peers.
    network: Network {
        one_way_delay_packets: u32 = 1, Allowed::Whole { min: 0, max: 1000 }, "packets",
            "One-way delay n_t in packet periods.";
        extra_delay_s: f64 = 0.0, number(0.0, 2.0), "s", "Constant time on top of the delay, both ways.";
        asymmetry_s: f64 = 0.0, number(0.0, 2.0), "s", "Constant time on top of the delay, from peer 2 to peer 1 only.";
        delay_step_s: f64 = 0.0, number(-2.0, 2.0), "s",
            "From network.delay_step_at_s on, the delay is longer (or shorter) by this.";
        delay_step_at_s: f64 = 0.0, number(0.0, 1e6), "s", "When the delay steps.";
        like: Like = Like::None, Allowed::Names(Like::NAMES), "",
            "A network that was measured, whose delay varies and which loses as that one did; of the other keys only constant delays, drift and seed count then.";
        jitter: Jitter = Jitter::None, Allowed::Names(Jitter::NAMES), "", "How the delay varies from packet to packet.";
        jitter_s: f64 = 0.0, number(0.0, 2.0), "s", "Uniform jitter: the most; gamma and Pareto jitter: the mean.";
        loss: f64 = 0.0, number(0.0, 0.95), "", "Fraction of the packets that are lost.";
        loss_burst_packets: f64 = 1.0, number(1.0, 1e4), "packets",
            "Mean length of a run of losses (Gilbert-Elliott); 1 is independent losses.";
        reorder: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that are held back and overtaken.";
        reorder_depth_packets: u32 = 4, Allowed::Whole { min: 1, max: 1000 }, "packets",
            "How far a packet is held back at the most.";
        reverse_block_packets: u32 = 0, Allowed::Whole { min: 0, max: 64 }, "packets",
            "Every block of this many packets arrives in reverse order, once its last is sent; 0 and 1 change nothing.";
        duplicate: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that arrive twice.";
        corrupt: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that arrive broken.";
        clock_drift_ppm: f64 = 0.0, number(-10000.0, 10000.0), "ppm", "How much slower peer 2's clock runs.";
        bandwidth_bit_per_s: f64 = 0.0, number(0.0, 1e12), "bit/s", "Rate of the line; 0 is unlimited.";
        playout_packets: u32 = 0, Allowed::Whole { min: 0, max: 32 }, "packets",
            "Play-out buffer: packets wait until they are this much later than the fastest, so that the delay is constant.";
        seed: u32 = 1, Allowed::Whole { min: 0, max: u32::MAX }, "", "Seed of everything random in a run.";
    }
}

impl PlantSettings {
    /// Timer counts of full duty, at which a bridge gives its whole supply.
    pub fn timer_counts(&self) -> u16 {
        match self.pwm_steps {
            0 => Duty::FULL_SCALE.unsigned_abs(),
            // At most 15 bits.
            steps => steps as u16,
        }
    }
}

impl Device {
    /// The longest delay from sensing to force that a device may have, in control periods.
    pub const MOST_DELAY_TICKS: f64 = 20.0;

    /// Its delay as whole control periods for which a force is held back, and the part of the next one that passes before it acts.
    pub fn delay(&self) -> (usize, f64) {
        let whole = (self.force_delay_ticks.ceil() - 1.0).max(0.0);
        (whole as usize, self.force_delay_ticks - whole)
    }
}

/// A scene: peers, devices, users and the network between the peers.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The coordination laws that the scene may name.
    pub laws: Laws,
    /// Settings of both peers, unless one has its own; peer 2 is on the other side of the object.
    pub peer: Settings,
    /// Settings of the world around the peers: devices and network.
    pub world: World,
    /// The users at the two devices.
    pub users: [User; 2],
    /// Settings of one end alone, by key: `peer.1.…` and `peer.2.…`, of [`OWN`].
    own: [OwnKeys; 2],
    /// Devices are what they are at home, and linear: [`Scene::linear`].
    at_home: bool,
    /// A recording of what the network did (`network.trace`), instead of what its table would draw.
    pub network_trace: Option<Arc<NetworkTrace>>,
}

/// Keys of one end alone, with their values, which were checked.
type OwnKeys = Vec<(&'static str, Value<'static>)>;

/// Largest scene file that is read: 1 MiB.
pub const MOST: Most = Most::new(1 << 20, "a scene");

/// Tables and keys that may differ between the two ends, written with `peer.1.` or `peer.2.` before them: a leader and a follower whose
/// devices, scales and limits are unlike. Settings that both must share are common, and in a simulation so
/// are the models of the devices.
const OWN: [&str; 7] =
    ["scale", "device", "fixture", "safety", "probe", "contact.stiffness_n_per_m", "contact.damping_n_s_per_m"];

/// The value that the text of an override stands for: a number, what TOML says, else a name.
pub fn value_of(text: &str) -> toml::Value {
    // TOML has no `.25`, and people do.
    let number = text.parse().ok().filter(|number: &f64| number.is_finite()).map(toml::Value::Float);
    let told = || format!("v = {text}").parse::<toml::Table>().ok().and_then(|mut table| table.remove("v"));
    number.or_else(told).unwrap_or_else(|| toml::Value::String(text.to_owned()))
}

/// The user (0 or 1) that a key belongs to, and its name in [`UserSettings`].
fn users_key(key: &str) -> Option<(usize, String)> {
    let (user, rest) = key.strip_prefix("user.")?.split_once('.')?;
    Some((["1", "2"].iter().position(|known| *known == user)?, format!("user.{rest}")))
}

/// The end (0 or 1) that a key belongs to, and the key's name at either end.
fn own_key(key: &str) -> Option<(usize, &str)> {
    let (end, rest) = key.strip_prefix("peer.")?.split_once('.')?;
    Some((["1", "2"].iter().position(|known| *known == end)?, rest))
}

/// Whether a key may differ between the two ends.
fn may_differ(key: &str) -> bool {
    OWN.iter().any(|own| key.strip_prefix(own).is_some_and(|rest| rest.is_empty() || rest.starts_with('.')))
}

impl Scene {
    /// Every key of a scene file with what it accepts, those of the two users included.
    pub fn keys(&self) -> Vec<(String, Key)> {
        let common = self.laws.schema().keys().chain(World::KEYS.iter().copied()).map(|key| (key.name.to_owned(), key));
        let users = (1..=2).flat_map(|user| {
            UserSettings::KEYS.iter().map(move |key| (key.name.replacen("user.", &format!("user.{user}."), 1), *key))
        });
        common.chain(users).filter(|(name, _)| name != "contact.side").collect()
    }

    /// Every key that has a value, and that value as TOML: with them a scene file says all of the scene.
    pub fn settings(&self) -> Vec<(String, String)> {
        let value = |name: String| self.get(&name).map(|value| (name, value.to_string()));
        let mut settings: Vec<_> = self.keys().into_iter().filter_map(|(name, _)| value(name)).collect();
        let users = (1..)
            .zip(&self.users)
            .filter_map(|(user, own)| Some((format!("user.{user}.trace"), &own.trace.as_ref()?.file)));
        let network = self.network_trace.iter().map(|trace| ("network.trace".to_owned(), &trace.file));
        let own = (1..).zip(&self.own).flat_map(|(end, own)| {
            own.iter().map(move |(key, value)| (format!("peer.{end}.{key}"), value.to_string()))
        });
        settings.extend(own);
        settings.extend(users.chain(network).map(|(key, file)| (key, format!("{:?}", file.display().to_string()))));
        settings
    }

    /// Whether what becomes of packets is drawn from `network.seed`.
    pub fn draws_packets(&self) -> bool {
        let Network { like, jitter, loss, reorder, duplicate, corrupt, .. } = self.world.network;
        let varies = like != Like::None || jitter != Jitter::None;
        self.network_trace.is_none() && (varies || [loss, reorder, duplicate, corrupt].iter().any(|share| *share > 0.0))
    }

    /// Whether runs with other seeds may be other runs: something is drawn, what becomes of packets or the noise of the power stage's
    /// converters, or the law is not one of core's, which draws nothing.
    pub fn draws(&self) -> bool {
        let from_outside = || self.laws.outside().any(|name| name == self.peer.coordination.comm);
        self.draws_packets() || self.world.plant.winding || from_outside()
    }

    /// A hash (FNV-1a, 32 bits) of all settings but the network's seed, to tell scenes from each other.
    pub fn fingerprint(&self) -> u32 {
        let settings = self.settings();
        let bytes = settings.iter().filter(|(key, _)| key != "network.seed").flat_map(|(key, value)| [key, value]);
        // FNV-1a.
        let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        bytes.flat_map(|text| text.bytes()).fold(0xcbf2_9ce4_8422_2325, mix) as u32
    }

    /// The default scene, which may name these laws.
    pub fn new(laws: Laws) -> Self {
        Self { laws, ..Self::default() }
    }

    /// The scene in `path`, or the default scene, with the overrides (`table.key=value`) applied in order, then checked.
    ///
    /// # Errors
    /// A file that cannot be read, text that is no scene, or a key that is out of range or impossible beside the
    /// others.
    pub fn load(laws: Laws, path: Option<&Path>, overrides: &[String]) -> Result<Self, Error> {
        let Some(path) = path else { return Self::of_text(laws, "", "scene", None, overrides) };
        let place = path.display().to_string();
        let text = haptic_io::text(path, MOST).map_err(Error::cannot("read", &place))?;
        Self::of_text(laws, &text, &place, path.parent(), overrides)
    }

    /// [`Scene::load`] of TOML text found at `place`; file names in it are taken relative to `folder`.
    pub(crate) fn of_text(
        laws: Laws,
        text: &str,
        place: &str,
        folder: Option<&Path>,
        overrides: &[String],
    ) -> Result<Self, Error> {
        let mut scene = Self::new(laws);
        scene.apply(text, place, folder)?;
        overrides.iter().try_for_each(|text| scene.apply_override(text))?;
        scene.check(place)?;
        Ok(scene)
    }

    /// Applies TOML text found at `place`; file names in it are taken relative to `folder`.
    ///
    /// # Errors
    /// Text that is no TOML, a key that does not exist, or a value that it does not accept.
    pub fn apply(&mut self, text: &str, place: &str, folder: Option<&Path>) -> Result<(), Error> {
        let mut table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
            let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
            let place = line.map_or_else(|| place.to_owned(), |line| format!("{place}:{line}"));
            Error::at(&place, error.message().replace('\n', " "))
        })?;
        // What made a file of results stands in its scene file too, and changes nothing.
        table.remove("made");
        self.apply_table("", &table, text, place, folder)
    }

    fn apply_table(
        &mut self,
        prefix: &str,
        table: &toml::Table,
        text: &str,
        place: &str,
        folder: Option<&Path>,
    ) -> Result<(), Error> {
        for (name, value) in table {
            let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            match value {
                toml::Value::Table(inner) => self.apply_table(&key, inner, text, place, folder)?,
                value => {
                    let line = text.lines().position(|line| line.trim_start().starts_with(name.as_str()));
                    let place = line.map_or_else(|| place.to_owned(), |line| format!("{place}:{}", line + 1));
                    self.set(&key, value, &place, folder)?;
                }
            }
        }
        Ok(())
    }

    /// Applies one `table.key=value`; a value that is no TOML is taken as text.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    pub fn apply_override(&mut self, text: &str) -> Result<(), Error> {
        let (key, value) = text.split_once('=').ok_or_else(|| Error::at(text, "write it as table.key=value"))?;
        let (key, value) = (key.trim(), value.trim());
        self.set(key, &value_of(value), "override", None)
    }

    /// Sets one key to a number, as a sweep does.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    pub fn set_number(&mut self, key: &str, number: f64) -> Result<(), Error> {
        self.set(key, &toml::Value::Float(number), "sweep", None)
    }

    /// Sets one key; an error names `place` as where the value stood, and names of files are relative to `folder`.
    ///
    /// # Errors
    /// There is no such key, or it does not accept the value.
    pub fn set(&mut self, key: &str, value: &toml::Value, place: &str, folder: Option<&Path>) -> Result<(), Error> {
        let plain = match value {
            toml::Value::Integer(whole) => Value::Number(*whole as f64),
            toml::Value::Float(number) => Value::Number(*number),
            toml::Value::Boolean(flag) => Value::Flag(*flag),
            toml::Value::String(text) => Value::Text(text),
            other => {
                let allowed = "a key takes a number, true or false, or a name";
                return Err(Error::at(place, Error::not_allowed(format!("{key} = {other}"), allowed)));
            }
        };
        // Keys that name a file: its path, and where a complaint about it belongs.
        let file = || match plain {
            Value::Text(file) => Ok(folder.map_or_else(|| PathBuf::from(file), |folder| folder.join(file))),
            _ => {
                let refused = Error::not_allowed(format!("{key} = {plain}"), "it must be the name of a file");
                Err(Error::at(place, refused))
            }
        };
        let wrong = |cause| Error::at(place, Error::at(key, cause));
        let outcome = match users_key(key) {
            _ if key == "network.trace" => {
                self.network_trace = Some(Arc::new(NetworkTrace::read(&file()?).map_err(wrong)?));
                Ok(())
            }
            Some((user, name)) if name == "user.trace" => {
                self.users[user].trace = Some(Trace::read(&file()?).map_err(wrong)?);
                Ok(())
            }
            Some((user, name)) => self.users[user].settings.set(&name, plain),
            _ => match own_key(key) {
                Some((end, name)) => self.set_own(end, name, plain),
                None if key == "contact.side" => Err(SetError::Unknown),
                None => set_of(self.laws, (&mut self.peer, &mut self.world), key, plain),
            },
        };
        outcome.map_err(|error| match error {
            SetError::Unknown => Error::at(place, Error::NoKey { key: key.to_owned(), hint: self.hint(key) }),
            // A user's key, or one end's, is declared once for both: name the one that was written.
            SetError::Refused(refused) => {
                let meant = match (refused.value, refused.allowed) {
                    (Value::Text(text), Allowed::Laws(laws)) => law_meant(text, laws),
                    (Value::Text(text), Allowed::Names(names)) => {
                        nearest(text, names.iter().copied()).map(|name| format!("did you mean {name}?"))
                    }
                    _ => None,
                };
                let hint = meant.map_or_else(String::new, |meant| format!("; {meant}"));
                Error::at(place, refused.to_string().replacen(refused.key, key, 1) + &hint)
            }
        })
    }

    /// Sets a key of one end alone.
    fn set_own<'a>(&mut self, end: usize, key: &str, value: Value<'a>) -> Result<(), SetError<'a>> {
        if !may_differ(key) {
            return Err(SetError::Unknown);
        }
        let (mut peer, mut world) = (self.peer, self.world);
        set_of(self.laws, (&mut peer, &mut world), key, value)?;
        let known = Settings::KEYS.iter().chain(World::KEYS).find(|known| known.name == key);
        let taken = peer.get(key).or_else(|| world.get(key));
        let (name, value) = known.map(|known| known.name).zip(taken).ok_or(SetError::Unknown)?;
        let own = &mut self.own[end];
        own.retain(|(key, _)| *key != name);
        own.push((name, value));
        own.sort_unstable_by_key(|(key, _)| *key);
        Ok(())
    }

    /// Settings of each end: its peer's, and those of the world around it.
    fn ends(&self) -> [(Settings, World); 2] {
        [0, 1].map(|end| {
            let (mut peer, mut world) = (self.peer, self.world);
            peer.contact.side = if end == 0 { Side::Left } else { Side::Right };
            for (key, value) in &self.own[end] {
                // It was taken before, and depends on no other.
                let _ = set_of(self.laws, (&mut peer, &mut world), key, *value);
            }
            (peer, world)
        })
    }

    /// The device of each end.
    pub fn devices(&self) -> [Device; 2] {
        self.ends().map(|(_, world)| world.device)
    }

    /// A device as the shared world has it must be one that could be written down: the analysis takes it for that.
    fn check_scale(&self) -> Result<(), Error> {
        for (end, (peer, world)) in (1..).zip(self.ends()) {
            let scaled = world.device.mass_kg * peer.scale.force / peer.scale.position;
            if !(1e-4..=1e3).contains(&scaled) {
                return Err(format!(
                    "device.mass_kg = {} of peer {end} is not allowed with scale.position = {} and scale.force = {}: in the world it is \
                     {scaled} kg, it must be 0.0001…1000 kg",
                    world.device.mass_kg, peer.scale.position, peer.scale.force
                ).into());
            }
        }
        Ok(())
    }

    /// Whether its devices are taken for what their mechanisms are at home, as the linear analysis has them.
    pub(crate) fn is_at_home(&self) -> bool {
        self.at_home
    }

    /// Whether the inertia of a device's joints couples its axes.
    pub fn is_coupled(&self) -> bool {
        self.devices().iter().any(|device| device.joint_inertia > 0.0)
    }

    /// What weighs at the joints is told of axes that are all shared, and free to move every way.
    fn check_joint_inertia(&self) -> Result<(), Error> {
        let refused = |with: String| {
            let said = self.devices().map(|device| device.joint_inertia).into_iter().fold(0.0, f64::max);
            Err(format!("device.joint_inertia = {said} is not allowed with {with}").into())
        };
        match () {
            () if !self.is_coupled() => Ok(()),
            () if !self.is_shared_along_several() => {
                refused("axis.shared = 1: it must be 0, or 2 or 3 axes shared".into())
            }
            () if self.world.plant.coulomb_n > 0.0 => {
                refused(format!("plant.coulomb_n = {}: one of them must be 0", self.world.plant.coulomb_n))
            }
            () if self.users.iter().any(User::has_wall) => refused(
                "user.1.wall_stiffness_n_per_m or user.2.wall_stiffness_n_per_m above 0: a wall is along one axis"
                    .into(),
            ),
            () => Ok(()),
        }
    }

    /// An arm takes its device nowhere that the links do not reach, nor where the peer would stop it.
    fn check_reach(&self) -> Result<(), Error> {
        for (end, (peer, user)) in self.peers().iter().zip(&self.users).enumerate() {
            let (profile, number, model) = (&user.settings.user, end + 1, peer.kinematics.model);
            let length_m = profile.reach_m.abs() + profile.tremor_m;
            if profile.arm_stiffness_n_per_m == 0.0 || length_m == 0.0 || model == KinematicsName::Direct {
                continue;
            }
            let toward = if end == 0 { 1.0_f64 } else { -1.0 } * profile.reach_m.signum();
            let direction = user.direction();
            let way_m = direction.map(|part| toward * length_m * part);
            // Down to what is said, so that it is allowed.
            let most_m = |share: f64| (1e4 * (share * length_m - profile.tremor_m)).floor() / 1e4;
            let farthest = direction.map(f64::abs).into_iter().fold(0.0, f64::max);
            if farthest * length_m > peer.safety.workspace_m {
                return Err(format!(
                    "user.{number}.reach_m = {} is not allowed with safety.workspace_m = {}: it leads {:.1} mm from home along an axis, in this \
                     direction it must be at most {:.4} m",
                    profile.reach_m,
                    peer.safety.workspace_m,
                    1e3 * farthest * length_m,
                    most_m(peer.safety.workspace_m / (farthest * length_m))
                )
                .into());
            }
            if let Some(Beyond { share, why }) = plant::beyond(peer, &self.world.plant, way_m) {
                let place = way_m.iter().take(peer.axis.count as usize).map(|part| format!("{:.1}", 1e3 * part));
                return Err(format!(
                    "user.{number}.reach_m = {} is not allowed with kinematics.model = \"{}\": at ({}) mm from home {why}; in this direction it must \
                     be at most {:.4} m",
                    profile.reach_m,
                    model.name(),
                    place.collect::<Vec<_>>().join(", "),
                    most_m(share)
                )
                .into());
            }
        }
        Ok(())
    }

    /// Whether the object is shared along several axes.
    pub fn is_shared_along_several(&self) -> bool {
        self.peer.axis.shared > 1
    }

    /// Refuses an object that is shared along several axes, where there is a place for one.
    ///
    /// # Errors
    /// The object is shared along several axes, which was asked for at `place`.
    pub fn check_one_axis(&self, place: &str) -> Result<(), Error> {
        let shared = self.peer.axis.shared;
        let said = "is not allowed here: it must be 1 but for `cooperate`, `peer`, `hub`, `play`, `sweep`, `compare`, `campaign`, \
                    `accuracy` and `stability`";
        if shared > 1 { Err(Error::at(place, format!("axis.shared = {shared} {said}"))) } else { Ok(()) }
    }

    /// Whether a peer with these settings can be built and run at a simulated device.
    fn check_peer(&self, peer: &Settings) -> Result<(), Refused<'static>> {
        peer.check_ranges()?;
        let axis = &peer.axis;
        if axis.shared > 1 && axis.shared < axis.count {
            return Err(Refused {
                key: "axis.count",
                value: Value::Number(f64::from(axis.count)),
                allowed: Allowed::Only(
                    "axis.shared where that is more than 1: a simulated device shares all of its axes",
                ),
                unit: "",
            });
        }
        match axis.shared {
            2 => self.laws.peer::<f64, 2, 2>(peer, [Motion::REST; 2]).map(drop),
            3.. => self.laws.peer::<f64, 3, 3>(peer, [Motion::REST; 3]).map(drop),
            _ => self.laws.peer::<f64, 1, AXES>(peer, [Motion::REST; AXES]).map(drop),
        }
    }

    /// Checks every range and combination, for scenes put together in code.
    ///
    /// # Errors
    /// The first value or combination that is not allowed; the error names `place` as where it stood.
    pub fn check(&self, place: &str) -> Result<(), Error> {
        let refused = |refused: Refused<'static>| Error::at(place, refused);
        let own = self.peers().into_iter().filter(|_| self.own.iter().any(|own| !own.is_empty()));
        for settings in core::iter::once(self.peer).chain(own) {
            self.check_peer(&settings).map_err(refused)?;
        }
        self.world.check_ranges().map_err(refused)?;
        for user in &self.users {
            user.settings.check_ranges().map_err(refused)?;
        }
        if self.world.plant.encoder {
            haptic_core::device::encoder::check(&self.peer).map_err(refused)?;
        }
        if self.world.plant.encoder && self.peer.axis.velocity == VelocityName::Measured {
            return Err(Error::at(
                place,
                "axis.velocity = \"measured\" is not allowed with plant.encoder = true: counts carry no velocity, it must be \
                 one of \"difference\", \"filtered\", \"adaptive\"",
            ));
        }
        self.check_mass()
            .and_then(|()| self.check_winding())
            .and_then(|()| self.check_scale())
            .and_then(|()| self.check_joint_inertia())
            .and_then(|()| self.check_reach())
            .map_err(|said| Error::at(place, said))
    }

    /// A winding is driven by duties, in whole PWM periods, and the loop around it fast enough to count as a delay.
    fn check_winding(&self) -> Result<(), Error> {
        let plant = &self.world.plant;
        if !plant.winding {
            return Ok(());
        }
        if !plant.motor {
            return Err(
                "plant.winding = true is not allowed with plant.motor = false: a winding is driven by motor duties"
                    .into(),
            );
        }
        current::periods_per_tick(&self.peer)?;
        if plant.drive == DriveName::Voltage {
            return Ok(());
        }
        CurrentLoop::build(&self.peer, plant.timer_counts())?;
        match self.force_delay_ticks() {
            ticks if ticks <= 1.0 => Ok(()),
            ticks => Err(format!(
                "motor.current_loop_hz = {} is not allowed with timing.control_period_s = {}: its current comes {ticks:.2} control \
                 periods after the force was sensed, it must be at most 1",
                self.peer.motor.current_loop_hz, self.peer.timing.control_period_s
            ).into()),
        }
    }

    /// Control periods from sensing to the force that comes of it: `device.force_delay_ticks`, or, with a winding in a current loop, the
    /// PWM period that the tick takes and the lag of the loop. That of a winding with more resistance than configured is longer, for more
    /// voltage has to add up; and what is sampled later in its period leaves less of it to the sum.
    pub fn force_delay_ticks(&self) -> f64 {
        let plant = &self.world.plant;
        if !plant.winding || plant.drive == DriveName::Voltage {
            return self.world.device.force_delay_ticks;
        }
        let crossover = std::f64::consts::TAU * self.peer.motor.current_loop_hz;
        let warmer_s = (plant.resistance_ratio - 1.0) / crossover;
        let sampled_s = (1.5 - plant.loop_delay_periods) * current::PWM_PERIOD_S;
        let lag_s = current::lag_s(&self.peer) + warmer_s + sampled_s;
        (current::PWM_PERIOD_S + lag_s) / self.peer.timing.control_period_s
    }

    /// An impact of a device that is thought heavier than what moves with it makes energy: a share
    /// (1 + e)·μ̂/μ·(2 − (1 + e)·μ̂/μ) of that of the approach is lost, μ and μ̂ the true and the assumed reduced mass, and with e = 1
    /// that is negative for any μ̂ > μ. One that is thought lighter keeps some of its approach; below half, most of it.
    fn check_mass(&self) -> Result<(), Error> {
        let (contact, device) = (&self.peer.contact, &self.world.device);
        let ends = self.ends().into_iter().zip(&self.users);
        let masses = ends.map(|((peer, world), user)| {
            let in_the_world = peer.scale.force / peer.scale.position;
            let mass_kg = world.device.mass_kg * in_the_world;
            (mass_kg, mass_kg + user.settings.user.arm_mass_kg * in_the_world)
        });
        let (heaviest, most) =
            masses.fold((0.0_f64, f64::INFINITY), |(heaviest, most), (mass, all)| (heaviest.max(mass), most.min(all)));
        let least = 0.5 * heaviest;
        // A rounding of the sum contradicts nothing.
        let agrees = (least..=most * (1.0 + 1e-12)).contains(&contact.device_mass_kg);
        if contact.rendering != RenderingName::Impulsive || agrees {
            return Ok(());
        }
        Err(format!(
            "contact.device_mass_kg = {} is not allowed with device.mass_kg = {} and contact.rendering = \"impulsive\": it must be \
             {least}…{most} kg, from half the device's mass to all that moves with it; more makes energy at every impact",
            contact.device_mass_kg, device.mass_kg
        ).into())
    }

    /// The value of a key, a user's included.
    pub fn get(&self, key: &str) -> Option<Value<'static>> {
        match users_key(key) {
            Some((user, name)) => self.users[user].settings.get(&name),
            None => match own_key(key) {
                Some((end, key)) => {
                    let (peer, world) = self.ends()[end];
                    peer.get(key).or_else(|| world.get(key)).filter(|_| may_differ(key))
                }
                None => self.laws.schema().get(&self.peer, key).or_else(|| self.world.get(key)),
            },
        }
    }

    /// Peer 1 or 2 (`at` 0 or 1) with its device where the scene puts it, disarmed, computing in `S`.
    ///
    /// # Errors
    /// The first key that is out of range or impossible beside the others.
    pub fn peer<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
        &self,
        at: usize,
    ) -> Result<Box<dyn DynPeer<S, SHARED, N>>, Refused<'static>> {
        self.peer_from(at, self.start(at))
    }

    /// [`Scene::peer()`] with its device somewhere else (m), at rest.
    ///
    /// # Errors
    /// As [`Scene::peer()`].
    pub fn peer_from<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
        &self,
        at: usize,
        device: [Motion<f64>; N],
    ) -> Result<Box<dyn DynPeer<S, SHARED, N>>, Refused<'static>> {
        let settings = &self.peers()[at];
        let in_the_world = |axis: Motion<f64>| Motion::at(S::from_f64(settings.scale.position * axis.position));
        self.laws.peer(settings, device.map(in_the_world))
    }

    /// Where the device of peer 1 or 2 (`at` 0 or 1) is at first: at rest, just clear of the object.
    pub fn start<const N: usize>(&self, at: usize) -> [Motion<f64>; N] {
        let contact = &self.peer.contact;
        let mut axes = [Motion::REST; N];
        if contact.one_sided {
            let gap_m = contact.gap_m / self.peers()[at].scale.position;
            axes[0].position = if at == 0 { -gap_m } else { gap_m };
        }
        axes
    }

    /// Settings of each of the two peers.
    pub fn peers(&self) -> [Settings; 2] {
        self.ends().map(|(peer, _)| peer)
    }

    /// The law that the scene names; one that is not known here has been refused.
    pub fn law(&self) -> &'static LawInfo {
        self.laws.schema().law(&self.peer).unwrap_or(&self.laws.all()[0])
    }

    /// What a mistyped key may have meant.
    fn hint(&self, key: &str) -> String {
        if let Some((_, now)) = RENAMED.iter().find(|(before, _)| *before == key) {
            return format!("; it is {now} now");
        }
        if key.starts_with("peer.") {
            return format!("; what one end alone may be told is peer.1. or peer.2. and a key of {}", OWN.join(", "));
        }
        let keys = self.keys();
        if let Some((table, _)) =
            key.rsplit_once('.').filter(|(table, _)| !keys.iter().any(|(k, _)| k.starts_with(&format!("{table}."))))
        {
            let mut tables: Vec<&str> =
                keys.iter().filter_map(|(name, _)| name.rsplit_once('.')).map(|(t, _)| t).collect();
            tables.dedup();
            return format!("; there is no table {table}, the tables are {}", tables.join(", "));
        }
        let near = nearest(key, keys.iter().map(|(name, _)| name.as_str()));
        near.map_or_else(String::new, |name| format!("; did you mean {name}?"))
    }
}

/// Sets a key of peer or world.
fn set_of<'a>(
    laws: Laws,
    (peer, world): (&mut Settings, &mut World),
    key: &str,
    value: Value<'a>,
) -> Result<(), SetError<'a>> {
    match laws.schema().set(peer, key, value) {
        Err(SetError::Unknown) => world.set(key, value),
        done => done,
    }
}

/// Keys that are called otherwise since they have another unit.
const RENAMED: [(&str, &str); 3] = [
    ("safety.fade_packets", "safety.fade_s, in s"),
    ("safety.disengage_packets", "safety.disengage_s, in s"),
    ("safety.peer_lost_packets", "safety.peer_lost_s, in s"),
];

/// Laws that are called otherwise since their names were those of other methods.
const RENAMED_LAWS: [(&str, &str); 2] =
    [("input-gated", "passivity-observer"), ("passivity-control", "passive-spring")];

/// Which law is meant by a name that none of these has, in words: the one that had it before, or else one whose name is like it.
pub fn law_meant(word: &str, laws: &[LawInfo]) -> Option<String> {
    if let Some((_, now)) = RENAMED_LAWS.iter().find(|(before, _)| *before == word) {
        return Some(format!("it is {now} now"));
    }
    nearest(word, laws.iter().map(|law| law.name)).map(|name| format!("did you mean {name}?"))
}

/// The name that a misspelt one is most like, if it is like any.
pub fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likely = names.map(|name| (strsim::jaro_winkler(name, word), name)).filter(|(likeness, _)| *likeness > 0.8);
    likely.max_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, name)| name)
}
