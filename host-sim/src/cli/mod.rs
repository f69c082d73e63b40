//! The command line: one file or folder per command, each a thin layer over the library.
//!
//! A command is `args.run(ui)`: results go to standard output (`--json`: one JSON document and nothing else), progress and
//! warnings to standard error, all of it through `ui::Ui`; flags that several commands take are declared in `flags`.
//! Exit status: 0 when the work was done (an unstable scene is a result), 1 when a live peer ended with a fault or was never let arm, 2 for
//! bad input, with one line that says what to change, 141 when whoever read the results went away.

mod accuracy;
mod address;
mod architectures;
mod bench;
mod board;
mod campaign;
mod columns;
mod cooperate;
mod device;
mod devices;
mod emulate;
mod entrants;
mod flags;
mod grid;
mod key;
mod listing;
mod listings;
mod live;
mod meeting;
mod network;
mod number;
mod paper;
mod play;
mod prove;
mod published;
mod recordings;
mod reproduce;
mod shared;
mod stability;
mod study;
mod sweep;
mod ui;
mod vectors;

use std::{error::Error, ffi::OsString, process::ExitCode};

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, FromArgMatches, Parser};
use clap_complete::Shell;

pub use device::device_options;
use flags::SceneArgs;
use haptic_live::devices::{Opens, Outside as OutsideDevice};
use haptic_report::Columns;
use haptic_sim::{Laws, scene::nearest};
pub use ui::provenance;
use ui::{Failure, Ui, Unsuccessful};

/// Declares a command, or a group of them, and runs whichever was asked for.
macro_rules! commands {
    ($(#[$doc:meta])* $Group:ident { $($(#[$about:meta])* $Name:ident($Args:ty)),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, clap::Subcommand)]
        pub(in crate::cli) enum $Group { $($(#[$about])* $Name($Args)),+ }

        impl $Group {
            pub(in crate::cli) fn run(&self, ui: &$crate::cli::Ui) -> Result<(), $crate::cli::Failure> {
                match self { $(Self::$Name(args) => args.run(ui)),+ }
            }
        }
    };
}
use commands;

/// Two people, two haptic devices, one shared virtual object, over a network: simulated, measured, proved.
///
/// Without a command: the cooperation paper's experiments (`paper`).
///
/// Exit status: 0 what was asked for is done, and good; 1 it is done and is not (`cooperate` unstable or apart, `stability point`
/// unstable, a peer with a fault or never armed); 2 it cannot be done, and one line says why.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version, disable_help_subcommand = true, mut_subcommands = negative_numbers)]
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

commands! {
    /// What host-sim does.
    Command {
        /// The cooperation paper's experiments, Figures 6-9 and its table of gains, beside the paper's own numbers.
        Paper(paper::Paper),
        /// Every table and figure of both papers, with a verdict on each claim: matched, holds in part, not matched, circular, not testable.
        Reproduce(reproduce::Reproduce),
        /// Hold it yourself: one object, two people in two browser windows or one and a partner, in real time on a page of this machine.
        Play(play::Play),
        /// Two peers hold one object: run a scene, report discrepancy, force, energy and stability.
        Cooperate(cooperate::Cooperate),
        /// Stability regions, limits and margins, computed from the code that flies.
        #[command(subcommand)]
        Stability(stability::Question),
        /// Forces stay within their limits, law by law: shown for every number from the code that flies.
        Prove(prove::Prove),
        /// Numbers of the laws' own papers beside what the laws do here.
        Published(published::Published),
        /// Every kind of communications over every kind of bad network: loss, bursts, jitter, reorder, drift.
        Campaign(campaign::Campaign),
        /// Laws beside each other, fairly: tuned by one search under the same bounds, tested on other networks; goes on where it was stopped.
        Bench(bench::Bench),
        /// Scenes or laws over ranges of their keys, networks and seeds: which is best where, and how sure that is; goes on where it was stopped.
        Study(study::Study),
        /// A scene over ranges of its keys and over seeds: a row a run, means with their intervals; goes on where it was stopped.
        Sweep(sweep::Sweep),
        /// The same task in every architecture: coherency, force, stability and bandwidth side by side, to choose by.
        Architectures(architectures::Architectures),
        /// Speed against error: every numerical choice, and what each model adds to a tick; f32 and fixed point beside f64.
        Accuracy(accuracy::Accuracy),
        /// One peer in real time over UDP, sealed; run two of them.
        Peer(live::Peer),
        /// What is attached to this machine, and ten steps to try one of them by, the smallest force first; writes what a scene needs of it.
        /// `devices emulate` is a device where none is.
        Devices(devices::Devices),
        /// Where 2 to 16 live peers hold one object: their wave lines meet in the lossless node, over UDP, sealed.
        Hub(live::Hub),
        /// A meeting place for two homes: rendezvous, STUN and a blind relay for sealed datagrams, on one UDP port.
        Meet(meeting::Meet),
        /// Make a table of a recording: Parquet or CSV; also of one that was cut.
        Convert(recordings::Convert),
        /// True discrepancy of a live run: the recordings of both ends on a common clock, with the error that the clock leaves.
        Merge(recordings::Merge),
        /// What is in the files: every column of every kind of table, with unit and meaning.
        Columns(columns::Args),
        /// Keys of sealed lines: make one, or turn it into a board's.
        #[command(subcommand)]
        Key(key::Key),
        /// A board on the bench: lines to it, calibration, recordings for another processor.
        #[command(subcommand)]
        Board(board::Board),
        /// A bad network for real, a recording of one, and what a network between two machines does.
        #[command(subcommand)]
        Network(network::Network),
        /// The shared environments of the architectures paper: one engine, taking turns, a game, a world to visit.
        #[command(subcommand)]
        Shared(shared::Shared),
    }
}

/// A flag that takes a value takes a negative number too: it is out of range, and no flag of its own.
fn negative_numbers(command: clap::Command) -> clap::Command {
    let takes = |arg: clap::Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(takes).mut_subcommands(negative_numbers)
}

/// What a command from outside does with its arguments.
type Does = dyn Fn(&clap::ArgMatches, Laws) -> Result<Columns, Failure>;

/// A command from outside: its name, its arguments as clap has them, and what it does.
struct Outside {
    name: &'static str,
    declare: fn(clap::Command) -> clap::Command,
    run: Box<Does>,
}

/// The command line of `host-sim`.
pub struct Cli {
    laws: Laws,
    outside: Vec<Outside>,
    devices: Vec<OutsideDevice>,
}

impl Default for Cli {
    /// With the laws of core and of other papers.
    fn default() -> Self {
        Self::new(haptic_guest_laws::laws())
    }
}

impl Cli {
    /// With these laws, in every command.
    pub fn new(laws: Laws) -> Self {
        Self { laws, outside: Vec::new(), devices: Vec::new() }
    }

    /// Adds a command of this name. Its arguments are `A`, which clap derives, with doc comments as help; its result is printed as a
    /// table, or with `--json` as a list with an object for each row.
    ///
    /// ```no_run
    /// use haptic_report::Columns;
    /// use haptic_sim::{Laws, Scene};
    ///
    /// /// Control periods in a packet period of the default scene, times what is asked for.
    /// #[derive(clap::Args)]
    /// struct Packets {
    ///     /// How many packet periods.
    ///     #[arg(long, default_value = "1")]
    ///     count: u32,
    /// }
    ///
    /// let packets = |asked: &Packets, laws: Laws| {
    ///     let ticks = asked.count * Scene::new(laws).peer.timing.ticks_per_packet;
    ///     Ok(Columns::of(&[()]).value("ticks", |()| ticks).done())
    /// };
    /// host_sim::Cli::default().with_command("packets", packets).main();
    /// ```
    #[must_use]
    pub fn with_command<A: clap::Args + 'static>(
        mut self,
        name: &'static str,
        run: impl Fn(&A, Laws) -> Result<Columns, Box<dyn Error + Send + Sync>> + 'static,
    ) -> Self {
        let run = Box::new(move |matches: &clap::ArgMatches, laws| run(&A::from_arg_matches(matches)?, laws));
        self.outside.push(Outside { name, declare: A::augment_args, run });
        self
    }

    /// Adds an adapter of a device: `--device NAME[:PLACE]` opens it, with what stands after the colon and what else is told of it. Axes,
    /// origin, ages and refusals are done for it, as for a built-in one.
    #[must_use]
    pub fn with_device(mut self, name: &'static str, open: Opens) -> Self {
        self.devices.push(OutsideDevice { name, open });
        self
    }

    /// Runs the command line of this process.
    pub fn main(self) -> ExitCode {
        let vectors = vectors::widest();
        let words: Vec<OsString> = std::env::args_os().collect();
        let mut ui = Ui::new(words.iter().any(|word| word == "--json"), self.laws);
        ui.devices.clone_from(&self.devices);
        let outcome = match (vectors, listed(&ui, &words)) {
            (Err(refused), _) => Err(refused),
            (Ok(()), Some(outcome)) => outcome,
            (Ok(()), None) => match self.command().try_get_matches_from(&words) {
                Ok(matches) => self.run(&ui, &matches),
                // Help and version are no errors.
                Err(answer) if !answer.use_stderr() => {
                    let _ = answer.print();
                    Ok(())
                }
                Err(error) => Err(refusal(&error).into()),
            },
        };
        match outcome {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                haptic_io::say(format_args!("host-sim: {}", haptic_io::escaped(&error.to_string())));
                ExitCode::from(if error.is::<Unsuccessful>() { 1 } else { 2 })
            }
        }
    }

    /// Every command, those from outside last.
    fn command(&self) -> clap::Command {
        let outside = self.outside.iter().map(|outside| (outside.declare)(clap::Command::new(outside.name)));
        CommandLine::command().subcommands(outside.map(negative_numbers))
    }

    fn run(&self, ui: &Ui, matches: &clap::ArgMatches) -> Result<(), Failure> {
        if let Some((name, matches)) = matches.subcommand()
            && let Some(outside) = self.outside.iter().find(|outside| outside.name == name)
        {
            return ui.result(&(outside.run)(matches, self.laws)?);
        }
        let line = CommandLine::from_arg_matches(matches)?;
        if let Some(shell) = line.completions {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut self.command(), "host-sim", &mut script);
            write!(Ui::new(false, self.laws), "{}", String::from_utf8(script)?);
            return Ok(());
        }
        line.command.unwrap_or_else(|| Command::Paper(paper::Paper::default())).run(ui)
    }
}

/// What `--keys` and `--scenes` list wherever a scene or a world is asked for; whatever else is missing there, as with `--help`.
fn listed(ui: &Ui, words: &[OsString]) -> Option<Result<(), Failure>> {
    let whole = CommandLine::command();
    let command = words.iter().fold(&whole, |command, word| command.find_subcommand(word).unwrap_or(command));
    let has = |name| command.get_arguments().any(|arg| arg.get_id() == name);
    let asked = |flag: &str| words.iter().any(|word| word == flag);
    match () {
        () if asked("--keys") && has("keys") => Some(listings::scene_keys(ui)),
        () if asked("--keys") && has("world-keys") => Some(listings::world_keys(ui)),
        () if asked("--scenes") && has("scenes") => Some(listings::scenes(ui)),
        () => None,
    }
}

/// What is wrong with the arguments, in one line.
fn refusal(error: &clap::Error) -> String {
    let texts = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => vec![text.as_str()],
        Some(ContextValue::Strings(texts)) => texts.iter().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    let text = |kind| texts(kind).last().copied();
    let value = text(ContextKind::InvalidArg).zip(text(ContextKind::InvalidValue)).zip(error.source());
    if let Some(((flag, value), cause)) = value.filter(|_| error.kind() == ErrorKind::ValueValidation) {
        let flag = flag.split(' ').next().unwrap_or(flag);
        return format!("{flag} {value} is not allowed: {cause}");
    }
    let rendered = error.to_string();
    let said: Vec<&str> = rendered.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
    let here = texts(ContextKind::SuggestedSubcommand);
    let command = text(ContextKind::InvalidSubcommand).and_then(|word| nearest(word, here.iter().copied()));
    let hint = match command.or(text(ContextKind::SuggestedArg)).or(text(ContextKind::SuggestedValue)) {
        Some(near) => format!("did you mean {near}?"),
        None => "--help lists what there is".to_owned(),
    };
    format!("{} ({hint})", said.join(" ").trim_start_matches("error: "))
}
