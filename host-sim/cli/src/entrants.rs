//! Scenes or laws that take part in a comparison or a study, as flags.

use std::path::PathBuf;

use clap::Args;
use cohold_sim::user::User;
use cohold_studies::entrant::Entrant;

use super::flags::Time;
use super::{Failure, Ui};

/// What they all have.
#[derive(Clone, Debug, Args)]
pub(super) struct EntrantArgs {
    /// Scene in which laws are tried, at the gains that each declares; without it, that of the campaign.
    #[arg(long, value_name = "NAME|FILE")]
    scene: Option<PathBuf>,
    /// Override one key of all of them; may be repeated.
    #[arg(long = "set", value_name = "TABLE.KEY=VALUE")]
    set: Vec<String>,
    /// First seed; without it, the first scene's.
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
}

impl EntrantArgs {
    /// Those that are named so; a warning where nobody pushes.
    pub(super) fn load(&self, ui: &Ui, texts: &[String], time: Time) -> Result<Vec<Entrant>, Failure> {
        let seed = self.seed.map(|seed| format!("network.seed={seed}"));
        let of = |text: &String| Entrant::of(ui.laws, text, self.scene.as_deref(), &self.set, seed.clone());
        let entrants = texts.iter().map(of).collect::<Result<Vec<_>, _>>()?;
        for entrant in &entrants {
            time.check(&entrant.scene)?;
            if !entrant.scene.users.iter().any(User::acts) {
                ui.warn(format_args!("{}: nobody pushes: set user.1.push_n", entrant.name));
            }
        }
        Ok(entrants)
    }
}
