//! Backward Euler: the one solve of [`super::midpoint`] with every force as it is when the tick ends, for springs that are too stiff for the tick.
//!
//! A port meets the copy at the end of the tick instead of midway: κ = K·T_c + B for a spring and a damper (midway: K·T_c/2 + B), and
//!
//! > v = (m_O/T_c·ẋ_o + Σf)/(m_O/T_c + b_O + Σz),   x_o ← x_o + T_c·v,   ẋ_o ← v
//!
//! **L-stable.** What a spring K between the copy and the end of a line of impedance b keeps of its stretch in a tick is
//! (1 − (1 − θ)·a)/(1 + θ·a) with a = K·T_c/z, z = b in a row with m_O/(θ·T_c), and θ = ½ midway, 1 here: for a large K that is −1 midway, an
//! alternation from tick to tick that takes a/4 ticks to fade, and 1/(1 + a) here, rest within the tick. Take it where K_T·T_c is far above
//! what the spring pulls at (a case beyond THEORY §7): at `coordination.stiffness_n_per_m` = 10⁷ a jolt alternates by newtons midway.
//!
//! **Passive.** Where the midpoint rule makes no energy, this takes some: ½·m_O·ẋ_o² changes by T_c·(ΣF·v − b_O·v²) − ½·m_O·(Δẋ_o)², and a
//! spring's ½K·s² by T_c·F·ṡ − ½K·(Δs)² with ṡ the velocity of the tick. So a law that pays for its energy with the way of the same tick
//! stays paid.
//!
//! **What it costs**: it is of first order, and an oscillation of ω loses 1 − 1/√(1 + (ω·T_c)²) of its amplitude each tick, as from a damping ratio
//! of ω·T_c/2: 3 % at 9 Hz and T_c = 1 ms. No instruction where it is not chosen, and none more where it is (f32, Cortex-M7).
//!
//! Source: Hairer & Wanner, "Solving Ordinary Differential Equations II", 2nd ed., 1996, §IV.3. Units: N, N·s/m, m, m/s.

use super::midpoint::Midpoint;

/// A mass that is moved by ports as they are when the tick ends. [`Midpoint`] with the numbers of this rule, so that no peer carries two solves.
pub type BackwardEuler<S> = Midpoint<S>;
