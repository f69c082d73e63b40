//! `cohold play`: the live page.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

use clap::{Args, Command, Subcommand};
use cohold_live::devices::Kind;
use cohold_live::{endpoint::Stop, key_file};
use cohold_protocol::key;
use cohold_report::Provenance;
use cohold_sim::scene::Scene;
use serde_json::json;

use cohold_cli::address::endpoint;
use cohold_cli::board::address;
use cohold_cli::device::DeviceArgs;
use cohold_cli::flags::{RecordTo, choice, seconds};
use cohold_cli::live::allowed;
use cohold_cli::live_peer::judge;
use cohold_cli::recordings::load;
use cohold_cli::road::Met;
use cohold_cli::{Commands, Failure, SceneArgs, Ui};

use super::{
    At, Boards, End, EnvironmentKind, HAND, Kinds, Model, Opened, OpenedPage, Page, Place, Role, Shown, moving_picture,
};

/// Beside the heart's.
#[derive(Debug, Subcommand)]
pub(crate) enum PageCommands {
    /// Hold the object yourself, on a page in your browser.
    Play(Play),
}

impl Commands for PageCommands {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let Self::Play(play) = self;
        play.run(ui)
    }

    /// It shows what other guests have.
    fn told(commands: Command, ui: &Ui) -> Command {
        let kinds = Kinds(ui.environments);
        commands.mut_subcommand("play", |play| play.mut_arg("environment", |arg| arg.value_parser(kinds.parser())))
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.help("Scene file (TOML) or built-in scene [default: any-network at rest]")))]
pub(crate) struct Play {
    #[command(flatten)]
    scene: SceneArgs,
    /// What is shown first; the page can show the others, too. Without it and without a scene, settings, a partner or a recording, the
    /// picture `delay`; else two peers with as many axes as the scene says: pair, plane and space are two peers along 1, 2 and 3.
    #[arg(long, value_parser = Kinds::default().parser(), value_name = "NAME")]
    environment: Option<EnvironmentKind>,
    /// Who holds the other hand while only one window is open.
    #[arg(long, value_parser = choice::<Model>(), value_name = "NAME")]
    partner: Option<Model>,
    /// One peer only, whose partner joins here by `play --join` or `peer` on another machine.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, requires = "key_file", conflicts_with = "join")]
    listen: Option<SocketAddr>,
    /// One peer only, whose partner listens there: `play --listen`, or `peer` on another machine.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, requires = "key_file")]
    join: Option<SocketAddr>,
    /// One board or two, whose operator this page is: ADDRESS[:PORT] of each, or `simulated` for two with software devices.
    #[arg(long, value_name = "ADDRESS,…", value_delimiter = ',', conflicts_with_all = ["listen", "join"])]
    board: Vec<String>,
    /// Key file, the same at both ends (`cohold key generate`); of boards their operator's (`key generate --operator`).
    #[arg(long, value_name = "FILE")]
    key_file: Option<PathBuf>,
    /// A recording (MCAP) of `play`, `peer`, `cooperate` or `recording merge A B OUT.mcap`, looked at on the same page.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["listen", "join", "board", "record", "scene", "set", "seed", "key_file", "number"])]
    open: Option<PathBuf>,
    /// Which peer this is, 1 or 2; without it, who listens is 1 and who joins is 2.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=2))]
    number: Option<u8>,
    #[command(flatten)]
    device: DeviceArgs,
    /// One peer only: arm also where the scene is unstable at the delays that are measured; without it, such an end waits for a better network.
    #[arg(long)]
    anyway: bool,
    /// Port on 127.0.0.1, and of `--lan`; 0 is any.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// Serve hands and onlookers on the local network as well, at this address of the machine (without one, at its only private address):
    /// a phone scans the code and is the second hand. Not encrypted.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, conflicts_with = "board")]
    #[expect(clippy::option_option, reason = "not at all, without an address, at an address")]
    lan: Option<Option<Ipv4Addr>>,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    #[command(flatten)]
    record: RecordTo,
    /// Write three laws on a bad network as a moving picture to FILE.svg, and nothing else.
    #[arg(long, value_name = "FILE.svg")]
    picture: Option<PathBuf>,
}

impl Play {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        if let Some(file) = &self.open {
            return self.look_at(file, ui);
        }
        let ((scene, provenance), stop) = (self.fitted(ui, &self.scene)?, Stop::on_signals()?);
        if let Some(file) = &self.picture {
            if file.extension().is_none_or(|ending| ending != "svg") {
                return Err(format!("--picture {}: its name must end in .svg", file.display()).into());
            }
            let picture = moving_picture(&EnvironmentKind::BadNetwork.fitting(scene)?)?;
            return Ok(cohold_plot::write_file(file, "SVG", picture.as_bytes(), cohold_io::Kind::Named)?);
        }
        let shown = self.shown(ui, &stop)?;
        // What a device is given in the scene depends on which of the two this is.
        let (scene, provenance) = match &shown {
            Shown::Remote(end) if !end.has_the_pages_hand() => {
                self.fitted(ui, &self.scene.over(end.number, &self.device.beneath(end.number))?)?
            }
            _ => (scene, provenance),
        };
        let shown = match shown {
            Shown::Remote(end) => {
                let hand = end.has_the_pages_hand().then_some(HAND);
                let judge = judge(scene.clone(), end.number, hand, allowed(self.anyway));
                Shown::Remote(Box::new(End { judge: Some(judge), ..*end }))
            }
            other => other,
        };
        let hands = match &shown {
            Shown::Here(_) => vec![1, 2],
            Shown::Boards(_) => vec![],
            Shown::Remote(end) => {
                ui.status(format_args!("partner:              {end}"));
                if end.has_the_pages_hand() { vec![end.number] } else { vec![] }
            }
        };
        let at = At { port: self.port, lan: self.lan };
        let page = Page::serve(Kinds(ui.environments), scene, shown, self.partner.unwrap_or_default(), at)?;
        let say = |who: String, roles: &[Role]| ui.status(format_args!("{who:<20}  {}", page.address(roles)));
        if let Some(hand) = hands.first() {
            say(format!("hand {hand} and operator:"), &[Role::of_hand(*hand), Role::Operator]);
        }
        hands.iter().for_each(|hand| say(format!("hand {hand}:"), &[Role::of_hand(*hand)]));
        say("operator:".into(), &[Role::Operator]);
        say("to watch:".into(), &[Role::Watch]);
        if let Some(hand) = hands.last() {
            say_lan(ui, &page, *hand);
        }
        ui.status("Ctrl-C ends it");
        let record = self.record.record.as_deref().map(|file| (file, &provenance));
        let kept = page.run(self.seconds.unwrap_or(f64::INFINITY), record, &stop)?;
        ui.report("play", &json!(kept))
    }

    /// This scene as what is shown first has it, and the settings that a recording says.
    fn fitted(&self, ui: &Ui, scene: &SceneArgs) -> Result<(Scene, Provenance), Failure> {
        // Whoever opens a page without a scene is to push it alone.
        let scene = scene.load_or(ui, "any-network")?;
        let fitting = self.environment(ui).map_or_else(|| Ok(scene.clone()), |kind| kind.fitting(scene.clone()))?;
        let provenance = ui.provenance().settings(fitting.settings());
        // Behind a picture, which has a scene of its own, stands the one that was given.
        let is_story = self.environment(ui).is_some_and(EnvironmentKind::is_story);
        Ok((if is_story { scene } else { fitting }, provenance))
    }

    /// The page of a recording.
    fn look_at(&self, file: &Path, ui: &Ui) -> Result<(), Failure> {
        let stop = Stop::on_signals()?;
        let opened = Opened::new(file, &load(ui, file)?, self.environment, Kinds(ui.environments))?;
        ui.status(format_args!("recording of:         {}, {:.3} s", opened.who(), opened.seconds()));
        if let Some(left_out) = &opened.left_out {
            ui.warn(left_out);
        }
        let of = json!({ "recording": file, "who": opened.who(), "recorded_s": opened.seconds() });
        let page = OpenedPage::serve(opened, Kinds(ui.environments), ui.laws, self.port)?;
        ui.status(format_args!("to watch:             {}", page.address()));
        ui.status("Ctrl-C ends it");
        page.run(self.seconds.unwrap_or(f64::INFINITY), &stop);
        ui.report("", &of)
    }

    /// What is shown first: what is asked for; a picture where nothing is said of what to hold; else what the scene says.
    fn environment(&self, ui: &Ui) -> Option<EnvironmentKind> {
        let said = !self.scene.is_plain() || self.partner.is_some() || self.record.record.is_some();
        let elsewhere = self.key_file.is_some() || !self.board.is_empty() || ui.meeting.is_given();
        self.environment.or_else(|| (!said && !elsewhere).then_some(EnvironmentKind::Delay))
    }

    fn shown(&self, ui: &Ui, stop: &Stop) -> Result<Shown, Failure> {
        if ui.meeting.is_given() && (self.listen.or(self.join).is_some() || !self.board.is_empty()) {
            return Err(
                "a meeting (--meet, --accept) takes the place of --listen, --join and --board: give one of them".into(),
            );
        }
        let device = self.device.wanted(ui)?;
        let remote = ui.meeting.is_given() || self.listen.or(self.join).is_some();
        let is_device = !matches!(device.kind, Kind::Simulated);
        if !remote && (is_device || self.anyway) {
            let flag = if is_device { "--device" } else { "--anyway" };
            return Err(format!(
                "{flag} is for one peer of two: --listen, --join, --invite or --accept say where the other is"
            )
            .into());
        }
        let own = self.key_file.as_deref().zip(self.number);
        if let Some(Met { number, key, road, code }) = ui.meeting.agree(ui, stop, own)? {
            return Ok(Shown::Remote(Box::new(End { device, ..End::meeting(&*road, key, number, code)? })));
        }
        if !self.board.is_empty() {
            return Ok(Shown::Boards(Boards::open(self.places()?)?));
        }
        let Some(file) = &self.key_file else { return Ok(Shown::Here(self.environment(ui).unwrap_or_default())) };
        let key = key_file::read(file, key::Role::Peers)?;
        let end = match (self.listen, self.join) {
            (Some(at), _) => End::listening(at, key, self.number.unwrap_or(1))?,
            (None, Some(to)) => End::joining(to, key, self.number.unwrap_or(2))?,
            (None, None) => return Err("--key-file is for --listen or --join: give one of them".into()),
        };
        Ok(Shown::Remote(Box::new(End { device, ..end })))
    }

    /// Where the boards are.
    fn places(&self) -> Result<Vec<Place>, Failure> {
        match (self.board.as_slice(), &self.key_file) {
            ([one], _) if one == "simulated" => Ok(vec![Place::Simulated; 2]),
            ([_, _, _, ..], _) => Err("--board is not allowed with more than two boards".into()),
            (_, None) => Err("--board needs --key-file, the operator's, unless it is simulated".into()),
            (boards, Some(file)) => boards.iter().map(|board| Ok(Place::At(address(board)?, file.clone()))).collect(),
        }
    }
}

/// The addresses on the local network, if it is served there, and the code of that of its hand.
fn say_lan(ui: &Ui, page: &Page, hand: u8) {
    for (who, role) in
        [(format!("hand {hand}, network:"), Role::of_hand(hand)), ("to watch, network:".into(), Role::Watch)]
    {
        if let Some(address) = page.lan_address(&[role]) {
            ui.status(format_args!("{who:<20}  {address}"));
        }
    }
    if let Some(code) = page.code() {
        ui.status(format_args!("a phone that scans this is hand {hand}:"));
        cohold_io::draw(code);
        ui.status(
            "the local network is not encrypted: who listens on it (the Wi-Fi) reads these two addresses, and can hold that hand and stop",
        );
    }
}
