//! `cohold devices`: what is attached, and ten steps with one of them.

use std::io::BufRead as _;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use cohold_io::Kind;
use cohold_live::devices::steps::{PUSH_N, Trial};
use cohold_live::devices::{Found, Health};
use cohold_report::Columns;
use cohold_sim::scene::Device;
use serde_json::json;

use super::device::DeviceArgs;
use super::flags::{SCENE, number};
use super::{Failure, SceneArgs, Ui};

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("any-network").help(SCENE)))]
#[command(args_conflicts_with_subcommands = true)]
pub(super) struct Devices {
    /// Look there as well: ADDRESS:PORT of Haply's service, a serial port, a CAN interface.
    #[arg(long, value_name = "PLACE")]
    look_at: Vec<String>,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    scene: SceneArgs,
    /// Which peer of the scene has the device: 1 (left) or 2 (right).
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    /// By how much you will move the hand along the device's x, m.
    #[arg(long, default_value_t = 0.03, value_name = "M", value_parser = number(0.005..=0.2, "m"))]
    distance_m: f64,
    /// Where the settings go that a scene needs of the device, once all ten steps have passed: a scene file of these alone.
    #[arg(long, value_name = "FILE.toml")]
    settings: Option<PathBuf>,
}

/// Asks on standard error, hears on standard input.
fn please(task: &str) -> Result<(), cohold_live::Error> {
    cohold_io::say(format_args!("{task}; then press Enter"));
    match std::io::stdin().lock().read_line(&mut String::new()) {
        Ok(0) => Err("standard input has ended: somebody has to be at the device".to_owned().into()),
        Ok(_) => Ok(()),
        Err(cause) => Err(cause.to_string().into()),
    }
}

impl Devices {
    /// Lists what is attached; with `--device`, goes through the ten steps with it.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let options = self.device.wanted(ui)?;
        let beneath = self.device.beneath(self.number);
        let scene = self.scene.over(self.number, &beneath)?.load(ui)?;
        let Some(mut port) = options.port(&scene, self.number)? else {
            let found: Vec<Found> = ui.devices.iter().flat_map(|adapter| (adapter.look)(&self.look_at)).collect();
            if found.is_empty() {
                ui.status("nothing is attached: no service of Haply's, no fdcanusb, no CAN interface");
            }
            let columns = Columns::of(&found);
            let columns =
                columns.value("device", |found: &Found| found.device.clone()).value("what", |found| found.what.clone());
            return ui.result(&columns.done());
        };
        ui.status(format_args!("the motors will move, with {PUSH_N} N at the most: keep the supply's switch at hand"));
        let peers = scene.peers();
        let axes = peers[usize::from(self.number == 2)].axis.count.min(port.abilities().axes as u32) as usize;
        let silent = Duration::from_secs_f64(options.silent_s);
        let mut trial = Trial::new(&mut *port, &please, axes, silent, self.distance_m);
        let passed = trial.run(|passed| ui.status(format_args!("{}: passed: {}", passed.step, passed.seen)))?;
        let delay_ticks = trial.delay_ticks();
        if let Some(file) = &self.settings {
            let (name, health) = (port.abilities().name.clone(), port.health());
            let text = self.table(&name, health, delay_ticks, &beneath);
            cohold_io::write(file, text.as_bytes(), Kind::Named)
                .map_err(cohold_sim::Error::cannot("write", &file.display()))?;
            ui.status(format_args!("what a scene needs of it is in {}", file.display()));
        }
        ui.report("", &json!({ "device": port.abilities().name, "passed": passed, "force_delay_ticks": delay_ticks, "health": port.health() }))
    }

    /// The settings of a scene for this device.
    fn table(&self, name: &str, health: Option<Health>, delay_ticks: f64, beneath: &[(&str, String)]) -> String {
        // More than so many ticks of delay are not to be had in a scene: its verdict would be about another loop.
        let most_ticks = Device::MOST_DELAY_TICKS;
        let (known, warning) = (
            delay_ticks.min(most_ticks),
            if delay_ticks > most_ticks {
                "# An answer takes more than 20 ticks: no scene has that, and a verdict is about another loop.\n"
            } else {
                ""
            },
        );
        let health = json!(health);
        let mut text =
            format!("# {name}, which passed the ten steps of `cohold devices`. It told of itself: {health}.\n");
        text += &format!("{warning}\n[device]\nforce_delay_ticks = {known:?}\n\n[peer.{}.safety]\n", self.number);
        for (key, set) in beneath {
            let (name, value) = (key.trim_start_matches("safety."), set.split_once('=').map_or("", |(_, value)| value));
            text += &format!("{name} = {value}\n");
        }
        text
    }
}
