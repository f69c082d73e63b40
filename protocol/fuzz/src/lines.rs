//! Two ends that say lines of text to each other over links and a wire that the script commands: what is heard is what was said,
//! whole, once and in order; and in the end all of it. A third says events that are no such lines: they come to something.

use cohold_protocol::lease::Word;
use cohold_protocol::lines::{END, Heard, LONGEST, Lines, PART};
use cohold_protocol::link::Link;
use cohold_protocol::wire::{Event, MAX_DATAGRAM};

use super::net::Net;
use super::pair;
use super::script::Script;

/// What a line of this text is when it is heard: as much as goes into 384 bytes, by whole characters.
fn cut(text: &str) -> &str {
    let end = (0..=text.len().min(LONGEST)).rev().find(|end| text.is_char_boundary(*end));
    &text[..end.expect("0 is a boundary")]
}

struct End {
    link: Link,
    lines: Lines,
    /// What the other end is to hear, and how much of it was heard.
    said: Vec<String>,
    heard: usize,
}

/// What `link` has to say sets out.
fn poll(ends: &mut [End; 2], at: usize, now: u64, net: &mut Net<Vec<u8>>) {
    let End { link, lines, .. } = &mut ends[at];
    let mut out = [0; MAX_DATAGRAM];
    lines.push(link);
    while let Some(len) = link.poll(now, &mut out) {
        net.send(at, 1 - at, out[..len].to_vec());
    }
}

fn receive(ends: &mut [End; 2], to: usize, mut datagram: Vec<u8>, now: u64) {
    let [one, two] = ends;
    let (End { link, lines, .. }, other) = if to == 0 { (one, two) } else { (two, one) };
    // A copy, or one that is too old, is refused.
    let _ = link.receive(now, &mut datagram);
    while let Some(Heard { line, .. }) = lines.hear(now, link) {
        assert_eq!(other.said.get(other.heard).map(String::as_str), Some(line.as_str()));
        other.heard += 1;
    }
}

/// Runs one fuzz input through two ends that send each other lines.
pub(super) fn run(bytes: &[u8]) {
    anything(bytes);
    let end = |link| End { link, lines: Lines::default(), said: Vec::new(), heard: 0 };
    let mut ends = pair::joined().map(end);
    let (mut net, mut script, mut now) = (Net::new(), Script(bytes), 5_000);
    while script.goes_on() {
        let call = script.byte();
        let at = usize::from(call >> 7);
        match call % 8 {
            0 => now += script.time_us() / 64,
            1 | 2 => poll(&mut ends, at, now, &mut net),
            3 | 4 => {
                if let Some((_, to, datagram)) = net.deliver(&mut script) {
                    receive(&mut ends, to, datagram, now);
                }
            }
            5 => net.lose(&mut script),
            _ => {
                let len = usize::from(script.byte()) * 2;
                let text = String::from_utf8_lossy(script.bytes(len)).repeat(1 + usize::from(call >> 4 & 3));
                let End { lines, said, .. } = &mut ends[at];
                if lines.say(&text, Word::default()) {
                    said.push(cut(&text).to_owned());
                }
            }
        }
    }
    // Peace. A line is 9 parts at most; events that were lost wait for a second at most.
    let end = now + 8_000_000;
    while ends.iter().any(|end| end.heard < end.said.len() || end.lines.is_saying()) {
        assert!(now < end, "a line does not come");
        now += 8_000;
        for at in [0, 1] {
            poll(&mut ends, at, now, &mut net);
        }
        for (_, to, datagram) in net.take_all() {
            receive(&mut ends, to, datagram, now);
        }
    }
}

/// Events with any bytes, of lines or not: what is heard is the text that they begin with, up to the longest line.
fn anything(bytes: &[u8]) {
    let [mut one, mut two] = pair::joined();
    let (mut lines, mut script, mut now) = (Lines::default(), Script(bytes), 5_000);
    let (mut out, mut so_far, mut wanted) = ([0; MAX_DATAGRAM], Vec::new(), Vec::new());
    while script.goes_on() {
        let (code, len) = ([PART, PART, END, 7][script.below(4)], script.below(49));
        let payload = script.bytes(len);
        one.push_event(Event::new(code, payload).expect("a short payload")).expect("each is acknowledged at once");
        if code != 7 {
            // The last part begins with a token.
            let text = if code == END { payload.get(8..).unwrap_or(payload) } else { payload };
            so_far.extend(text);
        }
        if code == END {
            so_far.truncate(LONGEST);
            let whole = std::str::from_utf8(&so_far).map_or_else(|wrong| wrong.valid_up_to(), |text| text.len());
            wanted.push(so_far[..whole].to_vec());
            so_far.clear();
        }
        now += 1_000;
        while let Some(len) = one.poll(now, &mut out) {
            let _ = two.receive(now, &mut out[..len]);
        }
        while let Some(Heard { line, .. }) = lines.hear(now, &mut two) {
            assert_eq!(line.as_bytes(), wanted.remove(0));
        }
        while let Some(len) = two.poll(now, &mut out) {
            let _ = one.receive(now, &mut out[..len]);
        }
    }
    assert!(wanted.is_empty());
}
