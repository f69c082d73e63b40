//! The page as a command has it: served, then run.

use std::net::Ipv4Addr;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use cohold_live::addresses;
use cohold_live::endpoint::Stop;
use cohold_live::recording::mcap::Channel;
use cohold_live::recording::origin::Origin;
use cohold_live::recording::recorder::Recorder;
use cohold_live::watch;
use cohold_report::Provenance;
use cohold_sim::peers::Builds;
use cohold_sim::{of_axes, scene::Scene};

use super::boards::Boards;
use super::control_loop::{self, Kept, Recording};
use super::doors::{Doors, Way, chosen};
use super::environment::{Environment, Opening};
use super::judge;
use super::kinds::{EnvironmentKind, Kinds};
use super::mailbox::Mailbox;
use super::orders;
use super::partner::Model;
use super::qr::Code;
use super::remote::{End, Remote};
use super::roles::Role;
use super::web::{Site, hello};
use cohold_cli::Failure;

/// What a page shows.
pub(crate) enum Shown {
    /// An environment of this process.
    Here(EnvironmentKind),
    /// One peer, whose partner is a process elsewhere.
    Remote(Box<End>),
    /// Boards, which are there.
    Boards(Boards),
}

/// One peer, along as many axes as the scene says.
fn remote<const SHARED: usize, const N: usize>(scene: Scene, end: End) -> Result<Box<dyn Environment>, Failure>
where
    f32: Builds<SHARED, N>,
{
    Ok(Box::new(Remote::<SHARED, N>::new(scene, end)?))
}

/// Where a page is served.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct At {
    /// At each address; 0 is any.
    pub(crate) port: u16,
    /// For the local network as well, at this address of the machine, or at its only private one.
    pub(crate) lan: Option<Option<Ipv4Addr>>,
}

/// A page that is served.
pub(crate) struct Page {
    mailbox: Arc<Mailbox>,
    site: Site,
    code: Option<Code>,
    kind: EnvironmentKind,
    kinds: Kinds,
    opening: Opening,
    recorded: Recorded,
}

/// What a recording of a page is.
struct Recorded {
    /// Whose it is.
    who: String,
    /// Channels that what is shown fills itself.
    own: Vec<Channel>,
    /// Topic of the samples.
    topic: &'static str,
    /// When the clock began by which those are timed; none, and it begins with the recording.
    start: Option<Instant>,
}

impl Recorded {
    fn of(shown: &Shown, scene: &Scene) -> Self {
        let page = |who: &str, topic| Self { who: who.to_owned(), own: Vec::new(), topic, start: None };
        match shown {
            Shown::Here(_) => page("both peers", "/both/ticks"),
            Shown::Boards(_) => page("a page of boards", "/boards/ticks"),
            // As a peer without a page records itself.
            Shown::Remote(end) => Self {
                who: watch::who(end.number),
                own: watch::channels(scene, end.number, end.meets()),
                topic: "/page/ticks",
                start: Some(end.start()),
            },
        }
    }

    fn begin(self, kinds: Kinds, file: &Path, provenance: &Provenance) -> Result<Recording, Failure> {
        let Self { who, own, topic, start } = self;
        let (start, others) = (start.unwrap_or_else(Instant::now), own.len() as u16);
        let channels = own.into_iter().chain(control_loop::channels(kinds, topic)).collect();
        let recorder = Recorder::create(file, &Origin::here(provenance, who, start), channels)?;
        Ok(Recording { recorder: Arc::new(recorder), start, others })
    }
}

impl Page {
    /// Serves the page of this scene. Nobody's hand moves before [`Page::run`].
    pub(crate) fn serve(kinds: Kinds, scene: Scene, shown: Shown, partner: Model, at: At) -> Result<Self, Failure> {
        orders::check(&scene)?;
        let lan = at.lan.map(|wanted| chosen(wanted, &addresses::of_this_machine())).transpose()?;
        let (doors, listeners) = Doors::open(at.port, lan)?;
        let mailbox = Arc::new(Mailbox::new(partner));
        let (other, fixed) = match &shown {
            Shown::Here(_) => (None, None),
            Shown::Remote(end) => {
                let why = "both ends were told these settings: end both and start them with others";
                (Some(end.to_string()), Some(why))
            }
            Shown::Boards(_) => (None, Some("boards are told their settings by `cohold board operator`")),
        };
        let mut site = Site::new(doors, hello(kinds, &scene, other, matches!(shown, Shown::Boards(_))))?;
        let kind = if let Shown::Here(kind) = &shown { *kind } else { EnvironmentKind::default() };
        let kind = kind.in_scene(&scene);
        // A picture has a scene of its own; the one that is given is the workshop's behind it.
        let workshop = scene.clone();
        let scene = if kind.is_story() { kind.fitting(scene)? } else { scene };
        // What cannot be shown is an error before anybody looks.
        if fixed.is_none() {
            kind.open(&scene)?;
        }
        let asks = judge::start(&mailbox, scene.clone(), workshop, kind, kinds, fixed)?;
        // On the network the last hand is held: the second, where there are two.
        let code = match &shown {
            Shown::Here(_) => site.offer(Role::Hand2)?,
            Shown::Remote(end) if end.has_the_pages_hand() => site.offer(Role::of_hand(end.number))?,
            Shown::Remote(_) | Shown::Boards(_) => None,
        };
        site.serve(listeners, &mailbox, asks)?;
        let recorded = Recorded::of(&shown, &scene);
        let opening: Opening = match shown {
            Shown::Here(_) => Box::new(move || kind.open(&scene)),
            Shown::Remote(end) => Box::new(move || of_axes!(scene, remote(scene, *end))),
            Shown::Boards(boards) => Box::new(move || Ok(Box::new(boards))),
        };
        Ok(Self { mailbox, site, code, kind, kinds, opening, recorded })
    }

    /// The address for who has these roles. What follows its `#` is told to nobody by a browser.
    pub(crate) fn address(&self, roles: &[Role]) -> String {
        self.site.address(roles)
    }

    /// The same on the local network, if it is served there.
    pub(crate) fn lan_address(&self, roles: &[Role]) -> Option<String> {
        self.site.address_by(Way::Lan, roles)
    }

    /// The QR code of a hand's address on the local network, line by line.
    pub(crate) fn code(&self) -> Option<Vec<String>> {
        self.code.as_ref().map(Code::lines)
    }

    /// Runs the control loop until it is stopped, or so many seconds are over: on a thread of its own, for what a
    /// thread starts inherits its real-time priority. Every tick goes into the recording, if there is one.
    pub(crate) fn run(self, seconds: f64, record: Option<(&Path, &Provenance)>, stop: &Stop) -> Result<Kept, Failure> {
        let Self { mailbox, kind, kinds, opening, recorded, .. } = self;
        let record = record.map(|(file, provenance)| recorded.begin(kinds, file, provenance)).transpose()?;
        let control_loop = || control_loop::run(&mailbox, kind, opening, seconds, record.as_ref(), stop);
        let kept = std::thread::scope(|scope| {
            let control_loop = std::thread::Builder::new().name("beat".into()).spawn_scoped(scope, control_loop);
            control_loop?.join().map_err(|_| "the beat failed".to_owned())?
        });
        // What was shown is gone, and with it the other end of this.
        if let Some(recorder) = record.and_then(|record| Arc::into_inner(record.recorder)) {
            cohold_io::say(recorder.finish().summary());
        }
        // Windows ask 60 times a second: each sees that it is over, and closes.
        mailbox.lock().over = true;
        std::thread::sleep(Duration::from_millis(100));
        kept
    }
}
