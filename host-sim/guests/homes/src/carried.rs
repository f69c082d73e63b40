//! A carrier under an endpoint's socket: what comes is sifted before an actor sees it, what an actor says goes where the path leads.
//!
//! The one socket is of both families where the system lets it (IPv6 with mapped IPv4 addresses), else of the meeting place's. The actor knows one address, the meeting place's;
//! `protocol/src/path.rs` and everything above see no change of path. The carrier is given its time whenever the socket is emptied, which is at every tick.

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cohold_live::addresses::any_towards;
use cohold_live::batch::ReceivedBatch;
use cohold_live::endpoint::Endpoint;
use cohold_live::road::{Change, PathReport, Road, Roads};
use cohold_live::{Error, key_file::entropy};
use cohold_protocol::key::Key;

use crate::carrier::{Carrier, Config};
use crate::mapping::{Mapping, PORT};

/// The carrier is given its time no more often.
const EVERY: Duration = Duration::from_micros(400);
/// Addresses that nobody has, of both families: where a datagram to the world would leave from is asked for, none is sent there.
const WORLD: [SocketAddr; 2] = [
    SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::new(192, 0, 2, 1)), 9),
    SocketAddr::new(std::net::IpAddr::V6(Ipv6Addr::new(0x2001, 0xDB8, 0, 0, 0, 0, 0, 1)), 9),
];

/// Which meeting place, and what of oneself is shown.
#[derive(Clone, Debug)]
pub struct Meeting {
    /// Where it is.
    pub place: SocketAddr,
    /// All flow stays on the relay, so that the partner learns no address of this end.
    pub relay_only: bool,
    /// An outer address that a router passes on to this end, where somebody has told it to.
    pub mapped: Option<SocketAddr>,
    /// Which router is asked to pass a port on; none, and it is the one that the system sends by, where that can be known.
    pub router: Option<SocketAddr>,
}

/// A carrier, and how its socket writes addresses.
#[derive(Debug)]
struct Carried {
    carrier: Mutex<Carrier>,
    /// The one address that an actor knows.
    address: SocketAddr,
    mapped: bool,
    polled: Mutex<Option<Instant>>,
    asking: Option<Mutex<Asking>>,
}

/// A router that is asked to pass a port on, by a socket that hears nobody else.
#[derive(Debug)]
struct Asking {
    socket: UdpSocket,
    router: SocketAddr,
    mapping: Mapping,
}

impl Asking {
    /// None where there is no router, or none of IPv4.
    fn new(router: Option<SocketAddr>, bases: &[SocketAddr]) -> Option<Self> {
        let router = router.or_else(router_of_this_machine)?;
        let own = bases.iter().find_map(|base| if let SocketAddr::V4(v4) = base { Some(*v4) } else { None })?;
        // Who stays on this machine needs no port of a router outside.
        let reaches = router.ip().is_loopback() == own.ip().is_loopback();
        let socket = UdpSocket::bind((*own.ip(), 0)).ok().filter(|_| reaches)?;
        socket.connect(router).and_then(|()| socket.set_nonblocking(true)).ok()?;
        let mapping = Mapping::new(router, own, &Key::new(entropy().ok()?), Instant::now());
        Some(Self { socket, router, mapping })
    }

    fn send(&self, questions: Vec<Vec<u8>>) {
        // A router that cannot be asked says nothing.
        questions.iter().for_each(|question| drop(self.socket.send(question)));
    }

    /// Asks what is due and takes what has come; the outer address.
    fn poll(&mut self, now: Instant) -> Option<SocketAddr> {
        let questions = self.mapping.poll(now);
        self.send(questions);
        let mut room = [0; 256];
        // A few at once, whoever sends more.
        for _ in 0..4 {
            let Ok(length) = self.socket.recv(&mut room) else { break };
            self.mapping.hear(now, self.router, &room[..length]);
        }
        self.mapping.outer(now)
    }
}

impl Drop for Asking {
    fn drop(&mut self) {
        let last = self.mapping.goodbye();
        self.send(last);
    }
}

/// The router by which this machine reaches the world, as Linux tells it; elsewhere nobody is asked.
fn router_of_this_machine() -> Option<SocketAddr> {
    let table = std::fs::read_to_string("/proc/net/route").ok()?;
    let router = table.lines().skip(1).find_map(|line| {
        let mut words = line.split_whitespace().skip(1);
        let (to, by) = (words.next()?, u32::from_str_radix(words.next()?, 16).ok()?);
        // The number is the address as memory has it.
        (to == "00000000" && by != 0).then(|| Ipv4Addr::from(by.to_ne_bytes()))
    })?;
    Some(SocketAddr::new(router.into(), PORT))
}

/// The address of a host and a port, which may be a name.
///
/// # Errors
/// There is none.
pub fn resolve(place: &str) -> Result<SocketAddr, Error> {
    let cannot = |why: String| Error::Refused(format!("no meeting place at {place}: {why}"));
    let mut found = place.to_socket_addrs().map_err(|cause| cannot(cause.to_string()))?;
    found.next().ok_or_else(|| cannot("the name has no address".into()))
}

/// An address as the socket of a family writes it.
pub(crate) fn written(address: SocketAddr, mapped: bool) -> SocketAddr {
    match address {
        SocketAddr::V4(v4) if mapped => SocketAddr::new(v4.ip().to_ipv6_mapped().into(), v4.port()),
        other => other,
    }
}

/// An address as people write it.
pub(crate) fn canonical(address: SocketAddr) -> SocketAddr {
    SocketAddr::new(address.ip().to_canonical(), address.port())
}

/// The address of this machine that a datagram to there would leave from.
fn own_towards(to: SocketAddr) -> Option<std::net::IpAddr> {
    let probe = UdpSocket::bind(any_towards(to)).ok()?;
    probe.connect(to).ok()?;
    probe.local_addr().ok().map(|own| own.ip()).filter(|ip| !ip.is_unspecified())
}

/// A socket that reaches a meeting place, and what else the machine lets it reach.
fn open(meeting: &Meeting, listen: Option<SocketAddr>) -> std::io::Result<UdpSocket> {
    let port = match listen {
        Some(listen) if !listen.ip().is_unspecified() => return UdpSocket::bind(listen),
        any => any.map_or(0, |any| any.port()),
    };
    // Elsewhere a socket of IPv6 is of IPv6 alone.
    let both = cfg!(unix).then(|| UdpSocket::bind((Ipv6Addr::UNSPECIFIED, port)).ok()).flatten();
    let reaches = |socket: &UdpSocket| socket.connect(written(meeting.place, true)).is_ok();
    let reached = both.filter(|_| UdpSocket::bind((Ipv6Addr::UNSPECIFIED, 0)).is_ok_and(|probe| reaches(&probe)));
    reached.map_or_else(|| UdpSocket::bind((any_towards(meeting.place).ip(), port)), Ok)
}

impl Carried {
    /// Under this socket; side 0 is peer 1, 1 is peer 2.
    fn new(socket: &UdpSocket, meeting: &Meeting, key: Key, side: u8) -> Result<Self, Error> {
        let own = socket.local_addr().map_err(cohold_sim::Error::cannot("ask", &"a socket"))?;
        let place = canonical(meeting.place);
        let mapped = own.ip().is_unspecified() && own.is_ipv6();
        let towards = |family: SocketAddr| if family.is_ipv4() == place.is_ipv4() { place } else { family };
        let world = WORLD.into_iter().filter(|family| mapped || family.is_ipv4() == own.is_ipv4());
        let bases = match own.ip().is_unspecified() {
            true => world.filter_map(|to| Some(SocketAddr::new(own_towards(towards(to))?, own.port()))).collect(),
            false => vec![canonical(own)],
        };
        let Meeting { relay_only, mapped: outer, router, .. } = *meeting;
        let asks = !relay_only && outer.is_none();
        let asking = asks.then(|| Asking::new(router, &bases)).flatten().map(Mutex::new);
        let config = Config { key, side, meet: place, bases, mapped: outer, relay_only };
        let carrier = Carrier::new(config, &Key::new(entropy()?), Instant::now());
        let (carrier, polled) = (Mutex::new(carrier), Mutex::new(None));
        Ok(Self { carrier, address: place, mapped, polled, asking })
    }

    fn lock(&self) -> MutexGuard<'_, Carrier> {
        self.carrier.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn send_by<'a>(&self, socket: &'a UdpSocket) -> impl FnMut(SocketAddr, &[u8]) + 'a {
        let mapped = self.mapped;
        // What the system does not take, a network may lose as well.
        move |to, bytes| drop(socket.send_to(bytes, written(to, mapped)))
    }
}

impl Road for Carried {
    fn address(&self) -> SocketAddr {
        self.address
    }

    fn poll(&self, socket: &UdpSocket) {
        let now = Instant::now();
        let mut polled = self.polled.lock().unwrap_or_else(PoisonError::into_inner);
        if polled.is_none_or(|at| now.saturating_duration_since(at) >= EVERY) {
            *polled = Some(now);
            let asking = self.asking.as_ref().map(|asking| asking.lock().unwrap_or_else(PoisonError::into_inner));
            let outer = asking.and_then(|mut asking| asking.poll(now));
            let mut carrier = self.lock();
            if let Some(outer) = outer {
                carrier.add_mapped(outer);
            }
            carrier.poll(now, &mut self.send_by(socket));
        }
    }

    fn sift(&self, came: &mut ReceivedBatch, socket: &UdpSocket) {
        let (now, mut carrier, mut send) = (Instant::now(), self.lock(), self.send_by(socket));
        came.sift(|from, datagram, waited| {
            let at = now.checked_sub(waited).unwrap_or(now);
            carrier.hear(at, canonical(from), datagram, &mut send).then_some(self.address)
        });
    }

    fn release(&self, came: &mut ReceivedBatch) {
        let (now, mut carrier) = (Instant::now(), self.lock());
        while came.has_room()
            && let Some(datagram) = carrier.release(now)
        {
            came.add(self.address, &datagram);
        }
    }

    fn say(&self, datagram: &[u8], each: &mut dyn FnMut(SocketAddr, &[u8])) -> bool {
        self.lock().send(Instant::now(), datagram, &mut |to, bytes| each(written(to, self.mapped), bytes))
    }

    fn take_change(&self) -> Option<Change> {
        self.lock().take_change()
    }

    fn report(&self) -> PathReport {
        self.lock().report()
    }
}

impl Roads for Meeting {
    fn place(&self) -> SocketAddr {
        self.place
    }

    fn open(&self, listen: Option<SocketAddr>, key: Key, side: u8) -> Result<Endpoint, Error> {
        let failed = cohold_sim::Error::cannot::<std::io::Error>("listen on", &listen.unwrap_or(self.place));
        let socket = open(self, listen).map_err(failed)?;
        let road = Carried::new(&socket, self, key, side)?;
        Endpoint::on_road(socket, Arc::new(road))
    }
}
