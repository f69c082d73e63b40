//! Network: the stack on its address, and everything that talks over it.
//!
//! Addresses are by the strap (board 1 is 192.168.77.1, board 2 192.168.77.2) or as set (`network.*`,
//! [`firmware_parts::kept`]). A board without a key, or without randomness, does not open the network at all.

use embassy_executor::Spawner;
use embassy_net::{DhcpConfig, IpEndpoint, Ipv4Address, Ipv4Cidr, Runner, Stack, StackResources, StaticConfigV4};
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::kept::Addresses;
use haptic_protocol::link::Link;
use static_cell::StaticCell;

use crate::board::{Number, ethernet, flash, random};
use crate::flow::{self, Flow};
use crate::tick::{Outgoing, Received};
use crate::{console::Console, port, telemetry::Telemetry};

fn address(number: Number) -> Ipv4Address {
    Ipv4Address::new(192, 168, 77, number as u8 + 1)
}

/// Brings the link up and starts everything that talks. A PHY that does not answer stops it here, and nothing else.
#[embassy_executor::task]
pub(crate) async fn start(
    pins: ethernet::Pins,
    number: Number,
    outgoing: Reader<'static, Outgoing>,
    incoming: Writer<'static, Received>,
    telemetry: Telemetry,
    console: Console,
) {
    let Some(key) = flash::key() else {
        defmt::error!("no key: this board talks to nobody and cannot be armed; cargo xtask provision gives it one");
        return;
    };
    let (settings, addresses, signals) = (console.applied.settings, console.applied.addresses, console.signals);
    static OPERATOR: StaticCell<Link> = StaticCell::new();
    static PEER: StaticCell<Link> = StaticCell::new();
    let operator = place(&OPERATOR, || port::link(&key, number, random::draw(&key, number)?));
    let link = place(&PEER, || flow::connect(&key, number, &settings));
    let (Some(operator), Some(link)) = (operator, link) else {
        defmt::error!("no randomness: this board talks to nobody and cannot be armed; its noise source has failed");
        return;
    };
    // The stack is not for sharing between executors: its tasks are spawned from the one they run on.
    // SAFETY: this future is polled by the executor of a task, which never ends.
    let spawner = unsafe { Spawner::for_current_executor() }.await;
    let (stack, runner) = stack(ethernet::start(pins, number), number, addresses);
    let peer = IpEndpoint::new(addresses.peer.unwrap_or(address(number.other())).into(), flow::PORT);
    let flow = Flow { key, number, link, peer, outgoing, incoming, signals, apart: false, outdated: false };
    spawner.spawn(defmt::unwrap!(flow::run(stack, flow)));
    spawner.spawn(defmt::unwrap!(run(runner)));
    spawner.spawn(defmt::unwrap!(port::run(stack, console, operator, telemetry)));
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

/// Runs the stack.
#[embassy_executor::task]
async fn run(mut runner: Runner<'static, ethernet::Device>) -> ! {
    runner.run().await
}
