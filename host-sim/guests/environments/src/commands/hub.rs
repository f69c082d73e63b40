//! `cohold shared hub`: where 2 to 16 live peers meet.

use clap::Args;
use cohold_cli::flags::{End, Patience, SCENE, Watching};
use cohold_cli::{Failure, SceneArgs, Ui};
use cohold_live::endpoint::{Span, Stop};

use crate::cooperative::MOST_USERS;
use crate::live::hub;

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("hub").help(SCENE)))]
pub(super) struct Hub {
    #[command(flatten)]
    scene: SceneArgs,
    /// How many peers; the one on line n has its key by `key generate --line n --of`, and is number 1 where n is odd, 2 where even.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=MOST_USERS as i64))]
    users: u8,
    #[command(flatten)]
    end: End,
    #[command(flatten)]
    patience: Patience,
    #[command(flatten)]
    watching: Watching,
}

impl Hub {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let key = self.end.key.read()?;
        let (users, listen) = (self.users, self.end.listen);
        let span = Span { duration_s: self.end.time.seconds, patience_s: self.patience.patience_s };
        ui.status(format_args!("hub for {users} peers listens on {listen}"));
        let wanted = self.watching.wanted(ui.provenance().settings(scene.settings()).with("users", users));
        let report = hub::run(&scene, &key, users.into(), listen, span, &wanted, &Stop::on_signals()?)?;
        ui.live_report(self.watching.telling.json_lines, "hub", &report)
    }
}
