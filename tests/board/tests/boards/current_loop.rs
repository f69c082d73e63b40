//! The current loop in the image, against windings: the same bits as cohold's, every period, and the tick and the loop in time whatever
//! else goes on.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP, PERIOD_NS};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::reviewed;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use cohold_sim::scene::Scene;
use firmware_parts::record::Record;

use crate::breaks;
use crate::budgets::within;

/// The paper's cube, both devices with windings. Without noise: the converter's steps are in both, and a board measures its sensors' zeros.
pub(crate) fn scene(set: &[&str]) -> Scene {
    breaks::scene(&[&CURRENT_LOOP[..], &["plant.current_noise_a=0"], set].concat())
}

#[test]
fn two_boards_with_windings_equal_cohold() {
    let seconds = 2;
    let (firmware, scene) = (Arc::new(Firmware::release()), scene(&[]));
    let wall = std::time::Instant::now();
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    bench.run_for_ms(1000 * seconds);
    println!("{seconds} s of two boards with windings in {:.1} s", wall.elapsed().as_secs_f64());
    let boards = [bench.armed_ticks(1), bench.armed_ticks(2)];
    let ticks = boards[0].len().min(boards[1].len()) as u64;
    assert!(ticks >= 1000 * seconds, "only {ticks} ticks were recorded");
    let duties = boards[0].iter().map(|record| record.duties()[0].0.unsigned_abs()).max();
    println!("{ticks} ticks, largest duty {duties:?}");
    assert_eq!(twin::closed_loop(&scene, boards), Equal { ticks, first_difference: None });
    bench.finish().iter().for_each(reviewed::check);
}

/// Both users push and nothing moves: the winding warms by i²·R alone, and the force falls before the mean square of the current, over
/// `motor.thermal_s`, is that of `motor.continuous_a`. Reckoned here from the currents that were asked for.
#[test]
fn a_motor_that_is_held_gives_way_before_it_is_too_warm() {
    const CONTINUOUS_A: f64 = 0.15;
    const THERMAL_S: f64 = 0.5;
    let set = ["user.1.push_n=2", "user.2.push_n=2", "motor.continuous_a=0.15", "motor.thermal_s=0.5"];
    let (firmware, scene) = (Arc::new(Firmware::release()), scene(&set));
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    bench.run_for_ms(4000);
    assert!(bench.stopped[0].bridges.on(), "{}", bench.ask(1, "status"));
    let amperes = |record: &Record| f64::from(record.duties()[0].0) / 32767.0 * scene.peer.motor.full_scale_a;
    let mut square = 0.0;
    let squares: Vec<f64> = (bench.since_armed(1).records.iter())
        .map(|record| {
            square += (amperes(record).powi(2) - square) * 1e-3 / THERMAL_S;
            square
        })
        .collect();
    let most = squares.iter().fold(0.0_f64, |most, square| most.max(*square));
    println!("{} ticks, a mean square of {most} A² at the most, {square} A² at last", squares.len());
    // What flows, which is what counts, is what is asked for to within half a per cent.
    let borne = CONTINUOUS_A.powi(2);
    assert!(squares.len() > 3900 && most < 1.01 * borne && square > 0.8 * borne, "{most}");
    bench.finish();
}

/// What a thermistor of 10 kΩ and 3950 K reads below 10 kΩ at a temperature, °C.
fn divided(celsius: f64) -> u16 {
    let ratio = (3950.0 / (celsius + 273.15) - 3950.0 / 298.15).exp();
    (65536.0 * ratio / (1.0 + ratio)) as u16
}

/// Two boards with thermistors that read this, armed, with little force.
fn with_thermistors(firmware: &Arc<Firmware>, scene: &Scene, reads: u16) -> Bench {
    let mut bench = Bench::start(firmware, 2, Line::default());
    (1..=2).for_each(|number| bench.input(number).thermistor = Some(reads));
    bench.set_up(scene).expect("the boards take the scene");
    bench.arm();
    bench.run_for_ms(200);
    bench
}

/// Both users push, and motor 1 of the first board warms: its force falls to what its temperature leaves, and fault 16 ends it at the limit. A
/// record has what the tick read, so cohold computes the same bits from it. One that is open or shorted is a fault, with the motors on or off.
#[test]
fn a_motor_with_a_thermistor_loses_force_before_it_is_too_warm() {
    const MOST_N: f64 = 4.0;
    let set = ["user.1.push_n=2", "user.2.push_n=2", "motor.thermistor=true"];
    let limits = ["safety.max_force_n=4", "safety.stuck_duty=0.04"];
    let (firmware, scene) = (Arc::new(Firmware::release()), scene(&[&set[..], &limits[..]].concat()));
    let mut bench = with_thermistors(&firmware, &scene, divided(25.0));
    let newton = |record: &Record| {
        let motor = &scene.peer.motor;
        f64::from(record.duties()[0].0.unsigned_abs()) / 32767.0
            * motor.full_scale_a
            * motor.newton_or_newton_metre_per_a
    };
    let [near, hot] = [52.5, 80.0].map(|celsius| f64::from(divided(celsius)));
    for celsius in [25.0, 50.0, 60.0, 66.0, 70.0, 74.0, 78.0, 79.5, 25.0, 78.0] {
        bench.input(1).thermistor = Some(divided(celsius));
        bench.run_for_ms(200);
        let last = bench.armed_ticks(1).last().expect("a tick");
        let exact = (62.0 * (near - f64::from(divided(celsius))) / (near - hot)).max(0.0);
        let code = f64::from(last.stage().expect("a current loop").thermistor);
        let (given, left) = (newton(last), MOST_N * (1.0 - code / 64.0));
        println!("{celsius} °C: {given:.3} N of {left:.3} N");
        assert!((code - exact).abs() < 1.0, "{celsius} °C: {code}, {exact}");
        assert!(given < left + 0.001 && (left > 1.5 || given > left - 0.01), "{celsius} °C: {given} N, {left} N");
        assert!(bench.stopped[0].bridges.on(), "{celsius} °C: {}", bench.ask(1, "status"));
    }
    let records = bench.armed_ticks(1);
    let ticks = records.len() as u64;
    assert!(ticks > 2000 && records.windows(2).all(|two| two[1].tick() == two[0].tick() + 1));
    assert_eq!(twin::replay(&scene.peers()[0], records), Equal { ticks, first_difference: None });

    for (what, reads, fault) in [("80.1 °C", divided(80.1), 16), ("open", u16::MAX, 73), ("shorted", 0, 73)] {
        bench.input(1).thermistor = Some(reads);
        let off = (1..100).find(|_| {
            bench.step();
            !bench.stopped[0].bridges.on()
        });
        assert!(off.is_some_and(|ms| ms <= 14), "{what}: off after {off:?} ms");
        let says = |bench: &mut Bench| bench.ask(1, "status").contains(&format!(" fault {fault} "));
        assert!(says(&mut bench), "{what}: {}", bench.ask(1, "status"));
        // With the motors off it is seen, too.
        assert_eq!(bench.ask(1, "clear"), "ok disarmed", "{what}");
        bench.run_for_ms(20);
        assert!(says(&mut bench), "{what}: {}", bench.ask(1, "status"));
        bench.input(1).thermistor = Some(divided(25.0));
        bench.run_for_ms(20);
        breaks::arm_again(&mut bench, what);
        bench.run_for_ms(20);
        println!("{what}: off after {off:?} ms");
    }
    bench.finish();
}

/// Without a current loop no converter reads one.
#[test]
fn a_thermistor_needs_a_current_loop() {
    let mut bench = Bench::start(&Arc::new(Firmware::release()), 1, Line::default());
    bench.hold_buttons(true);
    bench.run_for_ms(100);
    for line in ["set motor.drive amplifier", "set motor.thermistor true"] {
        assert!(bench.ask(1, line).starts_with("ok"), "{line}");
    }
    let answer = bench.ask(1, "apply");
    assert!(answer.starts_with("error ") && answer.contains("because only a current loop reads one"), "{answer}");
    assert!(bench.ask(1, "set motor.thermistor false").starts_with("ok"));
    assert_eq!(bench.ask(1, "apply"), "ok applied");
    bench.finish();
}

/// A PWM period, ns.
const PWM_NS: u64 = 50_000;

/// One period of everything at once for board 1: 100 Mbit/s of the smallest frames to the flow's port.
fn flooded(bench: &mut Bench) {
    let stranger = ([2, 0, 0, 0, 0, 0x66], [192, 168, 77, 66], 7701);
    let frame = udp(stranger, (board_mac(1), board_ip(1), 7701), &[0x55; 18]);
    bench.flood(1, &frame, 148);
}

/// Neither begins more than 10 instructions after its earliest, and there are as many as there ought to be.
fn in_time(bench: &Bench, what: &str, ticks: usize, loops: usize) {
    let (tick, current) = (&bench.meters[0], &bench.loops[0]);
    let delays = [within(&tick.began, PERIOD_NS), within(&current.began, PWM_NS)];
    println!(
        "{what}: {} ticks, {} runs of the loop, at most {delays:?} instructions late",
        tick.began.len(),
        current.began.len()
    );
    assert_eq!((tick.began.len(), current.began.len()), (ticks, loops), "{what}");
    assert!(delays.iter().all(|delay| *delay <= 10), "{what}: {delays:?}");
}

/// Instructions a second of board 1: of its current loop, its tick, and all else.
fn load(bench: &mut Bench, what: &str) -> String {
    const MS: u64 = 400;
    bench.run_for_ms(20);
    bench.meters[0].clear();
    bench.loops[0].clear();
    bench.run_for_ms(MS);
    let (tick, current) = (&bench.meters[0], &bench.loops[0]);
    let sum = |meter: &board_bench::cost::Meter| meter.ticks.iter().map(|ran| u64::from(*ran)).sum::<u64>();
    let all = tick.before[tick.before.len() - 1] - tick.before[0];
    let (tick, current) = (sum(tick), sum(current));
    let per_s = |ran: u64| {
        let per_s = (ran * 1000 / MS) as f64;
        format!("{:.2} M, {:.2} %", 1e-6 * per_s, 100.0 * per_s / board_bench::part::CORE_HZ as f64)
    };
    format!("| {what} | {} | {} | {} |", per_s(current), per_s(tick), per_s(all - tick - current))
}

/// A flood, a handshake with a board that has gone and come back, and, with the motors off, an erase of flash, all at once.
#[test]
fn tick_and_loop_are_in_time_whatever_else_goes_on() {
    const MS: usize = 250;
    // A flood drowns the operator, too: his lease outlasts it.
    let (firmware, scene) = (Arc::new(Firmware::release()), scene(&["safety.operator_lost_s=1"]));
    let mut bench = breaks::just_armed(&firmware, 2, Line::default(), &scene);
    bench.count_instructions();
    let mut rows = vec![load(&mut bench, "armed, every tick recorded and sent")];
    assert!(bench.ask(1, "stream off").starts_with("ok"));
    rows.push(load(&mut bench, "armed"));
    let meet_anew = |bench: &mut Bench| {
        for ms in 0..MS {
            // For long enough that the link lets go.
            bench.wire.line.silent = ms < 120;
            flooded(bench);
        }
    };
    let clear = |bench: &mut Bench| {
        bench.meters[0].clear();
        bench.loops[0].clear();
    };
    clear(&mut bench);
    meet_anew(&mut bench);
    in_time(&bench, "armed, a flood and a handshake", MS, 20 * MS);

    bench.run_for_ms(1200);
    assert_eq!(bench.ask(1, "disarm"), "ok disarmed");
    rows.push(load(&mut bench, "disarmed"));
    docs::table(
        "reference/board.md",
        "current_loop",
        "| board | current loop, 20 kHz | tick, 1 kHz | all else |",
        &rows,
    );
    // As many as a sector takes, until one has to erase.
    let mut said = String::new();
    for _ in 0..17 {
        said = bench.ask(1, "save");
        if !said.ends_with("saved") {
            break;
        }
    }
    assert_eq!(said, "ok saving, a few seconds: flash is being erased");
    clear(&mut bench);
    meet_anew(&mut bench);
    in_time(&bench, "disarmed, a flood, a handshake and an erase", MS, 0);
    bench.finish();
}
