//! Who may do what on the page: roles, each with a key of its own that is new in each run.
//!
//! An address carries a **ring**: behind its `#` stands `ROLE-KEY`, or several of them joined by `+`. A window may do what the
//! keys on its ring open together, and nothing else; a key opens nothing but the role it was made for. No key can be computed from another.
//!
//! | role | opens |
//! |---|---|
//! | `hand1`, `hand2` | that hand, and Stop: nobody is held by an object that he cannot stop |
//! | `operator` | every order: settings, line, partner, Start, Stop, and what a page may say to a board |
//! | `watch` | pictures only |

use cohold_core::names::Choice;
use cohold_live::key_file::entropy;

use super::environment::Command;
use cohold_cli::Failure;

cohold_sim::choices! {
    /// A role.
    Role {
        "hand1" => Hand1, "Holds hand 1.";
        "hand2" => Hand2, "Holds hand 2.";
        "operator" => Operator, "Orders.";
        "watch" => Watch, "Looks on.";
    }
}

impl Role {
    /// The role that holds hand 1 or 2.
    pub(crate) fn of_hand(number: u8) -> Self {
        if number == 2 { Self::Hand2 } else { Self::Hand1 }
    }
}

/// What a ring opens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Rights {
    /// The hand that it holds, 0 or 1.
    pub(super) hand: Option<usize>,
    /// It orders.
    pub(super) operates: bool,
}

impl Rights {
    /// Whether it may give this order; none is one for the judge.
    pub(super) fn may(self, order: Option<&Command>) -> bool {
        self.operates || (self.hand.is_some() && order == Some(&Command::Stop))
    }
}

/// A key of 128 random bits for each role, in the order of [`Role`].
#[derive(Clone, Debug)]
pub(super) struct Keys([String; Role::ALL.len()]);

impl Keys {
    /// Fresh ones; an error where the system gives no randomness.
    pub(super) fn new() -> Result<Self, Failure> {
        let mut keys = Self(Default::default());
        for key in &mut keys.0 {
            *key = entropy()?[..16].iter().map(|byte| format!("{byte:02x}")).collect();
        }
        Ok(keys)
    }

    /// The ring with the keys of these roles.
    pub(super) fn ring(&self, roles: &[Role]) -> String {
        let named = |role: &Role| format!("{}-{}", Role::NAMES[*role as usize], self.0[*role as usize]);
        roles.iter().map(named).collect::<Vec<_>>().join("+")
    }

    /// What a ring opens: none where one of its keys is not that of its role, or it would hold both hands.
    pub(super) fn opened_by(&self, ring: &str) -> Option<Rights> {
        let mut rights = Rights::default();
        for key in ring.split('+') {
            let (role, key) = key.split_once('-')?;
            let role = Role::from_name(role).filter(|role| same(key, &self.0[*role as usize]))?;
            match role {
                Role::Hand1 | Role::Hand2 if rights.hand.is_some() => return None,
                Role::Hand1 | Role::Hand2 => rights.hand = Some(role as usize),
                Role::Operator => rights.operates = true,
                Role::Watch => {}
            }
        }
        Some(rights)
    }
}

/// Whether two keys are the same, in a time that does not tell where they differ.
fn same(one: &str, other: &str) -> bool {
    one.len() == other.len() && one.bytes().zip(other.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}

#[cfg(test)]
#[path = "../tests/inside/roles.rs"]
mod tests;
