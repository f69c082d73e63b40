//! The page as a command has it: served, then run.

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use haptic_live::endpoint::Stop;
use haptic_live::recording::origin::Origin;
use haptic_live::recording::recorder::Recorder;
use haptic_protocol::wire::{Flows, Message};
use haptic_report::Provenance;
use haptic_sim::peers::Builds;
use haptic_sim::{of_axes, scene::Scene};

use super::boards::Boards;
use super::control_loop::{self, Kept};
use super::environment::{Environment, Opening};
use super::judge;
use super::kinds::EnvironmentKind;
use super::mailbox::Mailbox;
use super::orders;
use super::partner::Model;
use super::remote::{End, Remote};
use super::roles::Role;
use super::web::{Site, hello};
use crate::Error;

/// What a page shows.
pub(crate) enum Shown {
    /// An environment of this process.
    Here(EnvironmentKind),
    /// One peer, whose partner is a process elsewhere.
    Remote(End),
    /// Boards, which are there.
    Boards(Boards),
}

/// One peer, along as many axes as the scene says.
fn remote<const SHARED: usize, const N: usize>(scene: Scene, end: End) -> Result<Box<dyn Environment>, Error>
where
    Flows<SHARED>: Into<Message>,
    f32: Builds<SHARED, N>,
{
    Ok(Box::new(Remote::<SHARED, N>::new(scene, end)?))
}

/// A page that is served.
pub(crate) struct Page {
    mailbox: Arc<Mailbox>,
    site: Site,
    kind: EnvironmentKind,
    opening: Opening,
    /// Topic of a recording, and whose it is.
    recorded: (&'static str, &'static str),
}

impl Page {
    /// Serves the page of this scene on 127.0.0.1, at any port where `port` is 0. Nobody's hand moves before [`Page::run`].
    pub(crate) fn serve(scene: Scene, shown: Shown, partner: Model, port: u16) -> Result<Self, Error> {
        orders::check(&scene)?;
        let failed = haptic_sim::Error::cannot::<std::io::Error>("listen on", &format_args!("127.0.0.1:{port}"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        let mailbox = Arc::new(Mailbox::new(partner));
        let (other, fixed) = match &shown {
            Shown::Here(_) => (None, None),
            Shown::Remote(end) => {
                let why = "both ends were told these settings: end both and start them with others";
                (Some(end.to_string()), Some(why))
            }
            Shown::Boards(_) => (None, Some("boards are told their settings by `host-sim board operator`")),
        };
        let site = Site::new(listener.local_addr()?.port(), hello(&scene, other, matches!(shown, Shown::Boards(_))))?;
        let kind = if let Shown::Here(kind) = &shown { *kind } else { EnvironmentKind::default() };
        let kind = kind.in_scene(&scene);
        // What cannot be shown is an error before anybody looks.
        if fixed.is_none() {
            kind.open(&scene)?;
        }
        let asks = judge::start(&mailbox, scene.clone(), kind, fixed)?;
        site.serve(listener, &mailbox, asks)?;
        let recorded = match &shown {
            Shown::Here(_) => ("/both/ticks", "both peers"),
            Shown::Remote(_) => ("/page/ticks", "a page of one peer"),
            Shown::Boards(_) => ("/boards/ticks", "a page of boards"),
        };
        let opening: Opening = match shown {
            Shown::Here(_) => Box::new(move || kind.open(&scene)),
            Shown::Remote(end) => Box::new(move || of_axes!(scene, remote(scene, end))),
            Shown::Boards(boards) => Box::new(move || Ok(Box::new(boards))),
        };
        Ok(Self { mailbox, site, kind, opening, recorded })
    }

    /// The address for who has these roles. What follows its `#` is told to nobody by a browser.
    pub(crate) fn address(&self, roles: &[Role]) -> String {
        self.site.address(roles)
    }

    /// Runs the control loop until it is stopped, or so many seconds are over: on a thread of its own, for what a
    /// thread starts inherits its real-time priority. Every tick goes into the recording, if there is one.
    pub(crate) fn run(self, seconds: f64, record: Option<(&Path, &Provenance)>, stop: &Stop) -> Result<Kept, Error> {
        let Self { mailbox, kind, opening, recorded, .. } = self;
        let begin = |(file, provenance): (&Path, &Provenance)| {
            let (topic, who) = recorded;
            Recorder::create(file, &Origin::here(provenance, who, Instant::now()), control_loop::channels(topic))
        };
        let recorder = record.map(begin).transpose()?;
        let control_loop = || control_loop::run(&mailbox, kind, opening, seconds, recorder.as_ref(), stop);
        let kept = std::thread::scope(|scope| {
            let control_loop = std::thread::Builder::new().name("beat".into()).spawn_scoped(scope, control_loop);
            control_loop?.join().map_err(|_| "the beat failed".to_owned())?
        });
        if let Some(recorder) = recorder {
            haptic_io::say(recorder.finish().summary());
        }
        // Windows ask 60 times a second: each sees that it is over, and closes.
        mailbox.lock().over = true;
        std::thread::sleep(Duration::from_millis(100));
        kept
    }
}
