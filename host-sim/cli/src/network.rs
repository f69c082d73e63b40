//! `cohold network`: bad networks, and peers that are tried on them.

use std::{net::SocketAddr, path::PathBuf};

use clap::Args;
use cohold_live::{endpoint::Stop, measuring, relay};
use cohold_sim::network::link::Route;
use cohold_sim::network::rule::{Direction, Found, NetworkTrace};
use serde_json::json;

use super::address::endpoint;
use super::flags::{LiveTime, Time, number};
use super::{Failure, SceneArgs, Ui};

super::commands! {
    pub(crate) Network {
        /// A bad network between two live peers.
        Relay(Relay),
        /// Write down what a scene's network does to every packet.
        Trace(Trace),
        /// Measure the network between two machines: one listens and answers, the other one probes and writes a trace.
        Measure(Measure),
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60")))]
pub(super) struct Relay {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where peer 1 sends to.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    listen_1: SocketAddr,
    /// Where peer 2 sends to.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    listen_2: SocketAddr,
    /// Where peer 1 listens; what comes to --listen-1 from elsewhere goes nowhere.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    peer_1: SocketAddr,
    /// Where peer 2 listens; what comes to --listen-2 from elsewhere goes nowhere.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    peer_2: SocketAddr,
    /// Recorded network (as `--set network.trace=FILE`).
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    time: LiveTime,
}

impl Relay {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let mut scene = self.scene.load(ui)?;
        if let Some(trace) = &self.trace {
            scene.network_trace = Some(NetworkTrace::read(trace)?.into());
        }
        let routes = [Direction::OneToTwo, Direction::TwoToOne].map(|direction| Route::of_scene(&scene, direction, 0));
        let ends = [(self.listen_1, self.peer_1), (self.listen_2, self.peer_2)];
        let ends = ends.map(|(listen, peer)| relay::End { listen, peer });
        let relayed = relay::run(routes, ends, self.time.seconds, &Stop::on_signals()?)?;
        ui.report("relay, from peer 1 to 2 and back", &relayed)
    }
}

#[derive(Debug, Args)]
pub(super) struct Trace {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    time: Time,
    /// CSV file to write.
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

impl Trace {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let scene = self.scene.load(ui)?;
        let packet_s = scene.peer.timing.packet_period_s();
        NetworkTrace::record(&scene, (self.time.seconds / packet_s).ceil() as u64).write(&self.file)?;
        let measured = scene.network_trace.as_ref().filter(|trace| trace.found().constant_ns > 0);
        let Some(measured) = measured else { return ui.report("", &json!({ "files": [&self.file] })) };
        // What is constant is in no trace: it is the scene's.
        let constant_s = measured.constant_s();
        let packets = (constant_s / packet_s).round();
        let constant = json!({ "one_way_delay_s": constant_s, "network.one_way_delay_packets": packets });
        let Found { clock_steps, clock_drift_ppm, .. } = measured.found();
        let clocks = json!({ "steps": clock_steps, "drift_ppm": clock_drift_ppm });
        ui.report(
            "measured, and to be set",
            &json!({ "constant": constant, "clocks, left out": clocks, "files": [&self.file] }),
        )
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("seconds", |arg| arg.default_value("60")))]
pub(super) struct Measure {
    /// Answer probes that come here, and write nothing; whoever can reach it can measure.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, conflicts_with_all = ["to", "from", "every_ms", "file"], required_unless_present = "to")]
    listen: Option<SocketAddr>,
    /// Where the other machine listens; this one is peer 1.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, requires = "file")]
    to: Option<SocketAddr>,
    /// Where the probes come from; without it, any port.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, requires = "to")]
    from: Option<SocketAddr>,
    /// From one probe to the next, ms: the packet period of the scenes that are to have this network (`study bench`: 1).
    #[arg(long, default_value = "1", value_name = "MS", value_parser = number(1.0..=1000.0, "ms"))]
    every_ms: f64,
    #[command(flatten)]
    time: LiveTime,
    /// CSV file to write, for `network.trace` and `study bench --trace`.
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
}

impl Measure {
    fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (stop, seconds) = (Stop::on_signals()?, self.time.seconds);
        if let Some(listen) = self.listen {
            let ready = |address: SocketAddr| ui.status(format_args!("answering probes at {address}"));
            return ui.report("probes", &measuring::listen(listen, seconds, &stop, ready)?);
        }
        let (Some(to), Some(file)) = (self.to, &self.file) else { return Ok(()) };
        let measured = measuring::probe(to, self.from, 1e-3 * self.every_ms, seconds, &stop)?;
        measured.trace.write(file)?;
        let packets = (measured.constant_ms / self.every_ms).round();
        let told = "each way by itself, less its quickest; what is constant is half of the quickest round trip, and in no trace";
        let constant = json!({ "one_way_delay_ms": measured.constant_ms, "network.one_way_delay_packets": packets });
        ui.report("measured", &json!({ "probes": measured, "delays": told, "constant": constant, "files": [file] }))
    }
}
