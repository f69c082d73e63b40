//! A scene: what two peers, their users, their devices and the network between them have as settings before a run.
//!
//! Scene files are TOML. Every key is optional; the defaults are the cooperation paper's §5. Keys of the peer itself are
//! declared in `cohold_core::settings`, those of the world around it here, and both are read, checked and listed by the
//! same code. Whatever is wrong (unknown key, wrong unit, out of range) is one error that names the key, the value
//! and what is allowed, and where it stood.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use cohold_core::contact::Side;
use cohold_core::device::current;
use cohold_core::num::Motion;
use cohold_core::settings::{Allowed, Key, LawInfo, Refused, SetError, Settings, Tables, Value};

use cohold_io::Most;
use toml::de::DeTable;

use crate::Error;
use crate::network::fitted::Like;
use crate::network::trace::NetworkTrace;
use crate::peers::{Builds, DynPeer, Laws};
use crate::user::{Trace, User, UserSettings};

mod check;
mod linear;
mod meant;
mod world;

pub use meant::{law_meant, nearest};
pub use world::{Device, DriveName, Jitter, Network, PlantFault, PlantSettings, World};

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
    pub(crate) at_home: bool,
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

/// A file, and the line of a byte of its text.
fn line(place: &str, text: &str, at: usize) -> String {
    format!("{place}:{}", text[..at.min(text.len())].matches('\n').count() + 1)
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
    /// converters, or the law is from outside: none of the program's own draws anything.
    pub fn draws(&self) -> bool {
        self.draws_packets() || self.world.plant.winding || self.has_outside_law()
    }

    /// Whether the scene's law is none of the program's own.
    pub(crate) fn has_outside_law(&self) -> bool {
        self.laws.outside().any(|name| name == self.peer.coordination.comm)
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
        let text = cohold_io::text(path, MOST).map_err(Error::cannot("read", &place))?;
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
        let wrong = |error: toml::de::Error| {
            let place = error.span().map_or_else(|| place.to_owned(), |span| line(place, text, span.start));
            Error::at(&place, error.message().replace('\n', " "))
        };
        let mut table: toml::Table = text.parse().map_err(wrong)?;
        // What made a file of results stands in its scene file too, and changes nothing.
        table.remove("made");
        let written = DeTable::parse(text).map_err(wrong)?;
        if let Some(base) = table.remove("base") {
            let at = written.get_ref().get_key_value("base").map_or(0, |(name, _)| name.span().start);
            self.apply_base(&base).map_err(|cause| Error::at(line(place, text, at), cause))?;
        }
        self.apply_table("", &table, written.get_ref(), &|at| line(place, text, at), folder)
    }

    /// Applies the built-in scene of this name, from which a file differs.
    fn apply_base(&mut self, base: &toml::Value) -> Result<(), Error> {
        let allowed = || Error::not_allowed(format!("base = {base}"), "it must be the name of a built-in scene");
        let name = base.as_str().ok_or_else(allowed)?;
        let text = crate::scenes::text(name).ok_or_else(|| crate::scenes::unknown(name))?;
        self.apply(text, name, None)
    }

    /// Applies a table whose text is where `written` says; `line` makes of a byte of the text a place to name.
    fn apply_table(
        &mut self,
        prefix: &str,
        table: &toml::Table,
        written: &DeTable<'_>,
        line: &dyn Fn(usize) -> String,
        folder: Option<&Path>,
    ) -> Result<(), Error> {
        for (name, value) in table {
            let key = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
            let Some((name, text)) = written.get_key_value(name.as_str()) else { continue };
            match (value, text.get_ref().as_table()) {
                (toml::Value::Table(inner), Some(written)) => self.apply_table(&key, inner, written, line, folder)?,
                _ => self.set(&key, value, &line(name.span().start), folder)?,
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
        self.set(key, &value_of(value), "--set", None)
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

    /// Whether the inertia of a device's joints couples its axes.
    pub fn is_coupled(&self) -> bool {
        self.devices().iter().any(|device| device.joint_inertia > 0.0)
    }

    /// Whether the object is shared along several axes.
    pub fn is_shared_along_several(&self) -> bool {
        self.peer.axis.shared > 1
    }

    /// Control periods from sensing to the force that comes of it: `device.force_delay_ticks`, or, with a winding in a current loop, the
    /// PWM period that the tick takes and the lag of the loop. That of a winding with more resistance than configured is longer, for more
    /// voltage has to add up.
    pub fn force_delay_ticks(&self) -> f64 {
        let plant = &self.world.plant;
        if !plant.winding || plant.drive == DriveName::Voltage {
            return self.world.device.force_delay_ticks;
        }
        let crossover = std::f64::consts::TAU * self.peer.motor.current_loop_hz;
        let warmer_s = (plant.resistance_ratio - 1.0) / crossover;
        // After a negative voltage the loop's first sample is half a period older: a quarter on the average.
        (0.75 * current::PWM_PERIOD_S + current::lag_s(&self.peer) + warmer_s) / self.peer.timing.control_period_s
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
