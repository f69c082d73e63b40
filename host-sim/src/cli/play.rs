//! `host-sim play`: the live page.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use haptic_live::endpoint::Stop;
use haptic_protocol::key;
use haptic_sim::key_file;
use serde_json::json;

use super::board::address;
use super::flags::{RecordTo, choice, seconds};
use super::{Failure, SceneArgs, Ui};
use crate::play::{Boards, End, EnvironmentKind, Model, Page, Place, Role, Shown, measure};

/// How long each run of `--measure` takes where nobody says, s.
const MEASURED_S: f64 = 10.0;

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("any-network")))]
pub(super) struct Play {
    #[command(flatten)]
    scene: SceneArgs,
    /// What is shown first; the page can show the others, too. Without it, two peers with as many axes as the scene says; pair, plane and
    /// space are two peers along 1, 2 and 3.
    #[arg(long, value_parser = choice::<EnvironmentKind>(), value_name = "NAME")]
    environment: Option<EnvironmentKind>,
    /// Who holds the other hand while only one window is open.
    #[arg(long, value_parser = choice::<Model>(), default_value = "follows", value_name = "NAME")]
    partner: Model,
    /// One peer only, whose partner joins here by `play --join` or `peer` on another machine.
    #[arg(long, value_name = "ADDRESS:PORT", requires = "key_file", conflicts_with = "join")]
    listen: Option<SocketAddr>,
    /// One peer only, whose partner listens there: `play --listen`, or `peer` on another machine.
    #[arg(long, value_name = "ADDRESS:PORT", requires = "key_file")]
    join: Option<SocketAddr>,
    /// One board or two, whose operator this page is: ADDRESS[:PORT] of each, or `simulated` for two with software devices.
    #[arg(long, value_name = "ADDRESS,…", value_delimiter = ',', conflicts_with_all = ["listen", "join"])]
    board: Vec<String>,
    /// Key file, the same at both ends (`host-sim key generate`); of boards their operator's (`key generate --operator`).
    #[arg(long, value_name = "FILE")]
    key_file: Option<PathBuf>,
    /// Which peer this is, 1 or 2; without it, who listens is 1 and who joins is 2.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=2))]
    number: Option<u8>,
    /// Port on 127.0.0.1; 0 is any.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    #[command(flatten)]
    record: RecordTo,
    /// Print how many ticks are late without windows, with two, and with ten and three that misbehave, and nothing else.
    #[arg(long)]
    measure: bool,
}

impl Play {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (scene, stop) = (self.scene.load(ui)?, Stop::on_signals()?);
        let scene = self.environment.map_or_else(|| Ok(scene.clone()), |kind| kind.fitting(scene.clone()))?;
        if self.measure {
            return ui.result(&measure(&scene, self.seconds.unwrap_or(MEASURED_S), &stop)?);
        }
        let (shown, provenance) = (self.shown()?, ui.provenance().settings(scene.settings()));
        let hands = match &shown {
            Shown::Here(_) => vec![1, 2],
            Shown::Boards(_) => vec![],
            Shown::Remote(end) => {
                ui.status(format_args!("partner:              {end}"));
                vec![end.number]
            }
        };
        let page = Page::serve(scene, shown, self.partner, self.port)?;
        let say = |who: String, roles: &[Role]| ui.status(format_args!("{who:<20}  {}", page.address(roles)));
        if let Some(hand) = hands.first() {
            say(format!("hand {hand} and operator:"), &[Role::of_hand(*hand), Role::Operator]);
        }
        hands.iter().for_each(|hand| say(format!("hand {hand}:"), &[Role::of_hand(*hand)]));
        say("operator:".into(), &[Role::Operator]);
        say("to watch:".into(), &[Role::Watch]);
        ui.status("Ctrl-C ends it");
        let record = self.record.record.as_deref().map(|file| (file, &provenance));
        let kept = page.run(self.seconds.unwrap_or(f64::INFINITY), record, &stop)?;
        ui.report("play", &json!(kept))
    }

    fn shown(&self) -> Result<Shown, Failure> {
        if !self.board.is_empty() {
            return Ok(Shown::Boards(Boards::open(self.places()?)?));
        }
        let Some(file) = &self.key_file else { return Ok(Shown::Here(self.environment.unwrap_or_default())) };
        let key = key_file::read(file, key::Role::Peers)?;
        Ok(Shown::Remote(match (self.listen, self.join) {
            (Some(at), _) => End::listening(at, key, self.number.unwrap_or(1))?,
            (None, Some(to)) => End::joining(to, key, self.number.unwrap_or(2))?,
            (None, None) => return Err("--key-file is for --listen or --join: give one of them".into()),
        }))
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
