//! One client: a device with its user, the contact with the object as it was last heard of, the bounder, the limits.
//!
//! **View**: the object as the client renders it is the newest state that came, held until the next. When another engine
//! takes over, its states are of another age and would make the object jump; the difference to what was rendered is kept and
//! let go within `EASE_S`, so the force goes on from where it was. While nothing comes that should, because packets are
//! lost or the engine is on its way, the object coasts, at most `COAST_S`.

use core::cmp::Ordering;

use cohold_core::safety::{Fault, Guard, Patience};
use cohold_core::{contact::Contact, device::AXES, num::Motion, peer::Actuators, settings::Settings};
use cohold_protocol::clock::Clock;
use cohold_sim::{plant::Plant, scene::Scene};

use super::bounder;
use super::bounder::{Bound, Bounder};

/// Time constant with which the view goes over to another engine's, s.
const EASE_S: f64 = 0.1;

/// How long the object coasts in silence, s.
const COAST_S: f64 = 0.25;

/// A client: device, user, contact and limits.
#[derive(Clone, Debug)]
pub struct Client {
    pub(super) plant: Plant,
    contact: Contact<f64>,
    guard: Guard<f64>,
    bounder: Option<Bounder<f64>>,
    /// What the bounder allows now; the scene's own without one.
    pub bound: Bound<f64>,
    /// Round trips to the engine and back.
    pub clock: Clock,
    /// Added to what is measured: packets wait for their period at both ends, s.
    waiting_s: f64,
    /// The version of the engine whose states are shown, the newest of them, and ticks since.
    version: u32,
    received: Motion<f64>,
    silent: u64,
    /// Ticks between packets, and until it stops coasting.
    coasts: core::ops::Range<u64>,
    period_s: f64,
    /// What is left of the difference to the state of the engine before.
    ease: Motion<f64>,
    eased: f64,
    /// Commanded to the motor, N.
    motor_n: f64,
    saturated: Patience,
    /// The fault that stopped it.
    pub fault: Option<Fault>,
}

impl Client {
    /// The client of user `index`, whose profile and side are those of user `index mod 2` of the scene.
    pub(super) fn new(scene: &Scene, settings: &Settings, index: usize, bounded: bool) -> Self {
        let (period_s, contact) = (settings.timing.control_period_s, &settings.contact);
        Self {
            plant: Plant::new(scene, index % 2),
            contact: Contact::build(settings),
            guard: Guard::build(settings),
            bounder: bounded.then(|| bounder(scene)),
            bound: Bound { stiffness: contact.stiffness_n_per_m, damping: contact.damping_n_s_per_m, drag: 0.0 },
            clock: Clock::default(),
            waiting_s: 2.0 * f64::from(settings.timing.ticks_per_packet - 1) * period_s,
            version: 0,
            received: Motion::REST,
            silent: 0,
            coasts: u64::from(settings.timing.ticks_per_packet)..(COAST_S / period_s) as u64,
            period_s,
            ease: Motion::REST,
            eased: (-period_s / EASE_S).exp(),
            motor_n: 0.0,
            saturated: Patience::default(),
            fault: None,
        }
    }

    /// The object as it is rendered.
    pub fn view(&self) -> Motion<f64> {
        Motion {
            position: self.received.position + self.ease.position,
            velocity: self.received.velocity + self.ease.velocity,
        }
    }

    /// Takes in the object as the engine of this version tells it; older engines are not listened to.
    pub(super) fn tell(&mut self, version: u32, object: Motion<f64>) {
        if version < self.version {
            return;
        }
        if version > self.version && self.version > 0 {
            let shown = self.view();
            // Where the last engine's object would be shown by now.
            let since_s = match self.silent.cmp(&self.coasts.start) {
                Ordering::Less => 0.0,
                Ordering::Equal => self.coasts.start as f64 * self.period_s,
                Ordering::Greater => self.period_s,
            };
            self.ease = Motion {
                position: shown.position + since_s * shown.velocity - object.position,
                velocity: shown.velocity - object.velocity,
            };
        }
        (self.version, self.received, self.silent) = (version, object, 0);
    }

    /// The round trip as it counts for the bounder, s: measured, four deviations above, and the wait at both ends.
    pub(super) fn round_trip_s(&self) -> Option<f64> {
        let measured = self.clock.round_trip_us()? as f64 + 4.0 * f64::from(self.clock.jitter_us());
        Some(1e-6 * measured + self.waiting_s)
    }

    /// One tick of the bounder; `here`: the engine is at this client, without a network in between.
    pub(super) fn follow(&mut self, here: bool) {
        if let Some(bounder) = &self.bounder {
            let measured = if here { Some(0.0) } else { self.round_trip_s() };
            let [device, ..] = self.plant.motions();
            // Where contact has a gap this is more than the depth: stiffening is then slower than it need be.
            bounder.follow(&mut self.bound, measured, device.position - self.received.position - self.ease.position);
        }
        if self.coasts.contains(&self.silent) {
            self.received.position += self.period_s * self.received.velocity;
        }
        self.silent += 1;
        self.ease.position *= self.eased;
        self.ease.velocity *= self.eased;
    }

    /// Contact force on the object between this device and `object`, N.
    pub(super) fn contact_n(&self, device: Motion<f64>, object: Motion<f64>) -> f64 {
        self.contact.with_gains(self.bound.stiffness, self.bound.damping).force(device, object)
    }

    /// One tick of the device, which feels the reaction of `force_n` as far as the limits let it.
    pub(super) fn step(&mut self, time_s: f64, force_n: f64) {
        let [device, ..] = self.plant.motions();
        let stopped = if !force_n.is_finite() || !device.is_finite() {
            Some(Fault::Diverged)
        } else if device.velocity.abs() > self.guard.fastest {
            Some(Fault::Overspeed)
        } else if self.saturated.spent(force_n.abs() > self.guard.limits.most, self.guard.saturated_ticks) {
            Some(Fault::ForceSaturated)
        } else {
            None
        };
        self.fault = self.fault.or(stopped);
        self.motor_n = if self.fault.is_some() { 0.0 } else { self.guard.limits.limit(self.motor_n, -force_n) };
        let mut forces = [0.0; AXES];
        forces[0] = self.motor_n;
        self.plant.step(time_s, &Actuators { forces, enable: self.fault.is_none(), ..Actuators::<f64>::default() });
    }
}
