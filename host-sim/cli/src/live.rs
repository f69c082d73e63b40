//! `cohold peer`: one of two live peers, or of those around a hub.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::Args;
use cohold_live::endpoint::{Span, Stop};
use cohold_live::watch::LiveOptions;

use super::address::endpoint;
use super::device::DeviceArgs;
use super::flags::{LiveTime, Patience, SCENE, Watching};
use super::road::Met;
use super::{Failure, SceneArgs, Ui, ui::Unsuccessful};
use crate::live_peer::LivePeer;

#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.default_value("any-network").help(SCENE)))]
pub(super) struct Peer {
    #[command(flatten)]
    scene: SceneArgs,
    /// Which of the two: 1 (left) or 2 (right).
    #[arg(long, required = true, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: Option<u8>,
    /// Where the other peer, or the hub, listens.
    #[arg(long, required = true, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    connect: Option<SocketAddr>,
    /// Where this end listens; port 0 is any.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, required = true)]
    listen: Option<SocketAddr>,
    /// Key file, the same at both ends (`cohold key generate`).
    #[arg(long, value_name = "FILE", required = true)]
    key_file: Option<PathBuf>,
    #[command(flatten)]
    time: LiveTime,
    #[command(flatten)]
    patience: Patience,
    /// Arm also where the scene is unstable at the delays that are measured; without it, such a peer waits for a better network, and ends
    /// with exit status 1 if none comes within --seconds.
    #[arg(long)]
    anyway: bool,
    #[command(flatten)]
    device: DeviceArgs,
    #[command(flatten)]
    watching: Watching,
}

impl Peer {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        // The scene is looked at before anybody is met; what the device is given in it depends on which of the two this is.
        self.scene.load(ui)?;
        let (device, stop) = (self.device.wanted(ui)?, Stop::on_signals()?);
        let own = self.key_file.as_deref().zip(self.number);
        let met = ui.meeting.agree(ui, &stop, own)?;
        let listen = self.listen.unwrap_or((Ipv4Addr::UNSPECIFIED, 0).into());
        let (number, key, connect, meeting) = match (met, own, self.connect) {
            (Some(Met { number, key, road, .. }), ..) => (number, key, road.place(), Some(road)),
            (None, Some((file, number)), Some(connect)) => (number, LivePeer::key(file)?, connect, None),
            (None, ..) => return Err("a peer needs --number, --listen, --connect and --key-file".into()),
        };
        let scene = self.scene.over(number, &self.device.beneath(number))?.load(ui)?;
        let span = Span { duration_s: self.time.seconds, patience_s: self.patience.patience_s };
        let peer = LivePeer { scene, number, key, ends: [listen, connect], span, anyway: allowed(self.anyway) };
        let wanted = LiveOptions { device, meeting, ..self.watching.wanted(peer.provenance(ui.provenance())) };
        let report = peer.run(wanted, &stop)?;
        ui.live_report(self.watching.telling.json_lines, &format!("peer {number}"), &report)?;
        let unstable =
            report.verdict.filter(|_| report.refused).map(|verdict| format!("never armed: {}", verdict.text));
        report.fault.or(unstable).map_or(Ok(()), |why| Err(Unsuccessful(why).into()))
    }
}

/// Whether a scene that is unstable may be armed: where `--anyway` is given, or else what to say.
pub fn allowed(anyway: bool) -> Result<(), &'static str> {
    if anyway { Ok(()) } else { Err("with --anyway it does") }
}
