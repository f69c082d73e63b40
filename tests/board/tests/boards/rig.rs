//! What the rig measures is what is there: where the board is wrong, its test fails. `cargo xtask rig --virtual` runs the tests themselves.

use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::rig::{self, Rigged};
use cohold_rig::list::{TESTS, Test, Virtual};
use cohold_rig::run::{self, Boards, Extent, Outcome};

/// DBGMCU_APB2FZ1 that lets TIM1 go on while a debugger halts the core.
const GOES_ON: (u64, u32) = (0x5C00_104C, 0);
/// TIM1_CCR6, whose pulse starts the second sample: at 10 µs in place of the middle, which is 25; and there again.
const EARLIER: [(u64, u32); 2] = [(0x4001_005C, 2400), (0x4001_005C, 5999)];
/// TIM6_PSC, and a tick of five counts for four: 800 in a second. Its period is set anew with each plan.
const LONGER: (u64, u32) = (0x4000_1028, 4);

pub(crate) fn test(rigged: &mut Rigged, name: &str) -> Outcome {
    let test: &Test = TESTS.iter().find(|test| test.name == name).expect("the list has it");
    assert!(matches!(test.virtual_rig, Virtual::Runs(_)));
    run::run(rigged, test, Extent::Virtual, None).expect("somebody wrote it down")
}

#[test]
fn what_is_wrong_with_a_board_is_found() {
    let mut rigged = rig::start(Firmware::release()).expect("both take it");
    let says = |rigged: &mut Rigged, line: &str| {
        rigged.order(line)?;
        rigged.answer(100)
    };
    assert_eq!(says(&mut rigged, "volts 1234").as_deref(), Ok("ok"));
    assert_eq!(rigged.analogue, 1234);
    assert_eq!(says(&mut rigged, "pull stop").as_deref(), Ok("error PE14 is low already"));
    assert_eq!(says(&mut rigged, "watch 3").as_deref(), Ok("ok"));
    assert_eq!(rigged.answer(100).as_deref(), Ok("error PE14 did not fall"));
    rigged.spoil(GOES_ON.0, GOES_ON.1);
    let found = test(&mut rigged, "halt-while-armed");
    assert!(found.as_ref().is_err_and(|why| why.contains(" ns after the last pulse")), "{found:?}");
    assert_eq!(rigged.ask("clear").as_deref(), Ok("ok disarmed"));
    rigged.spoil(EARLIER[0].0, EARLIER[0].1);
    let found = test(&mut rigged, "sample-after-edge");
    assert!(found.as_ref().is_err_and(|why| why.starts_with("ok joint 1 current ")), "{found:?}");
    rigged.spoil(EARLIER[1].0, EARLIER[1].1);
    rigged.spoil(LONGER.0, LONGER.1);
    let found = test(&mut rigged, "tick-1-khz");
    assert!(found.as_ref().is_err_and(|why| why.contains(" 0 of them 20 periods after the last")), "{found:?}");
    let soak = TESTS.iter().find(|test| test.name == "soak").expect("the list has it");
    let found = run::run(&mut rigged, soak, Extent::Virtual, Some(1)).expect("somebody wrote it down");
    assert!(
        found.as_ref().is_err_and(|why| why.starts_with("80") && why.contains(" ticks in 1 s, 0 missed")),
        "{found:?}"
    );
    rigged.finish().iter().for_each(reviewed::check);
}
