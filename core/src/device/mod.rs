//! An axis of the device: encoder counts to position and velocity, force to motor duty.
//!
//! | module | does |
//! |---|---|
//! | `hand` | all of these, as a peer has them: what is sensed, believed, limited and told the motors |
//! | [`encoder`] | raw counts → joint position, with wrap-around and a plausibility check |
//! | [`velocity`] | joint positions → joint velocity, a list of estimators |
//! | [`kinematics`] | joints → axes of the task, and axis forces → joint forces, a list of mechanisms |
//! | [`scale`] | a device that is larger or smaller than the shared world |
//! | [`clutch`] | a device that comes free of the world, moves, and takes hold again |
//! | [`constraint`] | the force that holds an unused axis on its line |
//! | [`leaky`] | a leaky mean, for root-mean-square limits |
//! | [`motor`] | joint force → duty |
//! | [`current`] | duty, which is a current, → voltage of the motor: 20 000 times a second |
//! | [`stage`] | what the power stage of the motors measured |
//! | [`stage_watch`] | motors, their power stage and their encoders, by what the stage measured |
//! | [`thermal`] | how warm a motor's winding is |
//! | [`envelope`] | force and power on the hand, within their limits over time |
//! | [`watch`] | encoders that fail: stuck, or counting the wrong way |
//! | [`probe`] | a motor pushed open loop, within limits: calibration and the check before arming |
//! | [`winding`] | checks of motor, current sensor, bridge and encoder by voltage and current, before the loop closes |
//!
//! A *joint* is what an encoder and a motor share: a slide (m, N) or something that turns (rad, N·m). An *axis* is a
//! direction of the task: always m, m/s, N. Positions are zero where the encoders were when they were first read.

pub mod clutch;
pub mod constraint;
pub mod current;
pub mod encoder;
pub mod envelope;
pub(crate) mod hand;
pub mod kinematics;
pub mod leaky;
pub mod motor;
pub mod probe;
pub mod scale;
pub mod stage;
pub mod stage_watch;
pub mod thermal;
pub mod velocity;
pub mod watch;
pub mod winding;

use crate::names::{FixtureName, RenderingName};
use crate::num::Motion;
use crate::settings::{Allowed, Refused, Settings};

/// Number of axes, and joints, of a peer's device unless it is given: two in the plane; a device in space has three.
pub const AXES: usize = 2;

/// Raw value of a timer in encoder mode; wraps modulo 2¹⁶.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts(pub u16);

/// The position of the device, read once per tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reading<S, const N: usize = AXES> {
    /// Raw counts of every joint's encoder: a real device, or a simulated one down to its encoders.
    Counts([Counts; N]),
    /// Position (m) and velocity (m/s) of every axis: a simulated device, or one that computes them itself.
    Exact([Motion<S>; N]),
}

/// Refuses axes that a peer of `N` of which `shared` are shared has not, and what cannot be shared along several.
pub(crate) fn check_axes(settings: &Settings, shared: u32, n: u32) -> Result<(), Refused<'static>> {
    settings.within("axis.count", Allowed::Whole { min: 1, max: n })?;
    settings.within("axis.shared", Allowed::Whole { min: 1, max: settings.axis.count })?;
    settings.within("axis.shared", Allowed::Whole { min: shared, max: shared })?;
    let needs = |name, what| Err(settings.refuses(name, Allowed::Only(what)));
    if shared > 1 && settings.contact.rendering != RenderingName::Continuous {
        return needs(
            "contact.rendering",
            "\"continuous\" where axis.shared is more than 1: impacts are along one axis",
        );
    }
    if shared > 1 && settings.contact.one_sided {
        return needs("contact.one_sided", "false where axis.shared is more than 1: a side belongs to one axis");
    }
    let fixture = &settings.fixture;
    for (name, is_set, axes) in [
        ("fixture.direction_rad", fixture.direction_rad != 0.0, 2),
        ("fixture.elevation_rad", fixture.elevation_rad != 0.0, 3),
        ("fixture.drag_n_s_per_m", fixture.drag_n_s_per_m > 0.0, 2),
        ("fixture.friction", fixture.friction > 0.0, 2),
    ] {
        if is_set && shared < axes {
            return needs(name, if axes == 2 { "0 where axis.shared is 1" } else { "0 where axis.shared is 1 or 2" });
        }
    }
    if fixture.friction > 0.0 && fixture.kind == FixtureName::Guide {
        return needs("fixture.friction", "0 of a guide: there is no wall to rub on");
    }
    if shared > 1 && fixture.kind != FixtureName::None && settings.contact.gap_m > 0.0 {
        return needs("contact.gap_m", "0 beside a fixture where axis.shared is more than 1");
    }
    Ok(())
}
