//! The command line of the heart, and the doors by which guests add to it: one file or folder per command, each a thin layer over the
//! library.
//!
//! A command is `args.run(ui)`: results go to standard output (`--json`: one JSON document and nothing else), progress and
//! warnings to standard error, all of it through [`Ui`]; flags that several commands take are declared in [`flags`].
//! Exit status: 0 when the work was done (an unstable scene is a result), 1 when a live peer ended with a fault or was never let arm, 2 for
//! bad input, with one line that says what to change, 141 when whoever read the results went away.
//!
//! | a guest adds | by |
//! |---|---|
//! | laws | [`Cli::with_laws`], and the proofs of their limits by [`Cli::with_proofs`] |
//! | commands | [`Cli::with_commands`]; of one that only gives a table [`Cli::with_command`] |
//! | a list that a flag asks for | [`Cli::with_listing`] |
//! | headings for the commands in the help | [`Cli::with_groups`] |
//! | kinds of tables, for `recording columns` | [`Cli::with_tables`] |
//! | claims of a paper, for `paper reproduce` | [`Cli::with_paper`] |
//! | a road, by which an end is met | [`Cli::with_road`] |
//! | adapters of devices | [`Cli::with_device`] |
//! | environments for the page | [`Cli::with_environments`] |
#![forbid(unsafe_code)]

mod accuracy;
pub mod address;
mod bench;
pub mod board;
mod campaign;
pub mod columns;
mod cooperate;
pub mod device;
mod devices;
pub mod flags;
mod grid;
mod key;
mod listing;
pub mod listings;
pub mod live;
pub mod live_peer;
mod network;
mod number;
mod paper;
mod prove;
pub mod recordings;
mod reproduce;
pub mod road;
mod scene;
mod stability;
mod study;
mod sweep;
pub mod ui;
mod vectors;

use std::{error::Error as _, ffi::OsString, process::ExitCode, sync::Arc};

use clap::builder::Resettable;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;

use cohold_live::devices::{Adapter, Opens};
use cohold_live::playable::Playable;
use cohold_report::Columns;
use cohold_sim::{Laws, scene::nearest};
use cohold_studies::{proof::Prover, reproduce::Paper};
use columns::TableKind;
pub use device::device_options;
pub use flags::SceneArgs;
use road::Meets;
use ui::Unsuccessful;
pub use ui::{Failure, Ui, provenance};

/// Declares a command, or a group of them, and runs whichever was asked for.
#[macro_export]
macro_rules! commands {
    ($(#[$doc:meta])* $vis:vis $Group:ident { $($(#[$about:meta])* $Name:ident($Args:ty)),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, ::clap::Subcommand)]
        $vis enum $Group { $($(#[$about])* $Name($Args)),+ }

        impl $Group {
            pub(crate) fn run(&self, ui: &$crate::Ui) -> Result<(), $crate::Failure> {
                match self { $(Self::$Name(args) => args.run(ui)),+ }
            }
        }

        impl $crate::Commands for $Group {
            fn run(&self, ui: &$crate::Ui) -> Result<(), $crate::Failure> {
                Self::run(self, ui)
            }
        }
    };
}

/// A group of commands, as [`commands!`] declares it.
pub trait Commands: Subcommand {
    /// Runs whichever was asked for.
    ///
    /// # Errors
    /// It could not do what was asked, or the result is no good one.
    fn run(&self, ui: &Ui) -> Result<(), Failure>;

    /// Completes the commands with values from other guests.
    fn told(commands: clap::Command, _: &Ui) -> clap::Command {
        commands
    }
}

/// Two people hold one virtual object over a network. Simulates, measures and proves it.
///
/// Without a command it runs the cooperation paper's experiments (`paper`).
///
/// Exit status: 0 done, with a good result. 1 done, with a bad result, for example an unstable scene, or a peer that stopped with a
/// fault or never armed. 2 not done; one line names the reason.
#[derive(Debug, Parser)]
#[command(name = "cohold", version, disable_help_subcommand = true)]
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
    /// What cohold does.
    pub(crate) Command {
        /// Run the cooperation paper's experiments and compare them with its numbers.
        #[command(args_conflicts_with_subcommands = true)]
        Paper(paper::Paper),
        /// Simulate two peers that hold one object: position error, force, energy and stability.
        Cooperate(cooperate::Cooperate),
        /// Write a scene file to start from.
        #[command(subcommand)]
        Scene(scene::Scene),
        /// Compute stability from the firmware's own code: verdict, limit, map, gains, or proof.
        #[command(subcommand)]
        Stability(stability::Question),
        /// Compare scenes or laws over settings, networks and seeds, with confidence intervals.
        ///
        /// It resumes where it was stopped.
        #[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
        Study(study::Study),
        /// Measure the error and the cost of each numerical choice.
        Accuracy(accuracy::Accuracy),
        /// Run one peer in real time over an encrypted UDP line. Start two of them.
        Peer(live::Peer),
        /// List attached devices, test one in ten steps from the smallest force up, or emulate one.
        Devices(devices::Devices),
        /// Convert recordings, merge two of them on one clock, and explain their columns.
        #[command(subcommand)]
        Recording(recordings::RecordingCommands),
        /// Make a key file for peers, a hub or a board.
        #[command(subcommand)]
        Key(key::Key),
        /// Operate a board: arm, calibrate, bring up, update, read its log.
        #[command(subcommand)]
        Board(board::Board),
        /// Measure a network, record it, or put a bad one between two machines.
        #[command(subcommand)]
        Network(network::Network),
    }
}

/// This command with what is added, described as before: clap would take the comment on a group for its description.
fn as_described(command: clap::Command, add: impl FnOnce(clap::Command) -> clap::Command) -> clap::Command {
    let [about, long] = [command.get_about(), command.get_long_about()].map(|text| Resettable::from(text.cloned()));
    add(command).about(about).long_about(long)
}

/// With its commands under these headings, and behind them those that are under none.
fn grouped(command: clap::Command, groups: Groups) -> clap::Command {
    let is_under = |name: &str| groups.iter().any(|(_, names)| names.contains(&name));
    let names = command.get_subcommands().map(clap::Command::get_name);
    let others: Vec<&str> = names.filter(|name| !is_under(name)).collect();
    let line = |name: &&str| Some(format!("  {name:<11}{}\n", command.find_subcommand(name)?.get_about()?));
    let mut text = String::new();
    for (heading, names) in groups.iter().copied().chain([("Commands", &others[..])]).filter(|of| !of.1.is_empty()) {
        text += &format!("{heading}:\n{}\n", names.iter().filter_map(line).collect::<String>());
    }
    command.help_template(format!("{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{text}Options:\n{{options}}"))
}

/// A flag that takes a value takes a negative number too: it is out of range, and no flag of its own.
fn negative_numbers(command: clap::Command) -> clap::Command {
    let takes = |arg: clap::Arg| if arg.get_action().takes_values() { arg.allow_negative_numbers(true) } else { arg };
    command.mut_args(takes).mut_subcommands(negative_numbers)
}

/// What a command that was added does with what clap has read of the line.
type Does = dyn Fn(&clap::ArgMatches, &Ui) -> Result<(), Failure>;
/// Tells clap of commands.
type Declares = dyn Fn(clap::Command, &Ui) -> clap::Command;

/// Commands that a guest adds below one of the heart's, or below none: how clap is told of them, whether a word is one of them, and what is
/// done with the words behind it.
struct Added {
    under: &'static str,
    declare: Box<Declares>,
    has: Box<dyn Fn(&str) -> bool>,
    run: Box<Does>,
}

/// Headings, and the commands under each.
type Groups = &'static [(&'static str, &'static [&'static str])];

/// What a flag without a value prints instead of anything else.
type Listing = fn(&Ui) -> Result<(), Failure>;

/// The command line of `cohold`: the heart's commands and laws, and whatever guests add.
pub struct Cli {
    added: Vec<Added>,
    listings: Vec<(&'static str, Listing)>,
    groups: Groups,
    road: Option<Road>,
    /// What commands are given, of guests too.
    ui: Ui,
}

/// Flags by which the other end is met: at which commands they are, how clap is told of them, and what they say.
struct Road {
    at: &'static [&'static str],
    declare: fn(clap::Command) -> clap::Command,
    read: fn(&clap::ArgMatches) -> Result<Arc<dyn Meets>, clap::Error>,
}

impl Default for Cli {
    /// The heart alone.
    fn default() -> Self {
        Self {
            added: Vec::new(),
            listings: vec![("keys", listings::scene_keys), ("scenes", listings::scenes)],
            groups: &[],
            road: None,
            ui: Ui::new(),
        }
        .with_commands::<paper::PaperCommands>("paper")
        .with_commands::<study::StudyCommands>("study")
    }
}

impl Cli {
    /// With the commit that the program is built from, for the files that it writes.
    #[must_use]
    pub fn built_from(mut self, commit: Option<&str>) -> Self {
        self.ui.provenance = provenance(commit);
        self
    }

    /// Adds laws to those that there are, in every command: `|laws| laws.with::<Mine>()`.
    #[must_use]
    pub fn with_laws(mut self, add: fn(Laws) -> Laws) -> Self {
        self.ui.laws = add(self.ui.laws);
        self
    }

    /// With this proof of the limits of laws that core does not have, for `stability prove`.
    #[must_use]
    pub fn with_proofs(mut self, prover: Prover) -> Self {
        self.ui.prover = prover;
        self
    }

    /// Adds commands below the command of this name, or beside the heart's where it is empty.
    #[must_use]
    pub fn with_commands<C: Commands + 'static>(mut self, under: &'static str) -> Self {
        self.added.push(Added {
            under,
            declare: Box::new(|command, ui| C::told(C::augment_subcommands(command), ui)),
            has: Box::new(C::has_subcommand),
            run: Box::new(|matches, ui| C::from_arg_matches(matches)?.run(ui)),
        });
        self
    }

    /// Has this printed wherever the flag of this name (see [`flags::listing`]) is asked for, whatever else is missing there.
    #[must_use]
    pub fn with_listing(mut self, flag: &'static str, print: Listing) -> Self {
        self.listings.push((flag, print));
        self
    }

    /// Shows the commands under these headings in the help, each with the names of its commands.
    #[must_use]
    pub fn with_groups(self, groups: Groups) -> Self {
        Self { groups, ..self }
    }

    /// Adds kinds of tables to those that `recording columns` explains.
    #[must_use]
    pub fn with_tables(mut self, tables: fn(&Ui) -> Vec<TableKind>) -> Self {
        self.ui.tables.push(tables);
        self
    }

    /// Adds a command of this name. Its arguments are `A`, which clap derives, with doc comments as help; its result is printed as a
    /// table, or with `--json` as a list with an object for each row.
    ///
    /// ```no_run
    /// use cohold_report::Columns;
    /// use cohold_sim::{Laws, Scene};
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
    /// cohold_cli::Cli::default().with_command("packets", packets).main();
    /// ```
    #[must_use]
    pub fn with_command<A: Args + 'static>(
        mut self,
        name: &'static str,
        run: impl Fn(&A, Laws) -> Result<Columns, Failure> + 'static,
    ) -> Self {
        self.added.push(Added {
            under: "",
            declare: Box::new(move |command, _| command.subcommand(A::augment_args(clap::Command::new(name)))),
            has: Box::new(move |word| word == name),
            run: Box::new(move |matches, ui| {
                let matches = matches.subcommand_matches(name).unwrap_or(matches);
                ui.result(&run(&A::from_arg_matches(matches)?, ui.laws)?)
            }),
        });
        self
    }

    /// Adds flags by which the other end is met to these commands; `declare` adds them to one of them, and says which of its flags they stand for.
    #[must_use]
    pub fn with_road<M: Meets + Args + 'static>(
        self,
        at: &'static [&'static str],
        declare: fn(clap::Command) -> clap::Command,
    ) -> Self {
        Self { road: Some(Road { at, declare, read: |matches| Ok(Arc::new(M::from_arg_matches(matches)?)) }), ..self }
    }

    /// Adds a paper to those that `paper reproduce` computes.
    #[must_use]
    pub fn with_paper(mut self, paper: Paper) -> Self {
        self.ui.papers.push(paper);
        self
    }

    /// Adds an adapter of a device: `--device NAME[:PLACE]` opens it, with what stands after the colon and what else is told of it. Axes,
    /// origin, ages and refusals are done for it, as for a built-in one.
    #[must_use]
    pub fn with_device(self, name: &'static str, open: Opens) -> Self {
        self.with_adapters(&[Adapter { name, place: "[:PLACE]", check: |_, _| Ok(()), open, look: |_| Vec::new() }])
    }

    /// Adds environments that the page can show.
    #[must_use]
    pub fn with_environments(mut self, environments: &'static [Playable]) -> Self {
        self.ui.environments = environments;
        self
    }

    /// Adds adapters of devices that `devices` looks for.
    #[must_use]
    pub fn with_adapters(mut self, adapters: &[Adapter]) -> Self {
        self.ui.devices.extend_from_slice(adapters);
        self
    }

    /// Runs the command line of this process.
    pub fn main(mut self) -> ExitCode {
        let vectors = vectors::widest();
        let words: Vec<OsString> = std::env::args_os().collect();
        self.ui.json = words.iter().any(|word| word == "--json");
        let command = self.command();
        let outcome = match (vectors, self.listed(&command, &words)) {
            (Err(refused), _) => Err(refused),
            (Ok(()), Some(outcome)) => outcome,
            (Ok(()), None) => match command.try_get_matches_from(&words) {
                Ok(matches) => self.run(&matches),
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
                cohold_io::say(format_args!("cohold: {}", cohold_io::escaped(&error.to_string())));
                ExitCode::from(if error.is::<Unsuccessful>() { 1 } else { 2 })
            }
        }
    }

    /// Every command, those of guests last.
    fn command(&self) -> clap::Command {
        let add = |command: clap::Command, added: &Added| match added.under {
            "" => as_described(command, |command| (added.declare)(command, &self.ui)),
            under => command.mut_subcommand(under, |of| as_described(of, |of| (added.declare)(of, &self.ui))),
        };
        let mut command = self.added.iter().fold(CommandLine::command(), add);
        if let Some(Road { at, declare, .. }) = &self.road {
            let here = at.iter().filter(|name| command.find_subcommand(name).is_some()).collect::<Vec<_>>();
            let with_road = |command: clap::Command, name| command.mut_subcommand(name, |of| as_described(of, declare));
            command = here.into_iter().fold(command, with_road);
        }
        grouped(negative_numbers(command), self.groups)
    }

    fn run(&mut self, matches: &clap::ArgMatches) -> Result<(), Failure> {
        if let (Some(road), Some((name, matches))) = (&self.road, matches.subcommand())
            && road.at.contains(&name)
        {
            self.ui.meeting = (road.read)(matches)?;
        }
        let (mut below, mut under) = (matches, "");
        while let Some((name, matches)) = below.subcommand() {
            if let Some(added) = self.added.iter().find(|added| added.under == under && (added.has)(name)) {
                return (added.run)(below, &self.ui);
            }
            (below, under) = (matches, name);
        }
        let line = CommandLine::from_arg_matches(matches)?;
        if let Some(shell) = line.completions {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut self.command(), "cohold", &mut script);
            write!(Ui { json: false, ..self.ui.clone() }, "{}", String::from_utf8(script)?);
            return Ok(());
        }
        line.command.unwrap_or_else(|| Command::Paper(paper::Paper::default())).run(&self.ui)
    }

    /// What a listing prints, where one is asked for; whatever else is missing there, as with `--help`.
    fn listed(&self, command: &clap::Command, words: &[OsString]) -> Option<Result<(), Failure>> {
        let command = words.iter().fold(command, |command, word| command.find_subcommand(word).unwrap_or(command));
        let is_asked = |arg: &&clap::Arg| {
            let flag = arg.get_long().map(|long| format!("--{long}"));
            flag.is_some_and(|flag| words.iter().any(|word| *word == *flag))
        };
        let listing = |arg: &clap::Arg| self.listings.iter().find(|(flag, _)| arg.get_id() == *flag);
        let (_, print) = command.get_arguments().filter(is_asked).find_map(listing)?;
        Some(print(&self.ui))
    }
}

/// The numbers that an argument accepts, from an error of the parser.
fn plainly(cause: &str) -> String {
    match cause.split_once(" is not in ").and_then(|(_, range)| range.split_once("..=")) {
        Some((from, to)) => format!("it must be a whole number from {from} to {to}"),
        None if cause.starts_with("invalid digit") => "it must be a whole number".to_owned(),
        None => cause.to_owned(),
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
        return format!("{flag} {value} is not allowed: {}", plainly(&cause.to_string()));
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
