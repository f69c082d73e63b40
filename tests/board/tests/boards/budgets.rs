//! Flash, memory by bank, stack (static and painted), instructions of a tick and how late it may begin, against the reviewed
//! budgets.

use std::sync::Arc;

use board_bench::bench::{Bench, PERIOD_NS, STACK};
use board_bench::budget::Measured;
use board_bench::cost::{MedianAndMost, TICK};
use board_bench::image::{self, Firmware};
use board_bench::part::CORE_HZ;
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::stack::code::Code;
use board_bench::stack::{EXCEPTION_FRAME, Stack};
use board_bench::trial;
use board_bench::wire::Line;

use crate::{breaks, current_loop, moteus, same_bits, spi_encoders, three_axes};

/// Of the image's sections.
fn memory(firmware: &Firmware, measured: &mut Measured) {
    let bytes = |names: &[&str]| names.iter().map(|name| firmware.sections.get(*name).map_or(0, |s| s.1)).sum::<u64>();
    measured.add("flash_bytes", bytes(&[".vector_table", ".text", ".rodata", ".data", ".itcm", ".slow"]) as f64);
    measured.add("itcm_bytes", bytes(&[".itcm"]) as f64);
    measured.add("dtcm_bytes", bytes(&[".data", ".bss", ".uninit"]) as f64);
    measured.add("axi_bytes", bytes(&[".axi"]) as f64);
}

fn instructions_of(measured: &mut Measured, name: &str, counted: MedianAndMost) {
    measured.add(format!("tick_instructions_median.{name}"), counted.median);
    measured.add(format!("tick_instructions_max.{name}"), counted.max);
}

/// Of an armed tick, with every tick recorded, as it is while somebody watches at full rate.
fn instructions(firmware: &Arc<Firmware>, measured: &mut Measured) {
    for (name, comm, set) in [
        ("power", "power", &[][..]),
        ("wave", "wave", &[]),
        ("passive-wave", "passive-wave", &[]),
        ("passive-wave-2-axes", "passive-wave", &["axis.count=2"]),
        ("passive-wave-adaptive", "passive-wave", &["axis.velocity=adaptive"]),
    ] {
        let scene = breaks::built_in(&format!("paper-5.2-{comm}-16ms"), set);
        let trial = trial::run(firmware, &scene, 2.0).expect("the boards run it");
        assert_eq!((trial.equal.first_difference, trial.ticks_missed), (None, 0), "{name}");
        instructions_of(measured, name, trial.instructions);
    }
    let trial = trial::run(firmware, &current_loop::scene(&[]), 1.0).expect("the boards run it");
    assert_eq!((trial.equal.first_difference, trial.ticks_missed), (None, 0), "current loop");
    instructions_of(measured, "current-loop", trial.instructions);
    let (equal, three) = three_axes::run(2);
    assert_eq!(equal.first_difference, None, "three axes");
    instructions_of(measured, "three-axes", three);
    measured.add("itcm_bytes.three-axes", Firmware::with("three-axes").sections[".itcm"].1 as f64);
    let (equal, instructions) = spi_encoders::run(1);
    assert_eq!(equal.first_difference, None, "encoders on SPI");
    instructions_of(measured, "spi-encoders", instructions);
    measured.add("itcm_bytes.spi-encoders", Firmware::with("spi-encoders").sections[".itcm"].1 as f64);
    instructions_of(measured, "fixed-point", same_bits::in_fixed_point(1));
    measured.add("itcm_bytes.fixed-point", Firmware::with("fixed-point").sections[".itcm"].1 as f64);
    measured.add("loop_instructions_median", trial.loop_instructions.median);
    measured.add("loop_instructions_max", trial.loop_instructions.max);
}

/// How late ticks begin, at the most: instructions after the earliest, within their period.
fn entry_delay(began: &[u64]) -> u32 {
    within(began, PERIOD_NS)
}

/// The same of what begins once in another period, ns.
pub(crate) fn within(began: &[u64], period_ns: u64) -> u32 {
    let phases = began.iter().map(|at| at % period_ns);
    let spread = phases.clone().max().unwrap_or(0) - phases.min().unwrap_or(0);
    (spread * CORE_HZ).div_ceil(1_000_000_000) as u32
}

/// A hundred megabits per second of the smallest frames, to a port that nobody listens on and to the flow's.
fn flood(firmware: &Arc<Firmware>, measured: &mut Measured) {
    const FRAMES_PER_MS: usize = 148;
    let mut bench = Bench::start(firmware, 1, Line::default());
    bench.count_instructions();
    bench.run_for_ms(200);
    let idle = entry_delay(&bench.meters[0].began);
    let stranger = ([2, 0, 0, 0, 0, 0x66], [192, 168, 77, 66], 7701);
    for port in [9, 7701, 7702] {
        bench.meters[0].clear();
        let frame = udp(stranger, (board_mac(1), board_ip(1), port), &[0x55; 18]);
        for _ in 0..200 {
            bench.flood(1, &frame, FRAMES_PER_MS);
        }
        let meter = &bench.meters[0];
        assert_eq!(meter.began.len(), 200, "ticks under a flood of port {port}");
        println!("flood of port {port}: ticks {:?}", MedianAndMost::of(meter.ticks.iter().copied()));
        measured.add(format!("entry_delay_instructions.flood-{port}"), entry_delay(&meter.began));
    }
    measured.add("entry_delay_instructions.idle", idle);
    // The stack is silent for a second after it looked for the stranger in vain.
    bench.run_for_ms(1100);
    assert!(bench.ask(1, "status").starts_with("ok board 1 disarmed fault 0 "), "it answers again");
    measured.add("stack_bytes.flood", bench.stack_used(1) as f64);
    for report in bench.finish() {
        println!("flood: frames filtered, lost for want of buffers, without a link: {:?}", report.frames);
        assert_eq!(report.resets, Vec::<String>::new());
    }
}

/// The measure of entry delays sees one: the supervisor's interrupt is made to mask all others for 0.96 ms. For longer than a
/// period they would sometimes hold up two ticks, which the dead man ends by a reset.
#[test]
fn a_section_that_masks_interrupts_shows() {
    // cpsid i; movs r0, #56; lsls r0, r0, #12; subs r0, #1; bne; cpsie i; bx lr; nop.
    const MASKED: [u32; 4] = [0x2038_B672, 0x3801_0300, 0xB662_D1FD, 0xBF00_4770];
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.count_instructions();
    bench.run_for_ms(20);
    assert!(entry_delay(&bench.meters[0].began) <= 10);
    let supervisor = firmware.address("UART4");
    bench.input(1).poke.extend((supervisor..).step_by(4).zip(MASKED));
    bench.run_for_ms(10);
    let delay = entry_delay(&bench.meters[0].began);
    println!("a section of 0.96 ms delays a tick by {delay} instructions");
    assert!(delay > 10_000 && bench.stopped[0].resets == 0, "{delay}");
    bench.finish();
}

/// The deepest paths of thread mode and of an image's interrupts, each told to `each`; all of them on top of each other.
fn nested(code: &Code, mut each: impl FnMut(&str, f64)) -> f64 {
    let mut stack = Stack::of(code);
    let mut told = |entry: &str, name: &str| {
        let bytes = deepest(&mut stack, entry);
        each(name, bytes);
        bytes
    };
    let thread = told("Reset", "thread");
    let all = code.handlers.iter().fold(thread, |all, entry| all + told(entry, entry) + EXCEPTION_FRAME as f64);
    // Without the guard at its bottom and the words at its top.
    let whole = (STACK.end - STACK.start + 0x200) as f64;
    assert!(all <= 0.85 * whole, "{all} bytes of {whole} are more than leaves 15 % to spare");
    all
}

fn deepest(stack: &mut Stack<'_>, entry: &str) -> f64 {
    let path = stack.deepest(entry).unwrap_or_else(|why| panic!("the stack of {entry}: {why}"));
    println!("{entry}: {path}");
    path.bytes as f64
}

/// The same and the tasks of the usual image; gives all of the former on top of each other.
fn static_stack(measured: &mut Measured) -> f64 {
    let code = Code::read(&std::fs::read(image::path()).expect("the image is there"));
    let all = nested(&code, |name, bytes| measured.add(format!("static_stack_bytes.{name}"), bytes));
    let mut stack = Stack::of(&code);
    for (task, (_, size)) in code.tasks() {
        measured.add(format!("static_stack_bytes.{task}"), deepest(&mut stack, &format!("task {task}")));
        measured.add(format!("task_bytes.{task}"), size as f64);
    }
    measured.add("static_stack_bytes.all", all);
    all
}

/// The image for a moteus: its tick beside a board with a current loop.
fn of_a_moteus(measured: &mut Measured) {
    let (equal, instructions, _) = moteus::run(&current_loop::scene(&[]), 1);
    assert_eq!(equal.first_difference, None, "moteus");
    instructions_of(measured, "moteus", instructions);
}

/// Stack and memory of an image that lies beside the usual one.
fn beside(name: &str, measured: &mut Measured) {
    let path = image::path().with_file_name(format!("firmware-{name}"));
    let code = Code::read(&std::fs::read(&path).expect("it is beside it"));
    let all = nested(&code, |entry, bytes| {
        if entry == TICK {
            measured.add(format!("static_stack_bytes.TIM6_DAC.{name}"), bytes);
        }
    });
    measured.add(format!("static_stack_bytes.all.{name}"), all);
    let mut of_memory = Measured::default();
    memory(&Firmware::read(&path), &mut of_memory);
    for bank in ["itcm_bytes", "dtcm_bytes"] {
        measured.add(format!("{bank}.{name}"), of_memory.of(bank));
    }
}

/// Two boards at work, every tick recorded and sent.
fn stack(firmware: &Arc<Firmware>, measured: &mut Measured) {
    let mut bench = breaks::just_armed(firmware, 2, Line::default(), &breaks::scene(&[]));
    bench.run_for_ms(1000);
    measured.add("stack_bytes.two-boards", bench.stack_used(1) as f64);
    bench.finish();
}

#[test]
fn everything_is_within_its_budget() {
    let firmware = Arc::new(Firmware::release());
    let mut measured = Measured::default();
    memory(&firmware, &mut measured);
    let most = static_stack(&mut measured);
    stack(&firmware, &mut measured);
    flood(&firmware, &mut measured);
    instructions(&firmware, &mut measured);
    of_a_moteus(&mut measured);
    ["moteus", "usb"].into_iter().for_each(|name| beside(name, &mut measured));
    for painted in ["stack_bytes.two-boards", "stack_bytes.flood"] {
        assert!(measured.of(painted) <= most, "{painted}: deeper than the {most} bytes that the image says");
    }
    measured.check();
}

#[test]
fn nothing_that_the_tick_calls_leaves_itcm() {
    let firmware = Firmware::release();
    let within = |section: &str, address: u64| {
        let (start, size) = firmware.sections[section];
        (start..start + size).contains(&address)
    };
    let inside = |address: u64| within(".itcm", address);
    let code = Code::read(&std::fs::read(image::path()).expect("the image is there"));
    let outside = |entry: &str| {
        let reached = Stack::of(&code).reached(entry).unwrap_or_else(|why| panic!("what {entry} calls: {why}"));
        reached
            .into_iter()
            .filter(|(at, _)| !inside(*at) && !within(".slow", *at))
            .map(|(_, name)| name)
            .collect::<Vec<_>>()
    };
    for interrupt in ["TIM6_DAC", "ADC"] {
        assert_eq!(outside(interrupt), Vec::<String>::new(), "not in ITCM: into memory.x with them");
    }
    assert!(outside("UART4").len() > 3, "what another interrupt calls is seen to lie elsewhere");
    // Whatever else is there, too.
    let there = |what: &str| {
        let found = firmware.symbols.iter().filter(|(name, (at, _))| inside(*at) && name.contains(what));
        found.map(|(name, _)| name.as_str()).collect::<Vec<_>>()
    };
    let slow = |thunk: &&str| {
        let called = thunk.rsplit_once("Thunk_").and_then(|(_, name)| firmware.symbols.get(name));
        called.is_some_and(|(at, _)| within(".slow", *at))
    };
    assert!(there("Thunk").iter().all(slow) && !there("Thunk").is_empty(), "calls out of ITCM: {:?}", there("Thunk"));
    assert_eq!(there("panic"), Vec::<&str>::new(), "panics in ITCM");
}
