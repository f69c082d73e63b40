//! The static stack (src/stack) sees what is planted, agrees with what the compiler wrote for debuggers, and its list of tasks
//! is how the boards run.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::{self, Firmware};
use board_bench::stack::code::Code;
use board_bench::stack::{self, Stack};
use board_bench::wire::Line;
use cohold_cli::Failure;
use gimli::{CfaRule, DebugFrame, LittleEndian, RegisterRule, UnwindSection};
use object::{Object, ObjectSection};

const TICK: &str = "TIM6_DAC";
/// The stack pointer's number in debug information.
const SP: u16 = 13;

fn image() -> Vec<u8> {
    std::fs::read(image::path()).expect("the image is there")
}

/// The usual image, and the one that has tasks of its own.
fn images() -> [PathBuf; 2] {
    [image::path(), image::path().with_file_name("firmware-usb")]
}

fn tick(elf: &[u8]) -> Result<stack::Path, Failure> {
    Stack::of(&Code::read(elf)).deepest(TICK)
}

/// The image with another halfword at an address of ITCM or flash.
fn planted(address: u64, halfwords: &[u16]) -> Vec<u8> {
    let mut elf = image();
    let file = object::File::parse(&*elf).expect("ELF");
    let place = file.sections().find_map(|section| {
        let (offset, size) = section.file_range()?;
        let at = address.checked_sub(section.address()).filter(|at| *at < size && section.address() > 0)?;
        Some((offset + at) as usize)
    });
    let mut at = place.expect("the address lies in the image");
    for halfword in halfwords {
        elf[at..at + 2].copy_from_slice(&halfword.to_le_bytes());
        at += 2;
    }
    elf
}

#[test]
fn what_is_planted_in_the_tick_is_found() {
    let firmware = Firmware::release();
    let whole = tick(&image()).expect("the tick's stack can be said");
    let (start, code) = (firmware.address(TICK), firmware.code(TICK));
    // Places to plant at: where it reserves stack, an instruction of one halfword, and where it first calls, one of two.
    let find = |fits: &dyn Fn(u16, u16) -> bool| {
        let mut at = 0;
        while !fits(code[at], code[at + 1]) {
            // The second halfword of a wide instruction may look like a first one.
            at += if matches!(code[at] >> 11, 0b11101..=0b11111) { 2 } else { 1 };
        }
        (start + 2 * at as u64, code[at])
    };
    let (reserve, op) = find(&|first, _| first & 0xFF80 == 0xB080);
    let (call, _) = find(&|first, second| first & 0xF800 == 0xF000 && second & 0xD000 == 0xD000);

    let deep = tick(&planted(reserve, &[0xB0FF])).expect("still a number");
    let taken = 4 * u64::from(op & 0x7F);
    assert_eq!(deep.bytes, whole.bytes + 508 - taken, "sub sp, #508 in place of #{taken}");

    let refused = |at: u64, halfwords: &[u16], word: &str| {
        let why = tick(&planted(at, halfwords)).expect_err("no number").to_string();
        assert!(why.starts_with(TICK) && why.contains(word), "{why}");
    };
    refused(reserve, &[0x4780], "calls through a pointer");
    refused(reserve, &[0x4685], "moves the stack pointer");
    // bl to the tick's own beginning, and to what follows the call.
    let back = (start as i64 - (call as i64 + 4)) / 2;
    refused(call, &[0xF400 | (back >> 11 & 0x3FF) as u16, 0xF800 | (back & 0x7FF) as u16], "calls itself");
    refused(call, &[0xF000, 0xF800], "where no function begins");
}

#[test]
fn every_function_whose_address_is_taken_is_called_by_somebody() {
    for path in images() {
        let elf = std::fs::read(&path).expect("the image is there");
        assert_eq!(Stack::of(&Code::read(&elf)).unclaimed(), Vec::<String>::new(), "{path:?}: see calls.txt");
    }
}

/// What the compiler wrote for debuggers: how far the frame reaches, or, where a frame pointer marks it, how far the saved
/// registers do.
#[test]
fn frames_agree_with_the_debug_information() {
    let elf = image();
    let (file, code) = (object::File::parse(&*elf).expect("ELF"), Code::read(&elf));
    let data = file.section_by_name(".debug_frame").and_then(|section| section.data().ok()).expect("debug information");
    let mut frames = DebugFrame::new(data, LittleEndian);
    frames.set_address_size(4);
    let (bases, mut context) = (gimli::BaseAddresses::default(), gimli::UnwindContext::new());
    let (mut entries, mut compared) = (frames.entries(&bases), 0);
    while let Some(entry) = entries.next().expect("an entry") {
        let gimli::CieOrFde::Fde(partial) = entry else { continue };
        let function = partial.parse(DebugFrame::cie_from_offset).expect("a function's frame");
        let mut rows = function.rows(&frames, &bases, &mut context).expect("rows");
        let (mut saved, mut whole) = (0, None);
        while let Some(row) = rows.next_row().expect("a row") {
            for (_, rule) in row.registers() {
                if let RegisterRule::Offset(offset) = rule {
                    saved = saved.max(offset.unsigned_abs());
                }
            }
            whole = match row.cfa() {
                CfaRule::RegisterAndOffset { register, offset } if register.0 == SP => {
                    whole.max(Some(offset.unsigned_abs()))
                }
                _ => None,
            };
        }
        // Functions that were left out of the image begin at 0.
        let Some(known) = code.functions.get(&function.initial_address()).filter(|_| function.initial_address() > 0)
        else {
            continue;
        };
        let (name, body) = (&known.names[0], &known.body);
        // Four bytes may lie between saved registers, to align them.
        assert!(saved <= body.pushed + 4, "{name} saves {saved} bytes of registers, {} pushed", body.pushed);
        assert!(whole.is_none_or(|whole| whole == body.frame()), "{name}: {whole:?}, not {}", body.frame());
        compared += 1;
    }
    assert!(compared > 250, "{compared} functions compared");
}

/// Which executor polls a task stands in the task's memory.
#[test]
fn tasks_run_on_the_executors_that_the_list_names() {
    images().iter().for_each(|image| executors(image));
}

fn executors(image: &Path) {
    let code = Code::read(&std::fs::read(image).expect("the image is there"));
    let firmware = Arc::new(Firmware::read(image));
    let executors = [("UART4", "SUPERVISOR"), ("UART5", "NETWORK")]
        .map(|(interrupt, name)| (interrupt, code.statics[&format!("firmware::image::{name}")]));
    let mut bench = Bench::start(&firmware, 1, Line::default());
    for (task, (at, size)) in code.tasks() {
        let words = bench.peek(1, (at..at + size).step_by(4));
        let holds =
            |(start, size): (u64, u64)| words.iter().any(|word| (start..start + size).contains(&u64::from(*word)));
        let on = executors.iter().find(|(_, place)| holds(*place)).map_or("Reset", |(interrupt, _)| *interrupt);
        println!("{task} on {on}");
        for entry in ["UART4", "UART5", "Reset"] {
            let reached = Stack::of(&code).reached(entry).expect("the list says");
            let reached = reached.values().any(|name| *name == format!("task {task}"));
            assert_eq!(reached, entry == on, "{task} runs on {on}; calls.txt has it on {entry}: {reached}");
        }
    }
    bench.finish();
}
