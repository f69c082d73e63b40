//! The current loop in the image, against windings: the same bits as host-sim's, every period, and the tick and the loop in time whatever
//! else goes on.

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP, PERIOD_NS};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::reviewed;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use firmware_parts::record::Record;
use haptic_sim::scene::Scene;

use crate::breaks;
use crate::budgets::within;

/// The paper's cube, both devices with windings. Without noise: the converter's steps are in both, and a board measures its sensors' zeros.
pub(crate) fn scene(set: &[&str]) -> Scene {
    breaks::scene(&[&CURRENT_LOOP[..], &["plant.current_noise_a=0"], set].concat())
}

#[test]
fn two_boards_with_windings_equal_host_sim() {
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
    docs::table("current_loop", "| board | current loop, 20 kHz | tick, 1 kHz | all else |", &rows);
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
