//! Addresses of this machine by which others on its networks reach it.

use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};

/// An address, and the name of the network interface that has it.
pub type Named = (String, Ipv4Addr);

/// Of every interface that is up, loopback included; none where the system is not asked (anything but Linux) or does not tell.
pub fn of_this_machine() -> Vec<Named> {
    #[cfg(target_os = "linux")]
    {
        use nix::net::if_::InterfaceFlags;
        let address = |one: nix::ifaddrs::InterfaceAddress| {
            let address = one.address?.as_sockaddr_in()?.ip();
            one.flags.contains(InterfaceFlags::IFF_UP).then_some((one.interface_name, address))
        };
        nix::ifaddrs::getifaddrs().map(|all| all.filter_map(address).collect()).unwrap_or_default()
    }
    #[cfg(not(target_os = "linux"))]
    Vec::new()
}

/// Any address of this machine from which a datagram can go there.
pub fn any_towards(to: SocketAddr) -> SocketAddr {
    let ip = if to.is_ipv4() { Ipv4Addr::UNSPECIFIED.into() } else { Ipv6Addr::UNSPECIFIED.into() };
    SocketAddr::new(ip, 0)
}
