//! Every way that a piece of program may go, and one way by chance.
//!
//! A path that begins as the one before it did is **told again** what that was told, up to the question that it answers otherwise, and the
//! graph goes back to where it stood there: only what comes after is computed.

use super::{From, Graph, Place, on};
use crate::range::Range;

/// Paths of one tick that are tried.
pub(crate) const MOST_PATHS: usize = 1_000_000;

/// Who answers what ranges leave open.
pub(super) enum Answers {
    /// Yes, and once gone back to the last that was answered so: no. Where those that are still to be answered no were asked.
    Both { yes: Vec<Mark>, now_no: bool },
    /// As written, then by chance.
    Chance { state: u64, script: Vec<bool>, asked: usize },
}

impl Answers {
    pub(super) const BOTH: Self = Self::Both { yes: Vec::new(), now_no: false };
}

/// Where a computation stood: how much was told, computed and narrowed.
#[derive(Clone, Copy, Default)]
pub(super) struct Mark {
    told: usize,
    nodes: usize,
    narrowed: usize,
}

/// What a piece of program was told about its numbers.
#[derive(Clone, Copy)]
pub(super) enum Told {
    Place(Place),
    Range(Range),
    Answer(bool),
}

pub(super) trait Tell: Copy {
    fn tell(self) -> Told;
    fn again(told: Told) -> Option<Self>;
}

macro_rules! tells {
    ($($of:ty => $Kind:ident),+) => { $(
        impl Tell for $of {
            fn tell(self) -> Told {
                Told::$Kind(self)
            }
            fn again(told: Told) -> Option<Self> {
                if let Told::$Kind(said) = told { Some(said) } else { None }
            }
        }
    )+ };
}
tells!(Place => Place, Range => Range, bool => Answer);

/// What this says, or what it said when the path before came by here.
pub(super) fn told<T: Tell>(act: impl FnOnce(&mut Graph) -> T) -> T {
    on(|graph| {
        let before = graph.told.get(graph.again).map(|told| T::again(*told));
        let said = match before {
            // What runs is the same program: it asks the same until it is answered otherwise.
            Some(said) => said.expect("a piece of program that is explored asks the same each time"),
            None => {
                let said = act(graph);
                graph.told.push(said.tell());
                said
            }
        };
        graph.again += 1;
        said
    })
}

impl Graph {
    /// One of two answers that may both be.
    pub(super) fn decide(&mut self, yes: bool, no: bool) -> bool {
        if !(yes && no) {
            return yes;
        }
        let here = self.mark();
        match &mut self.answers {
            Answers::Both { .. } if self.impossible => true,
            Answers::Both { yes, now_no } => {
                if !std::mem::take(now_no) {
                    yes.push(here);
                    return true;
                }
                false
            }
            Answers::Chance { state, script, asked } => {
                if *asked == script.len() {
                    // Marsaglia's xorshift.
                    *state ^= *state << 13;
                    *state ^= *state >> 7;
                    *state ^= *state << 17;
                    script.push(*state & 1 == 1);
                }
                *asked += 1;
                script[*asked - 1]
            }
        }
    }

    fn mark(&self) -> Mark {
        Mark { told: self.told.len(), nodes: self.nodes.len(), narrowed: self.trail.len() }
    }

    /// What is explored begins here: what was computed before is not found again, and nothing is told.
    fn set_out(&mut self, answers: Answers) -> Mark {
        self.trail.clear();
        self.computed.clear();
        self.told.clear();
        self.answers = answers;
        self.mark()
    }

    /// Everything since the mark is forgotten, and the next run is told again what came before it.
    fn back_to(&mut self, mark: Mark) {
        while self.trail.len() > mark.narrowed {
            let Some((place, range, away)) = self.trail.pop() else { break };
            let node = &mut self.nodes[place as usize];
            (node.range, node.away) = (range, away);
        }
        for node in self.nodes.drain(mark.nodes..) {
            match node.from {
                From::Constant(bits) => _ = self.constants.remove(&bits),
                From::Computed(key) => _ = self.computed.remove(&key),
                From::Unknown => {}
            }
        }
        self.told.truncate(mark.told);
        (self.again, self.impossible, self.escaped, self.codes) = (0, false, false, Range::EMPTY);
    }
}

/// What a way to go through a piece of program came to.
pub struct Path<T> {
    /// Its result on this path.
    pub gave: T,
    /// Codes that motors were given on it.
    pub codes: Range,
    /// A number was taken out of its type.
    pub escaped: bool,
}

/// Runs a piece of program in every way that it may go, and hands over what came of each. False: there are more than 1,000,000 of them.
/// What runs must be a function of its answers: where they are the same it asks the same.
pub fn explore<T>(run: impl Fn() -> T, mut each: impl FnMut(Path<T>)) -> bool {
    let start = on(|graph| graph.set_out(Answers::BOTH));
    let mut from = start;
    for _ in 0..MOST_PATHS {
        on(|graph| graph.back_to(from));
        let gave = run();
        let (codes, escaped, impossible) = on(|graph| (graph.codes, graph.escaped, graph.impossible));
        if !impossible {
            each(Path { gave, codes, escaped });
        }
        // The last question that was answered yes is answered no.
        let last = on(|graph| match &mut graph.answers {
            Answers::Both { yes, now_no } => {
                let last = yes.pop();
                *now_no = last.is_some();
                last
            }
            Answers::Chance { .. } => None,
        });
        match last {
            Some(last) => from = last,
            None => {
                on(|graph| graph.back_to(start));
                return true;
            }
        }
    }
    false
}

/// Runs a piece of program in one way, by chance, until `good` is what came of it; the last answer is the first that is changed. None
/// after so many tries.
pub(crate) fn one_way<T>(seed: u64, tries: usize, run: impl Fn() -> T, good: impl Fn(&T) -> bool) -> Option<T> {
    let start = on(|graph| graph.set_out(Answers::Chance { state: seed | 1, script: Vec::new(), asked: 0 }));
    for _ in 0..tries {
        on(|graph| {
            graph.back_to(start);
            if let Answers::Chance { asked, .. } = &mut graph.answers {
                *asked = 0;
            }
        });
        let gave = run();
        if !on(|graph| graph.impossible) && good(&gave) {
            return Some(gave);
        }
        on(|graph| {
            if let Answers::Chance { script, asked, .. } = &mut graph.answers {
                script.truncate(*asked);
                let last = script.pop();
                script.extend(last.map(|answer| !answer));
            }
        });
    }
    None
}
