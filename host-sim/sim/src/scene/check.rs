//! What contradicts itself in a scene: every range, and what settings say of each other.

use cohold_core::contact::RenderingName;
use cohold_core::device::AXES;
use cohold_core::device::current::{self, CurrentLoop};
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::velocity::VelocityName;
use cohold_core::num::Motion;
use cohold_core::settings::{Choice, Refused, Settings, Tables};

use super::{DriveName, Scene};
use crate::Error;
use crate::plant::{self, Beyond};
use crate::user::User;

/// Largest share of a device's dry friction that its motors may take over.
const TAKEN_OVER: f64 = 0.8;

impl Scene {
    /// Checks every range and combination, for scenes put together in code.
    ///
    /// # Errors
    /// The first value or combination that is not allowed; the error names `place` as where it stood.
    pub fn check(&self, place: &str) -> Result<(), Error> {
        let refused = |refused: Refused<'static>| Error::at(place, refused);
        let own = self.peers().into_iter().filter(|_| self.own.iter().any(|own| !own.is_empty()));
        for settings in core::iter::once(self.peer).chain(own) {
            self.check_peer(&settings).map_err(refused)?;
        }
        self.world.check_ranges().map_err(refused)?;
        for user in &self.users {
            user.settings.check_ranges().map_err(refused)?;
        }
        if self.world.plant.encoder {
            cohold_core::device::encoder::check(&self.peer).map_err(refused)?;
        }
        if self.world.plant.encoder && self.peer.axis.velocity == VelocityName::Measured {
            return Err(Error::at(
                place,
                "axis.velocity = \"measured\" is not allowed with plant.encoder = true: counts carry no velocity, it must be \
                 one of \"difference\", \"filtered\", \"adaptive\"",
            ));
        }
        self.check_mass()
            .and_then(|()| self.check_winding())
            .and_then(|()| self.check_friction())
            .and_then(|()| self.check_scale())
            .and_then(|()| self.check_joint_inertia())
            .and_then(|()| self.check_reach())
            .map_err(|said| Error::at(place, said))
    }

    /// Refuses an object that is shared along several axes, where there is a place for one.
    ///
    /// # Errors
    /// The object is shared along several axes, which was asked for at `place`.
    pub fn check_one_axis(&self, place: &str) -> Result<(), Error> {
        let shared = self.peer.axis.shared;
        let said = "is not allowed here: it must be 1 but for `cooperate`, `peer`, `play`, `shared hub`, `study`, \
                    `accuracy` and `stability`";
        if shared > 1 { Err(Error::at(place, format!("axis.shared = {shared} {said}"))) } else { Ok(()) }
    }

    /// Whether a peer with these settings can be built and run at a simulated device.
    fn check_peer(&self, peer: &Settings) -> Result<(), Refused<'static>> {
        peer.check_ranges()?;
        let axis = &peer.axis;
        let in_space = "1 or 2, or 3 with axis.shared = 3: a simulated device in space shares all of its axes";
        let several = "axis.shared where that is more than 1: a simulated device shares all of its axes";
        let is_lone = axis.count == 1 || self.world.plant.cogging_n_or_n_m == 0.0;
        peer.all_fit(&[
            ("axis.count", axis.shared != 1 || axis.count <= AXES as u32, in_space),
            ("axis.count", axis.shared <= 1 || axis.shared >= axis.count, several),
            ("axis.count", is_lone, "1 with plant.cogging_n_or_n_m"),
        ])?;
        match axis.shared {
            2 => self.laws.peer::<f64, 2, 2>(peer, [Motion::REST; 2]).map(drop),
            3.. => self.laws.peer::<f64, 3, 3>(peer, [Motion::REST; 3]).map(drop),
            _ => self.laws.peer::<f64, 1, AXES>(peer, [Motion::REST; AXES]).map(drop),
        }
    }

    /// A motor that takes over more friction than there is pushes whoever moves it.
    fn check_friction(&self) -> Result<(), Error> {
        for (peer, world) in self.ends() {
            let (taken, there) = (peer.motor.friction_n, world.plant.coulomb_n);
            if taken > TAKEN_OVER * there {
                return Err(format!(
                    "motor.friction_n = {taken} is not allowed with plant.coulomb_n = {there}: it must be at most {TAKEN_OVER} of that, \
                     {:.4} N, so that motor and friction together still brake",
                    TAKEN_OVER * there
                ).into());
            }
        }
        Ok(())
    }

    /// A device as the shared world has it must be one that could be written down: the analysis takes it for that.
    fn check_scale(&self) -> Result<(), Error> {
        for (end, (peer, world)) in (1..).zip(self.ends()) {
            let scaled = world.device.mass_kg * peer.scale.force / peer.scale.position;
            if !(1e-4..=1e3).contains(&scaled) {
                return Err(format!(
                    "device.mass_kg = {} of peer {end} is not allowed with scale.position = {} and scale.force = {}: in the world it is \
                     {scaled} kg, it must be 0.0001…1000 kg",
                    world.device.mass_kg, peer.scale.position, peer.scale.force
                ).into());
            }
        }
        Ok(())
    }

    /// An impact of a device that is thought heavier than what moves with it makes energy: a share
    /// (1 + e)·μ̂/μ·(2 − (1 + e)·μ̂/μ) of that of the approach is lost, μ and μ̂ the true and the assumed reduced mass, and with e = 1
    /// that is negative for any μ̂ > μ. One that is thought lighter keeps some of its approach; below half, most of it.
    fn check_mass(&self) -> Result<(), Error> {
        let (contact, device) = (&self.peer.contact, &self.world.device);
        let ends = self.ends().into_iter().zip(&self.users);
        let masses = ends.map(|((peer, world), user)| {
            let in_the_world = peer.scale.force / peer.scale.position;
            let mass_kg = world.device.mass_kg * in_the_world;
            (mass_kg, mass_kg + user.settings.user.arm_mass_kg * in_the_world)
        });
        let (heaviest, most) =
            masses.fold((0.0_f64, f64::INFINITY), |(heaviest, most), (mass, all)| (heaviest.max(mass), most.min(all)));
        let least = 0.5 * heaviest;
        // A rounding of the sum contradicts nothing.
        let agrees = (least..=most * (1.0 + 1e-12)).contains(&contact.device_mass_kg);
        if contact.rendering != RenderingName::Impulsive || agrees {
            return Ok(());
        }
        Err(format!(
            "contact.device_mass_kg = {} is not allowed with device.mass_kg = {} and contact.rendering = \"impulsive\": it must be \
             {least}…{most} kg, from half the device's mass to all that moves with it; more makes energy at every impact",
            contact.device_mass_kg, device.mass_kg
        ).into())
    }

    /// A winding is driven by duties, in whole PWM periods, and the loop around it fast enough to count as a delay.
    fn check_winding(&self) -> Result<(), Error> {
        let plant = &self.world.plant;
        if !plant.winding {
            return Ok(());
        }
        if !plant.motor {
            return Err(
                "plant.winding = true is not allowed with plant.motor = false: a winding is driven by motor duties"
                    .into(),
            );
        }
        current::periods_per_tick(&self.peer)?;
        if plant.drive == DriveName::Voltage {
            return Ok(());
        }
        CurrentLoop::build(&self.peer, plant.timer_counts())?;
        match self.force_delay_ticks() {
            ticks if ticks <= 1.0 => Ok(()),
            ticks => Err(format!(
                "motor.current_loop_hz = {} is not allowed with timing.control_period_s = {}: its current comes {ticks:.2} control \
                 periods after the force was sensed, it must be at most 1",
                self.peer.motor.current_loop_hz, self.peer.timing.control_period_s
            ).into()),
        }
    }

    /// What weighs at the joints is told of axes that are all shared, and free to move every way.
    fn check_joint_inertia(&self) -> Result<(), Error> {
        let refused = |with: String| {
            let said = self.devices().map(|device| device.joint_inertia).into_iter().fold(0.0, f64::max);
            Err(format!("device.joint_inertia = {said} is not allowed with {with}").into())
        };
        match () {
            () if !self.is_coupled() => Ok(()),
            () if !self.is_shared_along_several() => {
                refused("axis.shared = 1: it must be 0, or 2 or 3 axes shared".into())
            }
            () if self.world.plant.coulomb_n > 0.0 => {
                refused(format!("plant.coulomb_n = {}: one of them must be 0", self.world.plant.coulomb_n))
            }
            () if self.users.iter().any(User::has_wall) => refused(
                "user.1.wall_stiffness_n_per_m or user.2.wall_stiffness_n_per_m above 0: a wall is along one axis"
                    .into(),
            ),
            () => Ok(()),
        }
    }

    /// An arm takes its device nowhere that the links do not reach, nor where the peer would stop it.
    fn check_reach(&self) -> Result<(), Error> {
        for (end, (peer, user)) in self.peers().iter().zip(&self.users).enumerate() {
            let (profile, number, model) = (&user.settings.user, end + 1, peer.kinematics.model);
            let length_m = profile.reach_m.abs() + profile.tremor_m;
            if profile.arm_stiffness_n_per_m == 0.0 || length_m == 0.0 || model == KinematicsName::Direct {
                continue;
            }
            let toward = if end == 0 { 1.0_f64 } else { -1.0 } * profile.reach_m.signum();
            let direction = user.direction();
            let way_m = direction.map(|part| toward * length_m * part);
            // Down to what is said, so that it is allowed.
            let most_m = |share: f64| (1e4 * (share * length_m - profile.tremor_m)).floor() / 1e4;
            let farthest = direction.map(f64::abs).into_iter().fold(0.0, f64::max);
            if farthest * length_m > peer.safety.workspace_m {
                return Err(format!(
                    "user.{number}.reach_m = {} is not allowed with safety.workspace_m = {}: it leads {:.1} mm from home along an axis, in this \
                     direction it must be at most {:.4} m",
                    profile.reach_m,
                    peer.safety.workspace_m,
                    1e3 * farthest * length_m,
                    most_m(peer.safety.workspace_m / (farthest * length_m))
                )
                .into());
            }
            if let Some(Beyond { share, why }) = plant::beyond(peer, &self.world.plant, way_m) {
                let place = way_m.iter().take(peer.axis.count as usize).map(|part| format!("{:.1}", 1e3 * part));
                return Err(format!(
                    "user.{number}.reach_m = {} is not allowed with kinematics.model = \"{}\": at ({}) mm from home {why}; in this direction it must \
                     be at most {:.4} m",
                    profile.reach_m,
                    model.name(),
                    place.collect::<Vec<_>>().join(", "),
                    most_m(share)
                )
                .into());
            }
        }
        Ok(())
    }
}
