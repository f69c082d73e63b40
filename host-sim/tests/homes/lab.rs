//! Two homes with the same private network behind a router each, and a meeting place outside: five network namespaces of this machine, made for one
//! test and removed after it. Routers are the kernel's, by nftables. A board may be beside the PC of a home, on a network that nobody else is on.

use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use super::peers::{COHOLD, Running, peer};

pub(crate) const PLACE: &str = "203.0.113.1:4000";
/// The port that both peers use inside.
const PORT: u16 = 40_000;

/// How a router gives out ports, and what else it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Router {
    /// One outer port for an inner one, whoever it writes to.
    Kept,
    /// Another for each.
    Symmetric,
    /// As symmetric, and one port is passed on to the host, as PCP, NAT-PMP or UPnP would have it.
    Mapped,
    /// As kept, but it takes a stranger's datagram as a flow of its own.
    Open,
}

fn run(program: &str, words: &str, input: Option<&str>) {
    use std::io::Write;
    let mut command = Command::new(program);
    command.args(words.split_whitespace()).stdin(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap_or_else(|cause| panic!("{program}: {cause}"));
    let mut pipe = child.stdin.take().expect("a pipe");
    pipe.write_all(input.unwrap_or_default().as_bytes()).expect("it reads");
    drop(pipe);
    assert!(child.wait().expect("it ends").success(), "{program} {words}");
}

pub(crate) struct Lab {
    /// What its namespaces' names begin with.
    prefix: String,
    namespaces: Vec<&'static str>,
    place: Option<Running>,
}

/// A board beside a PC, and that PC there.
pub(crate) const BESIDE: [&str; 2] = ["192.168.77.1:7701", "192.168.77.10:7701"];

impl Lab {
    /// Homes behind these routers; with `v6` each has a network of IPv6 as well, behind a firewall that keeps states.
    pub(crate) fn new(routers: [Router; 2], v6: [bool; 2]) -> Self {
        let mut lab = Self::bare();
        for (home, host) in [("a", 11), ("b", 12)] {
            lab.home(home, host, routers[host - 11], v6[host - 11]);
        }
        lab.opens();
        lab
    }

    /// Namespaces, and a network outside that nobody is on but the meeting place.
    fn bare() -> Self {
        static MADE: AtomicU32 = AtomicU32::new(0);
        let prefix = format!("homes{}-{}-", std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
        let mut lab = Self { prefix, namespaces: Vec::new(), place: None };
        ["net", "ra", "rb", "a", "b"].into_iter().for_each(|name| lab.namespace(name));
        lab.ip("net", "link add br0 type bridge");
        lab.ip("net", "link set br0 up");
        lab.ip("net", "addr add 203.0.113.1/24 dev br0");
        lab
    }

    fn namespace(&mut self, name: &'static str) {
        run("ip", &format!("netns add {}{name}", self.prefix), None);
        self.namespaces.push(name);
        // Nobody asks whether an address is another's: a browser that is told of one two seconds later gives up what it is loading.
        self.sysctl(name, "net.ipv6.conf.default.accept_dad=0");
        self.ip(name, "link set lo up");
    }

    /// A board beside the PC at home `a`: its network has the two, and leads nowhere.
    pub(crate) fn puts_a_board_beside(&mut self) {
        self.namespace("board");
        run(
            "ip",
            &format!("link add eth netns {} type veth peer name beside netns {}", self.name("board"), self.name("a")),
            None,
        );
        for (at, link, host) in [("board", "eth", 1), ("a", "beside", 10)] {
            self.ip(at, &format!("link set {link} up"));
            self.ip(at, &format!("addr add 192.168.77.{host}/24 dev {link}"));
        }
    }

    /// Both homes behind one router, which keeps them apart: each has a port of it, 40001 and 40002, and what one of them sends to the other's comes back in
    /// where the router knows hairpins.
    pub(crate) fn behind_one(hairpin: bool) -> Self {
        let mut lab = Self::bare();
        let router = lab.name("ra");
        run("ip", &format!("link add wan netns {router} type veth peer name wa netns {}", lab.name("net")), None);
        lab.ip("net", "link set wa master br0 up");
        lab.ip("ra", "link set wan up");
        lab.ip("ra", "addr add 203.0.113.11/24 dev wan");
        for (home, net) in [("a", 1), ("b", 2)] {
            run(
                "ip",
                &format!("link add lan{net} netns {router} type veth peer name eth netns {}", lab.name(home)),
                None,
            );
            lab.ip("ra", &format!("link set lan{net} up"));
            lab.ip(home, "link set eth up");
            lab.ip("ra", &format!("addr add 192.168.{net}.1/24 dev lan{net}"));
            lab.ip(home, &format!("addr add 192.168.{net}.10/24 dev eth"));
            lab.ip(home, &format!("route add default via 192.168.{net}.1"));
        }
        lab.sysctl("ra", "net.ipv4.ip_forward=1");
        // Who comes back in comes as from the router, so that the answer goes through it, too.
        let (comes, back) = if hairpin {
            ("", "oifname { lan1, lan2 } ct status dnat snat to 203.0.113.11;")
        } else {
            ("iifname wan", "")
        };
        let rules = format!(
            "table ip nat {{
                chain post {{ type nat hook postrouting priority 100; oifname wan masquerade; {back} }}
                chain pre {{ type nat hook prerouting priority -100;
                    {comes} ip daddr 203.0.113.11 udp dport 40001 dnat to 192.168.1.10:{PORT};
                    {comes} ip daddr 203.0.113.11 udp dport 40002 dnat to 192.168.2.10:{PORT};
                }}
            }}
            table inet wall {{
                chain input {{ type filter hook input priority 0; iifname wan ct state established,related accept; iifname wan udp dport != 0 drop; }}
                chain through {{ type filter hook forward priority 0; ct state established,related accept; ct status dnat accept;
                    iifname wan drop; oifname {{ lan1, lan2 }} drop; }}
            }}"
        );
        run("ip", &format!("netns exec {router} nft -f -"), Some(&rules));
        lab.opens();
        lab
    }

    fn name(&self, of: &str) -> String {
        format!("{}{of}", self.prefix)
    }

    fn ip(&self, of: &str, words: &str) {
        run("ip", &format!("-n {} {words}", self.name(of)), None);
    }

    fn sysctl(&self, of: &str, settings: &str) {
        run("ip", &format!("netns exec {} sysctl -qw {settings}", self.name(of)), None);
    }

    fn home(&self, home: &str, host: usize, router: Router, v6: bool) {
        let (router_name, net, inner) = (self.name(&format!("r{home}")), self.name("net"), self.name(home));
        let r = format!("r{home}");
        run("ip", &format!("link add wan netns {router_name} type veth peer name w{home} netns {net}"), None);
        run("ip", &format!("link add lan netns {router_name} type veth peer name eth netns {inner}"), None);
        self.ip("net", &format!("link set w{home} master br0 up"));
        self.ip(&r, "link set wan up");
        self.ip(&r, "link set lan up");
        self.ip(home, "link set eth up");
        self.ip(&r, &format!("addr add 203.0.113.{host}/24 dev wan"));
        self.ip(&r, "addr add 192.168.1.1/24 dev lan");
        self.ip(home, "addr add 192.168.1.10/24 dev eth");
        self.ip(home, "route add default via 192.168.1.1");
        self.sysctl(&r, "net.ipv4.ip_forward=1 net.ipv6.conf.all.forwarding=1");
        if v6 {
            self.ip(&r, &format!("addr add 2001:db8:ffff::{host}/64 dev wan nodad"));
            self.ip(&r, &format!("addr add 2001:db8:{home}::1/64 dev lan nodad"));
            self.ip(home, &format!("addr add 2001:db8:{home}::10/64 dev eth nodad"));
            self.ip(home, &format!("-6 route add default via 2001:db8:{home}::1"));
            let (other, via) = if home == "a" { ("b", 12) } else { ("a", 11) };
            self.ip(&r, &format!("-6 route add 2001:db8:{other}::/64 via 2001:db8:ffff::{via}"));
        }
        let random = if matches!(router, Router::Symmetric | Router::Mapped) { "fully-random" } else { "" };
        let mapped = if router == Router::Mapped {
            format!("iifname wan udp dport {PORT} dnat to 192.168.1.10;")
        } else {
            String::new()
        };
        let closed = if router == Router::Open {
            ""
        } else {
            "iifname wan ct state established,related accept; iifname wan udp dport != 0 drop;"
        };
        let rules = format!(
            "table ip nat {{
                chain post {{ type nat hook postrouting priority 100; oifname wan masquerade {random}; }}
                chain pre {{ type nat hook prerouting priority -100; {mapped} }}
            }}
            table inet wall {{
                chain input {{ type filter hook input priority 0; {closed} }}
                chain through {{ type filter hook forward priority 0; ct state established,related accept; ct status dnat accept;
                    iifname wan udp dport != 0 drop; }}
            }}"
        );
        run("ip", &format!("netns exec {router_name} nft -f -"), Some(&rules));
    }

    /// A program there.
    pub(crate) fn program(&self, of: &str, program: &str) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.name(of), program]);
        command
    }

    /// This program there.
    pub(crate) fn exec(&self, of: &str) -> Command {
        self.program(of, COHOLD)
    }

    /// The meeting place opens.
    pub(crate) fn opens(&mut self) {
        let mut command = self.exec("net");
        command.args(["meet", "--listen", PLACE]);
        let place = Running::start(command);
        place.says("meeting place on");
        self.place = Some(place);
    }

    /// It is killed.
    pub(crate) fn closes(&mut self) {
        if let Some(place) = self.place.take() {
            place.kill();
        }
    }

    /// A peer at home `a` or `b`, always from the same inner port.
    pub(crate) fn peer(&self, home: &str, seconds: u32, more: &[&str]) -> Running {
        let listen = format!("0.0.0.0:{PORT}");
        peer(self.exec(home), seconds, &[&["--listen", &listen], more].concat())
    }

    /// Whatever goes from router a to router b, or back, is dropped, but what goes by the meeting place.
    pub(crate) fn cut(&self, cut: bool) {
        let router = self.name("ra");
        if cut {
            let rules = "table inet cut {
                chain cut { type filter hook forward priority -10; ip daddr 203.0.113.12 drop; ip saddr 203.0.113.12 drop; }
            }";
            run("ip", &format!("netns exec {router} nft -f -"), Some(rules));
        } else {
            run("ip", &format!("netns exec {router} nft delete table inet cut"), None);
        }
    }

    /// Both routers lose so many of a hundred datagrams that they pass on, whatever way those go.
    pub(crate) fn loses(&self, of_a_hundred: u32) {
        let rules = format!(
            "table inet lossy {{
                chain lossy {{ type filter hook forward priority -5; meta l4proto udp numgen random mod 100 < {of_a_hundred} drop; }}
            }}"
        );
        for router in ["ra", "rb"] {
            run("ip", &format!("netns exec {} nft -f -", self.name(router)), Some(&rules));
        }
    }

    /// Router a forgets all that it has mapped: its line goes down and comes back.
    pub(crate) fn forgets(&self) {
        self.ip("ra", "link set wan down");
        self.ip("ra", "link set wan up");
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        self.closes();
        for name in &self.namespaces {
            let _ = Command::new("ip").args(["netns", "del", &self.name(name)]).status();
        }
    }
}
