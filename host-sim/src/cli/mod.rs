//! The command line: one file per command, each a thin layer over the library.
//!
//! Results go to standard output (`--json`: one JSON document and nothing else), progress and warnings to standard error.
//! Exit status: 0 when the work was done (an unstable scene is a result), 2 for bad input, with one line that says what to
//! change, 141 when whoever read the results went away.

mod accuracy;
mod architectures;
mod calibrate;
mod campaign;
mod collaborate;
mod cooperate;
mod cooperative;
mod crowd;
mod flood;
mod hub;
mod keys;
mod live;
mod operator;
mod paper;
mod precision;
mod record;
mod rendering;
mod restarts;
mod serve;
mod shape;
mod squash;
mod stability;
mod tune;
mod ui;
mod visit;
mod world;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;

use haptic_sim::report::Made;
use haptic_sim::scene::{Scene, SceneError};
use haptic_sim::scenes;
use ui::Ui;

/// What a command may fail with.
pub(super) type Failure = Box<dyn std::error::Error>;

/// Two people, two haptic devices, one shared virtual object, over a network: simulated, measured, proved.
///
/// Without a command: the cooperation paper's experiments (`paper`).
#[derive(Debug, Parser)]
#[command(name = "host-sim", version, arg_required_else_help = false)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// Print the result as one JSON document, and nothing else on standard output; files are written only with --out.
    #[arg(long, global = true)]
    json: bool,
    /// Print completions of this command line for a shell, and nothing else.
    #[arg(long, value_name = "SHELL")]
    completions: Option<Shell>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Two peers hold one object: run a scene, report discrepancy, force, energy and stability.
    Cooperate(cooperate::Cooperate),
    /// Many users push one object that one dynamics engine moves: limits, bounder, hand-over.
    Cooperative(cooperative::Cooperative),
    /// The same task in every architecture: coherency, force, stability and bandwidth side by side, to choose by.
    Architectures(architectures::Architectures),
    /// The cooperation paper's experiments, Figures 6-9 and its table of gains, beside the paper's own numbers.
    Paper(paper::Paper),
    /// Stability regions, limits and margins, computed from the code that flies.
    Stability(stability::Stability),
    /// How far f32 and fixed point stray from f64, scene by scene.
    Precision(precision::Precision),
    /// Speed against error: every numerical choice, and what each model adds to a tick.
    Accuracy(accuracy::Accuracy),
    /// Every kind of communications over every kind of bad network: loss, bursts, jitter, reorder, drift.
    Campaign(campaign::Campaign),
    /// One at a time edits an object, by a lock or a token ring, over everything that can go wrong.
    Collaborate(collaborate::Collaborate),
    /// Force Feedback Multi-player Squash: 2 to 8 bots play over a network, with the bounders or without.
    Squash(squash::Squash),
    /// What a board's encoders and motors are, found together with the person at it; leaves a settings file.
    Calibrate(calibrate::Calibrate),
    /// Make a key file: for two peers, or for one line of a server or hub.
    Keygen(live::Keygen),
    /// The key as a board keeps it in flash, for `cargo xtask provision`.
    KeyImage(live::KeyImage),
    /// One peer in real time over UDP, sealed; run two of them.
    Peer(live::Peer),
    /// Where 2 to 16 live peers hold one object: their wave lines meet in the lossless node, over UDP, sealed.
    Hub(hub::Hub),
    /// Say lines to a board: arm, stop, set up; sealed.
    Operator(operator::Operate),
    /// A bad network between two peers.
    Relay(live::Relay),
    /// A server of a static world over UDP: the whole world, or one region of it.
    Serve(serve::Serve),
    /// A client of one or several servers: downloads a world and feels it.
    Visit(visit::Visit),
    /// Very many clients at one server: how many it holds, and where it bends.
    Crowd(crowd::Crowd),
    /// Every key of a world file, or what a world holds.
    World(world::World),
    /// A hand strokes along an object of a world and pushes it about: force, depth at corners, energy.
    Shape(shape::ShapeArgs),
    /// Write down what a scene's network does to every packet.
    Trace(live::Trace),
    /// Forged datagrams by the hundred thousand against two peers on loopback: what they change, and what comes through.
    Flood(flood::Flood),
    /// Peers that restart at random instants, in virtual time: how soon and how gently they are together again.
    Restarts(restarts::Restarts),
    /// What one peer of a scene reads, for the same peer on another processor.
    Record(record::Record),
    /// Every key of a scene file: unit, default, range, meaning.
    Keys(keys::Keys),
}

/// Which scene, and what to change in it.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// Scene file (TOML) or the name of a built-in one; without it, the cooperation paper's defaults.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// Override one key of the scene; may be repeated.
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
}

impl SceneArgs {
    /// The scene, checked.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn load(&self) -> Result<Scene, SceneError> {
        match self.built_in() {
            Some(name) => self.changed(name),
            None => Scene::load(self.scene.as_deref(), &self.set),
        }
    }

    /// As [`Self::load`]; without a scene, the built-in one called `name`.
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn load_or(&self, name: &str) -> Result<Scene, SceneError> {
        if self.scene.is_some() { self.load() } else { self.changed(name) }
    }

    /// A built-in scene with the overrides.
    fn changed(&self, name: &str) -> Result<Scene, SceneError> {
        let mut scene = scenes::load(name)?;
        for text in &self.set {
            scene.apply_override(text)?;
        }
        scene.check(name)?;
        Ok(scene)
    }

    /// The name of the built-in scene that is meant, if there is no such file.
    fn built_in(&self) -> Option<&str> {
        let path = self.scene.as_ref().filter(|path| !path.exists())?;
        path.to_str().filter(|name| scenes::text(name).is_some())
    }

    /// Whether any of it was given.
    pub(super) fn is_given(&self) -> bool {
        self.scene.is_some() || !self.set.is_empty()
    }

    /// Short name of the scene, for file names and headings.
    pub fn name(&self) -> String {
        self.name_or("scene")
    }

    /// Name of the files of a run: the scene's, and where keys were overridden what tells these settings from others; the
    /// seed, where it is another one than usual.
    pub(super) fn run_name(&self, scene: &Scene) -> String {
        let mut name = self.name();
        if !self.set.is_empty() {
            name += &format!("-{:08x}", scene.fingerprint());
        }
        let seed = scene.world.network.seed;
        if seed == Scene::default().world.network.seed { name } else { format!("{name}-seed{seed}") }
    }

    /// As [`Self::name`]; without a scene, `name`.
    pub fn name_or(&self, name: &str) -> String {
        if let Some(name) = self.built_in() {
            return name.to_owned();
        }
        let stem = self.scene.as_ref().and_then(|path| path.file_stem());
        stem.map_or_else(|| name.to_owned(), |stem| stem.to_string_lossy().into_owned())
    }
}

/// Runs the command line of this process.
pub fn main() -> ExitCode {
    let line = match CommandLine::try_parse() {
        Ok(line) => line,
        Err(error) => {
            // Help and version are no errors; anything else is bad input, said in one line.
            if !error.use_stderr() {
                let _ = error.print();
                return ExitCode::SUCCESS;
            }
            let text = error.to_string();
            let said: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
            eprintln!("host-sim: {} (--help lists what there is)", said.join(" ").trim_start_matches("error: "));
            return ExitCode::from(2);
        }
    };
    if let Some(shell) = line.completions {
        clap_complete::generate(shell, &mut CommandLine::command(), "host-sim", &mut std::io::stdout());
        return ExitCode::SUCCESS;
    }
    let ui = Ui::new(line.json);
    let outcome = match line.command.unwrap_or_else(|| Command::Paper(paper::Paper::default())) {
        Command::Cooperate(command) => command.run(&ui),
        Command::Cooperative(command) => command.run(&ui),
        Command::Architectures(command) => command.run(&ui),
        Command::Paper(command) => command.run(&ui),
        Command::Stability(command) => command.run(&ui),
        Command::Precision(command) => command.run(&ui),
        Command::Accuracy(command) => command.run(&ui),
        Command::Campaign(command) => command.run(&ui),
        Command::Collaborate(command) => command.run(&ui),
        Command::Squash(command) => command.run(&ui),
        Command::Calibrate(command) => command.run(&ui),
        Command::Keygen(command) => command.run(&ui),
        Command::KeyImage(command) => command.run(&ui),
        Command::Peer(command) => command.run(&ui),
        Command::Hub(command) => command.run(&ui),
        Command::Operator(command) => command.run(&ui),
        Command::Relay(command) => command.run(&ui),
        Command::Serve(command) => command.run(&ui),
        Command::Visit(command) => command.run(&ui),
        Command::Crowd(command) => command.run(&ui),
        Command::World(command) => command.run(&ui),
        Command::Shape(command) => command.run(&ui),
        Command::Trace(command) => command.run(&ui),
        Command::Flood(command) => command.run(&ui),
        Command::Restarts(command) => command.run(&ui),
        Command::Record(command) => command.run(&ui),
        Command::Keys(command) => command.run(&ui),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("host-sim: {error}");
            ExitCode::from(2)
        }
    }
}

/// This program, from now on: what its files say of what made them.
pub fn made() -> Made {
    Made::now(env!("CARGO_PKG_VERSION"), option_env!("HOST_SIM_COMMIT").unwrap_or("unknown"))
}

/// Whether the system granted real-time priority, in a report's words.
fn granted(priority: bool) -> &'static str {
    if priority { "yes" } else { "no, the system did not allow it" }
}
