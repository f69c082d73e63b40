//! The ways in to the page: this machine, and where that is asked for (`--lan`) one of its addresses on a local network.
//!
//! The two are two listeners, and a connection may do what its way in lets it: from the network hands are held and watched, and no key
//! opens the operator's role there, for what crosses a network without encryption others on it can read. A request must name, as its
//! host, exactly the address and port at which it came in.

use std::net::{Ipv4Addr, SocketAddrV4, TcpListener};

use cohold_live::addresses::Named;

use super::roles::Rights;
use cohold_cli::Failure;

/// Which way a connection came in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// From this machine, on 127.0.0.1.
    Here,
    /// From a local network.
    Lan,
}

impl Way {
    /// Whether these rights may come in this way.
    pub(super) fn admits(self, rights: Rights) -> bool {
        self == Self::Here || !rights.operates
    }
}

/// Where the page is reached.
#[derive(Clone, Debug)]
pub(super) struct Doors {
    /// Port on 127.0.0.1.
    pub(super) here: u16,
    pub(super) lan: Option<SocketAddrV4>,
}

impl Doors {
    /// Listens on 127.0.0.1, and at that address of this machine, if there is one; at any port of each where `port` is 0.
    pub(super) fn open(port: u16, lan: Option<Ipv4Addr>) -> Result<(Self, Vec<(Way, TcpListener)>), Failure> {
        let listen = |address: Ipv4Addr| {
            let at = SocketAddrV4::new(address, port);
            let failed = cohold_sim::Error::cannot::<std::io::Error>("listen on", &at);
            let listener = TcpListener::bind(at).map_err(&failed)?;
            let port = listener.local_addr().map_err(&failed)?.port();
            Ok::<_, Failure>((SocketAddrV4::new(address, port), listener))
        };
        let (here, listener) = listen(Ipv4Addr::LOCALHOST)?;
        let mut listeners = vec![(Way::Here, listener)];
        let mut doors = Self { here: here.port(), lan: None };
        if let Some(address) = lan {
            let (at, listener) = listen(address)?;
            doors.lan = Some(at);
            listeners.push((Way::Lan, listener));
        }
        Ok((doors, listeners))
    }

    /// The address of a way in, with its port; none where there is no such way.
    pub(super) fn host(&self, way: Way) -> Option<String> {
        match way {
            Way::Here => Some(format!("127.0.0.1:{}", self.here)),
            Way::Lan => self.lan.map(|at| at.to_string()),
        }
    }

    /// Whether that is the host that a request which came this way must name.
    pub(super) fn is_host(&self, way: Way, name: &str) -> bool {
        let by_name = way == Way::Here && name.strip_prefix("localhost:") == Some(&self.here.to_string());
        by_name || self.host(way).as_deref() == Some(name)
    }
}

/// The address of this machine, which has `own`, that is served where `wanted` is asked for; without one, its only private one.
///
/// # Errors
/// It is none of this machine's, or all at once, or there is not exactly one to choose.
pub(super) fn chosen(wanted: Option<Ipv4Addr>, own: &[Named]) -> Result<Ipv4Addr, String> {
    let named = |of: &[&Named]| of.iter().map(|(name, at)| format!("{at} ({name})")).collect::<Vec<_>>().join(", ");
    let others: Vec<_> = own.iter().filter(|(_, at)| !at.is_loopback()).collect();
    let has = if others.is_empty() { "no other is known".to_owned() } else { format!("it has {}", named(&others)) };
    if let Some(wanted) = wanted {
        // Where the system did not tell which it has, it says so when it listens.
        let is_own = wanted.is_loopback() || own.is_empty() || own.iter().any(|(_, at)| *at == wanted);
        return match is_own {
            _ if wanted.is_unspecified() => Err(format!(
                "--lan {wanted} would be every network of this machine, of today and later: name one address; {has}"
            )),
            true => Ok(wanted),
            false => Err(format!("--lan {wanted} is no address of this machine: {has}")),
        };
    }
    let private: Vec<_> = others.iter().copied().filter(|(_, at)| at.is_private()).collect();
    match private[..] {
        [(_, address)] => Ok(*address),
        [] => Err(format!("--lan finds no private address of this machine: {has}; name one after --lan")),
        _ => Err(format!("--lan finds more than one address: name one of {}", named(&private))),
    }
}

#[cfg(test)]
#[path = "../tests/inside/doors.rs"]
mod tests;
