use super::*;

const SILENCE: Duration = Duration::from_micros(SILENCE_US);

/// What somebody on the path does to a board, and what its motors do.
#[derive(Clone, Default)]
struct Path {
    /// Drops samples alone; drops everything.
    no_rows: Arc<AtomicBool>,
    cut: Arc<AtomicBool>,
    driven: Arc<AtomicBool>,
}

/// A board that answers as the test sets it, and writes down what it hears.
struct Written {
    said: Arc<Mutex<Vec<String>>>,
    ticks: u32,
    near: Near,
    path: Path,
}

impl Written {
    fn exchange(&mut self) {
        if self.path.cut.load(Ordering::Relaxed) {
            let now_us = self.near.clock.elapsed().as_micros() as u64;
            let _ = self.near.holder.step(now_us, AtBoard::Look);
        } else if self.near.exchange(self.path.driven.load(Ordering::Relaxed)) {
            self.path.driven.store(false, Ordering::Relaxed);
            self.near.exchange(false);
        }
        self.path.driven.store(self.near.holder.motors() != Motors::Off, Ordering::Relaxed);
    }
}

impl BoardLink for Written {
    fn ask(&mut self, line: &str, run: Option<Word>) -> Result<String, Failure> {
        self.said.lock().expect("a list").push(line.to_owned());
        self.exchange();
        if self.path.cut.load(Ordering::Relaxed) {
            return Err("no answer".into());
        }
        if let Some(Err(no)) = run.map(|run| self.near.start(run)) {
            return Ok(format!("error {}", no.explain()));
        }
        // A check is over at once.
        self.path.driven.store(line == "arm" || self.path.driven.load(Ordering::Relaxed), Ordering::Relaxed);
        if run.is_some() && line != "arm" {
            let _ = self.near.holder.step(0, AtBoard::Off);
        }
        Ok(format!("ok {line}"))
    }

    fn stop(&mut self) -> Result<(), Failure> {
        self.said.lock().expect("a list").push("stop".to_owned());
        self.exchange();
        self.near.stopped()
    }

    fn rows(&mut self, _: f64) -> Result<Vec<[f64; NUMBERS]>, Failure> {
        std::thread::sleep(Duration::from_millis(5));
        self.exchange();
        self.ticks += 4;
        if self.path.no_rows.load(Ordering::Relaxed) {
            return Ok(Vec::new());
        }
        let mut row = [0.0; NUMBERS];
        (row[TICK], row[MODE], row[DEVICE]) =
            (self.ticks.into(), f64::from(u8::from(self.path.driven.load(Ordering::Relaxed))), f64::from(self.ticks));
        Ok(vec![row])
    }
}

/// A board whose motors are off, or were armed alone before anybody came.
fn boards(alone: bool) -> (Boards, Arc<Mutex<Vec<String>>>, Path) {
    let (reins, clock) = (Reins::default(), Instant::now());
    let mut link =
        Written { said: Arc::default(), ticks: 0, near: Near::new(reins.clone(), clock), path: Path::default() };
    if alone {
        let word = Word::of_byte(7 << 2 | 2);
        let before =
            [AtBoard::Heard { word, echo_us: Some(0) }, AtBoard::Start { word, alone: true }, AtBoard::Session];
        before.into_iter().for_each(|event| link.near.holder.step(0, event).expect("a fresh yes"));
        link.path.driven.store(true, Ordering::Relaxed);
    }
    let (said, path) = (Arc::clone(&link.said), link.path.clone());
    let open = Box::new(move || Ok(Box::new(link) as Box<dyn BoardLink>));
    let seat = Seat::attend("written".to_owned(), 0, (reins, clock), open).expect("a thread");
    (Boards::of_seats(vec![seat]), said, path)
}

/// The answers to this line that are shown.
fn answers(boards: &Boards, line: &str) -> Vec<String> {
    let said = boards.reported[0].said.iter().filter(|(said, _)| said == line);
    said.map(|(_, answer)| answer.clone()).collect()
}

/// Steps and, as a page does, asks; until it is done, and no longer than half a minute.
#[track_caller]
fn until(boards: &mut Boards, page: bool, mut done: impl FnMut(&Boards, &Sample) -> bool) {
    let start = Instant::now();
    loop {
        if page {
            boards.attend();
        }
        let sample = boards.step().expect("a tick");
        if done(boards, &sample) {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{sample:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What its ticks saw is played out in order; the motors stay on while a page asks, go off by a stop, which comes before what waits, and
/// a second after the last page.
#[test]
fn motors_are_on_only_while_a_person_looks() {
    let (mut boards, said, _) = boards(false);
    let mut last = 0.0;
    until(&mut boards, true, |_, sample| {
        assert!(sample[2].is_nan() || sample[2] >= last, "{last} {sample:?}");
        last = if sample[2].is_nan() { last } else { sample[2] };
        last > 400.0
    });
    boards.command(Command::Board(1, Line::Arm)).expect("it is said");
    boards.command(Command::Board(2, Line::Check(1))).expect("nobody is there");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == ARMED);
    let begin = Instant::now();
    until(&mut boards, true, |boards, _| {
        assert_eq!(boards.standing().modes[0], ARMED);
        begin.elapsed() > 2 * SILENCE
    });
    // What starts motors is refused while they are on, and what waits is forgotten by a stop.
    boards.command(Command::Board(1, Line::Check(1))).expect("it is refused");
    until(&mut boards, true, |boards, _| answers(boards, "check 1") == ["error its motors are on: stop them first"]);
    for _ in 0..ANSWERS {
        boards.command(Command::Board(1, Line::Clear)).expect("it is said");
    }
    boards.command(Command::Stop).expect("it stops");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == OFF);
    let lines = || said.lock().expect("a list").iter().filter(|line| *line != "status").cloned().collect::<Vec<_>>();
    // A busy machine may have carried some out before the stop was said; what waited behind it is forgotten.
    let until_stop = lines();
    let cleared = until_stop.iter().filter(|line| *line == "clear").count();
    let told: Vec<_> = until_stop.iter().filter(|line| *line != "clear").collect();
    assert!(
        told == ["arm", "stop"] && cleared < ANSWERS && until_stop.last() == told.last().copied(),
        "{until_stop:?}"
    );
    until(&mut boards, true, |boards, _| answers(boards, "stop") == [STOPPED]);

    boards.command(Command::Board(1, Line::Arm)).expect("it is said");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == ARMED);
    let left = Instant::now();
    until(&mut boards, false, |boards, _| boards.standing().modes[0] == OFF);
    assert!(left.elapsed() >= SILENCE - Duration::from_millis(50));
    drop(boards);
    assert_eq!(lines()[until_stop.len()..], ["arm", "stream off"]);
}

/// Why: a path that dropped samples alone kept motors on after the page was closed, and the headline said that they were off.
#[test]
fn a_path_that_drops_samples_alone_keeps_nothing_running_and_shows_nothing_as_off() {
    let (mut boards, _, path) = boards(false);
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == OFF);
    path.no_rows.store(true, Ordering::Relaxed);
    boards.command(Command::Board(1, Line::Arm)).expect("it is said");
    let is_on = || path.driven.load(Ordering::Relaxed);
    until(&mut boards, true, |_, _| is_on());
    let on = Instant::now();
    until(&mut boards, true, |boards, _| {
        // What is shown is no older than a look at the board.
        assert!(boards.standing().modes[0] == ARMED || on.elapsed() < Duration::from_millis(100));
        on.elapsed() > 2 * SILENCE
    });
    let left = Instant::now();
    until(&mut boards, false, |_, _| !is_on());
    assert!(left.elapsed() < SILENCE + Duration::from_micros(LEASE_US) + Duration::from_millis(300));
    until(&mut boards, false, |boards, _| boards.standing().modes[0] == OFF);
}

/// Why: Stop said "stopped" while a board that was armed alone went on.
#[test]
fn a_board_that_is_armed_alone_is_shown_as_such_and_stopped() {
    let (mut boards, _, path) = boards(true);
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == ALONE);
    // A page that is closed ends only what it has let run.
    let left = Instant::now();
    until(&mut boards, false, |boards, _| {
        assert_eq!(boards.standing().modes[0], ALONE);
        left.elapsed() > 2 * SILENCE
    });
    boards.command(Command::Stop).expect("it stops");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == OFF);
    until(&mut boards, true, |boards, _| answers(boards, "stop") == [STOPPED]);
    assert!(!path.driven.load(Ordering::Relaxed));
}

/// What a page is told of whether the board is there, and of its status.
fn told(boards: &mut Boards) -> (bool, String) {
    boards.news = true;
    let news: serde_json::Value = serde_json::from_str(&boards.news().expect("news")).expect("JSON");
    let told = &news["boards"][0]["told"];
    (told["there"] == true, told["status"].as_str().expect("words").to_owned())
}

/// Nothing is said to be off without the board's word; a stop goes on being said until it has come. Why: a status from before the stop was
/// shown after it.
#[test]
fn a_stop_that_nobody_confirms_is_no_stop() {
    let (mut boards, _, path) = boards(true);
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == ALONE);
    until(&mut boards, true, |boards, _| boards.reported[0].there);
    assert_eq!(told(&mut boards), (true, "ok status".into()));
    path.cut.store(true, Ordering::Relaxed);
    boards.command(Command::Stop).expect("it is said");
    until(&mut boards, true, |boards, _| answers(boards, "stop") == [UNCONFIRMED]);
    assert!(matches!(told(&mut boards), (false, status) if status != "ok status"));
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == WAITS);
    boards.command(Command::Board(1, Line::Arm)).expect("it is refused");
    until(&mut boards, true, |boards, _| answers(boards, "arm") == ["error the board has not confirmed the stop"]);
    assert!(path.driven.load(Ordering::Relaxed));
    // Its last status is not shown, also while its answer is waited for.
    boards.reported[0].there = true;
    assert_eq!(told(&mut boards), (false, SILENT.into()));
    path.cut.store(false, Ordering::Relaxed);
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == OFF);
    assert!(!path.driven.load(Ordering::Relaxed));
}

/// Ticks that never come to their turn, and more answers than are shown.
#[test]
fn what_a_board_says_takes_bounded_memory() {
    let (mut boards, ..) = boards(false);
    let seat = &mut boards.seats[0];
    let row = |tick: f64| {
        let mut row = [0.0; NUMBERS];
        row[TICK] = tick;
        row
    };
    for at in 0..100_000 {
        wait_for(&mut seat.rows, [row(if at % 2 == 0 { 1000.0 } else { 1340.0 })]);
        seat.play();
    }
    assert!(seat.rows.len() <= ROWS, "{} rows wait", seat.rows.len());
    let mut status = BoardStatus::default();
    (0..10 * ANSWERS).for_each(|at| status.say("status", at.to_string()));
    let said: Vec<_> = status.said.into_iter().map(|(_, answer)| answer).collect();
    assert_eq!(said, (9 * ANSWERS..10 * ANSWERS).map(|at| at.to_string()).collect::<Vec<_>>());
}

#[test]
fn a_page_says_few_lines() {
    for text in ["arm", "clear", "check 1", "check 2"] {
        assert_eq!(Line::from_text(text).map(Line::text).as_deref(), Some(text));
    }
    for text in ["disarm now", "arm alone", "set safety.max_force_n 40", "probe 1 pulse 1 1", "check 3", ""] {
        assert_eq!(Line::from_text(text), None, "{text}");
    }
}

/// The simulated board practises what a real one does: its ticks come in real time, it is armed and stopped.
#[test]
fn a_simulated_board_is_there_at_once() {
    let mut boards = Boards::open(vec![Place::Simulated; 2]).expect("two boards");
    until(&mut boards, true, |boards, sample| {
        boards.standing().modes == [OFF; 2] && sample[2] == 0.0 && sample[3] == 0.0
    });
    // A board that was not checked is not armed.
    boards.command(Command::Board(2, Line::Check(1))).expect("it is said");
    until(&mut boards, true, |boards, _| boards.reported[1].said.iter().any(|(_, answer)| answer.contains("agree")));
    until(&mut boards, true, |boards, _| boards.standing().modes == [OFF; 2]);
    boards.command(Command::Board(2, Line::Arm)).expect("it is said");
    until(&mut boards, true, |boards, _| boards.standing().modes == [OFF, ARMED]);
    boards.command(Command::Stop).expect("it stops");
    until(&mut boards, true, |boards, _| boards.standing().modes == [OFF; 2]);
    boards.news = true;
    let news = boards.news().expect("news");
    assert!(news.contains("simulated board 1") && news.contains("\"number\":2"), "{news}");
}
