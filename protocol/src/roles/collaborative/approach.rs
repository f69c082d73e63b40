//! Approach: a user who comes near an object wants to edit it, one who moves away has finished (Buttolo et al. 1997, §3.2).

/// What a user at some distance wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// To edit: ask.
    Edit,
    /// Whatever it was before.
    AsBefore,
    /// Nothing: give back what is held.
    Leave,
}

/// Two distances, so that a hand that trembles at one of them does not ask and give back all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Closer than this, the user wants to edit, m.
    pub near_m: f32,
    /// Farther than this, the user has finished, m; not less than `near_m`.
    pub far_m: f32,
}

impl Approach {
    /// What the user wants at this distance from the object, m. Not a number: whatever it was before.
    pub fn wish(&self, distance_m: f32) -> Wish {
        if distance_m < self.near_m {
            Wish::Edit
        } else if distance_m > self.far_m {
            Wish::Leave
        } else {
            Wish::AsBefore
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_the_two_distances_nothing_changes() {
        let approach = Approach { near_m: 0.02, far_m: 0.03 };
        let wishes = [0.019, 0.025, 0.031, f32::NAN].map(|distance| approach.wish(distance));
        assert_eq!(wishes, [Wish::Edit, Wish::AsBefore, Wish::Leave, Wish::AsBefore]);
    }
}
