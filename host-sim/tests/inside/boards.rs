use super::*;

/// A board that answers as the test sets it, and writes down what it hears.
#[derive(Default)]
struct Written {
    said: Arc<Mutex<Vec<String>>>,
    ticks: u32,
    armed: bool,
}

impl BoardLink for Written {
    fn ask(&mut self, line: &str, _: Moment) -> Result<String, Error> {
        self.said.lock().expect("a list").push(line.to_owned());
        self.armed |= line == "arm";
        Ok(format!("ok {line}"))
    }

    fn stop(&mut self) -> Result<Stopped, Error> {
        self.said.lock().expect("a list").push("stop".to_owned());
        self.armed = false;
        Ok(Stopped::LeaseOver)
    }

    fn rows(&mut self, _: f64) -> Result<Vec<[f64; NUMBERS]>, Error> {
        std::thread::sleep(Duration::from_millis(5));
        self.ticks += 4;
        let mut row = [0.0; NUMBERS];
        (row[TICK], row[MODE], row[DEVICE]) =
            (self.ticks.into(), f64::from(u8::from(self.armed)), f64::from(self.ticks));
        Ok(vec![row])
    }
}

fn boards() -> (Boards, Arc<Mutex<Vec<String>>>) {
    let link = Written::default();
    let said = Arc::clone(&link.said);
    let seat = Seat::attend(
        "written".to_owned(),
        0,
        Consent::default(),
        Box::new(move || Ok(Box::new(link) as Box<dyn BoardLink>)),
    )
    .expect("a thread");
    (Boards::of_seats(vec![seat]), said)
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
    let (mut boards, said) = boards();
    assert_eq!(boards.standing().modes, [WAITS, OFF]);
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
    for _ in 0..ANSWERS {
        boards.command(Command::Board(1, Line::Check(1))).expect("it is said");
    }
    boards.command(Command::Stop).expect("it stops");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == OFF);
    let lines = || said.lock().expect("a list").iter().filter(|line| *line != "status").cloned().collect::<Vec<_>>();
    // A busy machine may have carried some out before the stop was said; what waited behind it is forgotten.
    let until_stop = lines();
    let checks = until_stop.iter().filter(|line| *line == "check 1").count();
    let told: Vec<_> = until_stop.iter().filter(|line| *line != "check 1").collect();
    assert!(told == ["arm", "stop"] && checks < ANSWERS && until_stop.last() == told.last().copied(), "{until_stop:?}");

    boards.command(Command::Board(1, Line::Arm)).expect("it is said");
    until(&mut boards, true, |boards, _| boards.standing().modes[0] == ARMED);
    let left = Instant::now();
    until(&mut boards, false, |boards, _| boards.standing().modes[0] == OFF);
    assert!(left.elapsed() >= SILENCE);
    drop(boards);
    assert_eq!(lines()[until_stop.len()..], ["arm", "stop", "stop", "stream off"]);
}

/// Ticks that never come to their turn, and more answers than are shown.
#[test]
fn what_a_board_says_takes_bounded_memory() {
    let (mut boards, _) = boards();
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
    boards.command(Command::Board(2, Line::Arm)).expect("it is said");
    until(&mut boards, true, |boards, _| boards.standing().modes == [OFF, ARMED]);
    boards.command(Command::Stop).expect("it stops");
    until(&mut boards, true, |boards, _| boards.standing().modes == [OFF; 2]);
    boards.news = true;
    let news = boards.news().expect("news");
    assert!(news.contains("simulated board 1") && news.contains("\"number\":2"), "{news}");
}
