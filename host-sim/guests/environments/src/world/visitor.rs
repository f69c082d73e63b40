//! Visitor: a client of a static world, without a socket. It feels what it knows, whatever the network does.
//!
//! Each tick gives a force from what is held. Each packet period it asks for what it lacks, says where it is, and looks at which
//! servers it needs: its home, and every one within whose margin it is.

use std::collections::BTreeMap;

use cohold_core::num::Motion;
use cohold_live::refused::is_telling;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Error, Link};
use cohold_protocol::wire::{Goodbye, Message, Presence, Sighting};

use super::render::Renderer;
use super::{CLIENT, OBJECTS, PACKET_US, look_around, open_link};
use crate::records::{Manifest, Object, Region};
use crate::roles::static_scene::{Download, Roam, Taken};

/// An answer is taken to be lost after this many packet periods on top of the round trip.
const PATIENCE_PACKETS: u64 = 3;

/// A server and what is known from it, or another client, from which nothing is downloaded.
struct Contact {
    link: Link,
    download: Option<Box<Download<OBJECTS>>>,
}

/// Who a datagram goes to or came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Correspondent {
    /// The server with this number.
    Server(u8),
    /// The client on this line, straight.
    Client(u32),
}

/// Settings of a visitor.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The key of its line.
    pub key: Key,
    /// Number of its line.
    pub line: u32,
    /// Number of the server that it begins at.
    pub home: u8,
    /// Servers that it can reach.
    pub reachable: Vec<u8>,
    /// How far around itself it wants to know, m; `None`: everything.
    pub radius_m: Option<f32>,
}

/// A client of a static world.
pub struct Visitor {
    setup: Setup,
    entropy: Box<dyn FnMut() -> [u8; Key::LEN] + Send>,
    contacts: BTreeMap<Correspondent, Contact>,
    roam: Roam,
    regions: Vec<Region>,
    manifest: Manifest,
    /// What renders the objects that it knows.
    pub renderer: Renderer,
    hand: [Motion<f64>; 2],
    others: BTreeMap<u32, (u64, Sighting)>,
    tick: u32,
    /// Something that is held has changed.
    news: bool,
    /// Parts that were not what their checksum said.
    pub(crate) corrupt: u32,
    /// Who sent the newest datagram that was refused and tells something, and why it was.
    pub(crate) refused: Option<(Correspondent, Error)>,
}

impl Visitor {
    /// A visitor that begins to call with its first packet period.
    pub fn new(setup: Setup, entropy: impl FnMut() -> [u8; Key::LEN] + Send + 'static) -> Self {
        Self {
            roam: Roam::new(setup.home),
            setup,
            entropy: Box::new(entropy),
            contacts: BTreeMap::new(),
            regions: Vec::new(),
            manifest: Manifest::default(),
            renderer: Renderer::default(),
            hand: [Motion::REST; 2],
            others: BTreeMap::new(),
            tick: 0,
            news: false,
            corrupt: 0,
            refused: None,
        }
    }

    /// Tells the client on line `who` where this one is, straight and not by the server, over a link of the two's own.
    pub fn befriend(&mut self, who: u32, link: Link) {
        self.contacts.insert(Correspondent::Client(who), Contact { link, download: None });
    }

    /// One control period: the force on the hand, N.
    pub fn step(&mut self, hand: [Motion<f64>; 2]) -> [f64; 2] {
        self.hand = hand;
        self.tick = self.tick.wrapping_add(1);
        if std::mem::take(&mut self.news) {
            let known = self.known();
            self.renderer.know(&known);
        }
        self.renderer.step(hand)
    }

    /// Everything that is held from any server; of two versions of an object the higher one, and home's where they agree.
    fn known(&self) -> Vec<Object> {
        let mut known = BTreeMap::<u32, Object>::new();
        let home = Correspondent::Server(self.roam.home());
        let others = self.contacts.iter().filter(|(correspondent, _)| **correspondent != home).map(|(_, other)| other);
        let downloads = self.contacts.get(&home).into_iter().chain(others).filter_map(|one| one.download.as_ref());
        for object in downloads.flat_map(|download| download.objects()) {
            let held = known.entry(object.id).or_insert(*object);
            if object.version > held.version {
                *held = *object;
            }
        }
        known.into_values().collect()
    }

    fn position(&self) -> [f32; 2] {
        self.hand.map(|axis| axis.position as f32)
    }

    /// One packet period: everything that is to be said now, and to which server.
    pub fn exchange(&mut self, now: u64, mut send: impl FnMut(Correspondent, &[u8])) {
        self.roam(now);
        let position = self.position();
        let velocity = self.hand.map(|axis| axis.velocity as f32);
        let presence = Presence::new(self.tick, [Sighting { who: self.setup.line, position, velocity }]);
        let home = Correspondent::Server(self.roam.home());
        for (correspondent, Contact { link, download }) in &mut self.contacts {
            let mut send = |bytes: &[u8]| send(*correspondent, bytes);
            if let Some((download, radius)) = download.as_mut().zip(self.setup.radius_m) {
                look_around(download, position, radius);
            }
            if let Some(download) = download.as_mut().filter(|_| link.is_up()) {
                let round_trip = u64::from(link.clock().round_trip_us().unwrap_or(0));
                if let Some(ask) = download.poll(now, round_trip + PATIENCE_PACKETS * PACKET_US) {
                    link.say(now, ask, &mut send);
                }
            }
            // Of those at servers, only those at the same one know of each other.
            if download.is_none() || *correspondent == home && link.is_up() {
                link.say(now, presence, &mut send);
            }
            link.say_due(now, send);
        }
    }

    /// Calls servers that are needed, moves home, and leaves those that are not needed any more.
    fn roam(&mut self, now: u64) {
        let position = self.position();
        let contacts = &self.contacts;
        let of = |server| contacts.get(&Correspondent::Server(server)).and_then(|contact| contact.download.as_ref());
        let ready = |server| of(server).is_some_and(|download| download.is_complete());
        if self.roam.update(&self.regions, position, ready).is_some() {
            self.news = true;
            // Who was seen was seen at the server that was left.
            self.others.clear();
        }
        let needed = self.roam.needs(&self.regions, self.manifest.margin_m, position);
        for server in &needed {
            let new =
                self.setup.reachable.contains(server) && !self.contacts.contains_key(&Correspondent::Server(*server));
            if let Some(link) = new.then(|| self.call(*server)).flatten() {
                self.contacts.insert(Correspondent::Server(*server), Contact { link, download: Some(Box::default()) });
            }
        }
        let before = self.contacts.len();
        self.contacts.retain(
            |correspondent, _| !matches!(correspondent, Correspondent::Server(server) if !needed.contains(server)),
        );
        self.news |= self.contacts.len() != before;
        self.others.retain(|_, (seen_us, _)| now.saturating_sub(*seen_us) < 1_000_000);
    }

    fn call(&mut self, server: u8) -> Option<Link> {
        let link = open_link(self.setup.key.clone(), [CLIENT, server], (self.entropy)());
        link.ok().map(|link| link.on_line(self.setup.line))
    }

    /// Takes a datagram, opened in place, and sends what it must be answered with at once.
    pub fn receive(
        &mut self,
        now: u64,
        from: Correspondent,
        datagram: &mut [u8],
        mut send: impl FnMut(Correspondent, &[u8]),
    ) {
        let Some(Contact { link, download }) = self.contacts.get_mut(&from) else { return };
        match (link.receive(now, datagram), download) {
            (Ok(Some(Message::Part(part))), Some(download)) => match download.take(&part) {
                Taken::Nothing => {}
                Taken::Corrupt => self.corrupt += 1,
                Taken::World | Taken::More => self.news = true,
                Taken::Complete => {
                    self.news = true;
                    self.regions = download.regions().copied().collect();
                    self.manifest = download.world().map_or(self.manifest, |(_, manifest)| manifest);
                }
            },
            (Ok(Some(Message::Presence(sighted))), _) => {
                for other in sighted.seen() {
                    // A friend speaks for itself only.
                    let who = if let Correspondent::Client(who) = from { who } else { other.who };
                    self.others.insert(who, (now, Sighting { who, ..*other }));
                }
            }
            (Err(why), _) if is_telling(&why) => self.refused = Some((from, why)),
            // Whatever else comes is the link's own business.
            _ => {}
        }
        link.say_due(now, |bytes| send(from, bytes));
    }

    /// Tells servers and friends that this one goes.
    pub fn goodbye(&mut self, now: u64, mut send: impl FnMut(Correspondent, &[u8])) {
        for (correspondent, contact) in &mut self.contacts {
            contact.link.say(now, Goodbye {}, |bytes| send(*correspondent, bytes));
        }
    }

    /// The link to a server.
    pub fn link(&self, server: u8) -> Option<&Link> {
        self.contacts.get(&Correspondent::Server(server)).map(|contact| &contact.link)
    }

    /// The download from a server.
    pub fn download(&self, server: u8) -> Option<&Download<OBJECTS>> {
        self.contacts.get(&Correspondent::Server(server))?.download.as_deref()
    }

    /// Whether everything in scope is held from the home server.
    pub fn is_complete(&self) -> bool {
        self.download(self.roam.home()).is_some_and(Download::is_complete)
    }

    /// Number of the server that is its home.
    pub fn home(&self) -> u8 {
        self.roam.home()
    }

    /// How often it has moved home.
    pub fn moves(&self) -> u32 {
        self.roam.moves()
    }

    /// Others that were seen within the last second.
    pub fn others(&self) -> impl Iterator<Item = &Sighting> {
        self.others.values().map(|(_, sighting)| sighting)
    }
}
