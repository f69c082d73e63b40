//! What lies between the control loop, the judge and the windows: where hands are wanted, what is asked for, and the
//! latest samples.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use cohold_sim::scene::Scene;

use super::environment::{Command, Sample, Standing};
use super::kinds::EnvironmentKind;
use super::partner::Model;

/// Samples kept: what a window that asks late can still get.
const KEPT: usize = 2000;
/// Commands that may wait for a tick, and answers for windows.
const MOST: usize = 64;

/// What a pointer said last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pointed {
    /// Where it is, m, along, across and up; none, and it has let go.
    pub(super) at: Option<[f32; 3]>,
    /// The start that its window has seen last.
    pub(super) restarts: u32,
}

/// What an order asks for.
#[derive(Debug)]
pub(super) enum Request {
    /// These settings, of what is shown.
    Scene(Box<Scene>),
    /// Another environment, in this scene.
    Show(EnvironmentKind, Box<Scene>),
}

/// How it goes, in a few bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Status {
    /// Ticks that began more than a period late, and the latest of all, µs.
    pub(super) late: u32,
    pub(super) worst_us: u32,
    pub(super) standing: Standing,
    /// The environment shown.
    pub(super) kind: EnvironmentKind,
}

/// Everything in the mailbox.
#[derive(Debug)]
pub(super) struct Contents {
    /// What each pointer said since the control loop last looked.
    pub(super) pointed: [Option<Pointed>; 2],
    /// The window that holds each hand; `None`: nobody, so that the partner does.
    pub(super) holder: [Option<u64>; 2],
    /// A window of the operator has asked since the control loop last looked.
    pub(super) operator_asked: bool,
    /// Number of windows that were opened so far.
    pub(super) windows: u64,
    commands: VecDeque<Command>,
    wanted: Option<Request>,
    answers: VecDeque<(u64, String)>,
    /// What holds, for every window, and how often that has changed.
    /// And other news; of each, which of all that was announced it was.
    announced: [(String, u64); 2],
    samples: VecDeque<Sample>,
    /// Tick of the first sample that is kept.
    first: u32,
    pub(super) status: Status,
    /// The program is to end.
    pub(super) over: bool,
}

impl Contents {
    fn new(partner: Model) -> Self {
        Self {
            pointed: [None; 2],
            holder: [None; 2],
            operator_asked: false,
            windows: 0,
            commands: VecDeque::from([Command::Partner(partner)]),
            wanted: None,
            answers: VecDeque::new(),
            announced: Default::default(),
            samples: VecDeque::new(),
            first: 0,
            status: Status::default(),
            over: false,
        }
    }

    /// Asks for a command; a stop is never turned away.
    pub(super) fn ask(&mut self, command: Command) {
        if self.commands.len() < MOST {
            self.commands.push_back(command);
        } else if command == Command::Stop {
            self.commands.clear();
            self.commands.push_back(command);
        }
    }

    pub(super) fn next_command(&mut self) -> Option<Command> {
        self.commands.pop_front()
    }

    /// Asks for a scene or an environment from the next tick on, which comes of what was asked for before: that no tick has taken, and none
    /// will.
    pub(super) fn want(&mut self, request: Request) {
        self.wanted = Some(match (self.wanted.take(), request) {
            (Some(Request::Show(kind, _)), Request::Scene(scene)) => Request::Show(kind.in_scene(&scene), scene),
            (_, request) => request,
        });
    }

    /// What was asked for last.
    pub(super) fn take_wanted(&mut self) -> Option<Request> {
        self.wanted.take()
    }

    /// Says something to one window; what nobody fetches is forgotten, of the window first that has most.
    pub(super) fn answer(&mut self, window: u64, text: String) {
        if self.answers.len() == MOST {
            let waiting = |of: u64| self.answers.iter().filter(|(to, _)| *to == of).count();
            let most = (0..MOST).rev().max_by_key(|at| waiting(self.answers[*at].0)).unwrap_or_default();
            self.answers.remove(most);
        }
        self.answers.push_back((window, text));
    }

    /// What is said to this window, oldest first.
    pub(super) fn answer_for(&mut self, window: u64) -> Option<String> {
        let at = self.answers.iter().position(|(to, _)| *to == window)?;
        self.answers.remove(at).map(|(_, text)| text)
    }

    /// Sends what holds to every window.
    pub(super) fn tell(&mut self, text: String) {
        self.announced[0] = (text, self.announced() + 1);
    }

    /// Sends other news to every window.
    pub(super) fn tell_news(&mut self, text: String) {
        self.announced[1] = (text, self.announced() + 1);
    }

    fn announced(&self) -> u64 {
        self.announced[0].1.max(self.announced[1].1)
    }

    /// What holds and the news, as far as they are new to who has come to `edition`.
    pub(super) fn announced_since(&self, edition: &mut u64) -> Vec<String> {
        let before = std::mem::replace(edition, self.announced());
        let new = self.announced.iter().filter(|(_, at)| *at > before);
        new.map(|(text, _)| text.clone()).collect()
    }

    /// Lays down a sample.
    pub(super) fn put(&mut self, sample: Sample) {
        if self.samples.len() == KEPT {
            self.samples.pop_front();
            self.first = self.first.wrapping_add(1);
        }
        self.samples.push_back(sample);
    }

    /// Forgets the samples that are kept: those that follow are of something else.
    pub(super) fn clear(&mut self) {
        self.first = self.first.wrapping_add(self.samples.len() as u32);
        self.samples.clear();
    }

    /// The samples from tick `from` on, and the tick of the first of them. Who names a tick that is not there yet, as one who has
    /// none does, gets all that are kept.
    pub(super) fn since(&self, from: u32) -> (u32, impl Iterator<Item = &Sample>) {
        let skip = from.wrapping_sub(self.first) as usize;
        let skip = if skip <= self.samples.len() { skip } else { 0 };
        (self.first.wrapping_add(skip as u32), self.samples.iter().skip(skip))
    }
}

/// The state that control loop, judge and windows share.
#[derive(Debug)]
pub(super) struct Mailbox(Mutex<Contents>);

impl Mailbox {
    pub(super) fn new(partner: Model) -> Self {
        Self(Mutex::new(Contents::new(partner)))
    }

    /// For whoever may wait: a window's thread, the judge's.
    pub(super) fn lock(&self) -> MutexGuard<'_, Contents> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For the control loop, which may not.
    pub(super) fn try_lock(&self) -> Option<MutexGuard<'_, Contents>> {
        match self.0.try_lock() {
            Ok(contents) => Some(contents),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

#[cfg(test)]
#[path = "../tests/inside/mailbox.rs"]
mod tests;
