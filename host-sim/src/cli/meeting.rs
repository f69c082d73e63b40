//! `host-sim meet`, and the flags by which a peer or a page meets the other one there instead of calling an address.

use std::io::stdin;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use haptic_live::carried::{Meeting, resolve};
use haptic_live::endpoint::Stop;
use haptic_live::{invitation, key_file, meet};
use haptic_meeting::agreement::{Inviter, LIFE};
use haptic_meeting::invite::Invite;
use haptic_protocol::key::{Key, Role};

use super::address::endpoint;
use super::flags::seconds;
use super::{Failure, Ui};
use crate::play::qr::Code;

/// A peer's side of a meeting: its number, the key, and where.
pub(super) struct Met {
    pub(super) number: u8,
    pub(super) key: Key,
    pub(super) meeting: Meeting,
    /// Six digits that both ends of a link show.
    pub(super) code: Option<String>,
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Meeting")]
pub(super) struct MeetingArgs {
    /// A meeting place (`host-sim meet`): relays at first, until a direct path is found. With --key-file at both ends, or with --invite.
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
pub(super) struct Shown {
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
    pub(super) fn at(&self, place: &str) -> Result<Meeting, Failure> {
        let Self { relay_only, mapped, router } = *self;
        Ok(Meeting { place: resolve(place)?, relay_only, mapped, router })
    }
}

impl MeetingArgs {
    /// Whether the other end is met, and not called.
    pub(super) fn is_given(&self) -> bool {
        self.meet.is_some() || self.accept.is_some()
    }

    /// Comes to a key, where there is none yet: waits for who has the link, or uses it. None where nobody is to be met.
    pub(super) fn agree(&self, ui: &Ui, stop: &Stop, own: Option<(&Path, u8)>) -> Result<Option<Met>, Failure> {
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
                haptic_io::draw(Code::of(&link)?.lines());
                let key = invitation::invite(inviter, stop, |words| haptic_io::say(format_args!("warning: {words}")))?;
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
        Ok(Some(Met { number, key, meeting, code }))
    }
}

#[derive(Debug, Args)]
pub(super) struct Meet {
    /// Where it listens; `[::]:PORT` is of IPv4 and IPv6.
    #[arg(long, value_name = "ADDRESS:PORT", value_parser = endpoint)]
    listen: SocketAddr,
    /// End after so long, s; without it at Ctrl-C.
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
}

impl Meet {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let (place, stop) = (meet::Meet::open(self.listen)?, Stop::on_signals()?);
        ui.status(format_args!("meeting place on {} (UDP); Ctrl-C ends it", place.address()));
        ui.report("meeting place", &place.run(self.seconds.unwrap_or(f64::INFINITY), &stop)?)
    }
}
