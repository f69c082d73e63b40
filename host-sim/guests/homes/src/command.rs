//! `cohold meet`, and the flags by which a peer or a page meets the other one there instead of calling an address.

use std::io::stdin;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use cohold_cli::address::endpoint;
use cohold_cli::flags::seconds;
use cohold_cli::road::{Meets, Met};
use cohold_cli::{Failure, Ui};
use cohold_live::endpoint::Stop;
use cohold_live::key_file;
use cohold_protocol::key::{Key, Role};
use qrcode::render::unicode::Dense1x2;
use qrcode::{EcLevel, QrCode};

use crate::agreement::{Inviter, LIFE};
use crate::carried::{Meeting, resolve};
use crate::invite::Invite;
use crate::{invitation, meet};

cohold_cli::commands! {
    /// Beside the heart's.
    pub(crate) MeetCommands {
        /// Run a rendezvous server for two homes, with a relay that cannot read the traffic.
        Meet(Meet),
    }
}

/// The commands that take [`MeetingFlags`].
pub(crate) const MEETING: [&str; 2] = ["peer", "play"];

/// Adds [`MeetingFlags`] to one of them: who is met needs no address, and who comes by a link no key and no number.
pub(crate) fn declare(command: clap::Command) -> clap::Command {
    let (link, met) = (["invite", "accept"], ["meet", "accept"]);
    let mut command = MeetingFlags::augment_args(command).mut_arg("number", |arg| arg.conflicts_with_all(link));
    if command.get_name() == "peer" {
        command = command.mut_arg("connect", |arg| arg.conflicts_with_all(met));
        for (id, unless) in [("number", link), ("key_file", link), ("connect", met), ("listen", met)] {
            command = command.mut_arg(id, |arg| arg.required(false).required_unless_present_any(unless));
        }
    }
    command
}

/// How a peer or a page meets the other one.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meeting")]
pub(crate) struct MeetingFlags {
    /// A meeting place (`cohold meet`): relays at first, until a direct path is found. With --key-file at both ends, or with --invite.
    #[arg(long, value_name = "HOST:PORT")]
    meet: Option<String>,
    /// Print a link and its QR code, and be peer 1 to whoever uses it: one use, ten minutes. Then compare six digits aloud.
    #[arg(long, requires = "meet", conflicts_with_all = ["accept", "key_file"])]
    invite: bool,
    /// Use a link, and be peer 2 to whoever made it; with `-` it is read from standard input, so that no list of processes shows it. Then compare
    /// six digits aloud.
    #[arg(long, value_name = "LINK", conflicts_with_all = ["meet", "key_file"])]
    accept: Option<String>,
    /// Keep what was agreed on in a new key file, for --meet with --key-file from then on.
    #[arg(long, value_name = "FILE")]
    keep: Option<PathBuf>,
    #[command(flatten)]
    shown: Shown,
}

/// How an end that is met lets itself be reached.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meeting")]
pub(crate) struct Shown {
    /// An outer address that the router of this home passes on to this end's port, as it was told to, where the router cannot be asked for one.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    mapped: Option<SocketAddr>,
    /// The router that is asked (PCP, NAT-PMP) to pass a port on; without it the one that this machine sends by.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint, conflicts_with_all = ["mapped", "relay_only"])]
    router: Option<SocketAddr>,
    /// Stay on the relay, so that the partner learns no address of this end.
    #[arg(long)]
    relay_only: bool,
}

impl Shown {
    fn is_given(&self) -> bool {
        self.relay_only || self.mapped.is_some() || self.router.is_some()
    }

    /// A meeting at this place.
    pub(crate) fn at(&self, place: &str) -> Result<Meeting, Failure> {
        let Self { relay_only, mapped, router } = *self;
        Ok(Meeting { place: resolve(place)?, relay_only, mapped, router })
    }
}

impl Meets for MeetingFlags {
    fn is_given(&self) -> bool {
        self.meet.is_some() || self.accept.is_some()
    }

    fn agree(&self, ui: &Ui, stop: &Stop, own: Option<(&Path, u8)>) -> Result<Option<Met>, Failure> {
        if self.shown.is_given() && !self.is_given() || self.keep.is_some() && !self.invite && self.accept.is_none() {
            return Err(
                "--relay-only, --mapped and --router are for a meeting (--meet or --accept), and --keep for --invite or --accept"
                    .into(),
            );
        }
        let at = |place: &str| self.shown.at(place);
        let (number, key, meeting) = match (&self.accept, &self.meet, own) {
            (Some(link), ..) => {
                // Typed or piped in, so that no list of processes shows it.
                let typed = if link == "-" { stdin().lines().next().transpose()? } else { None };
                let link = typed.as_deref().unwrap_or(link).trim();
                let invite = Invite::parse(link).map_err(|wrong| format!("--accept {link}: {wrong}"))?;
                let meeting = at(&invite.meet)?;
                ui.status(format_args!("meeting at {}", invite.meet));
                (2, invitation::accept(&invite, stop)?, meeting)
            }
            (None, Some(place), _) if self.invite => {
                let meeting = at(place)?;
                let inviter = Inviter::new(place, &Key::new(key_file::entropy()?), Instant::now());
                let link = inviter.invite.link();
                let minutes = LIFE.as_secs() / 60;
                ui.status(format_args!(
                    "send this link to whom you invite; it serves once, within {minutes} minutes:\n{link}"
                ));
                let code = QrCode::with_error_correction_level(&link, EcLevel::L)?;
                cohold_io::draw(code.render::<Dense1x2>().build().lines());
                let key = invitation::invite(inviter, stop, |words| cohold_io::say(format_args!("warning: {words}")))?;
                ui.status("somebody has come with the link, and a key is agreed on");
                (1, key, meeting)
            }
            (None, Some(place), Some((file, number))) => (number, key_file::read(file, Role::Peers)?, at(place)?),
            (None, Some(_), None) => {
                return Err("--meet needs --invite, or --key-file and --number: the same key at both ends".into());
            }
            (None, None, _) => return Ok(None),
        };
        let is_new = self.invite || self.accept.is_some();
        let code = is_new.then(|| invitation::compare(&key)).transpose()?;
        if let Some(file) = &self.keep {
            key_file::write(file, Role::Peers, &key)?;
            ui.status(format_args!("wrote {}: with --meet and --key-file these two meet again", file.display()));
        }
        Ok(Some(Met { number, key, road: Arc::new(meeting), code }))
    }
}

#[derive(Debug, Args)]
pub(crate) struct Meet {
    /// Where it listens; `[::]:PORT` is of IPv4 and IPv6.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    listen: SocketAddr,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
}

impl Meet {
    pub(crate) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (place, stop) = (meet::Meet::open(self.listen)?, Stop::on_signals()?);
        ui.status(format_args!("meeting place on {} (UDP); Ctrl-C ends it", place.address()));
        ui.report("meeting place", &place.run(self.seconds.unwrap_or(f64::INFINITY), &stop)?)
    }
}
