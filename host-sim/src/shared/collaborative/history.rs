//! The checker: who built on what, and what was promised to whom. It knows nothing of locks and tokens.
//!
//! Every edit makes a value that occurs once, and the history remembers what it was made from. Then *no lost update* is a
//! statement about a tree: everything whose author was told that it is published lies on one branch, whatever is official
//! only moves outward on it, and what everybody has in the end lies beyond all of it.

use std::collections::HashMap;

use haptic_protocol::roles::collaborative::Value;

/// Edits and promises of one run.
#[derive(Clone, Debug)]
pub struct History {
    /// What each value was made from, and how many edits it is away from the beginning.
    made: HashMap<Value, (Value, u64)>,
    published: Vec<Value>,
    /// The published value that has the most edits in it.
    tip: Value,
    official: Value,
}

impl Default for History {
    fn default() -> Self {
        let start = Value::default();
        Self { made: HashMap::from([(start, (start, 0))]), published: Vec::new(), tip: start, official: start }
    }
}

impl History {
    /// Somebody edits: a value that never was before, made from `base`.
    ///
    /// # Errors
    /// Nobody has ever made `base`.
    pub fn edit(&mut self, base: &Value) -> Result<Value, String> {
        let depth = self.depth(base)?;
        let mut value = Value::default();
        value[..8].copy_from_slice(&(self.made.len() as u64).to_le_bytes());
        value[8..16].copy_from_slice(&(depth + 1).to_le_bytes());
        self.made.insert(value, (*base, depth + 1));
        Ok(value)
    }

    /// An author is told that its value is published.
    ///
    /// # Errors
    /// It and something that was published before do not build on each other.
    pub fn publish(&mut self, value: &Value) -> Result<(), String> {
        let (inner, outer) =
            if self.depth(value)? < self.depth(&self.tip)? { (*value, self.tip) } else { (self.tip, *value) };
        if !self.holds(&outer, &inner)? {
            return Err(format!(
                "edits {} and {} are both published and do not build on each other",
                name(&inner),
                name(&outer)
            ));
        }
        self.tip = outer;
        self.published.push(*value);
        Ok(())
    }

    /// The official copy, where there is one.
    ///
    /// # Errors
    /// It does not build on what was official before.
    pub fn official(&mut self, value: &Value) -> Result<(), String> {
        if !self.holds(value, &self.official)? {
            return Err(format!(
                "edit {} became official and does not build on edit {}",
                name(value),
                name(&self.official)
            ));
        }
        self.official = *value;
        Ok(())
    }

    /// What somebody has in the end.
    ///
    /// # Errors
    /// Something that was published is not in it.
    pub fn last(&self, value: &Value) -> Result<(), String> {
        for published in &self.published {
            if !self.holds(value, published)? {
                return Err(format!(
                    "edit {} was published and is not in the last state, edit {}",
                    name(published),
                    name(value)
                ));
            }
        }
        Ok(())
    }

    /// How many updates their authors were told are published.
    pub fn published(&self) -> u64 {
        self.published.len() as u64
    }

    fn depth(&self, value: &Value) -> Result<u64, String> {
        self.made.get(value).map(|(_, depth)| *depth).ok_or_else(|| format!("nobody has made {}", name(value)))
    }

    /// Whether `inner` is in `outer`.
    fn holds(&self, outer: &Value, inner: &Value) -> Result<bool, String> {
        let (mut at, end) = (*outer, self.depth(inner)?);
        while self.depth(&at)? > end {
            at = self.made[&at].0;
        }
        Ok(at == *inner)
    }
}

fn name(value: &Value) -> u64 {
    value.iter().take(8).rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_branch_is_well_and_two_are_a_lost_update() {
        let mut history = History::default();
        let one = history.edit(&Value::default()).unwrap();
        let two = history.edit(&one).unwrap();
        let other = history.edit(&Value::default()).unwrap();
        // Told in another order than made: well.
        history.publish(&two).unwrap();
        history.publish(&one).unwrap();
        history.last(&two).unwrap();
        assert!(history.last(&one).unwrap_err().contains("edit 2 was published"));
        assert!(history.publish(&other).unwrap_err().contains("do not build on each other"));
        history.official(&one).unwrap();
        history.official(&two).unwrap();
        assert!(history.official(&other).unwrap_err().contains("does not build on edit 2"));
        assert!(history.edit(&[9; 24]).unwrap_err().contains("nobody has made"));
    }
}
