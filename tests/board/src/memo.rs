//! Boards that are booted once and forked: what a board was told since power-on, what it answered, and where others go on from.
//!
//! A board that is told what another was, order by order and byte by byte, is answered from what that one answered, and nothing is emulated. At its
//! first other order it gets a process: a copy of the last one that was parked on the way, which is told the rest again and must answer the same.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, Weak};
use std::thread::{ThreadId, current};
use std::time::Duration;

use crate::process::Process;

/// How long a board waits for what another, which is where it is, is told next, before it goes on in a process of its own.
const PATIENCE: Duration = Duration::from_millis(100);

/// Processes that stay: they have some 25 MB each.
const MOST: usize = 24;

/// Orders with their answers, and how many answers of the first of them were another board's.
pub(crate) type Told = (Vec<(Vec<u8>, Option<Vec<u8>>)>, usize);

/// An order, after all before it.
#[derive(Debug)]
struct Step {
    before: Option<Arc<Step>>,
    order: Vec<u8>,
    now: Mutex<Now>,
    changed: Condvar,
}

#[derive(Default, Debug)]
struct Now {
    answer: Option<Vec<u8>>,
    /// Of this thread a board is to bring the answer.
    awaited: Option<ThreadId>,
    /// Boards in processes that have answered and were told no more yet.
    here: usize,
    /// A process that stays here for others.
    parked: Option<Process>,
    after: Vec<Weak<Step>>,
}

/// Steps at which processes stay, that which was used last behind.
static PARKED: Mutex<Vec<Arc<Step>>> = Mutex::new(Vec::new());

/// A board that is told and answers.
#[derive(Debug)]
pub(crate) struct Board {
    at: Arc<Step>,
    /// It brings the answers itself; before, so many were another's.
    live: bool,
    others: usize,
    process: Option<Process>,
    /// Nobody is like it.
    alone: bool,
}

fn gone<T>(result: Result<T, std::io::Error>) -> T {
    result.unwrap_or_else(|error| {
        panic!("a board's process ended, or could not be made (memory; processes that a user may have): {error}")
    })
}

impl Step {
    fn new(before: Option<Arc<Self>>, order: Vec<u8>, now: Now) -> Arc<Self> {
        Arc::new(Self { before, order, now: now.into(), changed: Condvar::new() })
    }

    /// The beginning, where nothing was told yet.
    fn first(process: Process) -> Arc<Self> {
        Self::new(None, Vec::new(), Now { parked: Some(process), ..Now::default() })
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().expect("nobody panics with it")
    }

    /// This order after that step, and whether it is for the one that asks to bring its answer.
    fn next(self: &Arc<Self>, order: Vec<u8>, live: bool) -> (Arc<Self>, bool) {
        let mut now = self.now();
        if !live {
            loop {
                let like = now.after.iter().filter_map(Weak::upgrade).find(|step| step.order == order && step.comes());
                if let Some(step) = like {
                    return (step, false);
                }
                if now.parked.is_some() || now.here == 0 {
                    break;
                }
                let (then, waited) = self.changed.wait_timeout(now, PATIENCE).expect("nobody panics with it");
                now = then;
                if waited.timed_out() {
                    break;
                }
            }
        }
        let step = Self::new(Some(self.clone()), order, Now { awaited: Some(current().id()), ..Now::default() });
        now.after.push(Arc::downgrade(&step));
        (step, true)
    }

    /// There is an answer, or it can be waited for.
    fn comes(&self) -> bool {
        let now = self.now();
        now.answer.is_some() || now.awaited.is_some_and(|thread| thread != current().id())
    }

    fn change(&self, change: impl FnOnce(&mut Now)) {
        change(&mut self.now());
        self.changed.notify_all();
    }

    /// A process that was told all up to here.
    fn process(self: &Arc<Self>) -> Process {
        let (mut from, mut told) = (self, Vec::new());
        let mut process = loop {
            if let Some(parked) = &from.now().parked {
                break gone(parked.copy());
            }
            told.push(from);
            from = from.before.as_ref().expect("at the beginning is a process");
        };
        PARKED.lock().expect("nobody panics with it").sort_by_key(|step| Arc::ptr_eq(step, from));
        for step in told.into_iter().rev() {
            gone(process.tell(&step.order));
            let again = gone(process.hear());
            let same = step.now().answer.as_ref() == Some(&again);
            assert!(same, "a board that is told the same does not answer the same");
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
    /// A board of which nothing is known, in a process that does this; or one that is like no other, `alone`.
    pub(crate) fn new(answers: fn() -> !, alone: bool) -> Self {
        static FIRST: Mutex<Option<Arc<Step>>> = Mutex::new(None);
        let mut first = FIRST.lock().expect("nobody panics with it");
        let first = first.get_or_insert_with(|| Step::first(gone(Process::start(answers))));
        let at = if alone { Step::first(first.process()) } else { first.clone() };
        Self { at, live: false, others: 0, process: None, alone }
    }

    /// Tells it what [`Board::hear`] answers.
    pub(crate) fn tell(&mut self, order: Vec<u8>) {
        let before = self.at.clone();
        let was_live = self.live;
        (self.at, self.live) = before.next(order, was_live);
        if !self.live {
            self.others += 1;
            return;
        }
        if was_live {
            before.change(|now| now.here -= 1);
        }
        let process = self.process.get_or_insert_with(|| before.process());
        gone(process.tell(&self.at.order));
    }

    /// What it answers.
    pub(crate) fn hear(&mut self) -> Vec<u8> {
        if let Some(process) = &mut self.process {
            let answer = gone(process.hear());
            self.at.change(|now| (now.answer, now.here) = (Some(answer.clone()), now.here + 1));
            return answer;
        }
        let now = self.at.changed.wait_while(self.at.now(), |now| now.answer.is_none() && now.awaited.is_some());
        if let Some(answer) = &now.expect("nobody panics with it").answer {
            return answer.clone();
        }
        // Who was to bring it is gone.
        self.others -= 1;
        let order = self.at.order.clone();
        self.at = self.at.before.clone().expect("an order is after another");
        self.tell(order);
        self.hear()
    }

    /// All orders and answers, the last first; and how many answers of the first were another's.
    pub(crate) fn told(&self) -> Told {
        let steps = std::iter::successors(Some(&self.at), |step| step.before.as_ref());
        (steps.map(|step| (step.order.clone(), step.now().answer.clone())).collect(), self.others)
    }

    /// Others go on from here if they are told the same so far.
    pub(crate) fn checkpoint(&self) {
        if let (Some(process), false) = (&self.process, self.alone) {
            let parked = gone(process.copy());
            self.at.change(|now| now.parked = Some(parked));
            let mut all = PARKED.lock().expect("nobody panics with it");
            all.push(self.at.clone());
            if all.len() > MOST {
                all.remove(0).change(|now| now.parked = None);
            }
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        if self.live {
            self.at.change(|now| match now.answer {
                Some(_) => now.here -= 1,
                None => now.awaited = None,
            });
        }
    }
}
