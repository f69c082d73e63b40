//! Who runs the list: what is said to the board under test, to the rig and to the probe, and what must come of it. The same for two boards
//! on a table and for two virtual ones ([`Boards`]).

use std::ops::{Range, RangeInclusive};

use crate::list::Test;

/// The board under test, the rig and the probe. What fails is said in a sentence.
pub trait Boards {
    /// The wires of this test join them from here on. On a table that is for a person to do before.
    fn wired(&mut self, _: &Test) {}
    /// Says a line to the board under test, as its operator does, and gives its answer.
    fn ask(&mut self, line: &str) -> Outcome;
    /// Says a line to the rig.
    fn order(&mut self, line: &str) -> Done;
    /// The rig's answer, which comes within so long.
    fn answer(&mut self, within_ms: u64) -> Outcome;
    /// Nothing is said for so long.
    fn wait_ms(&mut self, ms: u64) -> Done;
    /// How long the probe may take until it has done something, ms.
    fn probing_ms(&self) -> u64;
    /// The probe stops the timer of the board's tick.
    fn stop_ticks(&mut self) -> Done;
    /// The probe halts the board's processor, and lets it go on after so many ms.
    fn halt(&mut self, ms: u64) -> Done;
    /// What the converter read for both currents in every tick that came since this was asked last, in codes from the middle, if the board's
    /// settings say that these are of its current loop's full scale.
    fn codes(&mut self) -> [Vec<i16>; 2];
    /// Adds how often each has come since this was asked last.
    fn came(&mut self, came: &mut Came);
    /// What cohold's bring-up says of the emergency stop: what was seen of it, or why it does not pass. These are the orders to the rig where a
    /// person would press the stop, and release it.
    fn stop_is_seen(&mut self, pressed: &[&str], released: &[&str]) -> Outcome;
    /// Waits until a board that started anew answers its operator.
    fn meet(&mut self) -> Done;
    /// Every tick is recorded from here on; the counters of both encoders in the last one that was.
    fn counts(&mut self) -> Result<[u16; 2], String>;
    /// The records of all ticks since the board was armed last, computed again by the simulator from what the board read, at this rate: how
    /// many are the same, of how many.
    fn same(&mut self, per_ms: u32) -> Result<[u64; 2], String>;
}

/// What came of a test.
pub type Outcome = Result<String, String>;
/// Something was done, or why not.
pub type Done = Result<(), String>;

/// Ticks, by their records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Came {
    /// The number of the last tick.
    pub last: Option<u32>,
    /// That came.
    pub ticks: u64,
    /// That did not, between two that did.
    pub missed: u64,
    /// Of those that came, how many were not armed.
    pub unarmed: u64,
    /// Of those, how many had a smaller number than the one before: the board started anew.
    pub restarts: u64,
}

/// How often each test does what it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// As the list says.
    Whole,
    /// As often as a virtual board can in a few seconds.
    Virtual,
}

/// Runs a test, a soak for so many seconds; `None` for one that nobody has written down here.
pub fn run(boards: &mut dyn Boards, test: &Test, extent: Extent, soak_s: Option<u32>) -> Option<Outcome> {
    let times = |whole: u32, virtually: u32| if extent == Extent::Whole { whole } else { virtually };
    boards.wired(test);
    Some(match test.name {
        "tick-1-khz" => ticks(boards, 1, times(60_000, 1000)),
        "tick-2-khz" => ticks(boards, 2, times(60_000, 1000)),
        "tick-4-khz" => ticks(boards, 4, times(60_000, 1000)),
        "tick-5-khz" => ticks(boards, 5, times(60_000, 1000)),
        "break-by-stop" => breaks(boards, "stop", times(1000, 5)),
        "break-by-fault" => breaks(boards, "fault", times(1000, 5)),
        "dead-man" => dead_man(boards, times(100, 2)),
        "amplifiers-gate" => gate(boards),
        "encoder-counts" => encoder_counts(boards, times(10_000_000, 20_000)),
        "encoder-faults" => with(boards, &["set encoder.index true"], |boards| faults(boards, "mend", ENCODER)),
        "converter-codes" => {
            let (levels, ms) = (times(0, 2552)..=times(4095, 2568), u64::from(times(200, 120)));
            with(boards, CURRENT_LOOP, |boards| converter_codes(boards, levels, ms))
        }
        "converter-start" => with(boards, CURRENT_LOOP, |boards| converter_start(boards, times(100, 3))),
        "current-sensor-ends" => with(boards, CURRENT_LOOP, |boards| faults(boards, "winding", SENSOR)),
        "sample-after-edge" => with(boards, CURRENT_LOOP, sample_after_edge),
        "supply-behind-the-stop" => with(boards, CURRENT_LOOP, |boards| supply(boards, times(2200, 220))),
        "soak" => soak(boards, soak_s.unwrap_or(times(test.seconds, 5))),
        "halt-while-armed" => halt(boards, times(100, 3)),
        _ => return None,
    })
}

/// How long the rig may take beyond what it was asked for, ms.
const PATIENCE_MS: u64 = 5000;

/// A line to the rig, and its answer without `ok`.
fn rig(boards: &mut dyn Boards, line: &str) -> Outcome {
    rig_within(boards, line, 0)
}

/// [`rig`] for what takes so long.
fn rig_within(boards: &mut dyn Boards, line: &str, ms: u64) -> Outcome {
    boards.order(line)?;
    let answer = boards.answer(ms + PATIENCE_MS)?;
    let told = answer.strip_prefix("ok").ok_or(format!("the rig says to `{line}`: {answer}"))?;
    Ok(told.trim().to_owned())
}

/// The numbers in the rig's answer to a line that takes so long, ms.
fn measured<const N: usize>(boards: &mut dyn Boards, line: &str, ms: u64) -> Result<[u32; N], String> {
    let told = rig_within(boards, line, ms)?;
    numbers(&told).ok_or(format!("the rig says to `{line}`: {told}"))
}

/// The numbers among words.
fn numbers<const N: usize>(told: &str) -> Option<[u32; N]> {
    let numbers: Vec<u32> = told.split(' ').filter_map(|word| word.parse().ok()).collect();
    numbers.try_into().ok()
}

/// A line to the board, which must take it.
fn board(boards: &mut dyn Boards, line: &str) -> Outcome {
    let answer = boards.ask(line)?;
    if answer.starts_with("ok") { Ok(answer) } else { Err(format!("the board says to `{line}`: {answer}")) }
}

/// Tells a board that has just started what drives its motors; the rest is as it is delivered.
pub fn set_up(boards: &mut dyn Boards) -> Result<(), String> {
    rig(boards, "who")?;
    set(boards, &["defaults", "set motor.drive amplifier"])
}

/// Arms a board whose first joint has been checked since its start, or checks it first.
fn arm(boards: &mut dyn Boards) -> Result<(), String> {
    rig(boards, "device held")?;
    if boards.ask("arm alone")?.starts_with("ok") {
        return Ok(());
    }
    boards.ask("clear")?;
    rig(boards, "device free")?;
    board(boards, "check 1")?;
    for _ in 0..50 {
        boards.wait_ms(20)?;
        let told = boards.ask("probed")?;
        if told.contains(" running") {
            continue;
        }
        rig(boards, "device held")?;
        boards.wait_ms(5)?;
        if !told.contains("; agree: ") {
            return Err(format!("the check of the first joint: {told}"));
        }
        return board(boards, "arm alone").map(drop);
    }
    Err("the check of the first joint does not end".to_owned())
}

/// Armed, with an encoder that moves in every tick of so many periods.
fn shaken(boards: &mut dyn Boards, periods: u32) -> Result<(), String> {
    arm(boards)?;
    rig(boards, &format!("device sweep 10 {periods} 10"))?;
    boards.wait_ms(20)
}

/// The number after a word that the board says.
fn after(told: &str, word: &str) -> Result<u32, String> {
    let words: Vec<&str> = told.split([' ', ';']).collect();
    let pair = words.windows(2).find(|pair| pair[0] == word);
    pair.and_then(|pair| pair[1].parse().ok()).ok_or(format!("the board says no number of {word}: {told}"))
}

/// The longest of a time that the board keeps, cycles.
fn longest(boards: &mut dyn Boards, time: &str) -> Result<u32, String> {
    after(&board(boards, &format!("time {time}"))?, "most")
}

/// Cycles that a tick may take. Two instructions a cycle are the most that the processor has: fewer cycles are a counter that stands.
const TICK_CYCLES: Range<u32> = 300..24_000;

/// Periods of 50 µs in a millisecond.
const PERIODS: u32 = 20;

/// What was found, as passed or as failed.
fn judge(good: bool, figures: String) -> Outcome {
    if good { Ok(figures) } else { Err(figures) }
}

/// Every change of the pulses comes in step with the ticks, of so many in a millisecond, and most ticks change them; none is missed or long.
fn spacing(boards: &mut dyn Boards, per_ms: u32, ticks: u32) -> Outcome {
    let tick = PERIODS / per_ms;
    shaken(boards, tick)?;
    boards.counts()?;
    boards.came(&mut Came::default());
    let mut came = Came::default();
    let [periods, changes, in_step, off, residue, missing] =
        measured(boards, &format!("pulses {} {tick}", tick * ticks), (ticks / per_ms).into())?;
    boards.came(&mut came);
    let (most, spaced, missed) = (longest(boards, "duration")?, longest(boards, "spacing")?, came.missed);
    board(boards, "disarm")?;
    let figures = format!(
        "{changes} changes in {periods} periods, {in_step} of them {tick} periods after the last, {off} elsewhere, {missing} periods missing, at most \
         {residue} counts of 240 MHz beside a period; the board's own: {missed} ticks missed, {spaced} cycles off, the longest took {most} cycles"
    );
    // A tick may leave the pulses as they were; two clocks may differ by 100 ppm.
    let in_step = off == 0 && missing == 0 && in_step * 10 >= 9 * ticks && residue <= 24;
    judge(in_step && missed == 0 && spaced <= 100 && TICK_CYCLES.contains(&most), figures)
}

/// Ticks of so many in a millisecond are in step, and the simulator's.
fn ticks(boards: &mut dyn Boards, per_ms: u32, ticks: u32) -> Outcome {
    let period = format!("set timing.control_period_s {}", 1e-3 / f64::from(per_ms));
    with(boards, &[&period], |boards| {
        let spacing = spacing(boards, per_ms, ticks)?;
        Ok(format!("{spacing}; to the bit: {}", same_bits(boards, per_ms, ticks)?))
    })
}

/// Counts of 240 MHz that a break may take: 1 µs, and its filter.
const BREAK: u32 = 240 + 65;

/// PE14 falls soon enough after a line did.
fn breaks(boards: &mut dyn Boards, line: &str, times: u32) -> Outcome {
    let (mut least, mut most) = (u32::MAX, 0);
    for _ in 0..times {
        arm(boards)?;
        boards.wait_ms(10)?;
        let [took] = measured(boards, &format!("pull {line}"), 0)?;
        (least, most) = (least.min(took), most.max(took));
        boards.wait_ms(5)?;
    }
    let figures = format!("{} to {} ns, {times} times", ns(least), ns(most));
    // Less than its filter takes would be no filter.
    judge(most <= BREAK && least > 8, figures)
}

/// Counts of 240 MHz from a tick to the first pulse that it changed, 46 µs; and 2 ms.
const AFTER_TICK: u32 = 46 * 240;
const DEAD_MAN: u32 = 2000 * 240;

/// An armed board is stopped while the rig watches: how long after the last pulse of PE9 its PE14 fell, and after the last that changed.
fn watched(boards: &mut dyn Boards, stop: impl FnOnce(&mut dyn Boards) -> Done) -> Result<[u32; 2], String> {
    shaken(boards, PERIODS)?;
    let ms = boards.probing_ms();
    rig(boards, &format!("watch {ms}"))?;
    boards.wait_ms(2)?;
    stop(boards)?;
    let answer = boards.answer(ms + PATIENCE_MS)?;
    numbers(&answer).ok_or(format!("the rig says to `watch`: {answer}"))
}

/// PE14 falls soon enough after the last tick.
fn dead_man(boards: &mut dyn Boards, times: u32) -> Outcome {
    let (mut least, mut most) = (u32::MAX, 0);
    for _ in 0..times {
        let [_, change] = watched(boards, |boards| boards.stop_ticks())?;
        let took = change.wrapping_add(AFTER_TICK);
        (least, most) = (least.min(took), most.max(took));
        rig(boards, "device held")?;
        boards.meet()?;
        let status = boards.ask("status")?;
        if !status.contains("no tick came for 2 ms") {
            return Err(format!("the board started anew, and says: {status}"));
        }
        board(boards, "clear")?;
        set_up(boards)?;
    }
    judge(most < DEAD_MAN, format!("{} to {} µs, {times} times", ns(least) / 1000, ns(most) / 1000))
}

/// A gate that does not work is told, and nothing was asked of the amplifiers behind it.
fn gate(boards: &mut dyn Boards) -> Outcome {
    arm(boards)?;
    board(boards, "disarm")?;
    let mut found = String::new();
    for (wired, outputs) in [("enable", 12), ("timer", 10), ("never", 0), ("always", 15)] {
        rig(boards, &format!("gate {outputs}"))?;
        boards.wait_ms(5)?;
        rig(boards, "asked")?;
        let armed = boards.ask("arm alone")?;
        boards.wait_ms(20)?;
        let status = boards.ask("status")?;
        let [asked] = measured(boards, "asked", 0)?;
        if !status.contains(" faulted fault 31 ") || asked > 2 {
            return Err(format!("gate {wired}: {armed}; {status}; {asked} of 6000 asked for"));
        }
        found += &format!("{wired}: fault 31, ");
        rig(boards, "gate 8")?;
        boards.wait_ms(5)?;
        board(boards, "clear")?;
    }
    arm(boards)?;
    board(boards, "disarm")?;
    Ok(found + "nothing asked for; both: armed")
}

/// Both encoders' counters follow every edge, up and down.
fn encoder_counts(boards: &mut dyn Boards, edges: u32) -> Outcome {
    boards.ask("disarm")?;
    rig(boards, "device held")?;
    boards.wait_ms(5)?;
    for joint in 0..2_usize {
        for (way, sign) in [("up", 1), ("down", -1)] {
            let before = boards.counts()?;
            rig_within(boards, &format!("turn {} {edges} {way}", joint + 1), u64::from(edges) / 200)?;
            boards.wait_ms(5)?;
            let mut wanted = before;
            wanted[joint] = before[joint].wrapping_add_signed((sign * i64::from(edges)) as i16);
            let now = boards.counts()?;
            if now != wanted {
                return Err(format!("encoder {}, {edges} edges {way}: {before:?} became {now:?}", joint + 1));
            }
        }
    }
    // It went faster than any device may.
    boards.ask("clear")?;
    Ok(format!("{edges} edges each way of both encoders, all of them counted"))
}

/// Says lines that change settings, with the board's blue button held down, and has them taken.
fn set(boards: &mut dyn Boards, lines: &[&str]) -> Done {
    rig(boards, "button down")?;
    boards.wait_ms(100)?;
    for line in lines.iter().chain(&["apply"]) {
        board(boards, line)?;
    }
    rig(boards, "button up").map(drop)
}

/// Runs a test with other settings. Then sets all back: the device, the stop, the analogue output and the settings.
fn with(boards: &mut dyn Boards, settings: &[&str], test: impl FnOnce(&mut dyn Boards) -> Outcome) -> Outcome {
    set(boards, settings)?;
    let found = test(boards);
    boards.ask("disarm")?;
    for order in ["mend", "device held", "stop closed", "volts 2048"] {
        rig(boards, order)?;
    }
    // No current, and a supply that a board accepts, once the capacitor has them.
    boards.wait_ms(1000)?;
    boards.ask("clear")?;
    set_up(boards)?;
    found
}

/// Name, orders to the rig while the board is armed, and the faults of which the board must report one.
type Cases = &'static [(&'static str, &'static [&'static str], &'static [&'static str])];

/// An encoder with an index. A tick in the midst of the jump sees a device that is too fast.
const ENCODER: Cases = &[
    ("wire A cut", &["device sweep 1 1 800", "cut 1 A"], &["22"]),
    ("index elsewhere", &["mark", "device sweep 1 1 800", "mark"], &["20"]),
    ("jump", &["turn 1 9000 up"], &["2", "3"]),
];

/// Currents that nobody asked for, on either side of the end of the sensor's amplifier.
const SENSOR: Cases = &[
    ("3.09 V", &["volts 3835"], &["18"]),
    ("3.05 V", &["volts 3785"], &["17"]),
    ("0.21 V", &["volts 261"], &["18"]),
    ("0.25 V", &["volts 310"], &["17"]),
];

/// The board reports each fault and turns its outputs off. This order mends the rig before each case.
fn faults(boards: &mut dyn Boards, mends: &str, cases: Cases) -> Outcome {
    let mut found = String::new();
    for (what, orders, faults) in cases {
        rig(boards, mends)?;
        boards.wait_ms(5)?;
        boards.ask("clear")?;
        arm(boards)?;
        for order in *orders {
            rig(boards, order)?;
            boards.wait_ms(7)?;
        }
        boards.wait_ms(100)?;
        let status = boards.ask("status")?;
        let lines = rig(boards, "lines")?;
        let fault = faults.iter().find(|fault| status.contains(&format!(" faulted fault {fault} ")));
        let (Some(fault), "0 0") = (fault, &*lines) else {
            return Err(format!("{what}: {status}; PE14 and PF3 {lines}"));
        };
        found += &format!("{what}: fault {fault}; ");
    }
    Ok(found + "outputs off each time")
}

/// Records have the converter's own codes where full scale is the sensor's. A probe may ask for half of the supply.
const CURRENT_LOOP: &[&str] = &[
    "set motor.drive current-loop",
    "set motor.max_duty 0.7",
    "set motor.full_scale_a 6.875",
    "set probe.max_duty 0.5",
];

/// Slow enough for 10 kΩ and 10 µF to make of the rig's 4096 levels what lies between: no code is left out.
fn converter_codes(boards: &mut dyn Boards, levels: RangeInclusive<u32>, ms: u64) -> Outcome {
    let span = 15 * (levels.end() - levels.start()) as u16;
    boards.counts()?;
    rig(boards, &format!("volts {}", levels.start()))?;
    boards.wait_ms(1500)?;
    boards.codes();
    let mut seen = [Vec::new(), Vec::new()];
    for level in levels {
        rig(boards, &format!("volts {level}"))?;
        boards.wait_ms(ms)?;
        seen.iter_mut().zip(boards.codes()).for_each(|(seen, codes)| seen.extend(codes));
    }
    let [one, two] = seen.map(gap);
    let figures =
        |(step, span): (u16, u16)| format!("{} codes missing in a row at the most, of {span}", step.saturating_sub(1));
    let good = [one, two].iter().all(|(step, seen)| *step <= 9 && *seen >= span);
    judge(good, format!("PA3 {}; PC0 {}", figures(one), figures(two)))
}

/// The largest step from one code to the next that was seen, and how far the outermost are apart.
fn gap(mut codes: Vec<i16>) -> (u16, u16) {
    codes.sort_unstable();
    let step = codes.windows(2).map(|pair| pair[1].abs_diff(pair[0])).max();
    let span = codes.last().zip(codes.first()).map(|(last, first)| last.abs_diff(*first));
    (step.unwrap_or(u16::MAX), span.unwrap_or(0))
}

/// Compares the mean code of both inputs after each start, with the middle and with the other starts.
fn converter_start(boards: &mut dyn Boards, times: u32) -> Outcome {
    let mut means = [Vec::new(), Vec::new()];
    for _ in 0..times {
        rig(boards, "volts 2048")?;
        boards.stop_ticks()?;
        boards.meet()?;
        board(boards, "clear")?;
        let said = boards.ask("arm")?;
        if !said.starts_with("error check first: ") {
            return Err(format!("the board started anew, and says to `arm`: {said}"));
        }
        set(boards, CURRENT_LOOP)?;
        boards.counts()?;
        boards.codes();
        boards.wait_ms(100)?;
        for (means, codes) in means.iter_mut().zip(boards.codes()) {
            let sum: i64 = codes.iter().copied().map(i64::from).sum();
            means.push(sum.checked_div(codes.len() as i64).ok_or("no codes came")? as i16);
        }
    }
    let most = means.iter().flatten().map(|mean| mean.unsigned_abs()).max().unwrap_or(u16::MAX);
    let [one, two] = means.map(|means| gap(means).1);
    let figures = format!("within {most} codes of the middle, {times} starts within {one} codes (PA3) and {two} (PC0)");
    judge(most <= 655 && one.max(two) <= 8, figures)
}

/// A current goes to and fro through a winding whose sensor is at its end for 8 µs after each edge of its leg; a probe ends where a current is
/// twice what it asks for.
fn sample_after_edge(boards: &mut dyn Boards) -> Outcome {
    rig(boards, "winding")?;
    rig(boards, "device free")?;
    boards.ask("clear")?;
    board(boards, "probe 1 sine 0.33 0.02 50")?;
    boards.wait_ms(60)?;
    let probed = boards.ask("probed")?;
    judge(probed.contains(" done "), probed)
}

/// 24 V at the divider of PB1, of the analogue output's 4095.
const SUPPLY: u16 = 2707;

/// With the stop pressed, a supply that falls with this time constant passes, and one that stands does not.
fn supply(boards: &mut dyn Boards, ms: u32) -> Outcome {
    let stands = format!("volts {SUPPLY}");
    rig(boards, &stands)?;
    boards.wait_ms(700)?;
    boards.ask("clear")?;
    let fell = boards.stop_is_seen(&["stop open", &format!("fall {SUPPLY} {ms}")], &["stop closed", &stands]);
    // Current sensors on the same wire have read the end of their range.
    boards.wait_ms(700)?;
    boards.ask("clear")?;
    let stood = boards.stop_is_seen(&["stop open"], &["stop closed"]);
    let fell = fell.map_err(|why| format!("it falls within {ms} ms to a third: {why}"))?;
    match stood {
        Err(why) if why.contains("the supply stands at") => Ok(format!("falls: {fell}; stands: {why}")),
        Ok(seen) | Err(seen) => Err(format!("it stands: {seen}")),
    }
}

/// Packets that were refused or dropped, as `status` counts them.
fn refused(boards: &mut dyn Boards) -> Result<u32, String> {
    let status = board(boards, "status")?;
    ["overruns", "dropped", "refused"].into_iter().map(|name| after(&status, name)).sum()
}

/// Armed for so long, with an encoder that goes to and fro.
fn soak(boards: &mut dyn Boards, seconds: u32) -> Outcome {
    anew(boards)?;
    boards.counts()?;
    boards.came(&mut Came::default());
    let before = refused(boards)?;
    // Not a free device: what pushes it a little longer one way than the other has moved it out of its workspace by the evening.
    rig(boards, "device sweep 1 2 800")?;
    let mut came = Came::default();
    for _ in 0..seconds {
        boards.wait_ms(1000)?;
        boards.came(&mut came);
        if came.restarts > 0 || came.unarmed > 0 {
            break;
        }
    }
    let new = i64::from(refused(boards)?) - i64::from(before);
    let most = longest(boards, "duration")?;
    let status = boards.ask("status")?;
    boards.ask("disarm")?;
    rig(boards, "device held")?;
    let Came { ticks, missed, unarmed, restarts, .. } = came;
    let figures = format!(
        "{ticks} ticks in {seconds} s, {missed} missed, {unarmed} not armed, {restarts} restarts, {new} packets refused or dropped; the longest \
         took {most} cycles"
    );
    let good = missed + unarmed + restarts == 0 && new == 0 && ticks >= 990 * u64::from(seconds);
    let good = good && TICK_CYCLES.contains(&most);
    judge(good, figures).map_err(|figures| format!("{figures}; {status}"))
}

/// Half a period of the outputs, and more: they end with the processor.
const PERIOD: u32 = 50 * 240;

/// A halted processor leaves no output on. Pulses that went on in a halt of 5 ms do not change in it: 4 ms after the last that changed is late.
fn halt(boards: &mut dyn Boards, times: u32) -> Outcome {
    let (mut least, mut most) = (u32::MAX, 0);
    for _ in 0..times {
        let [edge, change] = watched(boards, |boards| boards.halt(5))?;
        let late = edge.max(change.saturating_sub(2 * DEAD_MAN));
        (least, most) = (least.min(late), most.max(late));
        rig(boards, "device held")?;
        boards.ask("arm").and_then(|said| judge(said == "error faulted, fault 72", said))?;
        board(boards, "clear")?;
        boards.wait_ms(5)?;
    }
    judge(most < PERIOD, format!("{} to {} ns after the last pulse, {times} times", ns(least), ns(most)))
}

/// Armed, in a world that begins anew, as the simulator's does.
fn anew(boards: &mut dyn Boards) -> Done {
    arm(boards)?;
    board(boards, "disarm")?;
    board(boards, "apply")?;
    boards.wait_ms(20)?;
    board(boards, "arm alone").map(drop)
}

/// A device that the board drives and a hand pushes: every record is what the simulator makes of its inputs.
fn same_bits(boards: &mut dyn Boards, per_ms: u32, ticks: u32) -> Outcome {
    boards.counts()?;
    anew(boards)?;
    rig(boards, "device free")?;
    for way in ["up", "down", "up", "down"] {
        rig(boards, &format!("push 1000 {way}"))?;
        boards.wait_ms(u64::from(ticks / 4 / per_ms))?;
    }
    board(boards, "disarm")?;
    rig(boards, "device held")?;
    let [same, all] = boards.same(per_ms)?;
    judge(same == all && all >= u64::from(ticks), format!("{same} of {all} ticks"))
}

/// Counts of 240 MHz as ns.
fn ns(counts: u32) -> u64 {
    u64::from(counts) * 25 / 6
}

#[cfg(test)]
#[path = "../tests/inside/run.rs"]
mod tests;
