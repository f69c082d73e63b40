//! Random linear scenes, the same ones in every run.

use cohold_core::device::velocity::VelocityName;
use cohold_core::law::LawInfo;
use cohold_core::law::wave::Decode;
use cohold_core::names::Choice;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;

/// SplitMix64 (Steele, Lea & Flood 2014).
pub(crate) struct Random(u64);

impl Random {
    /// Number `seed`.
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// Uniform in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Equal chances by ratio.
    pub(crate) fn spread(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// One of these.
    pub(crate) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.bits() % of.len() as u64) as usize]
    }

    pub(crate) fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (self.bits() % u64::from(high - low + 1)) as u32
    }

    /// Nothing, a whole tick, or anything between, a third each.
    fn delay(&mut self) -> f64 {
        let between = self.unit();
        self.one(&[0.0, 1.0, between])
    }

    fn sometimes(&mut self, value: f64) -> f64 {
        self.one(&[0.0, value, value])
    }
}

/// A random linear scene: any law, decode, integrator, delay, one to sixteen ticks per packet, with and without arms.
pub(crate) fn scene(seed: u64) -> Scene {
    of_law(seed, None)
}

/// [`scene`], of this law if one is named.
pub(crate) fn of_law(seed: u64, law: Option<&'static str>) -> Scene {
    let mut random = Random::new(seed);
    let mut scene = Scene::new(cohold_guest_laws::laws());
    let peer = &mut scene.peer;
    peer.timing.control_period_s = random.one(&[0.0005, 0.001, 0.001, 0.002]);
    peer.timing.ticks_per_packet = random.whole(1, 16);
    peer.contact.stiffness_n_per_m = random.spread(10.0, 5000.0);
    let damping = random.spread(0.1, 20.0);
    peer.contact.damping_n_s_per_m = random.sometimes(damping);
    peer.object.mass_kg = random.spread(0.02, 2.0);
    let damping = random.spread(0.1, 5.0);
    peer.object.damping_n_s_per_m = random.sometimes(damping);
    peer.object.force_delay_ticks = random.delay();
    peer.object.integrator = random.one(IntegratorName::ALL);
    // The self-timed line has a suite of its own: its outstanding samples are no constant of the scene. One spring is not linear.
    let drawn = |law: &&LawInfo| !law.own_time && law.name != "fractal-impedance";
    let kinds: Vec<_> = cohold_laws::LAWS.iter().filter(drawn).collect();
    let drawn = random.one(&kinds).name;
    peer.coordination.comm = law.unwrap_or(drawn);
    peer.coordination.decode = random.one(Decode::ALL);
    peer.coordination.stiffness_n_per_m = random.spread(1.0, 1e5);
    let damping = random.spread(0.1, 20.0);
    peer.coordination.damping_n_s_per_m = random.sometimes(damping);
    peer.coordination.wave_impedance_n_s_per_m = random.spread(1.0, 100.0);
    if peer.check_with::<cohold_laws::EveryLaw<f64>>().is_err() {
        // A law that needs one solve.
        peer.object.integrator = IntegratorName::Midpoint;
    }
    if peer.object.integrator.solves() {
        // What it needs.
        peer.coordination.decode = Decode::Implicit;
        peer.object.force_delay_ticks = 0.0;
    }
    peer.coordination.cutoff_hz = random.spread(5.0, 500.0);
    peer.axis.velocity =
        random.one(&[VelocityName::Measured, VelocityName::Measured, VelocityName::Difference, VelocityName::Filtered]);
    peer.axis.velocity_cutoff_hz = random.spread(5.0, 240.0);
    let world = &mut scene.world;
    world.device.mass_kg = random.spread(0.02, 2.0);
    let damping = random.spread(0.1, 10.0);
    world.device.damping_n_s_per_m = random.sometimes(damping);
    world.device.force_delay_ticks = random.delay();
    world.network.one_way_delay_packets = random.whole(0, 8);
    // In every fourth scene the way back is longer, by whole packets and fractions.
    let packet_s = peer.timing.packet_period_s();
    let longer = packet_s * 3.0 * random.unit();
    world.network.asymmetry_s = random.one(&[0.0, 0.0, 0.0, longer]);
    world.network.extra_delay_s = random.one(&[0.0, 0.0, 0.0, longer]);
    // No arms, equal arms, two different arms, one arm.
    let case = random.whole(0, 4);
    for user in 0..2 {
        let arm = (random.spread(1.0, 1000.0), random.spread(0.1, 20.0), random.spread(0.01, 2.0));
        let to = &mut scene.users[user].settings.user;
        if case > 1 && !(case == 4 && user == 1) {
            (to.arm_stiffness_n_per_m, to.arm_damping_n_s_per_m, to.arm_mass_kg) = arm;
        }
    }
    if case == 2 {
        scene.users[1] = scene.users[0].clone();
    }
    scene
}
