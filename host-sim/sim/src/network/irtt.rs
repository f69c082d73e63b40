//! Round trips that irtt measured ([`irtt client -o FILE`](https://github.com/heistp/irtt)), as a trace: the client is peer 1.
//!
//! | irtt | here |
//! |---|---|
//! | `delay.send`, `delay.receive`, ns | the delay from peer 1 to 2, and back, less the least of its direction: what is constant goes with it. Clocks that drift, or are set, are found ([`super::clocks`]) |
//! | `delay.rtt` alone (no clock at the server) | half of it each way, less half of the least |
//! | `lost` = true_up, true_down | lost from peer 1 to 2; back. What is not known of the other direction is as it was the round trip before |
//! | `lost` = true | lost in both directions |
//! | `config.params.interval`, ns | for how long the network is as a round trip found it, whatever the packet period of a scene is |

use serde::Deserialize;
use serde_json::Value;

use super::measured::{self, Measured};

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
    let wrong = |at: usize, what: &str| format!("round_trips[{at}]: {what}");
    let trip = |(at, trip): (usize, &RoundTrip)| {
        if trip.seqno != at as u64 {
            return Err(wrong(at, &format!("seqno {} must be {at}", trip.seqno)));
        }
        let lost = match &trip.lost {
            Value::Bool(lost) => [*lost; 2],
            Value::String(lost) if lost == "false" => [false; 2],
            Value::String(lost) if lost == "true" => [true; 2],
            Value::String(lost) if lost == "true_up" => [true, false],
            Value::String(lost) if lost == "true_down" => [false, true],
            _ => return Err(wrong(at, "lost must be false, true, true_up or true_down")),
        };
        let Delay { send, receive, rtt } = trip.delay;
        let each_way = send.zip(receive).map(|(send, receive)| [send, receive]);
        Ok(measured::RoundTrip { lost, delay_ns: each_way.or(rtt.map(|both| [both / 2; 2])) })
    };
    let trips = round_trips.iter().enumerate().map(trip).collect::<Result<Vec<_>, _>>()?;
    Measured::of(every_ns, &trips).map_err(|(at, what)| at.map_or(what.to_owned(), |at| wrong(at, what)))
}
