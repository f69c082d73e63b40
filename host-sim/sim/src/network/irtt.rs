//! Round trips that irtt measured ([`irtt client -o FILE.json`](https://github.com/heistp/irtt)), as a trace: the client is peer 1.
//!
//! | irtt | here |
//! |---|---|
//! | `delay.send`, `delay.receive`, ns | the delay from peer 1 to 2, and back, less the least of its direction: what is constant, and by how much the clocks differ, goes with it |
//! | `delay.rtt` alone (no clock at the server) | half of it each way, less half of the least |
//! | `lost` = true_up, true_down | lost from peer 1 to 2; back. What is not known of the other direction is as it was the round trip before |
//! | `lost` = true | lost in both directions |
//! | `config.params.interval`, ns | for how long the network is as a round trip found it, whatever the packet period of a scene is |
//!
//! Clocks that drift apart during the measurement are in the delays: 20 ppm are 1.2 ms in a minute. NTP keeps them within a fraction of that.

use serde::Deserialize;
use serde_json::Value;

use super::trace::Arrival;

/// What is read of irtt's file.
#[derive(Debug, Deserialize)]
struct File {
    config: Config,
    round_trips: Vec<RoundTrip>,
}

#[derive(Debug, Deserialize)]
struct Config {
    params: Params,
}

#[derive(Debug, Deserialize)]
struct Params {
    interval: u64,
}

#[derive(Debug, Deserialize)]
struct RoundTrip {
    seqno: u64,
    lost: Value,
    #[serde(default)]
    delay: Delay,
}

/// In ns; one way it is of two clocks, and may be below 0.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
struct Delay {
    send: Option<i64>,
    receive: Option<i64>,
    rtt: Option<i64>,
}

impl Delay {
    fn each_way(self) -> [Option<i64>; 2] {
        match (self.send, self.receive, self.rtt) {
            (Some(send), Some(receive), _) => [Some(send), Some(receive)],
            (_, _, Some(both)) => [Some(both / 2); 2],
            _ => [None; 2],
        }
    }
}

/// What a measurement says.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// Of each direction, what became of a packet in each interval.
    pub(super) packets: [Vec<Vec<Arrival>>; 2],
    /// The interval, ns.
    pub(super) every_ns: u64,
    /// Half of the quickest round trip, ns.
    pub(super) constant_ns: u64,
}

/// Longest delay that is taken, ns: 10,000 s.
const LONGEST_NS: i64 = 10_000_000_000_000;

/// Reads what irtt wrote.
///
/// # Errors
/// What is missing or wrong, in one sentence.
pub(super) fn read(bytes: &[u8]) -> Result<Measured, String> {
    let File { config, round_trips } =
        serde_json::from_slice(bytes).map_err(|cause| format!("not what irtt writes: {cause}"))?;
    let every_ns = config.params.interval;
    if every_ns == 0 {
        return Err("config.params.interval = 0 is not allowed: it must be at least 1 ns".to_owned());
    }
    let delays: Vec<[Option<i64>; 2]> = round_trips.iter().map(|trip| trip.delay.each_way()).collect();
    let quickest = round_trips.iter().filter_map(|trip| trip.delay.rtt).min().ok_or("no round trip came back")?;
    let bases = [0, 1].map(|way| delays.iter().filter_map(|delay| delay[way]).min().unwrap_or(0));
    let mut packets = [Vec::new(), Vec::new()];
    let mut last_ns = [0_u64; 2];
    for (at, (trip, delay)) in round_trips.iter().zip(&delays).enumerate() {
        let wrong = |what: &str| format!("round_trips[{at}]: {what}");
        if trip.seqno != at as u64 {
            return Err(wrong(&format!("seqno {} must be {at}", trip.seqno)));
        }
        let lost = match &trip.lost {
            Value::Bool(lost) => [*lost; 2],
            Value::String(lost) if lost == "false" => [false; 2],
            Value::String(lost) if lost == "true" => [true; 2],
            Value::String(lost) if lost == "true_up" => [true, false],
            Value::String(lost) if lost == "true_down" => [false, true],
            _ => return Err(wrong("lost must be false, true, true_up or true_down")),
        };
        for (way, half) in packets.iter_mut().enumerate() {
            if let Some(delay) = delay[way] {
                let more = delay.saturating_sub(bases[way]);
                if more > LONGEST_NS {
                    return Err(wrong("a delay is longer than 10000 s"));
                }
                last_ns[way] = more.unsigned_abs();
            } else if lost == [false; 2] {
                return Err(wrong("it is not lost and has no delay"));
            }
            let arrival = Arrival { delay_ns: last_ns[way], corrupt: false };
            half.push(if lost[way] { Vec::new() } else { vec![arrival] });
        }
    }
    Ok(Measured { packets, every_ns, constant_ns: (quickest / 2).max(0).unsigned_abs() })
}
