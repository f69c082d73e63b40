//! The verdict on a scene: spectral radius, stable or not, how many states.
//!
//! [`Analyser`] keeps its memory from one scene to the next, which is what a sweep needs; [`verdict`] is for one scene. Both
//! look at one mode, both hands in contact; [`super::judge`] looks at every mode.

use cohold_sim::scene::Scene;
use serde::Serialize;

use super::direction::{self, Direction};
use super::error::Error;
use super::lifted::delay::delays_ticks;
use super::lifted::driven::{Response, counts};
use super::lifted::pair::{Joined, hands_are_off, same_arms, same_ends, seat};
use super::lifted::{Lifted, Matrix, kicked, prune, rest};
use super::linear::matrix_says_all;
use super::spectrum::{Polar, Spectrum, radius};

/// How far outside the unit circle an eigenvalue may lie by rounding alone: a lossless scene has them on the circle.
pub const ROUNDING: f64 = 1e-9;

/// What the eigenvalues of one packet period say about a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Largest |eigenvalue| of the lifted matrix, rest modes left out; infinite where one period overflows (in JSON, which
    /// has no infinity: the largest number).
    #[serde(serialize_with = "finite")]
    pub spectral_radius: f64,
    /// No eigenvalue outside the unit circle (by more than [`ROUNDING`]).
    pub stable: bool,
    /// States of the pair that matter to the next packet period, rest modes included.
    pub states: usize,
    /// Rest modes left out: directions in which the pair can stand anywhere, or glide on for ever when nobody holds it.
    pub rest_modes: usize,
    /// The pair was taken apart into sum and difference.
    pub symmetric: bool,
    /// How long the line is in this verdict, ticks, if it is judged at several lengths: as `coordination.credit_ticks` has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_ticks: Option<usize>,
    /// Why the scene is not judged, which counts as unstable.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_judged_because: Option<&'static str>,
    /// Where the objects move in the mode that decides, if they are shared along several axes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
}

/// JSON has no infinity.
fn finite<S: serde::Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(value.min(f64::MAX))
}

/// What is said of a scene that is not judged, for this reason.
pub(crate) fn unjudged(because: &str) -> String {
    format!("not judged, because {because}: it counts as unstable")
}

impl Verdict {
    /// The verdict with a smaller radius than any other.
    pub(crate) const LEAST: Self = Self {
        spectral_radius: f64::NEG_INFINITY,
        stable: true,
        states: 0,
        rest_modes: 0,
        symmetric: false,
        line_ticks: None,
        not_judged_because: None,
        direction: None,
    };

    /// The one with the larger spectral radius, this one of equals.
    pub(crate) fn or_worse(self, other: Self) -> Self {
        if other.spectral_radius > self.spectral_radius { other } else { self }
    }

    /// Of a scene that is not judged, for this reason.
    fn not_judged(because: &'static str) -> Self {
        Self { not_judged_because: Some(because), ..Self::new(f64::INFINITY, 0, 0, false) }
    }

    fn new(spectral_radius: f64, states: usize, rest_modes: usize, symmetric: bool) -> Self {
        let stable = is_stable(spectral_radius);
        Self { spectral_radius, stable, states, rest_modes, symmetric, ..Self::LEAST }
    }
}

/// Whether this spectral radius is inside the unit circle or on it, but for rounding.
pub(crate) fn is_stable(spectral_radius: f64) -> bool {
    spectral_radius <= 1.0 + ROUNDING
}

/// The verdict on the linear scene behind this one ([`Scene::linear`]) with both hands on, and nothing else: the papers' own
/// question. [`super::judge`] asks for every mode that the scene can enter.
///
/// # Errors
/// A scene that cannot be built, or whose eigenvalues do not converge.
pub fn verdict(scene: &Scene) -> Result<Verdict, Error> {
    Analyser::default().verdict(&scene.linear())
}

/// Computes verdicts, one scene after the other.
#[derive(Debug, Default)]
pub struct Analyser {
    answers: Answers,
    whole: Lifted,
    /// For no, one and two hands on: along a sweep each keeps its size.
    solvers: [Solver; 3],
    /// Eigenvalues of every part that was solved for the scene.
    pub(crate) parts: Vec<Polar>,
    /// Where matrices are asked for instead: those of every part.
    reduced: Option<Vec<Reduced>>,
}

/// What is left of the lifted matrix of a part, rest modes divided out.
#[derive(Clone, Debug)]
pub(crate) struct Reduced {
    pub matrix: Matrix,
    /// Somebody holds an object, so that nothing glides.
    pub held: bool,
    /// States before rest modes were divided out.
    pub states: usize,
}

/// What the peers of a scene answer to a packet period, measured once for every mode and delay.
#[derive(Debug, Default)]
struct Answers {
    held: [Heard; 2],
    released: [Heard; 2],
    /// What is left of either peer when it is let go is the same, so that one answer is enough.
    released_alike: bool,
    /// M.
    ticks_per_packet: usize,
    /// Both users' arms are the same, so that one answer is enough.
    alike: bool,
    /// Nobody can hold anything, so that every mode is that of no hands.
    hands_off: bool,
    /// The scene that was measured, if its law counts ticks; and if no matrix says all of its law.
    counting: Option<Scene>,
    kicked: Option<Scene>,
    /// Longest delay of packets that peer 1 and peer 2 use, ticks.
    longest_ticks: [usize; 2],
}

/// A peer's answers for each tick of a packet period at which it is to hear a packet, one for each state in which it stays.
#[derive(Debug, Default)]
struct Heard {
    at_ticks: Vec<usize>,
    answers: Vec<Vec<Response>>,
}

impl Heard {
    fn measure(&mut self, linear: &Scene, index: usize, at_ticks: &[usize]) -> Result<(), Error> {
        self.at_ticks.clear();
        self.at_ticks.extend_from_slice(at_ticks);
        self.answers.resize_with(at_ticks.len(), Vec::new);
        for (answers, at_tick) in self.answers.iter_mut().zip(at_ticks) {
            Response::measure_each(answers, linear, index, *at_tick)?;
        }
        Ok(())
    }

    fn at(&self, at_tick: usize) -> &[Response] {
        let measured = self.at_ticks.iter().position(|known| *known == at_tick);
        &self.answers[measured.expect("what is joined was measured")]
    }
}

impl Analyser {
    /// The verdict on a scene that is linear already, both hands on.
    ///
    /// # Errors
    /// A scene that cannot be built, or whose eigenvalues do not converge.
    pub fn verdict(&mut self, linear: &Scene) -> Result<Verdict, Error> {
        let delays = delays_ticks(linear);
        self.parts.clear();
        self.measure((linear, matrix_says_all(linear)?), [true, false], &[delays])?;
        self.judged([false; 2], delays)
    }

    /// Spectral radius, states and rest modes of a lifted matrix from elsewhere; `anchors` are states known to matter.
    ///
    /// # Errors
    /// Eigenvalues that do not converge.
    pub fn judge(&mut self, lifted: Lifted, anchors: &[usize]) -> Result<Verdict, Error> {
        self.judge_held(lifted, anchors, true)
    }

    /// [`Analyser::judge`], also where nothing holds the object and it may glide (`held` is false).
    pub(crate) fn judge_held(&mut self, lifted: Lifted, anchors: &[usize], held: bool) -> Result<Verdict, Error> {
        let (states, stands) = self.solvers[0].reduce(&lifted, anchors);
        let (polar, glides) = self.solvers[0].eigenvalues(held)?;
        Ok(Verdict::new(radius(&polar), states, stands + glides, false))
    }

    /// Measures what the peers of a linear scene answer with a hand on, let go, or both, where packets are on their way to peer 1
    /// and to peer 2 for one of these numbers of ticks. The scene comes with whether [`matrix_says_all`] of it, at whatever delay.
    pub(crate) fn measure(
        &mut self,
        (linear, says_all): (&Scene, bool),
        [held, released]: [bool; 2],
        delays: &[[usize; 2]],
    ) -> Result<(), Error> {
        let answers = &mut self.answers;
        answers.counting = counts(linear).then(|| linear.clone());
        answers.kicked = (!says_all).then(|| linear.clone());
        let period_ns = linear.peer.timing.control_period_ns();
        answers.longest_ticks = linear.peers().map(|peer| (peer.safety.max_delay_ns() / period_ns) as usize);
        answers.ticks_per_packet = linear.peer.timing.ticks_per_packet as usize;
        let mut at_ticks: Vec<usize> = delays.iter().flatten().map(|ticks| ticks % answers.ticks_per_packet).collect();
        at_ticks.sort_unstable();
        at_ticks.dedup();
        answers.hands_off = hands_are_off(linear);
        answers.alike = answers.hands_off || same_arms(linear);
        if held && !answers.hands_off {
            answers.held[0].measure(linear, 0, &at_ticks)?;
            if !answers.alike {
                answers.held[1].measure(linear, 1, &at_ticks)?;
            }
        }
        if released || answers.hands_off {
            let seat = seat(linear, true);
            let [first, second] = seat.peers();
            answers.released_alike = first.fixture == second.fixture && same_ends(linear);
            answers.released[0].measure(&seat, 0, &at_ticks)?;
            if !answers.released_alike {
                answers.released[1].measure(&seat, 1, &at_ticks)?;
            }
        }
        Ok(())
    }

    /// What is left of the lifted matrix of every part that `joins` joins.
    pub(crate) fn reduced(
        &mut self,
        joins: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<Vec<Reduced>, Error> {
        self.reduced = Some(Vec::new());
        let joined = joins(self);
        let reduced = self.reduced.take().unwrap_or_default();
        joined.map(|()| reduced)
    }

    /// The eigenvalues of such a matrix, as `write` writes it.
    pub(crate) fn polar(&mut self, write: impl FnOnce(&mut Matrix), held: bool) -> Result<Polar, Error> {
        let solver = &mut self.solvers[0];
        write(&mut solver.kept.matrix);
        solver.eigenvalues(held).map(|(polar, _)| polar)
    }

    /// Whether it matters which of the two peers measured last is let go.
    pub(crate) fn sides_differ(&self) -> bool {
        !self.answers.alike
    }

    /// [`Analyser::joined`], unless packets are older by then than the peers use.
    pub(crate) fn judged(&mut self, released: [bool; 2], delays: [usize; 2]) -> Result<Verdict, Error> {
        if delays.iter().zip(&self.answers.longest_ticks).any(|(ticks, longest)| ticks > longest) {
            let because = "packets are older than safety.max_delay_s, and are not used";
            return Ok(self.without_a_matrix(Verdict::not_judged(because)));
        }
        self.joined(released, delays)
    }

    /// This verdict, which takes the place of a part.
    fn without_a_matrix(&mut self, verdict: Verdict) -> Verdict {
        let radius = verdict.spectral_radius;
        match &mut self.reduced {
            Some(reduced) => {
                reduced.push(Reduced { matrix: Matrix::from_element(1, 1, radius), held: true, states: 0 })
            }
            None => self.parts.push(vec![[radius, 0.0]]),
        }
        verdict
    }

    /// The verdict on the peers measured last, held or `released`, with these delays to peer 1 and to peer 2, ticks: the worst of all states in
    /// which they stay.
    pub(crate) fn joined(&mut self, released: [bool; 2], delays: [usize; 2]) -> Result<Verdict, Error> {
        let Answers { held, released: let_go, released_alike, alike, hands_off, ticks_per_packet, .. } = &self.answers;
        let released = released.map(|released| released || *hands_off);
        let [first, second] = [0, 1].map(|at: usize| {
            let (heard, same) = if released[at] { (let_go, released_alike) } else { (held, alike) };
            heard[if *same { 0 } else { at }].at(delays[at] % ticks_per_packet)
        });
        let hands = released.iter().filter(|released| !**released).count();
        let (Some(first_ends), Some(second_ends)) = (first.last(), second.last()) else {
            let kicked = self.answers.counting.as_ref().map(|linear| kicked::radius(linear, released)).transpose()?;
            return Ok(self.without_a_matrix(match kicked.flatten() {
                Some(radius) => Verdict::new(radius, 0, 0, false),
                None => Verdict::not_judged("the peers do not act on each other at this delay"),
            }));
        };
        let solver = &mut self.solvers[hands];
        let mut found = Verdict::LEAST;
        let lengths = first.len().max(second.len());
        for length in 0..lengths {
            let answers = [first.get(length).unwrap_or(first_ends), second.get(length).unwrap_or(second_ends)];
            let joined = Joined::new(answers, delays.map(|ticks| ticks / ticks_per_packet));
            let (objects, axes) = (joined.objects(), joined.axes());
            let mut direction = None;
            let (mut worst, mut states, mut rest_modes) = (0.0_f64, 0, 0);
            for sign in joined.signs() {
                joined.write(*sign, &mut self.whole);
                let (kept, stands) = solver.reduce(&self.whole, &objects);
                states += kept;
                rest_modes += stands;
                if let Some(reduced) = &mut self.reduced {
                    reduced.push(Reduced { matrix: solver.kept.matrix.clone(), held: hands > 0, states: kept });
                    continue;
                }
                let (polar, glides) = solver.eigenvalues(hands > 0)?;
                if let Some(largest) = polar.first().filter(|largest| axes > 1 && largest[0] > worst) {
                    direction = direction::direction(&self.whole.matrix, *largest, &objects, axes);
                }
                worst = worst.max(radius(&polar));
                rest_modes += glides;
                self.parts.push(polar);
            }
            let line_ticks = answers[0].line_ticks.filter(|_| lengths > 1);
            let verdict = Verdict::new(worst, states, rest_modes, joined.symmetric);
            found = found.or_worse(Verdict { direction, line_ticks, ..verdict });
        }
        // The matrix has a packet in each period, and is that of a law which is linear and learns nothing. A kicked run may be worse
        // than one that settles.
        let run = |linear| if found.stable { kicked::radius(linear, released) } else { Ok(Some(0.0)) };
        let kicked = self.answers.kicked.as_ref().map(run).transpose()?;
        Ok(match kicked.flatten().map(|radius| Verdict::new(radius, 0, 0, false)) {
            Some(kicked) => found.or_worse(self.without_a_matrix(kicked)),
            None => found,
        })
    }
}

/// Memory for eigenvalues of matrices of one size.
#[derive(Debug, Default)]
struct Solver {
    pruner: prune::Pruner,
    kept: Lifted,
    spectrum: Spectrum,
}

impl Solver {
    /// Leaves of a lifted matrix what can change, rest modes divided out; how many states matter, and how many modes rest.
    fn reduce(&mut self, whole: &Lifted, anchors: &[usize]) -> (usize, usize) {
        let kept = self.pruner.kept(&whole.matrix, anchors);
        let states = kept.len();
        prune::copy(whole, kept, &mut self.kept);
        rest::idle(&mut self.kept);
        (states, rest::divide_out(&mut self.kept))
    }

    /// The eigenvalues of what is left, and how many modes glide.
    fn eigenvalues(&mut self, held: bool) -> Result<(Polar, usize), Error> {
        // What nobody holds and nothing damps glides on for ever: 1 to rounding, which decides nothing and would hide how fast
        // everything else settles.
        let glides = |re: f64, im: f64| !held && (re - 1.0).hypot(im) <= ROUNDING;
        self.spectrum.polar_beside(&mut self.kept.matrix, glides).ok_or(Error::NoConvergence)
    }
}

#[cfg(test)]
#[path = "../tests/inside/verdict.rs"]
mod tests;
