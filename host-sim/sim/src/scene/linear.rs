//! Linear scenes for the stability analysis, derived from a scene that is run; each says what it leaves out.

use cohold_core::contact::RenderingName;
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::velocity::VelocityName;
use cohold_core::names::FixtureName;
use cohold_core::settings::{Choice, Fixture, PLENTY_J, Scale, Settings, Tables, Value};

use super::{DriveName, Network, PlantSettings, Scene};
use crate::user::User;

impl Scene {
    /// The linear scene that the stability analysis examines for this one: device and object in ideal, permanent
    /// contact, exact sensors and motors, and nobody pushing.
    pub fn linear(&self) -> Self {
        let mut linear = self.clone();
        linear.at_home = true;
        // Forces that are cut are not linear: as far out of the way as settings have them.
        (linear.peer.safety.max_force_n, linear.peer.safety.max_slew_n_per_s) = (200.0, 1e6);
        linear.peer.contact.rendering = RenderingName::Continuous;
        linear.peer.contact.one_sided = false;
        linear.peer.contact.gap_m = 0.0;
        linear.peer.coordination.ledger = false;
        linear.peer.coordination.drift_correction = false;
        for budget in self.law().budgets() {
            // Refused only where other laws' keys leave no room: then it is judged as it is.
            let _ = self.laws.schema().set(&mut linear.peer, budget.name, Value::Number(PLENTY_J));
        }
        linear.peer.axis.count = linear.peer.axis.shared;
        if !self.is_coupled() {
            linear.peer.kinematics.model = KinematicsName::Direct;
        }
        linear.world.device.force_delay_ticks = self.force_delay_ticks();
        linear.world.device.mass_kg += self.back_emf_mass_kg();
        linear.world.plant = PlantSettings::default();
        linear.users = Default::default();
        // Constant delay: what the analysis of one packet period can hold. Play-out is that and nothing else.
        let network = &self.world.network;
        linear.network_trace = None;
        linear.world.network = Network {
            one_way_delay_packets: network.one_way_delay_packets + network.playout_packets,
            extra_delay_s: network.extra_delay_s,
            asymmetry_s: network.asymmetry_s,
            ..Network::default()
        };
        linear.peer.scale = Scale::default();
        // What draws to another place is the same about zero; a wall that is away is none.
        let guides = |fixture: Fixture| if fixture.kind == FixtureName::Guide { fixture } else { Fixture::default() };
        let about_zero = |fixture: Fixture| Fixture { position_m: 0.0, friction: 0.0, ..guides(fixture) };
        linear.peer.fixture = about_zero(self.peer.fixture);
        let ends = self.ends().into_iter().zip(linear.users.iter_mut().zip(&mut linear.own));
        for (((peer, world), (user, own)), from) in ends.zip(&self.users) {
            // A scaled device is another device in the world; so is its arm.
            let heavier = peer.scale.force / peer.scale.position;
            let own_device = heavier != 1.0 || world.device != self.world.device;
            own.retain(|(key, _)| key.starts_with("contact."));
            let fixture = about_zero(peer.fixture);
            if fixture != linear.peer.fixture {
                let peer = Settings { fixture, ..peer };
                let keys = Settings::KEYS.iter().filter(|key| key.name.starts_with("fixture."));
                own.extend(keys.filter_map(|key| Some((key.name, peer.get(key.name)?))));
            }
            if own_device {
                let device = &world.device;
                let delay = if self.world.plant.winding { self.force_delay_ticks() } else { device.force_delay_ticks };
                own.extend([
                    ("device.mass_kg", Value::Number(heavier * (device.mass_kg + self.back_emf_mass_kg()))),
                    ("device.damping_n_s_per_m", Value::Number(heavier * device.damping_n_s_per_m)),
                    ("device.force_delay_ticks", Value::Number(delay)),
                    ("device.joint_inertia", Value::Number(heavier * device.joint_inertia)),
                ]);
            }
            // The arm is part of the plant; what the user wants to do is not.
            let (to, from) = (&mut user.settings.user, &from.settings.user);
            to.arm_stiffness_n_per_m = heavier * from.arm_stiffness_n_per_m;
            to.arm_damping_n_s_per_m = heavier * from.arm_damping_n_s_per_m;
            to.arm_mass_kg = heavier * from.arm_mass_kg;
        }
        linear
    }

    /// This scene with every wall that a device or the object can meet held in contact: each is a spring and a
    /// damper, as the linear analysis has it. None where there are no walls.
    pub fn at_walls(&self) -> Option<Self> {
        let is_wall = |kind| matches!(kind, FixtureName::ForbiddenAbove | FixtureName::ForbiddenBelow);
        let forbidden = self.peers().map(|peer| is_wall(peer.fixture.kind));
        if !self.users.iter().any(User::has_wall) && forbidden == [false; 2] {
            return None;
        }
        let mut met = self.clone();
        for user in &mut met.users {
            let user = &mut user.settings.user;
            user.arm_stiffness_n_per_m += user.wall_stiffness_n_per_m;
            user.arm_damping_n_s_per_m += user.wall_damping_n_s_per_m;
            (user.wall_stiffness_n_per_m, user.wall_damping_n_s_per_m) = (0.0, 0.0);
        }
        for (own, forbidden) in met.own.iter_mut().zip(forbidden) {
            if forbidden {
                own.retain(|(key, _)| *key != "fixture.kind");
                own.push(("fixture.kind", Value::Text(FixtureName::Guide.name())));
            }
        }
        Some(met)
    }

    /// This scene with both devices let go: K_LC = B_LC = 0, no impacts, and users without arms who do nothing. What
    /// is left is two copies of the object and their coordination (THEORY §9).
    pub fn hands_off(&self) -> Self {
        let mut off = self.clone();
        off.peer.contact.rendering = RenderingName::Continuous;
        off.peer.contact.stiffness_n_per_m = 0.0;
        off.peer.contact.damping_n_s_per_m = 0.0;
        off.own.iter_mut().for_each(|own| own.retain(|(key, _)| !key.starts_with("contact.")));
        off.users = Default::default();
        off
    }

    /// Whether the run itself is linear: permanent contact, no imperfections, no window that adapts, no ledger that cuts.
    pub fn is_linear(&self) -> bool {
        let (contact, plant) = (&self.peer.contact, &self.world.plant);
        !contact.one_sided
            && contact.gap_m == 0.0
            && !self.peer.coordination.ledger
            && *plant == PlantSettings::default()
            && self.peer.axis.velocity != VelocityName::Adaptive
    }

    /// How much heavier a device in a current loop feels, kg: while the back-EMF grows the loop lacks force, k²/(ω_c·R) for each m/s². None
    /// where it is sent forward, where the duty is no reference, and of mechanisms other than slides, whose pose it depends on.
    fn back_emf_mass_kg(&self) -> f64 {
        let (plant, motor) = (&self.world.plant, &self.peer.motor);
        let slide = self.peer.kinematics.model == KinematicsName::Direct;
        if !plant.winding || plant.drive == DriveName::Voltage || motor.back_emf_forward || !slide {
            return 0.0;
        }
        let crossover = std::f64::consts::TAU * motor.current_loop_hz;
        motor.newton_or_newton_metre_per_a.powi(2) / (crossover * motor.resistance_ohm)
    }
}
