//! The cable out in the middle of a recording: silence first fades the coordination, then ends it; no hand feels a step; back in, it comes
//! up again. Both boards stay armed all along, and render alone.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use board_bench::{docs, reviewed};
use cohold_board_tools::recording;
use cohold_core::law::degradation::STEP_N;
use cohold_core::safety::Mode;
use cohold_live::recording::file::read;
use firmware_parts::record::{ENGAGED, Record};

use crate::breaks;

fn largest_step(records: &[Record], of: impl Fn(&Record) -> f32) -> f32 {
    records.windows(2).map(|two| (of(&two[1]) - of(&two[0])).abs()).fold(0.0, f32::max)
}

#[test]
fn pulled_and_put_back() {
    let firmware = Arc::new(Firmware::release());
    // The operator is on the same cable: his lease outlasts it.
    let scene = breaks::scene(&["safety.operator_lost_s=1"]);
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    let files = [1, 2].map(|number| {
        let file = std::env::temp_dir().join(format!("cable-{number}-{}.mcap", std::process::id()));
        let _ = std::fs::remove_file(&file);
        bench.pc.record(number, 1, &file);
        file
    });
    bench.run_for_ms(3000);

    // Board 2's cable stays in: its records tell what a peer does whose other one falls silent.
    let pulled = bench.armed_ticks(2).len();
    bench.input(1).cable = Some(false);
    bench.run_for_ms(90);
    assert!(bench.ask(2, "status").contains("link fading"));
    bench.run_for_ms(400);
    let status = bench.ask(2, "status");
    assert!(status.contains("ok board 2 armed") && status.contains("link calling"), "{status}");
    assert!(bench.stopped.iter().all(|stopped| stopped.bridges.on()), "both render alone");
    let put_back = bench.armed_ticks(2).len();
    bench.input(1).cable = Some(true);
    bench.run_for_ms(2500);
    assert!(bench.ask(2, "status").contains("link running"));

    // And the logs of both say what happened, in that order.
    const SAID: [&str; 5] =
        ["peer: fading, no flow", "peer: disengaged", "peer: lost", "peer: joined", "peer: engaged"];
    for number in 1..=2 {
        let log = bench.log(&firmware, number);
        let mut said = log.iter();
        for line in SAID {
            assert!(said.any(|said| said.starts_with(line)), "{line:?} is not in its place in {number}: {log:#?}");
        }
    }
    // So do the recordings, at the same times, although what board 1 said came when its cable was back.
    bench.pc.end_recordings();
    let times = files.map(|file| {
        let recording = read(&file).expect("a recording");
        std::fs::remove_file(&file).expect("it is there");
        let log: Vec<_> = recording.log().collect();
        let pulled = log.iter().rposition(|(_, said)| said.words.starts_with(SAID[0])).expect("it faded");
        let mut said = log[pulled..].iter();
        SAID.map(|line| said.find(|(_, said)| said.words.starts_with(line)).expect("it is in its place").0)
    });
    println!("{SAID:?} at {times:?} ns");
    let [one, two] = times;
    // Each is as exact as the way there takes equally long.
    assert!(one.windows(2).all(|two| two[1] + 1_000_000 > two[0]), "{one:?}");
    assert!((400_000_000..700_000_000).contains(&(one[3] - one[0])), "{one:?}");
    assert!(one.iter().zip(two).all(|(one, two)| one.abs_diff(two) < 60_000_000), "{one:?} {two:?}");
    // Board 1 was out of its operator's reach: it says so, and sends ticks again once it is asked to.
    let log = bench.log(&firmware, 1);
    assert!(log.iter().any(|said| said == "operator: gone"), "{log:#?}");
    bench.meet(1);
    let told = bench.pc.records[0].len();
    assert!(bench.ask(1, "stream 1").starts_with("ok"));
    bench.run_for_ms(100);
    assert!(bench.pc.records[0].len() > told + 50, "board 1 sends ticks again");

    let records = bench.armed_ticks(2);
    assert!(records.windows(2).all(|two| two[1].tick() == two[0].tick() + 1), "telemetry lost ticks");
    assert!(records.iter().all(|record| record.mode() == Mode::Armed), "it stayed armed");
    for record in records {
        let (axis, row) = recording::row(&record.bytes(), 0.001).expect("a record");
        assert_eq!(axis, 0);
        let named =
            |name: &str| row[recording::COLUMNS.iter().position(|(column, _)| *column == name).expect("a column")];
        let [counts, _] = record.counts();
        let [duty, _] = record.duties();
        assert_eq!(named("tick"), f64::from(record.tick()));
        assert_eq!([named("mode"), named("fault")], [1.0, 0.0]);
        assert_eq!(named("flags"), f64::from(record.flags()));
        assert_eq!([named("encoder_1_counts"), 32767.0 * named("duty_1")], [f64::from(counts.0), f64::from(duty.0)]);
        let [received, sent] = record.energy_j().map(f64::from);
        assert_eq!([named("energy_received_j"), named("energy_sent_j")], [received, sent]);
        let seen = record.observed();
        for (name, motion) in [("device", seen.device), ("object", seen.object), ("decoded", seen.desired)] {
            let row = [named(&format!("{name}_m")), named(&format!("{name}_m_per_s"))];
            assert_eq!(row, [motion.position, motion.velocity].map(f64::from), "{name}");
        }
        let forces = [seen.contact_force, seen.coordination_force];
        assert_eq!([named("contact_n"), named("coordination_n")], forces.map(f64::from));
    }
    let coordination_n = |record: &Record| record.observed().coordination_force;
    let engaged = |record: &Record| record.flags() & ENGAGED != 0;
    let held = coordination_n(&records[pulled]);
    let gone = pulled + records[pulled..].iter().position(|record| !engaged(record)).expect("it lets go");
    let back = put_back + records[put_back..].iter().position(engaged).expect("it engages again");

    // 12 packets of 8 ms after the last one, which was under way for up to 12 ms when the cable went.
    assert!((88..=116).contains(&(gone - pulled)), "it let go after {} ms", gone - pulled);
    let away = &records[gone..back];
    let falls = away.iter().position(|record| coordination_n(record) == 0.0).expect("it falls to 0");
    let most = coordination_n(&records[gone - 1]).abs() / STEP_N as f32;
    assert!(falls as f32 <= most.ceil(), "{falls} ms for {most} steps");
    assert!(away[falls..].iter().all(|record| coordination_n(record) == 0.0), "no coordination while alone");
    let fallen = largest_step(&records[gone - 1..gone + falls], coordination_n);
    assert!(fallen <= STEP_N as f32 + 1e-6, "what was left fell by {fallen} N in a tick");
    let (before, fading, rising) = (&records[1000..pulled], &records[pulled..gone], &records[back..]);
    let steps =
        [before, fading, away, rising].map(|records| largest_step(records, |record| record.observed().contact_force));
    let (first, gains) = (&records[back], &scene.peer.coordination);
    let newton = |step: f32| format!("{step:.3} N");
    let rows = [
        ["before".to_owned(), "coordinated".to_owned(), newton(held.abs()), String::new(), newton(steps[0])],
        [
            "cable out".to_owned(),
            "the coordination fades".to_owned(),
            "falls".to_owned(),
            "`peer: fading`".to_owned(),
            newton(steps[1]),
        ],
        [
            format!("{} ms later", gone - pulled),
            "it renders alone, armed".to_owned(),
            format!("0 after {falls} ms more"),
            "`peer: disengaged`, `peer: lost`".to_owned(),
            newton(steps[2]),
        ],
        [
            format!("{} ms after the cable is back", back - put_back),
            "coordinated anew, from where the object is".to_owned(),
            format!(
                "begins with {:.3} N, damping at {:.3} m/s",
                coordination_n(first).abs(),
                first.observed().object.velocity.abs()
            ),
            "`peer: joined`, `peer: engaged`".to_owned(),
            newton(steps[3]),
        ],
    ];
    let rows = rows.map(|row| format!("| {} |", row.join(" | ")));
    println!("{}", rows.join("\n"));
    assert!(held.abs() > 0.5, "there was something to let go of: {held} N");
    // Well within the slew limit, 20 N a tick, and no more than the user's own push makes of it.
    let allowed = (0.001 * scene.peer.safety.max_slew_n_per_s) as f32;
    assert!(steps.iter().all(|step| *step < 0.02 * allowed), "{steps:?} N a tick");
    // It starts anew where the copy is, at rest: all that acts at first is the damping of a copy that moves.
    let damping =
        (gains.damping_n_s_per_m + gains.wave_impedance_n_s_per_m) as f32 * first.observed().object.velocity.abs();
    assert!(coordination_n(first).abs() <= damping, "{} N", coordination_n(first));

    for number in 1..=2 {
        let records = bench.armed_ticks(number);
        // Board 1's telemetry had no cable either: only what came before is without gaps, and one tick may have been on its way.
        let whole = if number == 1 { &records[..pulled - 1] } else { records };
        let equal = twin::replay(&scene.peers()[number - 1], whole);
        assert_eq!(equal, Equal { ticks: whole.len() as u64, first_difference: None });
    }
    let head = "| when | board 2 | coordination force | its log | largest step of the hand's force in a tick |";
    docs::table("guides/board/operate.md", "cable", head, &rows);
    reviewed::check_all(&bench.finish());
}
