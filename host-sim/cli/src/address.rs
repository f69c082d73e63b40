//! Addresses on the command line: numbers, names that this system resolves (`lab.local`), and link-local addresses with their zone.

use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs};

use super::Failure;

/// An address with its port; of a name that has several the first of IPv4, if it has one.
pub fn endpoint(text: &str) -> Result<SocketAddr, Failure> {
    endpoint_at(text, None)
}

/// An address whose port is this one unless it says another.
pub fn endpoint_at(text: &str, port: Option<u16>) -> Result<SocketAddr, Failure> {
    let no = |why: &str| Failure::from(format!("{text} is no address: {why}"));
    // An IPv6 address has colons of its own: with a port it stands in brackets.
    let split = text.rsplit_once(':').filter(|(host, _)| host.ends_with(']') || !host.contains(':'));
    let (host, port) = split.map_or((text, port), |(host, port)| (host, port.parse().ok()));
    let host = host.strip_prefix('[').and_then(|host| host.strip_suffix(']')).unwrap_or(host);
    // The system takes 192.168.77 for 192.168.0.77.
    let cut = host.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.') && host.parse::<Ipv4Addr>().is_err();
    let port = port.filter(|_| !cut && !host.is_empty());
    let port = port.ok_or_else(|| no("it must be like 192.168.77.1:7701, lab.local:7701 or [fe80::1%eth0]:7701"))?;
    let found: Vec<_> = (host, port).to_socket_addrs().map_err(|cause| no(&cause.to_string()))?.collect();
    let first = found.iter().find(|address| address.is_ipv4()).or(found.first());
    first.copied().ok_or_else(|| no("the name has none"))
}

#[cfg(test)]
#[path = "../tests/inside/address.rs"]
mod tests;
