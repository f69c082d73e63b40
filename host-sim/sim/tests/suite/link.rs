//! One way of a network and the receiver at its end.

use cohold_sim::network::link::{Counts, Inbox, Link, Numbered, Route};
use cohold_sim::network::rule::Direction;
use cohold_sim::pair::Pair;
use cohold_sim::{Laws, Scene};

/// Packets of 8 ms, and a receiver that looks as often.
struct Line {
    link: Link<Numbered<u64>>,
    inbox: Inbox<u64>,
}

fn scene(overrides: &[&str]) -> Scene {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scene::load(Laws::built_in(), None, &overrides).expect("a good scene")
}

fn line(overrides: &[&str]) -> Line {
    let scene = scene(overrides);
    Line {
        link: Link::new(Route::of_scene(&scene, Direction::OneToTwo, 0)),
        inbox: Inbox::new(&scene, scene.peer.timing.ticks_per_packet),
    }
}

/// One packet period in which both ends are on time.
fn period(Line { link, inbox }: &mut Line, number: u64) -> Option<u64> {
    let now_ns = 8_000_000 * number;
    link.send(now_ns, &Numbered::new(number, number));
    while let Some((due_ns, packet)) = link.take(now_ns) {
        inbox.put(due_ns, packet);
    }
    inbox.take(now_ns).copied()
}

#[test]
fn without_impairment_every_packet_arrives_after_the_delay() {
    for delay in [0_u64, 1, 5] {
        let mut line = line(&[&format!("network.one_way_delay_packets={delay}")]);
        for number in 0..50_u64 {
            assert_eq!(period(&mut line, number), number.checked_sub(delay));
        }
    }
}

#[test]
fn losses_come_as_often_and_in_runs_as_long_as_the_scene_says() {
    for (loss, burst) in [(0.2, 1.0), (0.1, 5.0), (0.5, 20.0)] {
        let mut line = line(&[
            "network.one_way_delay_packets=0",
            &format!("network.loss={loss}"),
            &format!("network.loss_burst_packets={burst}"),
        ]);
        let got: Vec<bool> = (0..200_000).map(|number| period(&mut line, number).is_some()).collect();
        let lost = got.iter().filter(|got| !**got).count() as f64;
        let runs = got.windows(2).filter(|pair| pair[0] && !pair[1]).count() as f64;
        assert!((lost / 200_000.0 - loss).abs() < 0.02, "{lost} lost at {loss}");
        // Independent losses come in runs of 1/(1 − p).
        let expected = if burst == 1.0 { 1.0 / (1.0 - loss) } else { burst };
        assert!((lost / runs / expected - 1.0).abs() < 0.1, "runs of {} for {expected}", lost / runs);
    }
}

/// Bursts last as long, however few packets are sent through them: of a chain with two states the share p is lost, and of those that
/// follow a lost one n packet periods later p + (1 − p)·λⁿ, λ = 1 − 1/burst − p/(burst·(1 − p)).
#[test]
fn a_burst_goes_on_while_nothing_is_sent() {
    let (loss, burst, every) = (0.3_f64, 20.0_f64, 10);
    let mut line = line(&[
        "network.one_way_delay_packets=0",
        &format!("network.loss={loss}"),
        &format!("network.loss_burst_packets={burst}"),
    ]);
    let got: Vec<bool> = (0..100_000).map(|number| period(&mut line, every * number).is_some()).collect();
    let lost = got.iter().filter(|got| !**got).count() as f64;
    let again = got.windows(2).filter(|pair| !pair[0] && !pair[1]).count() as f64;
    assert!((lost / 100_000.0 - loss).abs() < 0.02, "{lost} lost");
    let forgets = 1.0 - 1.0 / burst - loss / (burst * (1.0 - loss));
    let expected = loss + (1.0 - loss) * forgets.powi(every as i32);
    assert!((again / lost / expected - 1.0).abs() < 0.03, "{} for {expected}", again / lost);
}

/// Pareto with shape 2 around its mean of 5 ms, cut at 0.5 s: P(X > x) = (1 + x/λ)^-2 with λ = mean/0.99.
#[test]
fn heavy_tails_are_as_heavy_as_their_closed_form() {
    const PACKETS: usize = 1_000_000;
    let mut route = Route::of_scene(
        &scene(&["network.one_way_delay_packets=0", "network.jitter=pareto", "network.jitter_s=0.005"]),
        Direction::OneToTwo,
        0,
    );
    let mut late_s = Vec::with_capacity(PACKETS);
    for _ in 0..PACKETS {
        route.send(0, &[0_u8][..], |due_ns, _| late_s.push(1e-9 * due_ns as f64));
    }
    let scale = 0.005 / 0.99;
    let share = |x: f64| late_s.iter().filter(|late| **late > x).count() as f64 / PACKETS as f64;
    for times in [0.1, 1.0, 10.0, 50.0] {
        let (got, want) = (share(times * 0.005), (1.0 + times * 0.005 / scale).powi(-2));
        // Five standard deviations of a count.
        let within = 5.0 * (want / PACKETS as f64).sqrt();
        assert!((got - want).abs() < within, "{got} are later than {times} means, not {want}");
    }
    let (mean, most) = (late_s.iter().sum::<f64>() / PACKETS as f64, late_s.iter().copied().fold(0.0, f64::max));
    assert!((mean - 0.005).abs() < 1e-4, "mean {mean} s");
    assert!((most - 0.5).abs() < 1e-8, "largest {most} s");
}

#[test]
fn blocks_arrive_exactly_reversed() {
    let mut line: Link<Numbered<u64>> = {
        let scene = scene(&["network.one_way_delay_packets=1", "network.reverse_block_packets=4"]);
        Link::new(Route::of_scene(&scene, Direction::OneToTwo, 0))
    };
    let mut came = Vec::new();
    for number in 0..12_u64 {
        line.send(8_000_000 * number, &Numbered::new(number, number));
    }
    while let Some((due_ns, packet)) = line.take(u64::MAX) {
        came.push((due_ns / 8_000_000, packet.what));
    }
    // The last of a block after the constant delay, the others after it, a packet period from one to the next.
    let want: Vec<(u64, u64)> = (4..16).zip([3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8]).collect();
    assert_eq!(came, want);
    for nothing in ["network.reverse_block_packets=0", "network.reverse_block_packets=1"] {
        assert_eq!(period(&mut self::line(&[nothing]), 0), None);
        let mut line = self::line(&[nothing, "network.one_way_delay_packets=0"]);
        assert!((0..10).all(|number| period(&mut line, number) == Some(number)));
    }
}

#[test]
fn whatever_happens_on_the_way_numbers_only_grow() {
    let mut line = line(&[
        "network.jitter=gamma",
        "network.jitter_s=0.012",
        "network.reorder=0.3",
        "network.reorder_depth_packets=16",
        "network.duplicate=0.2",
        "network.corrupt=0.1",
        "network.loss=0.1",
    ]);
    let mut last = None;
    for sent in 0..20_000 {
        if let Some(number) = period(&mut line, sent) {
            assert!(last.is_none_or(|last| number > last), "{number} after {last:?}");
            last = Some(number);
        }
    }
    let (counts, Inbox { delivered, dropped, .. }) = (line.link.counts(), line.inbox);
    assert!(counts.corrupt > 1000 && counts.lost > 1000, "{counts:?}");
    assert!(dropped > 1000 && delivered > 5000, "{dropped} dropped, {delivered} delivered");
}

#[test]
fn play_out_makes_the_delay_constant() {
    let mut line = line(&["network.jitter=uniform", "network.jitter_s=0.012", "network.playout_packets=2"]);
    // Once the fastest has been seen.
    for number in 0..5000_u64 {
        let played = period(&mut line, number);
        assert!(number < 200 || played == number.checked_sub(3), "{played:?} in period {number}");
    }
    // Uniform to 12 ms is never later than two packets of 8 ms.
    let (counts, Inbox { delivered, dropped, .. }) = (line.link.counts(), line.inbox);
    assert!(delivered > 4_980 && dropped < 10 && counts.lost == 0, "{counts:?}, {delivered}, {dropped}");
}

/// Without impairment the fastest is known from the start, and every packet waits exactly as long as it is configured
/// to.
#[test]
fn play_out_on_a_good_network_is_more_delay_and_nothing_else() {
    let mut line = line(&["network.one_way_delay_packets=2", "network.playout_packets=4"]);
    for number in 0..500_u64 {
        assert_eq!(period(&mut line, number), number.checked_sub(6));
    }
}

fn datagrams(overrides: &[&str]) -> Link<[u8]> {
    Link::new(Route::of_scene(&scene(overrides), Direction::OneToTwo, 0))
}

#[test]
fn every_datagram_comes_out_after_the_delay_in_the_order_it_went_in() {
    let mut line = datagrams(&["network.one_way_delay_packets=2"]);
    for n in 0..5_u8 {
        line.send(1_000_000 * u64::from(n), &[n]);
        line.send(1_000_000 * u64::from(n), &[n, n]);
    }
    let due_ns = 16_000_000;
    assert_eq!(line.take(due_ns - 1), None);
    assert_eq!([(); 3].map(|()| line.take(due_ns)), [Some((due_ns, vec![0])), Some((due_ns, vec![0, 0])), None]);
    assert_eq!(std::iter::from_fn(|| line.take(20_000_000)).count(), 8);
    assert_eq!(line.counts(), Counts { taken: 10, sent: 10, ..Counts::default() });
}

#[test]
fn what_is_lost_never_comes_and_what_is_broken_differs_in_one_bit() {
    let mut line = datagrams(&["network.loss=0.3", "network.corrupt=0.2"]);
    for n in 0..10_000 {
        line.send(n, &[0; 60]);
    }
    let came: Vec<Vec<u8>> = std::iter::from_fn(|| line.take(u64::MAX)).map(|(_, bytes)| bytes).collect();
    let counts = line.counts();
    let flipped = |bytes: &Vec<u8>| bytes.iter().map(|byte| byte.count_ones()).sum::<u32>();
    assert!(came.iter().all(|bytes| bytes.len() == 60 && flipped(bytes) <= 1));
    assert_eq!(came.iter().filter(|bytes| flipped(bytes) == 1).count() as u64, counts.corrupt);
    assert_eq!((counts.taken, counts.sent, came.len() as u64), (10_000, 10_000 - counts.lost, counts.sent));
    assert!(counts.lost.abs_diff(3_000) < 200 && counts.corrupt.abs_diff(1_400) < 200, "{counts:?}");
}

/// A line with little room, on which everything stays for a second: what there is no room for is lost, and counted so.
#[test]
fn a_full_line_loses_what_there_is_no_room_for() {
    let mut line = Link::<[u8]>::new(Route::new(1_000_000_000)).holding(10_000);
    (0..1_000).for_each(|at| line.send(at, &[at as u8; 168]));
    // 168 bytes, and 32 for when it is due and where it lies.
    assert_eq!(line.counts(), Counts { taken: 1_000, sent: 50, lost: 950, corrupt: 0 });
    for at in 0..50 {
        assert_eq!(line.take(2_000_000_000), Some((1_000_000_000 + at, vec![at as u8; 168])));
    }
    assert_eq!(line.take(2_000_000_000), None);
    // What has come out makes room again.
    (0..1_000).for_each(|at| line.send(at, &[0; 168]));
    assert_eq!(line.counts().sent, 100);
}

/// What comes half a millisecond late waits for the next tick, not for the next packet period.
#[test]
fn a_peer_hears_at_the_tick_after_the_arrival() {
    for (extra, tick_of_period) in [("0", 0), ("0.0005", 1), ("0.0031", 4), ("0.008", 0)] {
        let extra = format!("network.extra_delay_s={extra}");
        let mut pair = Pair::<f64>::new(&scene(&["network.one_way_delay_packets=1", &extra])).expect("a good scene");
        let mut heard = [0, 0];
        for tick in 0..800 {
            pair.step_watched(&mut |seen| {
                if seen.heard.is_some() {
                    assert_eq!(tick % 8, tick_of_period, "{extra}");
                    heard[seen.number - 1] += 1;
                }
                assert_eq!(seen.exchanged, tick % 8 == 0);
            });
        }
        assert!(heard.iter().all(|heard| (98..100).contains(heard)), "{heard:?}");
    }
}
