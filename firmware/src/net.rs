//! Network: the 8 ms exchange with the other peer, sealed ([`Link`]). Never waits for the network.
//!
//! Addresses are by the strap (board 1 is 192.168.77.1, board 2 192.168.77.2) or as set (`network.*`,
//! [`firmware_parts::kept`]). Flow goes from port 7701 to port 7701, one datagram each packet period, the moment the tick has
//! made it. A board without a key, or without randomness, does not open the network at all.
//!
//! A datagram that cannot be handed to the driver now (neighbour unresolved, link down, queue full) is dropped: the next
//! one is newer. Of what comes in the link takes what is authentic and newer than the last; only flow of a peer whose motors
//! are on reaches the tick. When the link lets go of the other peer, the tick does too ([`tick::LIFE`]).

use core::future::poll_fn;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use core::task::Poll;

use embassy_executor::Spawner;
use embassy_futures::poll_once;
use embassy_futures::select::{Either3, select3};
use embassy_net::udp::{PacketMetadata, UdpSocket};
use embassy_net::{DhcpConfig, IpEndpoint, Ipv4Address, Ipv4Cidr, Runner, Stack, StackResources, StaticConfigV4};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant};
use firmware_parts::exchange::{Consumer, Reader, Writer};
use firmware_parts::kept::Addresses;
use firmware_parts::packet;
use firmware_parts::record::Record;
use haptic_core::settings::Settings;
use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::link::{Config, Incoming, Link, Notice, Stage};
use haptic_protocol::wire::{Datagram, MAX_DATAGRAM};
use static_cell::{ConstStaticCell, StaticCell};

use crate::board::{Number, ethernet, flash, pace, random};
use crate::console::Console;
use crate::port;
use crate::telemetry::Telemetry;
use crate::tick::{self, Outgoing, RECORDS, Received};

/// Port of the flow.
const FLOW_PORT: u16 = 7701;

/// Datagrams handed to the driver.
pub(crate) static SENT: AtomicU32 = AtomicU32::new(0);
/// Datagrams dropped because the driver could not take them.
pub(crate) static DROPPED: AtomicU32 = AtomicU32::new(0);
/// Datagrams taken in.
pub(crate) static RECEIVED: AtomicU32 = AtomicU32::new(0);
/// Datagrams refused: not authentic, or of no use; on the operator's port too.
pub(crate) static REFUSED: AtomicU32 = AtomicU32::new(0);
/// Settings that the tick was told: the link has to agree with the other peer about them anew. Set by the console.
pub(crate) static TOLD: Signal<CriticalSectionRawMutex, Settings> = Signal::new();
/// [`Stage`] of the link to the other peer, as a number.
static STAGE: AtomicU8 = AtomicU8::new(Stage::Calling as u8);

/// How far the link to the other peer is, for a person.
pub(crate) fn stage() -> &'static str {
    const NAMES: [&str; 6] = ["calling", "joining", "idle", "running", "fading", "refused: other settings"];
    NAMES.get(usize::from(STAGE.load(Ordering::Relaxed))).copied().unwrap_or("?")
}

/// One more.
pub(crate) fn count(counter: &AtomicU32) {
    counter.fetch_add(1, Ordering::Relaxed);
}

fn address(number: Number) -> Ipv4Address {
    match number {
        Number::One => Ipv4Address::new(192, 168, 77, 1),
        Number::Two => Ipv4Address::new(192, 168, 77, 2),
    }
}

/// Brings the link up and starts everything that talks. A PHY that does not answer stops it here, and nothing else.
#[embassy_executor::task]
pub(crate) async fn start(
    pins: ethernet::Pins,
    number: Number,
    outgoing: Reader<'static, Outgoing>,
    incoming: Writer<'static, Received>,
    records: Consumer<'static, Record, RECORDS>,
    console: Console,
) {
    let Some(key) = flash::key() else {
        defmt::error!("no key: this board talks to nobody and cannot be armed; cargo xtask provision gives it one");
        return;
    };
    let (settings, addresses) = (console.applied.settings, console.applied.addresses);
    static OPERATOR: StaticCell<Link> = StaticCell::new();
    static PEER: StaticCell<Link> = StaticCell::new();
    let operator = place(&OPERATOR, || port::link(&key, number, random::draw()?));
    let link = place(&PEER, || connect(&key, number, &settings));
    let (Some(operator), Some(link)) = (operator, link) else {
        defmt::error!("no randomness: this board talks to nobody and cannot be armed; its noise source has failed");
        return;
    };
    // The stack is not for sharing between executors: its tasks are spawned from the one they run on.
    // SAFETY: this future is polled by the executor of a task, which never ends.
    let spawner = unsafe { Spawner::for_current_executor() }.await;
    let (stack, runner) = stack(ethernet::start(pins, number), number, addresses);
    let peer = IpEndpoint::new(addresses.peer.unwrap_or(address(number.other())).into(), FLOW_PORT);
    let flow = Flow { key, number, link, peer, outgoing, incoming, apart: false, outdated: false };
    spawner.spawn(defmt::unwrap!(exchange(stack, flow)));
    spawner.spawn(defmt::unwrap!(run(runner)));
    spawner.spawn(defmt::unwrap!(port::run(stack, console, operator, Telemetry::new(records))));
}

/// The stack on its address, and what runs it.
fn stack(
    device: ethernet::Device,
    number: Number,
    addresses: Addresses,
) -> (Stack<'static>, Runner<'static, ethernet::Device>) {
    static RESOURCES: StaticCell<StackResources<6>> = StaticCell::new();
    let own = addresses.own.unwrap_or(address(number));
    let config = if addresses.dhcp {
        embassy_net::Config::dhcpv4(DhcpConfig::default())
    } else {
        embassy_net::Config::ipv4_static(StaticConfigV4 {
            address: Ipv4Cidr::new(own, 24),
            gateway: addresses.gateway,
            dns_servers: Default::default(),
        })
    };
    // The seed picks port numbers and DHCP's transactions only; it is no secret.
    embassy_net::new(device, config, RESOURCES.init(StackResources::new()), 1 + number as u64)
}

/// Makes a link where it is to stay: it is 4 kB, and this function's stack is gone when it returns.
#[inline(never)]
fn place(cell: &'static StaticCell<Link>, make: impl FnOnce() -> Option<Link>) -> Option<&'static mut Link> {
    make().map(|link| cell.init(link))
}

/// A link to the other peer that begins to call; `None` without randomness.
fn connect(key: &Key, number: Number, settings: &Settings) -> Option<Link> {
    let timing = &settings.timing;
    Link::new(Config {
        key: key.clone(),
        ends: Ends { local: number.peer(), remote: number.other().peer() },
        packet_period_us: (1e6 * timing.control_period_s * f64::from(timing.ticks_per_packet)) as u32,
        parameters: packet::parameters(settings),
        entropy: random::draw()?,
    })
    .ok()
}

/// Runs the stack.
#[embassy_executor::task]
async fn run(mut runner: Runner<'static, ethernet::Device>) -> ! {
    runner.run().await
}

/// Hands a datagram to the stack if it takes it now.
async fn send_now(socket: &UdpSocket<'_>, bytes: &[u8], to: IpEndpoint) -> bool {
    poll_fn(|cx| Poll::Ready(matches!(socket.poll_send_to(bytes, to, cx), Poll::Ready(Ok(()))))).await
}

/// A socket that only sends, and whose datagrams never wait for somebody who is not there.
///
/// The stack sends a socket's datagrams in order, and keeps one whose receiver does not answer ARP for ever: a single
/// stranger would silence the port. So what has waited for [`Sender::PATIENCE`] is thrown away, with all behind it.
///
/// Limit: after it looked for a stranger in vain the stack keeps the socket silent for up to a second.
pub(crate) struct Sender<'a> {
    socket: UdpSocket<'a>,
    port: u16,
    waiting_since: Option<Instant>,
}

impl<'a> Sender<'a> {
    const PATIENCE: Duration = Duration::from_millis(50);

    /// Sends from `port`. What comes in for that port must be another socket's, made before this one.
    pub(crate) fn new(socket: UdpSocket<'a>, port: u16) -> Self {
        let mut sender = Self { socket, port, waiting_since: None };
        sender.bind();
        sender
    }

    fn bind(&mut self) {
        if self.socket.bind(self.port).is_err() {
            defmt::panic!("port {=u16} cannot be bound", self.port);
        }
    }

    /// Throws away what has waited too long; call now and then.
    pub(crate) fn tend(&mut self) {
        if poll_once(self.socket.flush()).is_ready() {
            self.waiting_since = None;
        } else if self.waiting_since.get_or_insert_with(Instant::now).elapsed() > Self::PATIENCE {
            self.socket.close();
            self.bind();
            self.waiting_since = None;
        }
    }

    /// Hands a datagram to the stack if it takes it now.
    pub(crate) async fn send(&mut self, bytes: &[u8], to: IpEndpoint) -> bool {
        self.tend();
        send_now(&self.socket, bytes, to).await
    }
}

/// The flow to and from the other peer.
struct Flow {
    key: Key,
    number: Number,
    link: &'static mut Link,
    peer: IpEndpoint,
    outgoing: Reader<'static, Outgoing>,
    incoming: Writer<'static, Received>,
    /// The other peer's motors have gone off since its last flow that counted.
    apart: bool,
    /// The link still has the old settings.
    outdated: bool,
}

impl Flow {
    /// Takes a datagram.
    fn receive(&mut self, datagram: &mut [u8]) {
        let taken = self.link.receive(now(), datagram);
        // Before the flow is handed on: it may be the first of another life of the other peer.
        self.heed();
        match taken {
            Ok(Some(Incoming::Flow(flow))) => {
                count(&RECEIVED);
                if self.outdated {
                    return;
                }
                if !flow.engaged {
                    self.apart = true;
                } else {
                    if core::mem::take(&mut self.apart) {
                        // Armed anew it counts from zero, from another place: nothing that came before goes with it.
                        tick::LIFE.fetch_add(1, Ordering::Release);
                    }
                    let life = tick::LIFE.load(Ordering::Relaxed);
                    self.incoming.write(Received { life, packet: packet::packet(&flow) });
                }
            }
            Ok(_) => {}
            Err(_) => count(&REFUSED),
        }
    }

    /// What the link has noticed.
    fn heed(&mut self) {
        while let Some(notice) = self.link.take_notice() {
            match notice {
                Notice::Joined => defmt::info!("peer: joined"),
                Notice::NewPeer { .. } => defmt::info!("peer: has started anew"),
                Notice::Engaged => defmt::info!("peer: engaged, flow comes"),
                Notice::Fading => defmt::warn!("peer: fading, no flow for 3 packets"),
                Notice::Resumed => defmt::info!("peer: resumed, flow again"),
                Notice::Disengaged => {
                    defmt::warn!("peer: disengaged, no flow for 12 packets or another session");
                    tick::LIFE.fetch_add(1, Ordering::Release);
                }
                Notice::Lost => defmt::warn!("peer: lost, silent for 12 packets or another session"),
                Notice::Refused { table } => {
                    defmt::error!("peer: refused, it was told other settings: table {=str}", table);
                }
            }
        }
        STAGE.store(self.link.stage() as u8, Ordering::Relaxed);
    }

    /// Other settings: the other peer has to be told them too before the two meet again.
    #[inline(never)]
    fn told(&mut self, settings: &Settings) {
        tick::LIFE.fetch_add(1, Ordering::Release);
        if let Some(link) = connect(&self.key, self.number, settings) {
            *self.link = link;
            self.outdated = false;
        } else {
            self.outdated = true;
            defmt::error!("peer: no randomness for a new session, so no peer: the old session has the old settings");
        }
    }
}

fn now() -> u64 {
    Instant::now().as_micros()
}

/// Sends what the tick made, the moment it made it, and takes in what the other peer sent.
#[embassy_executor::task]
async fn exchange(stack: Stack<'static>, mut flow: Flow) -> ! {
    static RX_META: ConstStaticCell<[PacketMetadata; 8]> = ConstStaticCell::new([PacketMetadata::EMPTY; 8]);
    static TX_META: ConstStaticCell<[PacketMetadata; 8]> = ConstStaticCell::new([PacketMetadata::EMPTY; 8]);
    static RX: ConstStaticCell<[u8; 1024]> = ConstStaticCell::new([0; 1024]);
    static TX: ConstStaticCell<[u8; 1024]> = ConstStaticCell::new([0; 1024]);
    let mut socket = UdpSocket::new(stack, RX_META.take(), RX.take(), TX_META.take(), TX.take());
    if socket.bind(FLOW_PORT).is_err() {
        defmt::panic!("the flow's port cannot be bound");
    }
    let (mut bytes, mut out): (Datagram, Datagram) = ([0; MAX_DATAGRAM], [0; MAX_DATAGRAM]);
    loop {
        match select3(pace::rung(), socket.recv_from(&mut bytes), TOLD.wait()).await {
            Either3::First(()) => {
                if let Some(Outgoing { tick, armed, packet }) = flow.outgoing.take()
                    && !flow.outdated
                    && let Some(length) = flow.link.send_flow(now(), &packet::flow(packet, armed, tick), &mut out)
                {
                    let sent = send_now(&socket, out.get(..length).unwrap_or_default(), flow.peer).await;
                    count(if sent { &SENT } else { &DROPPED });
                }
            }
            Either3::Second(Ok((length, _))) => flow.receive(bytes.get_mut(..length).unwrap_or_default()),
            Either3::Second(Err(_)) => count(&REFUSED),
            Either3::Third(settings) => flow.told(&settings),
        }
        while let Some(length) = flow.link.poll(now(), &mut out) {
            // What the link repeats by itself needs no count.
            send_now(&socket, out.get(..length).unwrap_or_default(), flow.peer).await;
        }
        flow.heed();
    }
}
