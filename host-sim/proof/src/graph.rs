//! What is known of every number that a tick has computed so far, and which way each question about them was answered.
//!
//! A number is a node of its thread's computation graph: what it was computed from, and the [`Range`] that it lies in.
//! **The same operation on the same numbers is the same node**, so that what is learnt of a difference once holds wherever it is taken again. A comparison
//! that ranges leave open is answered both ways, one after the other ([`explore`]): the tick runs once for every sequence of answers,
//! depth first. An answer **narrows** what it was about, and what that was computed from: of a < b, a is below the largest b. Where a
//! contradiction comes of it, no number goes that way: the path is no path, and nothing more is asked on it.
//!
//! Narrowing only ever takes away what cannot be; where it does nothing the result is wider, never wrong.

use std::cell::RefCell;

use rustc_hash::FxHashMap;

use crate::range::{Float, Op, Range, at_least, below, of_two};

mod course;

use course::{Answers, Told, told};
pub(crate) use course::{MOST_PATHS, one_way};
pub use course::{Path, explore};

/// Index of a node in the computation graph.
pub(crate) type Place = u32;
/// 0 and 1 of every type.
pub(crate) const ZERO: Place = 0;
pub(crate) const ONE: Place = 1;

#[derive(Clone, Copy, Debug)]
struct Node {
    range: Range,
    /// No number in it is nearer to 0.
    away: f64,
    from: From,
}

/// Where a number is from, which is what it is found again by.
#[derive(Clone, Copy, Debug, PartialEq)]
enum From {
    Constant(u64),
    Unknown,
    Computed(Key),
}

/// What was done, to which, and whether in f64.
type Key = (Op, Place, Place, bool);

/// The computation graph of a thread.
struct Graph {
    nodes: Vec<Node>,
    constants: FxHashMap<u64, Place>,
    computed: FxHashMap<Key, Place>,
    /// What narrowing has changed.
    trail: Vec<(Place, Range, f64)>,
    /// What was told on this path, and how much of it this run was told again.
    told: Vec<Told>,
    again: usize,
    answers: Answers,
    impossible: bool,
    /// Whole numbers stand for every whole number.
    any_whole: bool,
    /// A number was taken out of its type, which no range follows.
    escaped: bool,
    /// Codes that motors were given.
    codes: Range,
}

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::new(Graph::new());
}

fn on<T>(act: impl FnOnce(&mut Graph) -> T) -> T {
    GRAPH.with_borrow_mut(act)
}

impl Graph {
    fn new() -> Self {
        let mut graph = Self {
            nodes: Vec::new(),
            constants: FxHashMap::default(),
            computed: FxHashMap::default(),
            trail: Vec::new(),
            told: Vec::new(),
            again: 0,
            answers: Answers::BOTH,
            impossible: false,
            any_whole: false,
            escaped: false,
            codes: Range::EMPTY,
        };
        graph.constant(0.0);
        graph.constant(1.0);
        graph
    }

    fn push(&mut self, range: Range, from: From) -> Place {
        self.nodes.push(Node { range, away: 0.0, from });
        // A graph of 4e9 numbers would be 200 GB.
        (self.nodes.len() - 1) as Place
    }

    fn constant(&mut self, number: f64) -> Place {
        let bits = number.to_bits();
        if let Some(place) = self.constants.get(&bits) {
            return *place;
        }
        let place = self.push(Range::point(number), From::Constant(bits));
        self.constants.insert(bits, place);
        place
    }

    fn range(&self, place: Place) -> Range {
        self.nodes[place as usize].range
    }

    fn is_constant(&self, place: Place) -> bool {
        matches!(self.nodes[place as usize].from, From::Constant(_))
    }

    fn compute<F: Float>(&mut self, op: Op, a: Place, b: Place) -> Place {
        // What is the same number is the same node, but for the sign of a zero, which no range tells.
        match (op, a, b) {
            (Op::Add, same, ZERO) | (Op::Add, ZERO, same) | (Op::Sub, same, ZERO) => return same,
            (Op::Mul, same, ONE) | (Op::Mul, ONE, same) | (Op::Ratio | Op::Over, same, ONE) => return same,
            _ => {}
        }
        let (of_a, of_b) = (self.range(a), self.range(b));
        let mut range = of_two::<F>(op, of_a, of_b);
        if self.is_constant(a) && self.is_constant(b) && range.is_point() {
            return self.constant(if range.nan { f64::NAN } else { range.lo });
        }
        if a == b {
            range = range.and(match op {
                // What is no number, or infinite, less itself is none.
                Op::Sub => Range::point(0.0).with_nan(range.nan),
                Op::Mul => Range { lo: 0.0, ..Range::ANY },
                _ => range,
            });
        }
        if op == Op::Sub {
            range = range.and(self.regained::<F>(a, b));
        }
        let away = if matches!(op, Op::Neg | Op::Abs) { self.nodes[a as usize].away } else { 0.0 };
        if op == Op::Abs {
            range.lo = range.lo.max(away);
        }
        let key = (op, a, b, F::EPSILON == f64::EPSILON);
        if let Some(place) = self.computed.get(&key).copied() {
            self.narrow::<F>(place, range, 0);
            return place;
        }
        let place = self.push(range, From::Computed(key));
        self.nodes[place as usize].away = away;
        self.computed.insert(key, place);
        place
    }

    /// What a − b is if a is the sum or the difference of b and another number, to rounding: nearly that number; or if a is the larger or the
    /// smaller of two, of which each has its own difference.
    fn regained<F: Float>(&self, a: Place, b: Place) -> Range {
        let From::Computed((op, one, two, _)) = self.nodes[a as usize].from else { return Range::ANY };
        if matches!(op, Op::Max | Op::Min) && !(self.range(one).nan || self.range(two).nan || self.range(b).nan) {
            let [one, two] =
                [one, two].map(|of| of_two::<F>(Op::Sub, self.range(of), self.range(b)).and(self.regained::<F>(of, b)));
            let of = if op == Op::Max { f64::max } else { f64::min };
            return Range::of(of(one.lo, two.lo), of(one.hi, two.hi)).with_nan(one.nan || two.nan);
        }
        let other = match op {
            Op::Add if one == b => self.range(two),
            Op::Add if two == b => self.range(one),
            Op::Sub if one == b => self.range(two).negative(),
            _ => return Range::ANY,
        };
        let ranges = [self.range(a), self.range(b), other];
        if !ranges.iter().all(|range| range.is_finite() && range.has_numbers()) {
            return Range::ANY;
        }
        let [_, least] = F::ENDS;
        let rounding = 2.0 * F::EPSILON * ranges.iter().map(|range| range.most()).fold(0.0, f64::max) + least;
        Range::of(F::at_most(other.lo - rounding), at_least::<F>(other.hi + rounding))
    }

    /// Takes away from a number, and from what it was computed from, what is not in this range.
    fn narrow<F: Float>(&mut self, place: Place, to: Range, depth: u32) {
        let Node { range: old, away, from } = self.nodes[place as usize];
        let mut range = old.and(to);
        if range.lo > -away {
            range.lo = range.lo.max(away);
        }
        if range.hi < away {
            range.hi = range.hi.min(-away);
        }
        if !range.has_numbers() {
            range = Range::EMPTY.with_nan(range.nan);
        }
        if range == old || matches!(from, From::Constant(_)) && !range.is_empty() {
            return;
        }
        if range.is_empty() {
            self.impossible = true;
            return;
        }
        self.trail.push((place, old, away));
        self.nodes[place as usize].range = range;
        let From::Computed((op, a, b, _)) = from else { return };
        if depth < 16 {
            self.narrow_operands::<F>(op, [a, b], range, depth + 1);
        }
    }

    fn narrow_operands<F: Float>(&mut self, op: Op, [a, b]: [Place; 2], range: Range, depth: u32) {
        let (of_a, of_b) = (self.range(a), self.range(b));
        match op {
            Op::Add | Op::Sub | Op::Mul if !range.nan => {
                // A finite result has finite operands, and one that is a number has numbers.
                let zero = |range: Range| op == Op::Mul && range == Range::point(0.0);
                let finite = range.is_finite();
                let numbers = Range::ANY.numbers();
                let kind = |other| if finite || zero(other) { Range::finite::<F>() } else { numbers };
                self.narrow::<F>(a, kind(of_b), depth);
                self.narrow::<F>(b, kind(of_a), depth);
                if op == Op::Mul || !(range.has_numbers() && of_a.has_numbers() && of_b.has_numbers()) {
                    return;
                }
                // The sum before rounding lies between the neighbours of what it was rounded to.
                let (least, most) = (below::<F>(range.lo), F::above(range.hi));
                let of_b = if op == Op::Sub { self.range(b).negative() } else { self.range(b) };
                self.narrow::<F>(a, between::<F>(least - of_b.hi, most - of_b.lo), depth);
                let of_a = self.range(a);
                let (lo, hi) = (least - of_a.hi, most - of_a.lo);
                let (lo, hi) = if op == Op::Sub { (-hi, -lo) } else { (lo, hi) };
                self.narrow::<F>(b, between::<F>(lo, hi), depth);
            }
            Op::Neg => self.narrow::<F>(a, range.negative(), depth),
            Op::Abs => {
                let node = self.nodes[a as usize];
                if range.lo > node.away {
                    self.trail.push((a, node.range, node.away));
                    self.nodes[a as usize].away = range.lo;
                }
                self.narrow::<F>(a, Range { lo: -range.hi, ..range }, depth);
            }
            // A counter has other neighbours than what it is of: what is learnt of one is not passed on.
            _ => {}
        }
    }

    fn compare<F: Float>(&mut self, a: Place, b: Place, strict: bool) -> bool {
        let (of_a, of_b) = (self.range(a), self.range(b));
        let numbers = of_a.has_numbers() && of_b.has_numbers();
        let lost = of_a.nan || of_b.nan;
        let (can, can_not) = if a == b {
            (!strict && numbers, strict || lost)
        } else if strict {
            (numbers && of_a.lo < of_b.hi, lost || numbers && of_a.hi >= of_b.lo)
        } else {
            (numbers && of_a.lo <= of_b.hi, lost || numbers && of_a.hi > of_b.lo)
        };
        let answer = self.decide(can, can_not);
        if a == b {
            if answer {
                self.narrow::<F>(a, Range::ANY.numbers(), 0);
            }
        } else if answer {
            self.order::<F>(a, b, strict);
        } else if !lost {
            self.order::<F>(b, a, !strict);
        }
        answer
    }

    /// That one number is less than another, or no more than it.
    fn order<F: Float>(&mut self, less: Place, more: Place, strict: bool) {
        let (hi, lo) = (self.range(more).hi, self.range(less).lo);
        let (hi, lo) = if strict { (below::<F>(hi), F::above(lo)) } else { (hi, lo) };
        self.narrow::<F>(less, Range::of(f64::NEG_INFINITY, hi), 0);
        self.narrow::<F>(more, Range::of(lo, f64::INFINITY), 0);
    }
}

fn between<F: Float>(lo: f64, hi: f64) -> Range {
    // What f64 rounds away is less than the step of f32; ∞ − ∞ says nothing.
    let lo = if lo.is_nan() { f64::NEG_INFINITY } else { at_least::<F>(lo.next_down()) };
    let hi = if hi.is_nan() { f64::INFINITY } else { F::at_most(hi.next_up()) };
    Range::of(lo, hi)
}

pub(crate) fn constant(number: f64) -> Place {
    told(|graph| graph.constant(number))
}

pub(crate) fn unknown(range: Range) -> Place {
    told(|graph| graph.push(range, From::Unknown))
}

pub(crate) fn range(place: Place) -> Range {
    told(|graph| graph.range(place))
}

pub(crate) fn compute<F: Float>(op: Op, a: Place, b: Place) -> Place {
    told(|graph| graph.compute::<F>(op, a, b))
}

pub(crate) fn less<F: Float>(a: Place, b: Place, strict: bool) -> bool {
    told(|graph| graph.compare::<F>(a, b, strict))
}

pub(crate) fn equal<F: Float>(a: Place, b: Place) -> bool {
    told(|graph| {
        let (of_a, of_b) = (graph.range(a), graph.range(b));
        let both = of_a.and(of_b).numbers();
        let same = a == b || of_a.is_point() && of_b.is_point() && both.has_numbers();
        let answer = graph.decide(both.has_numbers(), of_a.nan || of_b.nan || !same);
        if answer {
            graph.narrow::<F>(a, both, 0);
            graph.narrow::<F>(b, both, 0);
        }
        answer
    })
}

pub(crate) fn is_finite<F: Float>(place: Place) -> bool {
    told(|graph| {
        let range = graph.range(place);
        let finite = Range::finite::<F>();
        let answer = graph.decide(range.and(finite).has_numbers(), !range.is_finite());
        if answer {
            graph.narrow::<F>(place, finite, 0);
        }
        answer
    })
}

/// A whole number that is a constant while things are built, and afterwards any.
pub(crate) fn whole<F: Float>(value: i32) -> Place {
    told(|graph| {
        let of = |value: i32| F::from_i32(value).to_f64();
        if graph.any_whole {
            graph.push(Range::of(of(i32::MIN), of(i32::MAX)), From::Unknown)
        } else {
            graph.constant(of(value))
        }
    })
}

/// The number itself, if there is only one; otherwise it is noted that it was taken out of its type.
pub(crate) fn taken_out(place: Place) -> f64 {
    let range = range(place);
    if range.is_point() && !range.is_empty() {
        return if range.nan { f64::NAN } else { range.lo };
    }
    on(|graph| graph.escaped = true);
    0.0
}

/// One of the ends of a code, which a motor is given.
pub(crate) fn code<F: Float>(place: Place) -> i32 {
    let range = range(place);
    let [least, most] = [range.lo, range.hi].map(|end| F::from_f64(end).round_to_i32());
    on(|graph| {
        graph.codes = graph.codes.or(Range::of(f64::from(least), f64::from(most)));
        graph.codes.nan |= range.nan;
    });
    if told(|graph| graph.decide(true, least != most)) { most } else { least }
}

/// Whether whole numbers stand for any.
pub(crate) fn any_whole(any: bool) {
    on(|graph| graph.any_whole = any);
}

/// A new computation graph: no [`Unknown`](crate::unknown::Unknown) of before means anything any more.
pub fn begin() {
    on(|graph| *graph = Graph::new());
}

/// Of everything that was computed since the graph began, nothing is known any more but that these lie in these ranges; what was
/// constant stays. So whatever holds of a program that goes on from here holds for any numbers in its state.
pub(crate) fn forget(but: &[(Place, Range)]) {
    on(|graph| {
        graph.trail.clear();
        graph.computed.clear();
        for node in graph.nodes.iter_mut().filter(|node| !matches!(node.from, From::Constant(_))) {
            *node = Node { range: Range::ANY, away: 0.0, from: From::Unknown };
        }
        for (place, range) in but {
            let node = &mut graph.nodes[*place as usize];
            if !matches!(node.from, From::Constant(_)) {
                node.range = *range;
            }
        }
    });
}
