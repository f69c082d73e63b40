//! What made a recording, and which clock its times are of.

use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use cohold_report::Provenance;

/// What made a recording, and when.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Version of the program.
    pub version: String,
    /// A scene file with a table `[made]`, as beside other files.
    pub provenance: String,
    /// Who recorded: `peer 1`, `hub`, `operator of board 2`, `both peers`.
    pub who: String,
    /// Unix time at time 0, ns: programs show it; it is no clock to compare by.
    pub start_unix_ns: u64,
    /// The clock that times are of: of two recordings that name the same one, times differ by their starts alone.
    pub clock: String,
    /// What that clock showed at time 0, ns.
    pub start_clock_ns: u64,
}

impl Origin {
    /// Recorded on this machine's clock, with time 0 at `start`.
    pub fn here(provenance: &Provenance, who: impl Into<String>, start: Instant) -> Self {
        let (since, (clock_ns, unix_ns)) = at_once(start, || {
            let unix_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos() as u64;
            (monotonic_ns(), unix_ns)
        });
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            provenance: provenance.toml(),
            who: who.into(),
            start_unix_ns: unix_ns.saturating_sub(since),
            clock: boot(),
            start_clock_ns: clock_ns.unwrap_or(0).saturating_sub(since),
        }
    }

    /// Origin of a recording in simulated time.
    pub fn simulated(provenance: &Provenance, who: impl Into<String>) -> Self {
        let start = Self::here(provenance, who, Instant::now());
        Self { clock: String::new(), start_clock_ns: 0, ..start }
    }

    /// How long after time 0 that is, s.
    pub fn since_s(&self, unix_ns: u64) -> f64 {
        (unix_ns as i64 - self.start_unix_ns as i64) as f64 * 1e-9
    }

    /// As they stand in the file.
    pub(super) fn facts(&self) -> Vec<(&'static str, String)> {
        vec![
            ("who", self.who.clone()),
            ("version", self.version.clone()),
            ("scene", self.provenance.clone()),
            ("start_unix_ns", self.start_unix_ns.to_string()),
            ("clock", self.clock.clone()),
            ("start_clock_ns", self.start_clock_ns.to_string()),
        ]
    }

    /// As they stood in a file.
    pub(super) fn of_facts(fact: impl Fn(&str) -> String) -> Self {
        let number = |name| fact(name).parse().unwrap_or(0);
        Self {
            version: fact("version"),
            provenance: fact("scene"),
            who: fact("who"),
            start_unix_ns: number("start_unix_ns"),
            clock: fact("clock"),
            start_clock_ns: number("start_clock_ns"),
        }
    }
}

/// What `read` shows, and how long after `start` it did, ns: the quickest of a few tries, for a busy machine may halt any of
/// them between two clocks for longer than what [`merge`](super::merge) judges by them.
fn at_once<T>(start: Instant, read: impl Fn() -> T) -> (u64, T) {
    const TRIES: usize = 16;
    let look = || {
        let before = start.elapsed();
        let shown = read();
        (start.elapsed() - before, before, shown)
    };
    let quicker =
        |best: (Duration, Duration, T), next: (Duration, Duration, T)| if next.0 < best.0 { next } else { best };
    let (took, before, shown) = (1..TRIES).map(|_| look()).fold(look(), quicker);
    ((before + took / 2).as_nanos() as u64, shown)
}

/// This machine since it was started: what its steady clock counts from. Empty where the system does not tell.
fn boot() -> String {
    let id = std::fs::read_to_string(Path::new("/proc/sys/kernel/random/boot_id")).unwrap_or_default();
    id.trim().to_owned()
}

/// The steady clock, which [`Instant`] reads as well, as a number, ns.
fn monotonic_ns() -> Option<u64> {
    #[cfg(target_os = "linux")]
    {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        Some(now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64)
    }
    #[cfg(not(target_os = "linux"))]
    None
}

#[cfg(test)]
#[path = "../../tests/inside/recording_origin.rs"]
mod tests;
