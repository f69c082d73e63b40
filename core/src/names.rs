//! Closed words: what a setting may be called where the list of names is fixed.

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
    /// What this value is called.
    fn name(self) -> &'static str {
        Self::ALL.iter().position(|known| *known == self).and_then(|at| Self::NAMES.get(at).copied()).unwrap_or("?")
    }
}

macro_rules! words {
    ($( $(#[$doc:meta])* $Name:ident { $( $(#[$word_doc:meta])* $word:literal => $Variant:ident, )+ } )+) => { $(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Name { $( $(#[$word_doc])* $Variant ),+ }

        impl Choice for $Name {
            const NAMES: &'static [&'static str] = &[$($word),+];
            const ALL: &'static [Self] = &[$(Self::$Variant),+];
        }
    )+ };
}

words! {
    /// Where the velocity of an axis comes from.
    VelocityName {
        /// The reading's own velocity.
        "measured" => Measured,
        /// Backward difference.
        "difference" => Difference,
        /// Backward difference through a one-pole low pass.
        "filtered" => Filtered,
        /// First-order adaptive windowing.
        "adaptive" => Adaptive,
    }

    /// A mechanism.
    KinematicsName {
        /// Each joint is an axis.
        "direct" => Direct,
        /// A motor drives a paddle through a capstan.
        "capstan" => Capstan,
        /// Two motors on a base, two links each, one hand.
        "five-bar" => FiveBar,
    }

    /// Which sine and cosine a mechanism is computed with.
    Maths {
        /// Exact to the last bit or so.
        "libm" => Libm,
        /// To 1.1e-3 where the number type has it (`f32`), in a fraction of the time.
        "micromath" => Micromath,
    }

    /// How contact is rendered.
    RenderingName {
        /// A spring and a damper.
        "continuous" => Continuous,
        /// Impacts.
        "impulsive" => Impulsive,
    }

    /// The side of the object that the device is on.
    Side {
        /// Pushes toward positive x.
        "left" => Left,
        /// Pushes toward negative x.
        "right" => Right,
    }

    /// How the object advances by one tick.
    IntegratorName {
        /// The old velocity moves the position.
        "forward-euler" => ForwardEuler,
        /// The new velocity moves the position.
        "semi-implicit" => SemiImplicit,
        /// The matrix exponential, for a held force.
        "exact" => Exact,
    }

    /// How the algebraic loop of the wave decode is opened.
    Decode {
        /// ẋ_d\[n\] from F_T\[n−1\]; x_d\[n\] = x_d\[n−1\] + T_c·ẋ_d\[n−1\].
        "delayed" => Delayed,
        /// Backward Euler on x_d, solved in closed form.
        "implicit" => Implicit,
    }
}
