//! Network: the 8 ms exchange with the other board. Never waits for the network.
//!
//! Addresses are fixed by the strap, for a cable or a switch of its own: board 1 is 192.168.77.1, board 2 192.168.77.2, a
//! PC anything else in 192.168.77.0/24. Flow goes from port 7701 to port 7701, one datagram each packet period, the moment
//! the tick has made it.
//!
//! A datagram that cannot be handed to the driver now (neighbour unresolved, link down, queue full) is dropped: the next
//! one is newer. Of what comes in, only the other board's address is listened to, and only what is newer than the last.

use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use embassy_executor::Spawner;
use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embassy_net::udp::{PacketMetadata, UdpSocket};
use embassy_net::{IpEndpoint, Ipv4Address, Ipv4Cidr, Runner, Stack, StackResources, StaticConfigV4};
use embassy_time::{Duration, Instant};
use firmware_parts::exchange::{Consumer, Reader, Writer};
use firmware_parts::record::Record;
use haptic_core::couple::Packet;
use haptic_core::motion::Motion;
use haptic_protocol::wire::Flow;
use static_cell::{ConstStaticCell, StaticCell};

use crate::board::{Number, ethernet, pace};
use crate::console::{self, Console};
use crate::telemetry;
use crate::tick::{Outgoing, RECORDS};

/// Port of the flow.
const FLOW_PORT: u16 = 7701;

/// Datagrams handed to the driver.
pub(crate) static SENT: AtomicU32 = AtomicU32::new(0);
/// Datagrams dropped because the driver could not take them.
pub(crate) static DROPPED: AtomicU32 = AtomicU32::new(0);
/// Datagrams taken in.
pub(crate) static RECEIVED: AtomicU32 = AtomicU32::new(0);
/// Datagrams refused: not the other board's, not a flow, or late.
pub(crate) static REFUSED: AtomicU32 = AtomicU32::new(0);

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

/// The other board's address.
fn other(number: Number) -> Ipv4Address {
    match number {
        Number::One => address(Number::Two),
        Number::Two => address(Number::One),
    }
}

/// Brings the link up and starts everything that talks. A PHY that does not answer stops it here, and nothing else.
#[embassy_executor::task]
pub(crate) async fn start(
    pins: ethernet::Pins,
    number: Number,
    outgoing: Reader<'static, Outgoing>,
    incoming: Writer<'static, Packet<f32>>,
    records: Consumer<'static, Record, RECORDS>,
    console: Console,
) {
    // The stack is not for sharing between executors: its tasks are spawned from the one they run on.
    // SAFETY: this future is polled by the executor of a task, which never ends.
    let spawner = unsafe { Spawner::for_current_executor() }.await;
    let (stack, runner) = stack(ethernet::start(pins, number), number);
    spawner.spawn(defmt::unwrap!(flow(stack, number, outgoing, incoming)));
    spawner.spawn(defmt::unwrap!(run(runner)));
    spawner.spawn(defmt::unwrap!(telemetry::run(stack, records)));
    spawner.spawn(defmt::unwrap!(console::listen(stack, console)));
}

/// The stack on its fixed address, and what runs it.
fn stack(device: ethernet::Device, number: Number) -> (Stack<'static>, Runner<'static, ethernet::Device>) {
    static RESOURCES: StaticCell<StackResources<6>> = StaticCell::new();
    let config = embassy_net::Config::ipv4_static(StaticConfigV4 {
        address: Ipv4Cidr::new(address(number), 24),
        gateway: None,
        dns_servers: Default::default(),
    });
    // The seed picks port numbers only, and ours are fixed.
    embassy_net::new(device, config, RESOURCES.init(StackResources::new()), 1 + number as u64)
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

/// Sends what the tick made, the moment it made it, and takes in what the other board sent.
#[embassy_executor::task]
async fn flow(
    stack: Stack<'static>,
    number: Number,
    mut outgoing: Reader<'static, Outgoing>,
    mut incoming: Writer<'static, Packet<f32>>,
) -> ! {
    static RX_META: ConstStaticCell<[PacketMetadata; 8]> = ConstStaticCell::new([PacketMetadata::EMPTY; 8]);
    static TX_META: ConstStaticCell<[PacketMetadata; 8]> = ConstStaticCell::new([PacketMetadata::EMPTY; 8]);
    static RX: ConstStaticCell<[u8; 1024]> = ConstStaticCell::new([0; 1024]);
    static TX: ConstStaticCell<[u8; 1024]> = ConstStaticCell::new([0; 1024]);
    let mut socket = UdpSocket::new(stack, RX_META.take(), RX.take(), TX_META.take(), TX.take());
    if socket.bind(FLOW_PORT).is_err() {
        defmt::panic!("the flow's port cannot be bound");
    }
    let peer = IpEndpoint::new(other(number).into(), FLOW_PORT);
    let mut newest: Option<u32> = None;
    let mut bytes = [0; 64];
    loop {
        match select(pace::rung(), socket.recv_from(&mut bytes)).await {
            Either::First(()) => {
                let Some(out) = outgoing.take() else { continue };
                let mut datagram = [0; Flow::LEN];
                let sent = flow_of(&out).emit(&mut datagram).is_ok() && send_now(&socket, &datagram, peer).await;
                count(if sent { &SENT } else { &DROPPED });
            }
            Either::Second(Ok((length, from))) => {
                let flow = bytes.get(..length).and_then(|bytes| Flow::parse(bytes).ok());
                match flow {
                    Some(flow) if from.endpoint == peer && newest.is_none_or(|last| newer(flow.tick, last)) => {
                        newest = Some(flow.tick);
                        incoming.write(packet_of(&flow));
                        count(&RECEIVED);
                    }
                    _ => count(&REFUSED),
                }
            }
            Either::Second(Err(_)) => count(&REFUSED),
        }
    }
}

/// Newer in a count that wraps, or so much older that the sender must have started anew.
fn newer(tick: u32, last: u32) -> bool {
    const RESTARTED: u32 = 10_000;
    let ahead = tick.wrapping_sub(last);
    (1..1 << 31).contains(&ahead) || last.wrapping_sub(tick) > RESTARTED && ahead != 0
}

fn flow_of(out: &Outgoing) -> Flow {
    let Outgoing { tick, armed, packet } = *out;
    Flow {
        engaged: armed,
        tick,
        position: packet.motion.position,
        velocity: packet.motion.velocity,
        wave: packet.wave,
        wave_integral: packet.wave_integral,
        energy_sent: packet.energy_j,
        ..Flow::default()
    }
}

fn packet_of(flow: &Flow) -> Packet<f32> {
    Packet {
        motion: Motion { position: flow.position, velocity: flow.velocity },
        wave: flow.wave,
        energy_j: flow.energy_sent,
        wave_integral: flow.wave_integral,
    }
}
