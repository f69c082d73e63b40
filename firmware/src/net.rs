//! Network: the stack on its address, and everything that talks over it.
//!
//! Addresses are by the strap (board 1 is 192.168.77.1, board 2 192.168.77.2) or as set (`network.*`,
//! [`firmware_parts::kept`]). A board without its two keys, or without randomness, does not open the network at all.

use cohold_core::settings::Settings;
use cohold_protocol::{
    key::Key,
    link::{ConfigError, Link},
    peer::Lives,
};
use embassy_executor::Spawner;
use embassy_net::{DhcpConfig, IpEndpoint, Ipv4Address, Ipv4Cidr, Runner, Stack, StackResources, StaticConfigV4};
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::kept::Addresses;
use firmware_parts::keys::Keyless;
use static_cell::StaticCell;

use crate::board::{Number, cable, flash};
use crate::flow::{self, Flow};
use crate::tick::{Outgoing, Received};
use crate::{console::Console, port, serial, telemetry::Telemetry};

fn address(number: Number) -> Ipv4Address {
    Ipv4Address::new(192, 168, 77, number as u8 + 1)
}

/// Brings the link up and starts everything that talks. A PHY that does not answer stops it here, and nothing else.
#[embassy_executor::task]
pub(crate) async fn start(
    pins: cable::Pins,
    number: Number,
    outgoing: Reader<'static, Outgoing>,
    incoming: Writer<'static, Received>,
    telemetry: Telemetry,
    console: Console,
) {
    let (addresses, signals) = (console.applied.addresses, console.signals);
    let lives = Lives::new(flow::bounds(&console.applied.settings));
    // The stack is not for sharing between executors: its tasks are spawned from the one they run on.
    // SAFETY: this future is polled by the executor of a task, which never ends.
    let spawner = unsafe { Spawner::for_current_executor() }.await;
    let (plugged, port) = cable::plug(pins, number, &spawner);
    serial::start(port, &spawner);
    let Some(Links { key, seed, operator, peer: link }) = links(number, &console.applied.settings) else { return };
    let (stack, runner) = stack(cable::open(plugged), number, addresses);
    let peer = IpEndpoint::new(addresses.peer.unwrap_or(address(number.other())).into(), flow::PORT);
    let flow = Flow { key, seed, number, link, peer, outgoing, incoming, signals, lives, outdated: false };
    spawner.spawn(defmt::unwrap!(flow::run(stack, flow)));
    spawner.spawn(defmt::unwrap!(run(runner)));
    spawner.spawn(defmt::unwrap!(port::run(stack, console, operator, telemetry)));
}

/// The board's two links, the peers' key, and what random bytes are mixed with.
struct Links {
    key: Key,
    seed: Key,
    operator: &'static mut Link,
    peer: &'static mut Link,
}

/// Says why there are no links, in the log and at the serial port.
macro_rules! silent {
    ($why:literal) => {{
        defmt::error!($why);
        serial::say($why);
        return None;
    }};
}

/// Makes the links, or says why this board talks to nobody.
#[inline(never)]
fn links(number: Number, settings: &Settings) -> Option<Links> {
    static OPERATOR: StaticCell<Made> = StaticCell::new();
    static PEER: StaticCell<Made> = StaticCell::new();
    let keys = match flash::keys() {
        Ok(keys) => keys,
        Err(Keyless::NoPeers) => silent!("no peers' key: this board talks to nobody and cannot be armed"),
        Err(Keyless::NoOperator) => silent!("no operator's key: this board talks to nobody and cannot be armed"),
        Err(Keyless::Single) => {
            silent!("one key for peers and operator, of a version before: this board talks to nobody")
        }
        Err(Keyless::Same) => silent!("peers' key and operator's are the same: this board talks to nobody"),
    };
    let seed = keys.seed();
    let operator = place(&OPERATOR, || port::link(&keys.operator, &seed, number));
    let peer = place(&PEER, || flow::connect(&keys.peers, &seed, number, settings));
    let (Ok(operator), Ok(peer)) = (operator, peer) else {
        silent!("no randomness: this board talks to nobody and cannot be armed; its noise source has failed")
    };
    Some(Links { key: keys.peers, seed, operator, peer })
}

/// The stack on its address, and what runs it.
fn stack(
    device: cable::Device,
    number: Number,
    addresses: Addresses,
) -> (Stack<'static>, Runner<'static, cable::Device>) {
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

/// What makes a link, or says why there is none.
type Made = Result<Link, ConfigError>;

/// Makes a link where it is to stay: it is 4 kB, and this function's stack is gone when it returns.
#[inline(never)]
fn place(
    cell: &'static StaticCell<Made>,
    make: impl FnOnce() -> Made,
) -> Result<&'static mut Link, &'static ConfigError> {
    cell.init_with(make).as_mut().map_err(|why| &*why)
}

/// Runs the network stack for ever.
#[embassy_executor::task]
async fn run(mut runner: Runner<'static, cable::Device>) -> ! {
    runner.run().await
}
