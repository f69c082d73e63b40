//! `cohold shared collaborate`: one at a time edits an object, by a lock or by a token ring, on trial.

use clap::Args;
use cohold_cli::flags::choice;
use cohold_cli::ui::and;
use cohold_cli::{Failure, Ui};
use serde_json::json;

use crate::collaborative;
use crate::collaborative::{MOST_USERS, Mistake, Scheme, Trial};

#[derive(Debug, Args)]
pub(crate) struct Collaborate {
    /// Who says whose turn it is.
    #[arg(long, default_value = "both", value_parser = ["lock", "ring", "both"])]
    scheme: String,
    /// Users; by default 2, 3, 5 and 8 in turn.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(2..=i64::from(MOST_USERS)))]
    users: Option<u8>,
    /// Runs of each scheme, shared among the numbers of users; a seed each.
    #[arg(long, default_value_t = 10_000, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    runs: u64,
    /// Seed of the first run.
    #[arg(long, default_value_t = 1, value_name = "K")]
    seed: u64,
    /// Put a mistake in on purpose, to see that it is found.
    #[arg(long, value_name = "NAME", value_parser = choice::<Mistake>())]
    mistake: Option<Mistake>,
}

impl Collaborate {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let schemes: &[Scheme] = match self.scheme.as_str() {
            "lock" => &[Scheme::Lock],
            "ring" => &[Scheme::Ring],
            _ => &[Scheme::Lock, Scheme::Ring],
        };
        let mistake = self.mistake;
        if !schemes.iter().all(|scheme| mistake.is_none_or(|mistake| mistake.fits(*scheme))) {
            let allowed = "no-fence only with --scheme lock, no-majority only with --scheme ring";
            return Err(format!("--mistake is not allowed with this --scheme: {allowed}").into());
        }
        let users = self.users.map_or_else(|| vec![2, 3, 5, 8], |users| vec![users]);
        let each = self.runs / users.len() as u64 + u64::from(!self.runs.is_multiple_of(users.len() as u64));
        let trials: Vec<_> =
            schemes.iter().flat_map(|scheme| users.iter().map(move |users| (*scheme, *users))).collect();
        let (rows, _) = ui.work(each as usize * trials.len(), "collaborate", |step| -> Result<Vec<_>, Failure> {
            let row = |(scheme, users)| {
                let trial = Trial { scheme, users, seed: self.seed, mistake };
                and(json!({ "scheme": scheme, "users": users }), &collaborative::campaign(&trial, each, &step))
            };
            trials.into_iter().map(row).collect()
        })?;
        ui.report("", &rows)
    }
}
