//! Everything that can happen to a model within so many actions, depth first; a state that was searched as deep before is not
//! searched again. States are distinguished by a fingerprint of 64 bits.

use std::collections::HashMap;
use std::fmt::Debug;

/// What is searched.
pub(super) trait Model: Clone {
    type Action: Copy + Debug;
    type Promise: Debug;

    /// What can happen next.
    fn actions(&self) -> Vec<Self::Action>;

    /// Lets it happen; an error says which promise is broken.
    fn act(&mut self, action: Self::Action) -> Result<(), Self::Promise>;

    /// Equal for states that have the same future.
    fn fingerprint(&self) -> u64;
}

/// What a search has seen.
#[derive(Debug)]
pub(super) struct SearchResult<A, P> {
    /// Different states.
    pub(super) states: usize,
    /// Actions tried.
    pub(super) actions: u64,
    /// A sequence of actions at the end of which a promise is broken, and which.
    pub(super) broken: Option<(Vec<A>, P)>,
}

struct Search<A> {
    /// How many actions deep the search went on from each state.
    known: HashMap<u64, u32>,
    path: Vec<A>,
    actions: u64,
}

impl<A: Copy> Search<A> {
    fn below<M: Model<Action = A>>(&mut self, model: &M, depth: u32) -> Result<(), M::Promise> {
        let known = self.known.entry(model.fingerprint()).or_insert(0);
        if depth <= *known {
            return Ok(());
        }
        *known = depth;
        for action in model.actions() {
            let mut next = model.clone();
            self.actions += 1;
            self.path.push(action);
            next.act(action)?;
            self.below(&next, depth - 1)?;
            self.path.pop();
        }
        Ok(())
    }
}

/// All sequences of up to `depth` actions, until a promise is broken.
pub(super) fn all<M: Model>(start: &M, depth: u32) -> SearchResult<M::Action, M::Promise> {
    let mut search = Search { known: HashMap::new(), path: Vec::new(), actions: 0 };
    let broken = search.below(start, depth).err().map(|promise| (search.path, promise));
    SearchResult { states: search.known.len(), actions: search.actions, broken }
}

/// The shortest sequence of up to `depth` actions that breaks a promise.
pub(super) fn shortest<M: Model>(start: &M, depth: u32) -> SearchResult<M::Action, M::Promise> {
    let mut seen = all(start, 0);
    for depth in 1..=depth {
        let next = all(start, depth);
        seen = SearchResult { actions: seen.actions + next.actions, ..next };
        if seen.broken.is_some() {
            break;
        }
    }
    seen
}
