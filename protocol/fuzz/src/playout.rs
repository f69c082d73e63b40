//! Packets with any tick at any time. They are played once each and in order; none earlier than the fastest packet's delay and
//! the depth after it was sent, and none left waiting longer than the slowest packet's and the depth.

use cohold_core::playout::{MOST, Playout};

use super::script::Script;

/// Runs one fuzz input, a series of packets, through a play-out buffer.
pub(super) fn run(bytes: &[u8]) {
    let mut script = Script(bytes);
    let (packets, ticks) = (u32::from(script.byte() % 8), u32::from(script.byte() % 16) + 1);
    let mut playout = Playout::new(packets, ticks);
    let depth = packets * ticks;
    // The clocks differ by anything, the sender's ticks come in order but for what the network does to them.
    let (mut now, tick_offset) = (u32::from(script.half()) << 16, u32::from(script.half()) << 16);
    let mut sent = now;
    let wild = script.byte() == 255;
    let (mut waiting, mut last) = (Vec::<u32>::new(), None::<u32>);
    // Least and most that any packet took, by the clocks as they are read.
    let mut took = None::<(u32, u32)>;
    while script.goes_on() {
        let call = script.byte();
        match call % 4 {
            0 => {
                now = now.wrapping_add(u32::from(call / 4));
                sent = sent.wrapping_add(u32::from(call / 4));
            }
            1 | 2 => {
                let late = u32::from(script.byte());
                // Sent not long ago; or, by a sender that has lost its mind, at any time.
                let tick = if wild && late > 250 { u32::from(script.half()) << 16 } else { sent.wrapping_sub(late) };
                let tick = tick.wrapping_add(tick_offset);
                let delay = now.wrapping_sub(tick);
                let (least, most) = took.unwrap_or((delay, delay));
                let before = |one: u32, two: u32| (one.wrapping_sub(two) as i32) < 0;
                took = Some((
                    if before(delay, least) { delay } else { least },
                    if before(most, delay) { delay } else { most },
                ));
                let known = waiting.contains(&tick) || last.is_some_and(|last| !before(last, tick));
                let oldest = waiting.iter().copied().reduce(|one, two| if before(one, two) { one } else { two });
                let full = waiting.len() == MOST;
                let taken = playout.put(now, tick, tick);
                let late = full && oldest.is_some_and(|oldest| before(tick, oldest));
                // Which is the oldest of ticks from everywhere, nobody can say: one or another goes.
                assert!(wild || taken != (known || late), "tick {tick} after {last:?}");
                if taken {
                    waiting.retain(|other| *other != tick && (wild || !full || Some(*other) != oldest));
                    waiting.push(tick);
                }
            }
            _ => {
                let played = playout.take(now);
                if let Some(tick) = played {
                    assert!(waiting.contains(&tick), "{tick} is played and does not wait");
                    assert!(last.is_none_or(|last| (tick.wrapping_sub(last) as i32) > 0), "{tick} after {last:?}");
                    waiting.retain(|other| (other.wrapping_sub(tick) as i32) > 0);
                    last = Some(tick);
                }
                if let (Some((least, most)), false) = (took, wild) {
                    // How long after its sending each is played, less the clocks' difference: as an i32 from the least.
                    let age = |tick: u32| now.wrapping_sub(tick).wrapping_sub(least) as i32;
                    let spread = most.wrapping_sub(least) as i32;
                    if let Some(tick) = played {
                        assert!(age(tick) >= depth as i32, "{tick} is played {} ticks early", depth as i32 - age(tick));
                    }
                    for tick in &waiting {
                        assert!(age(*tick) < spread + depth as i32, "{tick} waits though it is due");
                    }
                }
                assert!(playout.take(now).is_none(), "more was due");
            }
        }
        assert!(playout.waiting() <= MOST && (wild || playout.waiting() == waiting.len()));
    }
    playout.clear();
    assert!(playout.waiting() == 0 && playout.put(now, 7, 7) && playout.take(now.wrapping_add(depth)) == Some(7));
}
