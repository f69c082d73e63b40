//! Settings that are one of a fixed list of names, with the meaning of each.

/// A setting that is one of a fixed list of names.
pub trait Choice: Copy + PartialEq + 'static {
    /// The names, in the order of [`Choice::ALL`].
    const NAMES: &'static [&'static str];
    /// The values, in the order of [`Choice::NAMES`].
    const ALL: &'static [Self];

    /// The value called `name`.
    fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().position(|known| *known == name).and_then(|at| Self::ALL.get(at).copied())
    }
    /// The name of this value.
    fn name(self) -> &'static str {
        Self::ALL.iter().position(|known| *known == self).and_then(|at| Self::NAMES.get(at).copied()).unwrap_or("?")
    }
}

/// Names with what each means, the first one by default.
macro_rules! words {
    ($(
        $(#[$doc:meta])*
        $Name:ident { $first_word:literal => $First:ident, $first:literal; $( $word:literal => $Variant:ident, $meaning:literal; )+ }
    )+) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub enum $Name { #[doc = $first] #[default] $First, $( #[doc = $meaning] $Variant ),+ }

        impl $crate::names::Choice for $Name {
            const NAMES: &'static [&'static str] = &[$first_word, $($word),+];
            const ALL: &'static [Self] = &[Self::$First, $(Self::$Variant),+];
        }

        $crate::num::word!($Name);

        impl $Name {
            /// The meaning of this value, for a person.
            pub fn explain(self) -> &'static str {
                match self { Self::$First => $first, $( Self::$Variant => $meaning ),+ }
            }
        }
    )+ };
}
pub(crate) use words;

words! {
    /// Where the velocity of an axis comes from.
    VelocityName {
        "measured" => Measured, "The reading's own velocity.";
        "difference" => Difference, "Backward difference.";
        "filtered" => Filtered, "Backward difference through a one-pole low pass.";
        "adaptive" => Adaptive, "First-order adaptive windowing.";
    }

    /// The mechanism between joints and axes.
    KinematicsName {
        "direct" => Direct, "Each joint is an axis.";
        "capstan" => Capstan, "A motor drives a paddle through a capstan.";
        "five-bar" => FiveBar, "Two motors on a base, two links each, one hand.";
        "arm" => Arm, "Three motors: a turning base, two links, the outer one held by a parallelogram.";
    }

    /// What turns a duty into a motor current.
    MotorDrive {
        "current-loop" => CurrentLoop, "The board itself: bridges and current sensors, a loop at 20 kHz.";
        "amplifier" => Amplifier, "An amplifier in current mode behind the PWM.";
    }

    /// The sine and cosine that a mechanism is computed with.
    Maths {
        "libm" => Libm, "Exact to the last bit or so.";
        "micromath" => Micromath, "To 1.1e-3 where the number type has it (`f32`), in a fraction of the time.";
    }

    /// How contact is rendered.
    RenderingName {
        "continuous" => Continuous, "A spring and a damper.";
        "impulsive" => Impulsive, "Impacts.";
    }

    /// The side of the object that the device is on.
    Side {
        "left" => Left, "Pushes toward positive x.";
        "right" => Right, "Pushes toward negative x.";
    }

    /// How the object advances by one tick.
    IntegratorName {
        "forward-euler" => ForwardEuler, "The old velocity moves the position.";
        "semi-implicit" => SemiImplicit, "The new velocity moves the position.";
        "exact" => Exact, "The matrix exponential, for a held force.";
        "midpoint" => Midpoint, "One solve a tick for everything that pushes; makes no energy.";
        "backward-euler" => BackwardEuler, "The same solve with forces as the tick ends: what is too stiff for the tick rests within it; takes energy.";
    }

    /// A virtual fixture at the object.
    FixtureName {
        "none" => None, "There is none.";
        "guide" => Guide, "A spring and a damper that draw it to a place.";
        "forbidden-above" => ForbiddenAbove, "A wall: more than this position is forbidden.";
        "forbidden-below" => ForbiddenBelow, "A wall: less than this position is forbidden.";
    }

    /// How the algebraic loop of the wave decode is opened.
    Decode {
        "delayed" => Delayed, "ẋ_d(n) from F_T(n−1); x_d(n) = x_d(n−1) + T_c·ẋ_d(n−1).";
        "implicit" => Implicit, "Backward Euler on x_d, solved in closed form.";
    }
}
