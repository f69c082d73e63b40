//! Who runs the list: what is said to the board under test, to the rig and to the probe, and what must come of it. The same for two boards
//! on a table and for two virtual ones ([`Boards`]).

use crate::list::Test;

/// The board under test, the rig and the probe. What fails is said in a sentence.
pub trait Boards {
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
    /// How often each has come since this was asked last: see [`Came`].
    fn came(&mut self) -> Came;
    /// What host-sim's bring-up says of the emergency stop: what was seen of it, or why it does not pass. These are the orders to the rig where a
    /// person would press the stop, and release it.
    fn stop_is_seen(&mut self, pressed: &[&str], released: &[&str]) -> Outcome;
    /// Waits until a board that started anew answers its operator.
    fn meet(&mut self) -> Done;
    /// Every tick is recorded from here on; the counters of both encoders in the last one that was.
    fn counts(&mut self) -> Result<[u16; 2], String>;
    /// The records of all ticks since the board was armed last, computed again by the simulator from what the board read: how many are the
    /// same, of how many.
    fn same(&mut self) -> Result<[u64; 2], String>;
}

/// What came of a test.
pub type Outcome = Result<String, String>;
/// Something was done, or why not.
pub type Done = Result<(), String>;

/// Ticks, by their records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Came {
    /// That came.
    pub ticks: u64,
    /// That did not, between two that did.
    pub missed: u64,
    /// Of those that came, how many were not armed.
    pub unarmed: u64,
    /// Of those, how many had a smaller number than the one before: the board started anew.
    pub restarts: u64,
}

impl Came {
    /// These too.
    #[must_use]
    pub fn and(self, more: Self) -> Self {
        Self {
            ticks: self.ticks + more.ticks,
            missed: self.missed + more.missed,
            unarmed: self.unarmed + more.unarmed,
            restarts: self.restarts + more.restarts,
        }
    }
}

/// How often each test does what it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// As the list says.
    Whole,
    /// As often as a virtual board can in a few seconds.
    Virtual,
}

/// How long a soak takes without a length of its own, s.
const SOAK_S: u32 = 86_400;
const SOAK_VIRTUAL_S: u32 = 5;

/// Runs a test, a soak for so many seconds; `None` for one that nobody has written down here.
pub fn run(boards: &mut dyn Boards, test: &Test, extent: Extent, soak_s: Option<u32>) -> Option<Outcome> {
    let times = |whole: u32, virtually: u32| if extent == Extent::Whole { whole } else { virtually };
    Some(match test.name {
        "tick-duration" => tick_duration(boards),
        "tick-spacing" => tick_spacing(boards, times(100_000, 1000)),
        "break-by-stop" => breaks(boards, "stop", times(1000, 5)),
        "break-by-fault" => breaks(boards, "fault", times(1000, 5)),
        "dead-man" => dead_man(boards, times(100, 2)),
        "amplifiers-gate" => gate(boards),
        "encoder-counts" => encoder_counts(boards, times(10_000_000, 20_000)),
        "encoder-faults" => encoder_faults(boards),
        "converter-codes" => {
            let (from, to) = if extent == Extent::Whole { (0, 4095) } else { (2552, 2568) };
            converter_codes(boards, from, to, u64::from(times(200, 20)))
        }
        "supply-behind-the-stop" => supply(boards, times(2200, 220)),
        "soak" => soak(boards, soak_s.unwrap_or(times(SOAK_S, SOAK_VIRTUAL_S))),
        "halt-while-armed" => halt(boards, times(100, 3)),
        "same-bits" => same_bits(boards, times(60_000, 1000)),
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

/// Armed, with an encoder that moves in every tick.
fn shaken(boards: &mut dyn Boards) -> Result<(), String> {
    arm(boards)?;
    rig(boards, "device shake 10")?;
    boards.wait_ms(20)?;
    Ok(())
}

/// The longest of a time that the board keeps, cycles.
fn longest(boards: &mut dyn Boards, time: &str) -> Result<u32, String> {
    let told = board(boards, &format!("time {time}"))?;
    let most = told.split("most ").nth(1).and_then(|rest| rest.split(' ').next());
    most.and_then(|most| most.parse().ok()).ok_or(format!("the board says to `time {time}`: {told}"))
}

/// Fewest cycles that a tick of a thousand instructions can take, less some.
const LEAST_CYCLES: u32 = 300;

/// The longest tick, disarmed and armed.
fn tick_duration(boards: &mut dyn Boards) -> Outcome {
    shaken(boards)?;
    boards.wait_ms(200)?;
    let most = longest(boards, "duration")?;
    board(boards, "disarm")?;
    // Two instructions a cycle are the most that the processor has: fewer cycles are a counter that stands.
    judge((LEAST_CYCLES..24_000).contains(&most), format!("{most} cycles at the most"))
}

/// What was found, as passed or as failed.
fn judge(good: bool, figures: String) -> Outcome {
    if good { Ok(figures) } else { Err(figures) }
}

/// Every change of the pulses comes in step with the ticks, and most ticks change them.
fn tick_spacing(boards: &mut dyn Boards, ticks: u32) -> Outcome {
    shaken(boards)?;
    let [periods, changes, in_step, off, residue, missing] =
        measured(boards, &format!("pulses {}", 20 * ticks), ticks.into())?;
    let most = longest(boards, "spacing")?;
    board(boards, "disarm")?;
    let figures = format!(
        "{changes} changes in {periods} periods, {in_step} of them 20 periods after the last, {off} elsewhere, {missing} periods missing, at most \
         {residue} counts of 240 MHz beside a period; the board's own: {most} cycles"
    );
    // A tick may leave the pulses as they were; two clocks may differ by 100 ppm.
    let good = off == 0 && missing == 0 && in_step * 10 >= 9 * ticks && residue <= 24 && most <= 100;
    judge(good, figures)
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
    shaken(boards)?;
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
    for wired in ["enable", "timer", "never", "always"] {
        rig(boards, &format!("gate {wired}"))?;
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
        rig(boards, "gate both")?;
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

/// What an encoder shows that fails is told.
fn encoder_faults(boards: &mut dyn Boards) -> Outcome {
    set(boards, &["set encoder.index true"])?;
    let found = encoder_fails(boards);
    for order in ["mend", "device held"] {
        rig(boards, order)?;
    }
    boards.wait_ms(5)?;
    boards.ask("clear")?;
    set(boards, &["set encoder.index false"])?;
    found
}

/// [`encoder_faults`] with an index. A tick in the midst of the jump sees a device that is too fast.
fn encoder_fails(boards: &mut dyn Boards) -> Outcome {
    let mut found = String::new();
    for (what, orders, faults) in [
        ("wire A cut", &["device sweep 1", "cut 1 A"][..], &["22"][..]),
        ("index elsewhere", &["mark", "device sweep 1", "mark"], &["20"]),
        ("jump", &["turn 1 9000 up"], &["2", "3"]),
    ] {
        arm(boards)?;
        for order in orders {
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
        rig(boards, "mend")?;
        rig(boards, "device held")?;
        boards.wait_ms(5)?;
        boards.ask("clear")?;
    }
    Ok(found + "outputs off each time")
}

/// Records have the converter's own codes where full scale is the sensor's.
const CURRENT_LOOP: &[&str] = &["set motor.drive current-loop", "set motor.max_duty 0.9", "set motor.full_scale_a 5.5"];

/// Slow enough for 10 kΩ and 10 µF to make of the rig's 4096 levels what lies between: no code is left out.
fn converter_codes(boards: &mut dyn Boards, from: u16, to: u16, ms: u64) -> Outcome {
    set(boards, CURRENT_LOOP)?;
    boards.counts()?;
    rig(boards, &format!("volts {from}"))?;
    boards.wait_ms(1500)?;
    boards.codes();
    boards.order(&format!("ramp {from} {to} {ms}"))?;
    let mut seen = [Vec::new(), Vec::new()];
    for _ in 0..(u64::from(to - from) * ms + 500) / 100 {
        boards.wait_ms(100)?;
        seen.iter_mut().zip(boards.codes()).for_each(|(seen, codes)| seen.extend(codes));
    }
    let answer = boards.answer(PATIENCE_MS)?;
    // No current, and a supply that a board takes: it stays.
    rig(boards, "volts 2048")?;
    boards.wait_ms(1500)?;
    boards.ask("clear")?;
    set_up(boards)?;
    if answer != "ok" {
        return Err(format!("the rig says to `ramp`: {answer}"));
    }
    let [one, two] = seen.map(|codes| gap(codes, i32::from(to - from) * 16));
    let figures = |(step, span): (i32, i32)| format!("{} codes missing in a row at the most, of {span}", step - 1);
    judge(
        [one, two].iter().all(|(gap, span)| *gap <= 9 && *span >= i32::from(to - from) * 15),
        format!("PA3 {}; PC0 {}", figures(one), figures(two)),
    )
}

/// The largest step from one code to the next that was seen, and how far the outermost are apart; nothing that leaves the board's numbers.
fn gap(mut codes: Vec<i16>, most: i32) -> (i32, i32) {
    codes.sort_unstable();
    let step = codes.windows(2).map(|pair| i32::from(pair[1]) - i32::from(pair[0])).max().unwrap_or(most);
    let span = codes.last().zip(codes.first()).map_or(0, |(last, first)| i32::from(*last) - i32::from(*first));
    (step, span)
}

/// 24 V at the divider of PB1, of the analogue output's 4095.
const SUPPLY: u16 = 2707;

/// With the stop pressed, a supply that falls with this time constant passes, and one that stands does not.
fn supply(boards: &mut dyn Boards, ms: u32) -> Outcome {
    let stands = format!("volts {SUPPLY}");
    set(boards, CURRENT_LOOP)?;
    rig(boards, &stands)?;
    boards.wait_ms(700)?;
    boards.ask("clear")?;
    let fell = boards.stop_is_seen(&["stop open", &format!("fall {SUPPLY} {ms}")], &["stop closed", &stands]);
    // Current sensors on the same wire have read the end of their range.
    boards.wait_ms(700)?;
    boards.ask("clear")?;
    let stood = boards.stop_is_seen(&["stop open"], &["stop closed"]);
    for order in ["stop closed", "volts 2048"] {
        rig(boards, order)?;
    }
    boards.wait_ms(700)?;
    boards.ask("clear")?;
    set_up(boards)?;
    let fell = fell.map_err(|why| format!("it falls within {ms} ms to a third: {why}"))?;
    match stood {
        Err(why) if why.contains("the supply stands at") => Ok(format!("falls: {fell}; stands: {why}")),
        Ok(seen) | Err(seen) => Err(format!("it stands: {seen}")),
    }
}

/// Counters of packets in `status` that must stay.
const REFUSED: [&str; 3] = ["overruns", "dropped", "refused"];

/// What `status` says of them.
fn refused(boards: &mut dyn Boards) -> Result<[u32; 3], String> {
    let status = board(boards, "status")?;
    let words: Vec<&str> = status.split([' ', ';']).collect();
    let after = |name: &str| words.iter().position(|word| *word == name).and_then(|at| words.get(at + 1)?.parse().ok());
    let [Some(overruns), Some(dropped), Some(refused)] = REFUSED.map(after) else {
        return Err(format!("the board counts no {} in {status}", REFUSED.join(", ")));
    };
    Ok([overruns, dropped, refused])
}

/// Armed for so long, with an encoder that goes to and fro.
fn soak(boards: &mut dyn Boards, seconds: u32) -> Outcome {
    anew(boards)?;
    boards.counts()?;
    boards.came();
    let before = refused(boards)?;
    // Not a free device: what pushes it a little longer one way than the other has moved it out of its workspace by the evening.
    rig(boards, "device sweep 2")?;
    let mut came = Came::default();
    for _ in 0..seconds {
        boards.wait_ms(1000)?;
        came = came.and(boards.came());
        if came.restarts > 0 || came.unarmed > 0 {
            break;
        }
    }
    let after = refused(boards)?;
    let most = longest(boards, "duration")?;
    let status = boards.ask("status")?;
    boards.ask("disarm")?;
    rig(boards, "device held")?;
    let new = after.map(i64::from).iter().zip(before).map(|(after, before)| after - i64::from(before)).sum::<i64>();
    let Came { ticks, missed, unarmed, restarts } = came;
    let figures = format!(
        "{ticks} ticks in {seconds} s, {missed} missed, {unarmed} not armed, {restarts} restarts, {new} packets refused or dropped; the longest \
         took {most} cycles"
    );
    let good = missed + unarmed + restarts == 0 && new == 0 && ticks >= 990 * u64::from(seconds);
    let good = good && (LEAST_CYCLES..24_000).contains(&most);
    judge(good, if good { figures } else { format!("{figures}; {status}") })
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
fn same_bits(boards: &mut dyn Boards, ticks: u32) -> Outcome {
    boards.counts()?;
    anew(boards)?;
    rig(boards, "device free")?;
    for way in ["up", "down", "up", "down"] {
        rig(boards, &format!("push 1000 {way}"))?;
        boards.wait_ms(u64::from(ticks / 4))?;
    }
    board(boards, "disarm")?;
    rig(boards, "device held")?;
    let [same, all] = boards.same()?;
    judge(same == all && all >= u64::from(ticks), format!("{same} of {all} ticks"))
}

/// Counts of 240 MHz as ns.
fn ns(counts: u32) -> u64 {
    u64::from(counts) * 25 / 6
}

#[cfg(test)]
#[path = "../tests/inside/run.rs"]
mod tests;
