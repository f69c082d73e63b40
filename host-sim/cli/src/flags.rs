//! Flags that mean the same everywhere, declared once: scene, world, time, output folder, key file, patience; and how numbers
//! and closed words are read.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Arg, ArgAction, Args, ValueEnum};
use cohold_board_tools::calibrate::settings_file;
use cohold_core::names::Choice;
use cohold_live::key_file;
use cohold_live::recording::mcap::Channel;
use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::recording::ticks::name_of;
use cohold_live::tell::Manner;
use cohold_live::watch::LiveOptions;
use cohold_protocol::key::{Key, Role};
use cohold_report::Provenance;
use cohold_sim::run::Account;
use cohold_sim::scene::{MOST, Scene};
use cohold_sim::scenes;

use super::address::endpoint;
use super::ui::{Failure, Ui};

pub use super::number::number;
pub use super::ui::Out;

/// Longest time that may be asked for, s: a day. Beyond it, sums of ticks of 1 ms in f64 begin to round.
const LONGEST_S: f64 = 86_400.0;
/// Longest time of what runs by the clock, s: 100 years, which is no limit but for slips of the pen.
const LONGEST_LIVE_S: f64 = 3.2e9;

/// The help of a `--scene` that has a default.
pub const SCENE: &str = "Scene file (TOML) or the name of a built-in scene";

/// Which scene, and what to change in it.
#[derive(Clone, Debug, Args)]
#[command(arg(listing("keys", "List every key of a scene: unit, default, range, meaning")))]
#[command(arg(listing("scenes", "List the built-in scenes")))]
pub struct SceneArgs {
    /// Scene file (TOML) or the name of a built-in scene; without it, the cooperation paper's defaults.
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<PathBuf>,
    /// Override one key of the scene; may be repeated.
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// Seed of everything random in the run, as `--set network.seed=N`.
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
}

impl SceneArgs {
    /// This scene, as it is.
    pub fn of(scene: &Path) -> Self {
        Self { scene: Some(scene.to_owned()), set: Vec::new(), seed: None }
    }

    /// Whether nothing is said of the scene.
    pub fn is_plain(&self) -> bool {
        self.scene.is_none() && self.set.is_empty() && self.seed.is_none()
    }

    /// As [`Self::load`]. Where no scene is named, the built-in one of this name, whose users do not push.
    pub fn load_or(&self, ui: &Ui, name: &str) -> Result<Scene, Failure> {
        if self.scene.is_some() {
            return self.load(ui);
        }
        let still = [1, 2].map(|number| format!("user.{number}.push_n=0"));
        Self { scene: Some(name.into()), set: [&still, &self.set[..]].concat(), seed: self.seed }.load(ui)
    }

    /// The scene.
    pub fn load(&self, ui: &Ui) -> Result<Scene, Failure> {
        self.load_with(ui, &[], None)
    }

    /// As [`Self::load`], of an object that is shared along one axis.
    pub fn load_of_one_axis(&self, ui: &Ui) -> Result<Scene, Failure> {
        let scene = self.load(ui)?;
        scene.check_one_axis(&self.name())?;
        Ok(scene)
    }

    /// As [`Self::load`]; `base` is set first where no scene is named, `last` after everything else.
    pub fn load_with(&self, ui: &Ui, base: &[&str], last: Option<String>) -> Result<Scene, Failure> {
        let scene = self.find(ui, base, last)?;
        scene.check(&self.name())?;
        Ok(scene)
    }

    fn find(&self, ui: &Ui, base: &[&str], last: Option<String>) -> Result<Scene, Failure> {
        self.built_in()?;
        let base = base.iter().filter(|_| self.scene.is_none()).map(|key| (*key).to_owned());
        let seed = self.seed.map(|seed| format!("network.seed={seed}"));
        let overrides: Vec<String> = base.chain(self.set.iter().cloned()).chain(seed).chain(last).collect();
        scenes::find(ui.laws, self.scene.as_deref(), &overrides).map_err(|error| {
            let hint = if error.is_unlike() { "; --keys lists them all" } else { "" };
            format!("{error}{hint}").into()
        })
    }

    /// This scene, with settings of a peer under what it says: of keys that neither it nor its overrides name, for both peers or for that
    /// one. Each is the key, and its override for the peer `number`.
    pub fn over(&self, number: u8, beneath: &[(&str, String)]) -> Result<Self, Failure> {
        let named = self.named()?;
        let own = format!("peer.{number}");
        let says = |key: &str| named.iter().any(|name| name == key || *name == format!("{own}.{key}") || *name == own);
        let first = beneath.iter().filter(|(key, _)| !says(key)).map(|(_, set)| set.clone());
        Ok(Self { set: first.chain(self.set.iter().cloned()).collect(), ..self.clone() })
    }

    /// The built-in scene that is meant, if one is.
    fn built_in(&self) -> Result<Option<&str>, Failure> {
        scenes::meant(self.scene.as_deref()).map_err(|error| format!("--scene {error}").into())
    }

    /// The keys that the scene and its overrides name, as `table.key`.
    pub fn named(&self) -> Result<Vec<String>, Failure> {
        let text = match (&self.scene, self.built_in()?) {
            (_, Some(name)) => scenes::text(name).unwrap_or_default().to_owned(),
            (Some(path), _) => {
                cohold_io::text(path, MOST).map_err(cohold_sim::Error::cannot("read", &path.display()))?
            }
            (None, None) => String::new(),
        };
        let set = self.set.iter().filter_map(|text| text.split_once('=')).map(|(key, _)| key.trim().to_owned());
        Ok(settings_file::named(&text).into_iter().chain(set).collect())
    }

    /// The scene that is named, if one is, and the settings over it.
    pub fn parts(&self) -> (Option<&Path>, Vec<String>) {
        let seed = self.seed.map(|seed| format!("network.seed={seed}"));
        (self.scene.as_deref(), self.set.iter().cloned().chain(seed).collect())
    }

    /// Whether anything is said of the scene.
    pub fn is_given(&self) -> bool {
        self.scene.is_some() || !self.set.is_empty() || self.seed.is_some()
    }

    /// Name of the files of a run: the scene's, and where keys were overridden what tells these settings from others; the
    /// seed, where it is another one than usual.
    pub fn run_name(&self, scene: &Scene) -> String {
        let mut name = self.name();
        if !self.set.is_empty() {
            name += &format!("-{:08x}", scene.fingerprint());
        }
        let seed = scene.world.network.seed;
        if seed == Scene::default().world.network.seed { name } else { format!("{name}-seed{seed}") }
    }

    /// Short name of the scene, for file names and headings.
    pub fn name(&self) -> String {
        if let Ok(Some(name)) = self.built_in() {
            return name.to_owned();
        }
        let stem = self.scene.as_ref().and_then(|path| path.file_stem());
        stem.map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// The number type the peers compute in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum ScalarName {
    /// What flies on the board.
    F32,
    /// What the analyser drives.
    #[default]
    F64,
    /// Fixed point, I32F32.
    I32f32,
}

/// A flag that is answered as `--help` is, whatever else is missing: see [`super::listings`].
pub fn listing(name: &'static str, help: &'static str) -> Arg {
    Arg::new(name).long(name).action(ArgAction::SetTrue).help(help)
}

/// How long.
#[derive(Clone, Copy, Debug, Args)]
pub struct Time {
    /// How long, s; a simulated run in simulated time.
    #[arg(long, default_value = "20", value_name = "S", value_parser = seconds)]
    pub seconds: f64,
}

impl Time {
    /// A run of this scene has a tick at least.
    pub fn check(self, scene: &Scene) -> Result<(), Failure> {
        let period_s = scene.peer.timing.control_period_s;
        if self.seconds >= period_s {
            return Ok(());
        }
        let message = "is not allowed: it must be a number from";
        Err(format!("--seconds {} {message} {period_s} (one control period) to {LONGEST_S} s", self.seconds).into())
    }
}

/// One end of sealed lines over UDP, and how long it runs.
#[derive(Clone, Debug, Args)]
pub struct End {
    /// Where this end listens; port 0 is any.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    pub listen: SocketAddr,
    /// Its key.
    #[command(flatten)]
    pub key: KeyFile,
    /// How long it runs.
    #[command(flatten)]
    pub time: LiveTime,
}

/// How long, by the clock.
#[derive(Clone, Copy, Debug, Args)]
pub struct LiveTime {
    /// How long, s.
    #[arg(long, default_value = "20", value_name = "S", value_parser = live_seconds)]
    pub seconds: f64,
}

/// What is recorded of a live command, and what it says while it runs.
#[derive(Clone, Debug, Args)]
pub struct Watching {
    #[command(flatten)]
    record: RecordTo,
    /// What it says.
    #[command(flatten)]
    pub telling: Telling,
}

impl Watching {
    /// As the live commands take it.
    pub fn wanted(&self, provenance: Provenance) -> LiveOptions {
        LiveOptions {
            record: self.record.record.clone().map(|file| (file, provenance)),
            manner: self.telling.manner(),
            ..LiveOptions::default()
        }
    }
}

/// What a live command says while it runs.
#[derive(Clone, Copy, Debug, Args)]
pub struct Telling {
    /// Say nothing while it runs; without it, a line each second and what happens in between.
    #[arg(long)]
    quiet: bool,
    /// Say each second, each event and in the end the report as a JSON object, one a line, on standard output.
    #[arg(long, conflicts_with = "quiet")]
    pub json_lines: bool,
}

impl Telling {
    /// The same, as a live command has it.
    pub fn manner(self) -> Manner {
        match (self.json_lines, self.quiet) {
            (true, _) => Manner::Json,
            (_, true) => Manner::Quiet,
            _ => Manner::Words,
        }
    }
}

/// A recording.
#[derive(Clone, Debug, Args)]
pub struct RecordTo {
    /// Record every tick in this file, NAME.mcap, while it runs; it must not be there yet. `cohold recording convert` makes Parquet or CSV of it.
    #[arg(long, value_name = "FILE", value_parser = recording)]
    pub record: Option<PathBuf>,
}

impl RecordTo {
    /// Begins a recording of both peers in simulated time, if one is wanted: a channel for each of so many shared axes.
    pub(super) fn simulated(&self, provenance: &Provenance, axes: usize) -> Result<Option<Recorder>, Failure> {
        let channel = |axis| Channel::new(format!("/both/{}", name_of(axis)), "Tick", Account::columns());
        let (origin, channels) = (Origin::simulated(provenance, "both peers"), (0..axes).map(channel).collect());
        Ok(self.record.as_ref().map(|file| Recorder::create(file, &origin, channels)).transpose()?)
    }
}

/// What is asked of a run in memory.
#[derive(Clone, Debug, Args)]
pub(super) struct Simulation {
    #[command(flatten)]
    pub(super) time: Time,
    /// Number type of the peers.
    #[arg(long, value_enum, default_value_t)]
    pub(super) scalar: ScalarName,
    #[command(flatten)]
    pub(super) record: RecordTo,
    #[command(flatten)]
    pub(super) out: Out,
}

/// How long a live command calls before it gives up.
#[derive(Clone, Copy, Debug, Args)]
pub struct Patience {
    /// How long to call the others before giving up, s.
    #[arg(long, default_value = "30", value_name = "S", value_parser = live_seconds)]
    pub patience_s: f64,
}

/// The key of a sealed line.
#[derive(Clone, Debug, Args)]
pub struct KeyFile {
    /// Key file, the same at both ends (`cohold key generate`).
    #[arg(long, value_name = "FILE")]
    pub key_file: PathBuf,
}

impl KeyFile {
    /// The key in this file.
    pub fn read(&self) -> Result<Key, Failure> {
        Ok(key_file::read(&self.key_file, Role::Peers)?)
    }
}

/// A time on the command line.
pub fn seconds(text: &str) -> Result<f64, Failure> {
    up_to(LONGEST_S, text)
}

/// A time by the clock on the command line.
pub fn live_seconds(text: &str) -> Result<f64, Failure> {
    up_to(LONGEST_LIVE_S, text)
}

fn up_to(longest_s: f64, text: &str) -> Result<f64, Failure> {
    let seconds = text.parse().ok().filter(|seconds| *seconds > 0.0 && *seconds <= longest_s);
    seconds.ok_or_else(|| format!("it must be above 0 and up to {longest_s} s").into())
}

/// The name of a recording that is to be made: what its ending says is what it is.
fn recording(text: &str) -> Result<PathBuf, Failure> {
    let file = PathBuf::from(text);
    let is_mcap = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    is_mcap
        .then_some(file)
        .ok_or_else(|| "a recording ends in .mcap; `cohold recording convert` makes CSV or Parquet of it".into())
}

/// One of the names of a closed list, on the command line.
pub fn choice<C: Choice + Send + Sync>() -> impl TypedValueParser<Value = C> {
    PossibleValuesParser::new(C::NAMES).try_map(|name| C::from_name(&name).ok_or("there is no such name"))
}

/// `on` or `off`.
pub fn switch() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(["on", "off"]).map(|word| word == "on")
}
