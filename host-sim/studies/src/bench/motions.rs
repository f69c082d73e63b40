//! What the hands do on the bench.
//!
//! | motion | hands | what it asks |
//! |---|---|---|
//! | against | both push 1 N toward each other, one 0.25 sin 3t N more (the cooperation paper's §5.2) | how near the copies are |
//! | together | both push 1 N the same way for 1 s, from rest | how far the object goes, and what it runs into |
//! | led | an arm of 400 N/m leads one hand over 200 mm at 0.7 Hz; the other goes along | what a hand feels of what it moves |
//! | contact | one hand presses and leaves, ±20 mm at 0.5 Hz through an arm of 200 N/m, the other is an arm of 100 N/m; contact only pushes | contact that is made and lost |
//! | let go | an arm of 200 N/m holds against 2 N, which end after 3 s | what is stored comes free |

use cohold_core::names::Choice;
use cohold_sim::scene::Scene;
use cohold_sim::user::{Trace, User};

use crate::Error;

cohold_sim::choices! {
    /// A motion.
    Motion {
        "against" => Against, "Pushes against each other.";
        "together" => Together, "A common push.";
        "led" => Led, "Imposed by an arm.";
        "contact" => Contact, "Contact made and lost.";
        "let go" => LetGo, "A hand that lets go.";
    }
}

/// When a common push begins and when a hand lets go, s: a line that follows the network has learned it.
const AT_S: f64 = 3.0;
/// How hard both push together, and one against an arm, N.
const PUSH_N: f64 = 1.0;
const HOLD_N: f64 = 2.0;

impl Motion {
    /// How long a run of it is, s.
    pub fn duration_s(self) -> f64 {
        match self {
            Self::Against => 10.0,
            Self::Together => AT_S + 1.0,
            Self::Led | Self::Contact => 8.0,
            Self::LetGo => 6.0,
        }
    }

    /// The scene with these hands.
    ///
    /// # Errors
    /// A key that the scene has not.
    pub fn of(self, scene: &Scene) -> Result<Scene, Error> {
        let mut scene = scene.clone();
        let traces = match self {
            // A push of user 2 toward the other peer is toward negative x.
            Self::Together => [PUSH_N, -PUSH_N].map(|push_n| Some(Trace::step(AT_S, push_n))),
            Self::LetGo => [None, Some(Trace::step(AT_S, -HOLD_N))],
            _ => [None, None],
        };
        scene.users = traces.map(|trace| User { trace, ..User::default() });
        self.settings().split_whitespace().try_for_each(|setting| scene.apply_override(setting))?;
        scene.check(self.name())?;
        Ok(scene)
    }

    fn settings(self) -> &'static str {
        match self {
            Self::Against => "user.1.push_n=1 user.2.push_n=1 user.2.sine_n=0.25 user.2.sine_rad_per_s=3",
            Self::Together => "",
            Self::Led => {
                "user.1.arm_stiffness_n_per_m=400 user.1.arm_damping_n_s_per_m=5 user.1.tremor_m=0.1 user.1.tremor_hz=0.7"
            }
            Self::Contact => {
                "contact.one_sided=true user.1.arm_stiffness_n_per_m=200 user.1.arm_damping_n_s_per_m=5 user.1.tremor_m=0.02 \
                 user.1.tremor_hz=0.5 user.2.arm_stiffness_n_per_m=100 user.2.arm_damping_n_s_per_m=5"
            }
            Self::LetGo => "user.1.arm_stiffness_n_per_m=200 user.1.arm_damping_n_s_per_m=5 user.2.push_n=2",
        }
    }
}
