//! The checker: who built on what, and what was promised to whom. It knows nothing of locks and tokens.
//!
//! Every edit makes a value that occurs once, and the history remembers what it was made from. Then *no lost update* is a
//! statement about a tree: everything whose author was notified that it is published lies on one branch, whatever is official
//! only moves outward on it, and what everybody has in the end lies beyond all of it.

use std::collections::HashMap;

use crate::roles::collaborative::Value;

/// Edits and promises of one run.
#[derive(Clone)]
pub(super) struct History {
    /// What each value was made from, and how many edits it is away from the beginning.
    made: HashMap<Value, (Value, u64)>,
    pub(super) published: Vec<Value>,
    /// The published value that has the most edits in it.
    tip: Value,
    official: Value,
    /// The first thing that was wrong.
    pub(super) wrong: Option<String>,
}

impl Default for History {
    fn default() -> Self {
        let start = Value::default();
        Self {
            made: HashMap::from([(start, (start, 0))]),
            published: Vec::new(),
            tip: start,
            official: start,
            wrong: None,
        }
    }
}

impl History {
    /// Somebody edits: a value that never was before, made from `base`. Wrong if nobody has ever made `base`.
    pub(super) fn edit(&mut self, base: &Value) -> Value {
        let depth = self.depth(base) + 1;
        let mut value = Value::default();
        value[..8].copy_from_slice(&(self.made.len() as u64).to_le_bytes());
        value[8..16].copy_from_slice(&depth.to_le_bytes());
        self.made.insert(value, (*base, depth));
        value
    }

    /// An author is notified that its value is published. Wrong if it and something that was published before do not build on
    /// each other.
    pub(super) fn publish(&mut self, value: &Value) {
        let inside = self.depth(value) < self.depth(&self.tip.clone());
        let (inner, outer) = if inside { (*value, self.tip) } else { (self.tip, *value) };
        if !self.holds(&outer, &inner) {
            let (inner, outer) = (name(&inner), name(&outer));
            self.complain(format!("edits {inner} and {outer} are both published and do not build on each other"));
        }
        self.tip = outer;
        self.published.push(*value);
    }

    /// The official copy, where there is one. Wrong if it does not build on what was official before.
    pub(super) fn official(&mut self, value: &Value) {
        if !self.holds(value, &self.official.clone()) {
            let (new, old) = (name(value), name(&self.official));
            self.complain(format!("edit {new} became official and does not build on edit {old}"));
        }
        self.official = *value;
    }

    /// What peer `who` has in the end. Wrong if something that was published is not in it.
    pub(super) fn last(&mut self, who: usize, value: &Value) {
        let missing = self.published.clone().into_iter().find(|published| !self.holds(value, published));
        if let Some(missing) = missing {
            let (missing, value) = (name(&missing), name(value));
            self.complain(format!(
                "peer {who}: edit {missing} was published and is not in the last state, edit {value}"
            ));
        }
    }

    pub(super) fn complain(&mut self, what: String) {
        self.wrong.get_or_insert(what);
    }

    /// How many edits a value is away from the beginning. Wrong if nobody has made it.
    fn depth(&mut self, value: &Value) -> u64 {
        let depth = self.made.get(value).map(|(_, depth)| *depth);
        if depth.is_none() {
            self.complain(format!("nobody has made {}", name(value)));
        }
        depth.unwrap_or(0)
    }

    /// Whether `inner` is in `outer`.
    fn holds(&mut self, outer: &Value, inner: &Value) -> bool {
        let (mut at, end) = (*outer, self.depth(inner));
        while self.depth(&at) > end {
            at = self.made[&at].0;
        }
        at == *inner
    }
}

fn name(value: &Value) -> u64 {
    value.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

#[cfg(test)]
#[path = "../../tests/inside/collaborative_history.rs"]
mod tests;
