//! Boards and operators' ends that run [`crate::lease`], and everything around them that may go wrong.
//!
//! Time goes in units. All times are relative to now and saturate beyond the longest that anything compares with, and numbers of words
//! are relative to their operator's newest one, so that the space is finite although runs are not. The network holds up to so many
//! datagrams each way, and passes any of them on at any time and in any order, or drops it. Copies need no action: a session takes each
//! datagram once. **Assumed**: datagrams are authentic, a handshake is one step, and no number comes again while a line is under way.

use std::hash::{Hash, Hasher};

use super::super::{Aged, AtBoard, AtOperator, Giver, Holder, LAST, Motors, Number, Told, Want, Word};

/// Now, in every state.
const NOW: u64 = 16;

/// A mistake that is made on purpose, to see that it is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Planted {
    Nothing,
    /// Stop only takes permission back, and *stopped* is said when the board has heard it: version 3.
    OldStop,
    /// *Stopped* is said when the lease is over: version 3.
    LeaseOver,
    /// Permission ends only if the newest row that was shown says that motors are on: version 3.
    GateByRow,
    /// The newest row is shown however old it is: version 3.
    ShownWithoutAge,
    /// A start does not look at the age of its permission: version 3.
    YesOfAnyAge,
    /// A start counts as often as it comes.
    UsedAgain,
    /// The board measures the lease by the operator's clock.
    OtherClock,
    /// Each operator stops only its own run, and is told of no other.
    OwnRunAlone,
}

/// Bounds, and times in units.
#[derive(Clone, Debug)]
pub(super) struct World {
    pub(super) planted: Planted,
    /// The lease, one unit of which is the time that turning off takes; how old a shown word may be; how long nobody may ask.
    pub(super) lease: u64,
    pub(super) shown: u64,
    pub(super) silence: u64,
    /// Operators, and datagrams under way to the board and to each operator.
    pub(super) operators: usize,
    pub(super) to_board: usize,
    pub(super) to_operator: usize,
    pub(super) alone: bool,
    pub(super) switch: bool,
    pub(super) restarts: bool,
    /// The board's clock and the operators' clock advance independently, so at any rates. Otherwise they are one clock.
    pub(super) drift: bool,
    /// Of how many states one is tried for what a person may count on; 0: none.
    pub(super) live_every: u64,
}

/// A moment by the operators' clock, and by the board's, which only promises look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Moment {
    operators: u64,
    board: u64,
}

/// A line that starts something.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Line {
    word: Word,
    alone: bool,
    /// By whom Stop was pressed since the start was; one of them was told that it stopped; it has started something. Only promises look.
    stops: u8,
    void: bool,
    done: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct ToBoard {
    word: Word,
    echo: Option<u64>,
    sealed: Moment,
    line: Option<Line>,
    /// Something newer has come.
    late: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct ToOperator {
    told: Told,
    echo: Option<u64>,
    sealed: u64,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Operator {
    giver: Giver,
    /// A session was begun in this process; it was with this life of the board.
    met: bool,
    knows: bool,
    /// The newest time of the board's clock.
    stamp: Option<u64>,
    /// The newest start, which goes on being sent.
    line: Option<Line>,
    came: Vec<ToOperator>,
    /// When a yes was sealed last; kept for one mistake only.
    yes: u64,
}

/// What runs, for promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Ran {
    by: usize,
    line: Line,
    since: u64,
    /// When the newest yes that has come was sealed.
    yes: u64,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct State {
    holder: Holder,
    /// The motors are on; they are not what the holder wants, for a whole unit.
    driven: bool,
    lags: bool,
    held: bool,
    session: Option<usize>,
    /// Whose words the board has; none if that end has restarted.
    peer: Option<usize>,
    /// When the newest datagram of its operator was sealed.
    stamp: Option<Moment>,
    under_way: Vec<ToBoard>,
    operators: Vec<Operator>,
    ran: Option<Ran>,
    broken: Option<&'static str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Tick {
        board: bool,
        operators: bool,
    },
    /// The tick does what the holder wants.
    CarryOut,
    Connect(usize),
    Restart(usize),
    BoardRestarts,
    Start {
        by: usize,
        alone: bool,
    },
    Stop(usize),
    Leave(usize),
    Asked(usize),
    Send {
        by: usize,
        line: bool,
    },
    Say,
    ReachBoard(usize),
    DropToBoard(usize),
    ReachOperator(usize, usize),
    DropToOperator(usize, usize),
    Release,
    Hold,
    Fault,
}

/// What was told, however old it is.
fn told_at_all(told: &Aged<Told>) -> Told {
    *told.within(NOW, NOW).expect("no time is before 0")
}

impl World {
    /// Longer ago than a lease.
    fn long_ago(&self) -> u64 {
        NOW - self.lease - 1
    }

    fn operator(&self) -> Operator {
        let giver = Giver { shown_us: self.shown, silence_us: self.silence, ..Giver::default() };
        Operator { giver, met: false, knows: false, stamp: None, line: None, came: Vec::new(), yes: self.long_ago() }
    }

    pub(super) fn start(&self) -> State {
        let mut state = State {
            holder: Holder::new(self.lease - 1),
            driven: false,
            lags: false,
            held: !self.switch,
            session: None,
            peer: None,
            stamp: None,
            under_way: Vec::new(),
            operators: (0..self.operators).map(|_| self.operator()).collect(),
            ran: None,
            broken: None,
        };
        self.settle(&mut state);
        state
    }

    pub(super) fn actions(&self, state: &State) -> Vec<Action> {
        let mut actions = vec![Action::CarryOut, Action::Say, Action::Fault];
        let clocks: &[_] = if self.drift { &[(true, false), (false, true)] } else { &[(true, true)] };
        actions.extend(clocks.iter().map(|&(board, operators)| Action::Tick { board, operators }));
        if self.switch {
            actions.extend([Action::Release, Action::Hold]);
        }
        if self.restarts {
            actions.push(Action::BoardRestarts);
        }
        for by in 0..self.operators {
            actions.extend([Action::Connect(by), Action::Stop(by), Action::Leave(by), Action::Asked(by)]);
            actions.extend([false, true].map(|line| Action::Send { by, line }));
            actions.push(Action::Start { by, alone: false });
            if self.alone {
                actions.push(Action::Start { by, alone: true });
            }
            if self.restarts {
                actions.push(Action::Restart(by));
            }
            for at in 0..state.operators[by].came.len() {
                actions.extend([Action::ReachOperator(by, at), Action::DropToOperator(by, at)]);
            }
        }
        for at in 0..state.under_way.len() {
            actions.extend([Action::ReachBoard(at), Action::DropToBoard(at)]);
        }
        actions
    }

    /// The state after an action; none if that cannot be, or changes nothing.
    pub(super) fn next(&self, last: &State, action: Action) -> Option<State> {
        let mut state = last.clone();
        self.act(&mut state, action)?;
        (state != *last).then_some(state)
    }

    fn act(&self, state: &mut State, action: Action) -> Option<()> {
        match action {
            Action::Tick { board, operators } => {
                if board && state.lags {
                    self.carry_out(state);
                }
                self.pass(state, board, operators);
                if board {
                    let _ = state.holder.step(NOW, AtBoard::Look);
                    state.lags = state.driven != (state.holder.motors != Motors::Off);
                }
                for by in 0..self.operators {
                    let Operator { giver, yes, .. } = &state.operators[by];
                    if self.planted == Planted::LeaseOver && giver.want() == Want::Stop && NOW - yes > self.lease {
                        state.says_stopped(by);
                    }
                }
            }
            Action::CarryOut => {
                (state.driven != (state.holder.motors != Motors::Off)).then_some(())?;
                self.carry_out(state);
            }
            Action::Connect(by) => {
                if state.peer != Some(by) {
                    let _ = state.holder.step(NOW, AtBoard::Session);
                    state.ran.iter_mut().for_each(|ran| ran.line.word = Word::default());
                }
                let operator = &mut state.operators[by];
                if !operator.knows {
                    let _ = operator.giver.step(NOW, AtOperator::Session);
                }
                // A line that was said in an earlier session does nothing.
                (operator.met, operator.knows, operator.stamp, operator.line) = (true, true, None, None);
                operator.came.clear();
                (state.session, state.peer, state.stamp) = (Some(by), Some(by), None);
                state.under_way.clear();
            }
            Action::Restart(by) => {
                state.operators[by].met.then_some(())?;
                state.operators[by] = self.operator();
                state.peer = state.peer.filter(|peer| *peer != by);
            }
            Action::BoardRestarts => {
                state.session?;
                state.holder = Holder::new(self.lease - 1);
                (state.driven, state.lags, state.session, state.peer, state.stamp, state.ran) =
                    (false, false, None, None, None, None);
                state.under_way.clear();
                state.operators.iter_mut().for_each(|operator| operator.knows = false);
            }
            Action::Start { by, alone } => {
                let operator = &mut state.operators[by];
                operator.met.then_some(())?;
                operator.giver.step(NOW, AtOperator::Start).ok()?;
                let word = operator.giver.word;
                operator.line = Some(Line { word, alone, stops: 0, void: false, done: false });
            }
            Action::Stop(by) => {
                let before = state.operators[by].giver.word;
                let _ = state.operators[by].giver.step(NOW, AtOperator::Stop);
                (state.operators[by].giver.word != before).then_some(())?;
                state.lines(|line| line.stops |= 1 << by);
            }
            Action::Leave(by) => {
                let _ = state.operators[by].giver.step(NOW, AtOperator::Leave);
            }
            Action::Asked(by) => {
                let _ = state.operators[by].giver.step(NOW, AtOperator::Asked);
            }
            Action::Send { by, line } => self.send(state, by, line)?,
            Action::Say => {
                let by = state.session?;
                let (mut told, echo) = (state.holder.told(state.driven), state.stamp.map(|stamp| stamp.operators));
                if self.planted == Planted::OwnRunAlone && state.ran.is_some_and(|ran| ran.by != by) {
                    told.motors = Motors::Off;
                }
                let operator = &mut state.operators[by];
                (operator.met && operator.came.len() < self.to_operator).then_some(())?;
                let said = ToOperator { told, echo, sealed: NOW };
                (operator.came.last() != Some(&said)).then_some(())?;
                operator.came.push(said);
            }
            Action::ReachBoard(at) => self.reach_board(state, at)?,
            Action::DropToBoard(at) => {
                (state.under_way.len() == self.to_board).then_some(())?;
                state.under_way.remove(at);
            }
            Action::ReachOperator(by, at) => {
                let operator = &mut state.operators[by];
                (at < operator.came.len()).then_some(())?;
                let came = operator.came.drain(..=at).next_back()?;
                operator.stamp = Some(came.sealed);
                let before = operator.giver.is_stopped();
                let _ = operator.giver.step(NOW, AtOperator::Heard { told: came.told, echo_us: came.echo });
                let heard = operator.giver.want() == Want::Stop && came.told.heard == operator.giver.word.number;
                if operator.giver.is_stopped() && !before || self.planted == Planted::OldStop && heard {
                    state.says_stopped(by);
                }
            }
            Action::DropToOperator(by, at) => {
                let came = &mut state.operators[by].came;
                (came.len() == self.to_operator).then_some(())?;
                came.remove(at);
            }
            Action::Release => {
                state.held.then_some(())?;
                state.held = false;
                let _ = state.holder.step(NOW, AtBoard::Off);
            }
            Action::Hold => state.held = true,
            Action::Fault => {
                let _ = state.holder.step(NOW, AtBoard::Off);
            }
        }
        self.settle(state);
        Some(())
    }

    fn send(&self, state: &mut State, by: usize, line: bool) -> Option<()> {
        let operator = &mut state.operators[by];
        (operator.met && state.session == Some(by) && state.under_way.len() < self.to_board).then_some(())?;
        let asked = operator.giver.asked_us;
        if self.planted == Planted::GateByRow
            && operator.giver.told.is_none_or(|told| told_at_all(&told).motors != Motors::Leased)
        {
            operator.giver.asked_us = NOW;
        }
        let word = operator.giver.word(NOW);
        operator.giver.asked_us = asked;
        if word.want == Want::Run && NOW - asked > self.silence {
            state.broken = Some("S3: a yes although nobody asks");
        }
        if word.want == Want::Run && self.planted == Planted::LeaseOver {
            operator.yes = NOW;
        }
        // An end that has changed its mind does not say the line again.
        let line = if line { Some(operator.line.filter(|line| word == line.word)?) } else { None };
        // Promises are about how old a yes is, and there is none in other words.
        let board = if word.want == Want::Run { NOW } else { self.long_ago() };
        let sealed = Moment { operators: NOW, board };
        let said = ToBoard { word, echo: operator.stamp, sealed, line, late: false };
        (state.under_way.last() != Some(&said)).then_some(())?;
        state.under_way.push(said);
        Some(())
    }

    fn reach_board(&self, state: &mut State, at: usize) -> Option<()> {
        let by = state.session?;
        (at < state.under_way.len()).then_some(())?;
        let came = state.under_way.remove(at);
        if !came.late {
            state.stamp = Some(came.sealed);
            let stops = match self.planted {
                Planted::OldStop => false,
                Planted::OwnRunAlone => state.ran.is_none_or(|ran| ran.by == by),
                _ => true,
            };
            let old_stop = !stops && came.word.want == Want::Stop;
            let heard = if old_stop { Word { want: Want::Nothing, ..came.word } } else { came.word };
            let other_clock = self.planted == Planted::OtherClock;
            let echo_us = if other_clock { Some(came.sealed.operators) } else { came.echo };
            let _ = state.holder.step(NOW, AtBoard::Heard { word: heard, echo_us });
            state.under_way[..at].iter_mut().for_each(|older| older.late = true);
            let run = |ran: &&mut Ran| ran.by == by && came.word == ran.line.word;
            state.ran.as_mut().filter(run).into_iter().for_each(|ran| ran.yes = came.sealed.board);
        }
        // The console refuses a line before the lease does if motors are on or the switch is not held.
        let Some(line) = came.line.filter(|_| !state.driven && state.held) else { return Some(()) };
        if self.planted == Planted::YesOfAnyAge && state.holder.word == line.word {
            state.holder.said_us = Some(NOW);
        }
        if self.planted == Planted::UsedAgain {
            state.holder.used = false;
        }
        if state.holder.step(NOW, AtBoard::Start { word: line.word, alone: line.alone }).is_ok() {
            // The newest datagram says the run of this line, or it had not started.
            let yes = state.stamp.map_or(0, |stamp| stamp.board);
            if line.void || line.done || NOW - yes > self.lease {
                state.broken = Some("S4: something old, used or stopped has started");
            }
            state.ran = Some(Ran { by, line, since: NOW, yes });
            let done = |other: &mut Line| other.done |= other.word == line.word;
            state.under_way.iter_mut().filter_map(|came| came.line.as_mut()).for_each(done);
            state.operators[by].line.iter_mut().for_each(done);
        }
        Some(())
    }

    fn carry_out(&self, state: &mut State) {
        let driven = state.holder.motors != Motors::Off;
        if driven && !state.driven {
            state.ran.iter_mut().for_each(|ran| ran.since = NOW);
        }
        (state.driven, state.lags) = (driven, false);
    }

    /// A unit of time passes by these clocks. Each time saturates beyond what it is compared with.
    fn pass(&self, state: &mut State, board: bool, operators: bool) {
        fn older(time: &mut u64, passed: bool, longest: u64) {
            *time = (*time - u64::from(passed)).max(NOW - longest);
        }
        let by_board = |time: &mut u64| older(time, board, self.lease + 1);
        let by_operators = |time: &mut u64| older(time, operators, self.shown + 1);
        let fresh_by_board = |time: &mut u64| older(time, board, self.lease);
        state.holder.said_us.iter_mut().for_each(fresh_by_board);
        state.under_way.iter_mut().filter_map(|came| came.echo.as_mut()).for_each(fresh_by_board);
        for sealed in state.stamp.iter_mut().chain(state.under_way.iter_mut().map(|came| &mut came.sealed)) {
            by_board(&mut sealed.board);
            by_operators(&mut sealed.operators);
        }
        for operator in &mut state.operators {
            operator.stamp.iter_mut().for_each(fresh_by_board);
            older(&mut operator.giver.asked_us, operators, self.silence + 1);
            operator.giver.told.iter_mut().for_each(|told| by_operators(&mut told.at));
            for came in &mut operator.came {
                came.echo.iter_mut().for_each(by_operators);
                fresh_by_board(&mut came.sealed);
            }
            if self.planted == Planted::LeaseOver {
                older(&mut operator.yes, operators, self.lease + 1);
            }
        }
        if let Some(ran) = &mut state.ran {
            by_operators(&mut ran.since);
            by_board(&mut ran.yes);
        }
    }

    /// One form for what has the same future.
    fn settle(&self, state: &mut State) {
        if !state.driven && state.holder.motors == Motors::Off {
            state.ran = None;
        }
        for ran in state.ran.iter_mut().filter(|ran| ran.line.alone) {
            ran.yes = NOW;
        }
        // The age of a permission counts for what runs by it, and for what it may start.
        let Holder { word, used, motors, .. } = state.holder;
        if motors != Motors::Leased && (word.want != Want::Run || used) && self.planted != Planted::UsedAgain {
            state.holder.said_us = None;
        }
        if word.want != Want::Run || used {
            state.stamp.iter_mut().for_each(|stamp| stamp.board = self.long_ago());
        }
        let fresh = |said_us: &u64| NOW - said_us < self.lease;
        state.holder.said_us = state.holder.said_us.filter(fresh);
        state.under_way.iter_mut().for_each(|came| came.echo = came.echo.filter(fresh));
        let rows = [Planted::GateByRow, Planted::ShownWithoutAge].contains(&self.planted);
        for (by, operator) in state.operators.iter_mut().enumerate() {
            let giver = &mut operator.giver;
            if giver.want() != Want::Run {
                giver.asked_us = 0;
            }
            giver.asked_us = giver.asked_us.max(NOW - self.silence - 1);
            // What the board has heard is this end's word, or any other; of an old row no more counts than that it confirms a stop.
            let (number, stop) = (giver.word.number, giver.want() == Want::Stop && !giver.stopped);
            let confirmed = Told { motors: Motors::Off, heard: number };
            let young = |said_us: u64| rows || NOW - said_us <= self.shown;
            let plain =
                |told: Told| if told.heard == number { told } else { Told { heard: Number::default(), ..told } };
            let told = giver.told.filter(|told| young(told.at));
            giver.told = told.map(|told| Aged::new(plain(told_at_all(&told)), told.at));
            for came in &mut operator.came {
                (came.told, came.echo) = (plain(came.told), came.echo.filter(|echo| young(*echo)));
                if came.echo.is_none() && !(stop && came.told == confirmed) && !rows {
                    came.told = Told::default();
                }
            }
            operator.line = operator.line.filter(|line| giver.word == line.word);
            // A session begins without these.
            if state.session != Some(by) {
                (operator.line, operator.stamp) = (None, None);
                operator.came.iter_mut().for_each(|came| came.sealed = NOW);
            }
        }
        // What came out of order counts for nothing but its line, and that only while a word of its number may be about.
        if let Some(by) = state.session {
            let mut words: Vec<_> = state.under_way.iter().filter(|came| !came.late).map(|came| came.word).collect();
            words.extend([state.operators[by].giver.word, state.holder.word]);
            state.under_way.retain(|came| !came.late || came.line.is_some_and(|line| words.contains(&line.word)));
        }
        for came in state.under_way.iter_mut().filter(|came| came.late) {
            (came.word, came.echo) = (Word::default(), None);
            came.sealed = Moment { operators: NOW, board: NOW };
        }
        for by in 0..state.operators.len() {
            self.renumber(state, by);
        }
    }

    /// Numbers are only compared with each other, or are the next one: each operator's newest word has the first number.
    fn renumber(&self, state: &mut State, by: usize) {
        let less_by = state.operators[by].giver.word.number.0 - 1;
        if less_by == 0 {
            return;
        }
        let less = |number: &mut Number| {
            if *number != Number::default() {
                number.0 = (number.0 - 1 + LAST - less_by) % LAST + 1;
            }
        };
        let operator = &mut state.operators[by];
        less(&mut operator.giver.word.number);
        if let Some(told) = &mut operator.giver.told {
            let mut now_known = told_at_all(told);
            less(&mut now_known.heard);
            *told = Aged::new(now_known, told.at);
        }
        operator.line.iter_mut().for_each(|line| less(&mut line.word.number));
        operator.came.iter_mut().for_each(|came| less(&mut came.told.heard));
        // An end that has restarted has other numbers than what is left of it.
        if state.peer == Some(by) {
            less(&mut state.holder.word.number);
            for came in &mut state.under_way {
                less(&mut came.word.number);
                came.line.iter_mut().for_each(|line| less(&mut line.word.number));
            }
            state.ran.iter_mut().for_each(|ran| less(&mut ran.line.word.number));
        }
    }

    /// The promise that a state breaks, if any.
    pub(super) fn broken(&self, state: &State, mark: u64) -> Option<&'static str> {
        let ran = state.ran.filter(|_| state.driven);
        let shows = |motors: Motors| {
            state.operators.iter().any(|operator| {
                let shown = match self.planted {
                    Planted::ShownWithoutAge => operator.giver.told.map(|told| told_at_all(&told).motors),
                    _ => operator.giver.shown(NOW),
                };
                shown == Some(motors)
            })
        };
        let since = ran.map_or(NOW, |ran| ran.since);
        let alone = ran.is_some_and(|ran| ran.line.alone) && state.holder.motors == Motors::Alone;
        let live = || mark.is_multiple_of(self.live_every) && !(0..self.operators).all(|by| self.lets_use(state, by));
        if state.broken.is_some() {
            state.broken
        } else if state.driven && state.ran.is_some_and(|ran| ran.line.void) {
            Some("S1: on after stopped was said, without a later start")
        } else if ran.is_some_and(|ran| !ran.line.alone && NOW - ran.yes > self.lease) {
            Some("S2: on without a yes within the lease")
        } else if NOW - since > self.shown && shows(Motors::Off) {
            Some("S2: shown as off although on")
        } else if NOW - since > self.shown && alone && shows(Motors::Leased) {
            Some("S2: shown as leased although alone")
        } else if !state.held && state.holder.motors != Motors::Off {
            Some("on although the switch is not held")
        } else if self.live_every > 0 && live() {
            Some("S5: on a good network a person cannot stop, start, run and stop")
        } else {
            None
        }
    }

    /// What there must be among all states: a run, one that is alone, and a stop that is confirmed.
    pub(super) fn kinds(&self, state: &State) -> [bool; 3] {
        let alone = state.holder.motors == Motors::Alone;
        [
            state.driven && !alone,
            state.driven && alone,
            state.operators.iter().any(|operator| operator.giver.is_stopped()),
        ]
    }

    /// Everything under way comes, in order, and each end says something once more.
    fn exchange(&self, state: &mut State, by: usize) {
        let flush = |state: &mut State| {
            while !state.under_way.is_empty() {
                let _ = self.act(state, Action::ReachBoard(0));
                let _ = self.act(state, Action::CarryOut);
            }
            while !state.operators[by].came.is_empty() {
                let _ = self.act(state, Action::ReachOperator(by, 0));
            }
        };
        flush(state);
        let _ = self.act(state, Action::Say);
        flush(state);
        let _ = self.act(state, Action::Asked(by));
        let line = state.operators[by].line.is_some();
        let _ = self.act(state, Action::Send { by, line });
        flush(state);
        let _ = self.act(state, Action::Say);
        flush(state);
        let _ = self.act(state, Action::Tick { board: true, operators: true });
    }

    /// From here on nobody disturbs: whether a person at operator `by` can stop what runs, start, keep it running and stop it.
    fn lets_use(&self, state: &State, by: usize) -> bool {
        let mut state = state.clone();
        state.held = true;
        if state.session != Some(by) || !state.operators[by].met {
            let _ = self.act(&mut state, Action::Connect(by));
        }
        let off = |state: &State| state.operators[by].giver.shown(NOW) == Some(Motors::Off);
        let exchanges = |state: &mut State, count| (0..count).for_each(|_| self.exchange(state, by));
        exchanges(&mut state, 4);
        if !off(&state) || state.operators[by].giver.want() == Want::Run {
            let _ = self.act(&mut state, Action::Stop(by));
            exchanges(&mut state, 4);
        }
        if !off(&state) || self.act(&mut state, Action::Start { by, alone: false }).is_none() {
            return false;
        }
        exchanges(&mut state, 2);
        for _ in 0..2 * self.lease {
            if !state.driven {
                return false;
            }
            self.exchange(&mut state, by);
        }
        let _ = self.act(&mut state, Action::Stop(by));
        exchanges(&mut state, 2);
        state.operators[by].giver.is_stopped() && !state.driven
    }
}

/// A faster hash than SipHash. Both gave the same counts of states.
#[derive(Default)]
pub(super) struct Mixed(u64);

impl Hasher for Mixed {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for part in bytes.chunks(8) {
            let number = part.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
            self.write_u64(number);
        }
    }
    fn write_u64(&mut self, number: u64) {
        let wide = u128::from(self.0.rotate_left(23) ^ number ^ 0x243f_6a88_85a3_08d3) * 0x9e37_79b9_7f4a_7c15_u128;
        self.0 = wide as u64 ^ (wide >> 64) as u64;
    }
}

impl State {
    /// A fingerprint, which two operators share whichever of them is the first.
    pub(super) fn mark(&self) -> u64 {
        let hash = |state: &Self| {
            let mut hasher = Mixed::default();
            state.hash(&mut hasher);
            hasher.finish()
        };
        if self.operators.len() == 2 { hash(self).min(hash(&self.swapped())) } else { hash(self) }
    }

    /// The same with its two operators in each other's place.
    fn swapped(&self) -> Self {
        let mut state = self.clone();
        state.operators.reverse();
        for by in [&mut state.session, &mut state.peer].into_iter().flatten() {
            *by = 1 - *by;
        }
        state.ran.iter_mut().for_each(|ran| ran.by = 1 - ran.by);
        state.lines(|line| line.stops = line.stops >> 1 & 1 | line.stops << 1 & 2);
        state
    }

    fn lines(&mut self, mut each: impl FnMut(&mut Line)) {
        self.under_way.iter_mut().filter_map(|came| came.line.as_mut()).for_each(&mut each);
        self.operators.iter_mut().filter_map(|operator| operator.line.as_mut()).for_each(&mut each);
        self.ran.iter_mut().for_each(|ran| each(&mut ran.line));
    }

    /// This operator's person is told that it has stopped.
    fn says_stopped(&mut self, by: usize) {
        self.lines(|line| line.void |= line.stops >> by & 1 != 0);
    }
}
