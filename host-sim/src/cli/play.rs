//! `host-sim play`: the live page.

use clap::Args;
use serde_json::json;

use super::flags::{choice, seconds};
use super::{Failure, SceneArgs, Ui};
use crate::live::endpoint::Stop;
use crate::play::{Model, Page, measure};

/// How long each run of `--measure` takes where nobody says, s.
const MEASURED_S: f64 = 10.0;

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("any-network")))]
pub(super) struct Play {
    #[command(flatten)]
    scene: SceneArgs,
    /// Who holds the other hand while only one window is open.
    #[arg(long, value_parser = choice::<Model>(), default_value = "follows", value_name = "NAME")]
    partner: Model,
    /// Port on 127.0.0.1; 0 is any.
    #[arg(long, default_value_t = 0)]
    port: u16,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
    /// Print how many ticks are late without windows, with two, and with ten and three that misbehave, and nothing else.
    #[arg(long)]
    measure: bool,
}

impl Play {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (scene, stop) = (self.scene.load(ui)?, Stop::on_signals()?);
        if self.measure {
            return ui.result(&measure(&scene, self.seconds.unwrap_or(MEASURED_S), &stop)?);
        }
        let page = Page::serve(scene, self.partner, self.port)?;
        let addresses = [1, 2, 0].map(|person| page.address(person));
        let [one, two, watch] = &addresses;
        ui.status(format_args!("person 1:  {one}\nperson 2:  {two}\nto watch:  {watch}\nCtrl-C ends it"));
        let kept = page.run(self.seconds.unwrap_or(f64::INFINITY), &stop)?;
        ui.report("play", &json!(kept))
    }
}
