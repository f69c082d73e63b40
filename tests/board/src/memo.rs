//! Boards that are booted once and forked: what a board was told since power-on, what it answered, and where others go on from.
//!
//! A board that is told what another was, order by order and byte by byte, is answered from what that one answered, and nothing is emulated. Whoever
//! tells first takes the process along, others follow; who then tells something else gets a copy of the last process that was parked on the way,
//! which is told the rest again and must answer the same.

use std::sync::{Arc, Mutex, MutexGuard, Weak};

use crate::process::Process;

/// Processes that are parked at a time: they have some 25 MB each.
const MOST: usize = 32;

/// An order, after all before it.
#[derive(Debug)]
struct Step {
    before: Option<Arc<Step>>,
    order: Vec<u8>,
    now: Mutex<Now>,
}

#[derive(Default, Debug)]
struct Now {
    answer: Option<Vec<u8>>,
    /// A process that was told all up to here and no more. One that is parked stays, and a copy of it goes on.
    process: Option<Process>,
    parked: bool,
    after: Vec<Weak<Step>>,
}

/// Steps at which processes are parked, that which was used last behind.
static PARKED: Mutex<Vec<Arc<Step>>> = Mutex::new(Vec::new());

/// A board that is told and answers.
#[derive(Debug)]
pub(crate) struct Board {
    at: Arc<Step>,
    /// How many of its orders others were told before.
    others: usize,
}

/// All orders with their answers, the last first; and how many of the first others were told before.
pub(crate) type Told = (Vec<(Vec<u8>, Option<Vec<u8>>)>, usize);

fn gone<T>(result: Result<T, std::io::Error>) -> T {
    result.unwrap_or_else(|error| panic!("a board's process ended, or there is no memory or number for one: {error}"))
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("no other test failed with this board")
}

impl Step {
    /// The beginning, where nothing was told yet.
    fn first(process: Process) -> Arc<Self> {
        let now = Now { process: Some(process), parked: true, ..Now::default() };
        Arc::new(Self { before: None, order: Vec::new(), now: now.into() })
    }

    /// A process that was told all up to here.
    fn process(self: &Arc<Self>) -> Process {
        let (mut from, mut told) = (self, Vec::new());
        let mut process = loop {
            let mut now = lock(&from.now);
            match &now.process {
                Some(parked) if now.parked => break gone(parked.copy()),
                Some(_) if told.is_empty() => return now.process.take().expect("it is here"),
                _ => told.push(from),
            }
            from = from.before.as_ref().expect("at the beginning is a process");
        };
        lock(&PARKED).sort_by_key(|step| Arc::ptr_eq(step, from));
        for step in told.into_iter().rev() {
            gone(process.tell(&step.order));
            let again = Some(gone(process.hear()));
            assert!(lock(&step.now).answer == again, "a board that is told the same does not answer the same");
        }
        process
    }
}

impl Drop for Step {
    fn drop(&mut self) {
        // One by one: there are more than fit on a stack.
        let mut before = self.before.take();
        while let Some(step) = before {
            before = Arc::into_inner(step).and_then(|mut step| step.before.take());
        }
    }
}

impl Board {
    /// A board that was told nothing yet, in a process that does this; or one whose orders no others were told, `alone`.
    pub(crate) fn new(answers: fn() -> !, alone: bool) -> Self {
        static FIRST: Mutex<Option<Arc<Step>>> = Mutex::new(None);
        let mut first = lock(&FIRST);
        let first = first.get_or_insert_with(|| Step::first(gone(Process::start(answers))));
        Self { at: if alone { Step::first(first.process()) } else { first.clone() }, others: 0 }
    }

    /// Tells it what [`Board::hear`] answers.
    pub(crate) fn tell(&mut self, order: Vec<u8>) {
        let mut now = lock(&self.at.now);
        let like = now.after.iter().filter_map(Weak::upgrade).find(|step| step.order == order);
        if let Some(step) = like {
            drop(now);
            (self.at, self.others) = (step, self.others + 1);
            return;
        }
        let step = Arc::new(Step { before: Some(self.at.clone()), order, now: Mutex::default() });
        // Who comes here meanwhile waits.
        let mut next = lock(&step.now);
        now.after.push(Arc::downgrade(&step));
        drop(now);
        let mut process = self.at.process();
        gone(process.tell(&step.order));
        next.process = Some(process);
        drop(next);
        self.at = step;
    }

    /// What it answers.
    pub(crate) fn hear(&mut self) -> Vec<u8> {
        let now = &mut *lock(&self.at.now);
        let process = &mut now.process;
        let hear = || gone(process.as_mut().expect("it goes no further before it has answered").hear());
        now.answer.get_or_insert_with(hear).clone()
    }

    /// See [`Told`].
    pub(crate) fn told(&self) -> Told {
        let steps = std::iter::successors(Some(&self.at), |step| step.before.as_ref());
        (steps.map(|step| (step.order.clone(), lock(&step.now).answer.clone())).collect(), self.others)
    }

    /// Its process is parked here, if it is here: others go on from here.
    pub(crate) fn checkpoint(&self) {
        let mut now = lock(&self.at.now);
        if now.process.is_none() || std::mem::replace(&mut now.parked, true) {
            return;
        }
        drop(now);
        let mut all = lock(&PARKED);
        all.push(self.at.clone());
        if all.len() > MOST {
            let oldest = all.remove(0);
            let mut now = lock(&oldest.now);
            (now.process, now.parked) = (None, false);
        }
    }
}
