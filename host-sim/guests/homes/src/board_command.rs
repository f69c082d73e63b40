//! `cohold board bridge`: a board far away, reached through the PC beside it.

use std::net::{Ipv4Addr, SocketAddr};

use clap::Args;
use cohold_cli::address::{endpoint, endpoint_at};
use cohold_cli::flags::{KeyFile, Telling, live_seconds};
use cohold_cli::{Failure, Ui};
use cohold_live::endpoint::Stop;

use crate::beside::{Ends, Open, PORT};
use crate::command::Shown;

cohold_cli::commands! {
    /// Below `board`.
    pub(crate) BoardCommands {
        /// Reach a partner far away for a board: this PC stands beside it and carries its sealed datagrams to a meeting, unopened.
        Bridge(Bridging),
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("key_file", |arg| arg.help("The peers' key file that the board was provisioned with; the far end has the same")))]
#[command(mut_arg("quiet", |arg| arg.help("Say nothing while it runs; without it, which way the flow goes, and whether the board is there")))]
#[command(mut_arg("json_lines", |arg| arg.help("Say that, and in the end the report, as a JSON object each, one a line, on standard output")))]
pub(crate) struct Bridging {
    /// The board's address; its port is 7701 unless another is given. What comes from elsewhere goes nowhere.
    #[arg(long, value_name = "ADDRESS[:PORT]", value_parser = |text: &str| endpoint_at(text, Some(PORT)))]
    board: SocketAddr,
    /// Which of the two the board is: 1 (strap open) or 2.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    #[command(flatten)]
    key: KeyFile,
    /// The meeting place (`cohold meet`): relays at first, until a direct path is found.
    #[arg(long, value_name = "HOST:PORT")]
    meet: String,
    /// Where the board sends to: this PC is its partner (`network.peer`).
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, default_value_t = SocketAddr::from((Ipv4Addr::UNSPECIFIED, PORT)))]
    listen: SocketAddr,
    /// Where the far end's datagrams come to, for --mapped; any port without it.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    outside: Option<SocketAddr>,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = live_seconds)]
    seconds: Option<f64>,
    #[command(flatten)]
    telling: Telling,
    #[command(flatten)]
    shown: Shown,
}

impl Bridging {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (key, meeting, stop) = (self.key.read()?, self.shown.at(&self.meet)?, Stop::on_signals()?);
        let Self { board, listen, outside, number, .. } = *self;
        let ends = Ends { board, listen, outside, number, key, meeting };
        let open = Open::new(ends, self.telling.manner())?;
        ui.status(format_args!(
            "carries board {number} at {board} to {}; the board's partner is this PC, port {}; Ctrl-C ends it",
            self.meet,
            open.address().port()
        ));
        let report = open.run(self.seconds.unwrap_or(f64::INFINITY), &stop)?;
        ui.live_report(self.telling.json_lines, &format!("bridge to board {number}"), &report)
    }
}
