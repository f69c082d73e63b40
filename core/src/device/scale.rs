//! A device that is larger or smaller than the shared world: `scale.position` and `scale.force`, for a leader and a follower that
//! are unlike.
//!
//! A metre of the device is s_p metres of the world, a newton of the device s_f newtons of the world:
//!
//! > x = s_p·x_device,   F = s_f·F_device,   so   F·ẋ = s_p·s_f·F_device·ẋ_device
//!
//! What the hand feels of the world's impedance Z is Z·s_p/s_f; a device of mass m is one of m·s_f/s_p in the world. All energy is
//! counted in the world's units; the hand's is that over s_p·s_f. A constant scale keeps passivity: a
//! passive hand is passive at any scale, and what is passive in the world gives the hands no energy, each hand's weighed by its
//! own s_p·s_f (Colgate 1993, "Robust impedance shaping telemanipulation").
//!
//! **Design**: a peer computes in the world's units from its encoders to its duties. So the scale is applied once, to the settings that
//! are in the device's own units: counts and lengths of its mechanism, motors, and every limit that keeps the person safe, which thus
//! holds in newtons and metres of the device. At scale 1 nothing changes, to the last bit.
//!
//! Where a tick is given positions instead of counts, or takes forces instead of duties (a simulated device), those are of the
//! world: who simulates the device scales them.

use crate::device::kinematics::KinematicsName;
use crate::settings::Settings;

impl Settings {
    /// Settings of the unscaled device that behaves like this one in the world's units. The current loop, the check
    /// of a motor against its encoder and a probe belong to the device and use its own settings.
    #[must_use]
    pub fn in_the_world(&self) -> Self {
        let (longer, stronger) = (self.scale.position, self.scale.force);
        let (stiffer, more) = (stronger / longer, longer * stronger);
        let mut world = *self;
        // A slide becomes longer; what turns keeps its angles, at longer links.
        let (travel, motor) = match self.kinematics.model {
            KinematicsName::Direct => (longer, stronger),
            KinematicsName::Capstan | KinematicsName::FiveBar | KinematicsName::Arm => (1.0, more),
        };
        world.encoder.counts_per_m /= longer;
        world.encoder.index_at_m_or_rad *= travel;
        world.encoder.max_speed_m_per_s *= longer;
        world.kinematics.paddle_radius_m *= longer;
        world.kinematics.base_m *= longer;
        world.kinematics.proximal_m *= longer;
        world.kinematics.distal_m *= longer;
        world.motor.newton_or_newton_metre_per_a *= motor;
        world.motor.friction_n *= stronger;
        world.motor.cogging_n_or_n_m *= motor;
        world.motor.cogging_period_m_or_rad *= travel;
        world.motor.cogging_at_m_or_rad *= travel;
        world.axis.hold_stiffness_n_per_m *= stiffer;
        world.axis.hold_damping_n_s_per_m *= stiffer;
        let safety = &mut world.safety;
        safety.max_force_n *= stronger;
        safety.max_slew_n_per_s *= stronger;
        safety.max_rms_force_n *= stronger;
        safety.max_speed_m_per_s *= longer;
        safety.workspace_m *= longer;
        safety.max_rms_power_w *= more;
        safety.max_hand_power_w *= more;
        world
    }
}
