//! `host-sim network relay`: a bad network between two live peers.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

use crate::cli::flags::Time;
use crate::cli::{Failure, SceneArgs, Ui};
use crate::live::endpoint::Stop;
use crate::live::relay;
use haptic_sim::network::link::Route;
use haptic_sim::network::rule::{Direction, NetworkTrace};

/// Arguments of `relay`.
#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60")))]
pub(in crate::cli) struct Relay {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where peer 1 sends to.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen_1: SocketAddr,
    /// Where peer 2 sends to.
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen_2: SocketAddr,
    /// Recorded network (as `--set network.trace=FILE`).
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    time: Time,
}

impl Relay {
    /// Relays until the time is over.
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let mut scene = self.scene.load(ui)?;
        if let Some(trace) = &self.trace {
            scene.network_trace = Some(NetworkTrace::read(trace)?.into());
        }
        let routes = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| Route::of_scene(&scene, direction, 0));
        let listen = [self.listen_1, self.listen_2];
        let relayed = relay::run(routes, listen, self.time.seconds, &Stop::on_signals()?)?;
        ui.document(&relayed)?;
        for (way, count) in ["1 to 2", "2 to 1"].iter().zip(relayed) {
            writeln!(
                ui,
                "{way}: {} taken, {} sent on, {} lost, {} broken",
                count.taken, count.sent, count.lost, count.corrupt
            );
        }
        Ok(())
    }
}
