//! Every key a peer understands: table, name, type, default, allowed range, unit and meaning, in one place.
//!
//! Scene files, `--set`, runtime settings over the network, help texts and sweeps all work from these tables and from the
//! keys that a coordination law declares beside itself, through [`crate::schema::Schema`]. Defaults are the cooperation
//! paper's §5 experiments. There is no value here that switches a guard off.

use crate::names::{
    Decode, FixtureName, IntegratorName, KinematicsName, Maths, MotorDrive, RenderingName, Side, VelocityName,
};

mod key;
mod law;

pub use crate::names::Choice;
pub use key::{Allowed, Key, Refused, SetError, Setting, Tables, Value, number};
pub use law::{LawInfo, MOST_OWN_KEYS, OwnValues, PLENTY_J, Promise, Sends};

use key::whole;

impl Timing {
    /// The packet period T_n, s.
    pub fn packet_period_s(&self) -> f64 {
        self.control_period_s * f64::from(self.ticks_per_packet)
    }

    /// Number of packet periods in `time_s` (s), to the nearest.
    pub fn packet_periods(&self, time_s: f64) -> u32 {
        // A cast saturates: positive, and at most 1000 s of 10 µs.
        (time_s / self.packet_period_s() + 0.5) as u32
    }

    /// The control period T_c to the nearest nanosecond, ns; simulated time advances by it.
    pub fn control_period_ns(&self) -> u64 {
        // Positive and at most 0.1 s.
        (1e9 * self.control_period_s + 0.5) as u64
    }

    /// The packet period T_n, ns: M times [`Timing::control_period_ns`].
    pub fn packet_period_ns(&self) -> u64 {
        self.control_period_ns() * u64::from(self.ticks_per_packet)
    }
}

impl Safety {
    /// Longest one-way delay of packets that are used, µs, as links measure it.
    pub fn max_delay_us(&self) -> u32 {
        // At most 1 s.
        (1e6 * self.max_delay_s) as u32
    }

    /// The same in ns.
    pub fn max_delay_ns(&self) -> u64 {
        1000 * u64::from(self.max_delay_us())
    }
}

crate::settings! {
    /// Every setting of a peer.
    pub struct Settings [
        /// Values of the keys that laws declare themselves, where they differ from the defaults.
        own: OwnValues
    ];

    /// The control period T_c and the packet period T_n = M·T_c.
    timing: Timing {
        control_period_s: f64 = 0.001, number(1e-5, 0.1), "s", "Control period T_c of the force loop.";
        ticks_per_packet: u32 = 8, whole(1, 1000), "", "Ticks per packet M; the packet period is T_n = M·T_c.";
    }

    /// Contact between the device and the local copy of the shared object.
    contact: Contact {
        rendering: RenderingName = RenderingName::Continuous, Allowed::Names(RenderingName::NAMES), "",
            "How contact is rendered: as a spring and a damper, or as impacts.";
        stiffness_n_per_m: f64 = 1000.0, number(0.0, 1e6), "N/m", "Contact stiffness K_LC.";
        damping_n_s_per_m: f64 = 2.0, number(0.0, 1e4), "N·s/m", "Contact damping B_LC.";
        one_sided: bool = false, Allowed::Flag, "", "Push only: no force unless the device is past the surface.";
        gap_m: f64 = 0.0, number(0.0, 1.0), "m", "Free travel before contact begins; two-sided, the play to each side.";
        side: Side = Side::Left, Allowed::Names(Side::NAMES), "",
            "Side of the object the device is on; of a pair, user 1 is on the left and user 2 on the right.";
        restitution: f64 = 1.0, number(0.0, 1.0), "",
            "Impulsive rendering: share of the speed of approach with which device and object part.";
        device_mass_kg: f64 = 0.1, number(1e-4, 1e3), "kg",
            "Impulsive rendering: mass with which the device takes part in an impact.";
    }

    /// The local copy of the shared virtual object.
    object: Object {
        mass_kg: f64 = 0.3, number(1e-4, 1e3), "kg", "Mass m_O of one copy.";
        damping_n_s_per_m: f64 = 0.0, number(0.0, 1e4), "N·s/m", "Viscous damping b_O of one copy.";
        force_delay_ticks: f64 = 1.0, number(0.0, 1.0), "ticks",
            "Delay τ of the forces that move the copy: the old force acts for τ·T_c, then the new one.";
        integrator: IntegratorName = IntegratorName::ForwardEuler, Allowed::Names(IntegratorName::NAMES), "",
            "How the copy advances by one tick.";
    }

    /// A virtual fixture at this peer's copy of the object: with integrator "midpoint" only.
    fixture: Fixture {
        kind: FixtureName = FixtureName::None, Allowed::Names(FixtureName::NAMES), "",
            "A guide to a place, or a wall that the object may not pass.";
        position_m: f64 = 0.0, number(-1000.0, 1000.0), "m", "Where it is, on the object's axis or along its normal.";
        stiffness_n_per_m: f64 = 500.0, number(0.0, 1e6), "N/m", "Its stiffness.";
        damping_n_s_per_m: f64 = 2.0, number(0.0, 1e4), "N·s/m", "Its damping.";
        direction_rad: f64 = 0.0, number(-6.3, 6.3), "rad",
            "Where its normal points, from the first axis toward the second, with axis.shared of 2 or 3.";
        elevation_rad: f64 = 0.0, number(-1.6, 1.6), "rad",
            "Where its normal points, from these two axes toward the third, with axis.shared = 3.";
        drag_n_s_per_m: f64 = 0.0, number(0.0, 1e4), "N·s/m",
            "Viscous friction across its normal, of a wall while it is touched, with axis.shared of 2 or 3.";
        friction: f64 = 0.0, number(0.0, 10.0), "",
            "Coulomb friction along a wall over what it pushes with, with axis.shared of 2 or 3.";
    }

    /// What holds the two copies together.
    coordination: Coordination {
        comm: &'static str = "passive-wave", Allowed::Laws(&[]), "", "Coordination law, by what it sends.";
        decode: Decode = Decode::Delayed, Allowed::Names(Decode::NAMES), "",
            "How the wave decode's algebraic loop is opened.";
        stiffness_n_per_m: f64 = 10620.0, number(0.0, 1e7), "N/m", "Coordination stiffness K_T.";
        damping_n_s_per_m: f64 = 2.0, number(0.0, 1e4), "N·s/m", "Coordination damping B_T.";
        wave_impedance_n_s_per_m: f64 = 10.0, number(1e-3, 1e4), "N·s/m", "Wave impedance b.";
        cutoff_hz: f64 = 60.0, number(0.01, 1e5), "Hz", "Cutoff of the anti-aliasing filter, Ω_c/2π.";
        ledger: bool = false, Allowed::Flag, "",
            "Never emit more wave energy than the other peer is known to have absorbed: passive on any network.";
        drift_correction: bool = false, Allowed::Flag, "",
            "Make good what losses took from the wave integral, paid from the ledger; with comm \"passive-mean\".";
    }

    /// How positions and velocities are sensed.
    axis: Axis {
        count: u32 = 1, whole(1, 3), "", "Axes in use; the first ones are free (axis.shared), the others are held on their line.";
        shared: u32 = 1, whole(1, 3), "", "Axes along which the object is shared, the first ones of axis.count.";
        velocity: VelocityName = VelocityName::Measured, Allowed::Names(VelocityName::NAMES), "",
            "Where the velocity of an axis comes from.";
        velocity_cutoff_hz: f64 = 100.0, number(0.1, 1e4), "Hz", "Cutoff of the filtered velocity estimator.";
        velocity_window_ticks: u32 = 16, whole(2, 16), "ticks", "Longest window of the adaptive velocity estimator.";
        hold_stiffness_n_per_m: f64 = 1500.0, number(0.0, 1e5), "N/m",
            "Stiffness that holds every axis that is not shared on its line.";
        hold_damping_n_s_per_m: f64 = 3.0, number(0.0, 1e4), "N·s/m",
            "Damping that holds every axis that is not shared on its line.";
    }

    /// The position encoder of every joint.
    encoder: Encoder {
        counts_per_m: f64 = 200000.0, number(1.0, 2e8), "counts/m",
            "Counts per metre, where a joint is a slide (kinematics \"direct\").";
        counts_per_rev: f64 = 8192.0, number(16.0, 1e7), "counts/rev",
            "Counts per revolution, where a joint turns (every other kinematics).";
        reversed: bool = false, Allowed::Flag, "", "Counts grow against the axis.";
        index: bool = false, Allowed::Flag, "",
            "The encoders have an index: the first sets the position, and each one after it tells lost counts.";
        index_at_m_or_rad: f64 = 0.0, number(-100.0, 100.0), "m or rad",
            "Where a joint is at its index (its first one after a start, whose turn is then the one meant), with encoder.index.";
        max_speed_m_per_s: f64 = 10.0, number(0.01, 100.0), "m/s",
            "Fastest that the device can move; an encoder that goes further between two readings has jumped.";
    }

    /// The mechanism between the joints (encoders, motors) and the axes of the task, with its lengths.
    kinematics: Kinematics {
        model: KinematicsName = KinematicsName::Direct, Allowed::Names(KinematicsName::NAMES), "", "Kind of mechanism.";
        maths: Maths = Maths::Libm, Allowed::Names(Maths::NAMES), "",
            "Which sine and cosine the mechanism is computed with.";
        capstan_ratio: f64 = 10.0, number(0.1, 1000.0), "", "Capstan: motor turns per paddle turn.";
        paddle_radius_m: f64 = 0.08, number(0.001, 1.0), "m", "Capstan: distance of the hand from the paddle's axis.";
        base_m: f64 = 0.06, number(0.0, 1.0), "m", "Five-bar: distance between the two motors.";
        proximal_m: f64 = 0.1, number(0.01, 1.0), "m", "Five-bar: length of the links at the motors; arm: of the link at the base, level at home.";
        distal_m: f64 = 0.12, number(0.01, 1.0), "m", "Five-bar: length of the links at the hand; arm: of the one at the hand, upright at home.";
        left_home_rad: f64 = core::f64::consts::PI - core::f64::consts::FRAC_PI_3, number(-6.3, 6.3), "rad",
            "Five-bar: angle of the left link from the base where its joint is zero.";
        right_home_rad: f64 = core::f64::consts::FRAC_PI_3, number(-6.3, 6.3), "rad",
            "Five-bar: angle of the right link from the base where its joint is zero.";
    }

    /// How much larger the shared world is than this device; each of the two peers has its own.
    scale: Scale {
        position: f64 = 1.0, number(0.1, 10.0), "", "Metres of the world to a metre of the device.";
        force: f64 = 1.0, number(0.1, 10.0), "",
            "Newtons of the world to a newton of the device. Limits, axis.hold and all that is the device's stay in the device's units.";
    }

    /// The motor and amplifier of every joint.
    motor: Motor {
        newton_or_newton_metre_per_a: f64 = 8.0, number(1e-4, 1e3), "N/A or N·m/A",
            "Force (direct) or torque (turning joint) per ampere.";
        drive: MotorDrive = MotorDrive::CurrentLoop, Allowed::Names(MotorDrive::NAMES), "",
            "On a board, what makes a current of a duty, as it is wired; a simulated device has its own, plant.drive.";
        full_scale_a: f64 = 5.0, number(1e-3, 1e3), "A", "Current at full duty.";
        max_duty: f64 = 0.95, number(0.01, 1.0), "",
            "Largest duty the amplifier may be given, as a fraction of full scale.";
        reversed: bool = false, Allowed::Flag, "", "Positive duty pushes against the axis.";
        resistance_ohm: f64 = 4.8, number(0.001, 1e4), "Ω", "Resistance R of the winding, for the current loop.";
        inductance_h: f64 = 0.0005, number(1e-6, 10.0), "H", "Inductance L of the winding, for the current loop.";
        current_loop_hz: f64 = 1000.0, number(50.0, 2000.0), "Hz",
            "Crossover of the current loop; phase margin 63° at 1000 and 36° at 2000, after a negative voltage 54° and 18°.";
        back_emf_forward: bool = false, Allowed::Flag, "",
            "The current loop adds the voltage that the motor makes by moving, from the joint's speed.";
        sense_a: f64 = 6.875, number(1e-3, 1e3), "A",
            "Current that would take its sensor to either supply rail, which its amplifier does not reach; at least 1.28 times the largest asked for.";
        emf_tolerance_v: f64 = 0.6, number(0.01, 60.0), "V",
            "With a current loop: voltage that dead time, sensors and brushes may take, unseen by the check of encoders against the motor.";
        min_supply_v: f64 = 18.0, number(5.0, 65.0), "V",
            "Least supply of the bridges, where it is measured; below it the motors go off.";
        max_supply_v: f64 = 30.0, number(5.0, 65.0), "V",
            "Largest supply of the bridges, where it is measured; above it the motors go off.";
        continuous_a: f64 = 2.0, number(1e-3, 1e3), "A", "Current that the winding bears for ever.";
        thermal_s: f64 = 30.0, number(0.1, 1e4), "s", "Time constant with which the winding warms.";
        thermistor: bool = false, Allowed::Flag, "",
            "A thermistor of 10 kΩ at a motor limits its force, too; only on a board with a current loop.";
        thermistor_b_k: f64 = 3950.0, number(2500.0, 4500.0), "K", "Constant B of the thermistor.";
        max_temperature_c: f64 = 80.0, number(40.0, 125.0), "°C",
            "Temperature of the thermistor at which its motor is too warm; the force falls from half of the way from 25 °C on.";
        friction_n: f64 = 0.0, number(0.0, 20.0), "N",
            "Dry friction along each axis that the motors take over; at most 0.8 of what the device has.";
        cogging_n_or_n_m: f64 = 0.0, number(0.0, 20.0), "N or N·m",
            "Amplitude of the cogging that the motor cancels at its joint, with encoder.index and one axis; 0 cancels nothing.";
        cogging_period_m_or_rad: f64 = 0.01, number(1e-4, 10.0), "m or rad",
            "Distance from one detent of the motor to the next; of a joint that turns a whole part of a turn.";
        cogging_at_m_or_rad: f64 = 0.0, number(-10.0, 10.0), "m or rad",
            "Where the joint is when its cogging is 0 and pushes it on, whichever way it leaves: half a period from a detent.";
    }

    /// Limits of force, speed, power and silence that hold whatever the other tables say.
    safety: Safety {
        max_force_n: f64 = 40.0, number(0.01, 200.0), "N", "Largest force on any axis: what is asked beyond it neither hand nor object gets, for as long as it is asked.";
        max_slew_n_per_s: f64 = 20000.0, number(1.0, 1e6), "N/s",
            "Fastest growth of a force on any axis, away from zero; a force falls at once.";
        max_speed_m_per_s: f64 = 10.0, number(0.01, 100.0), "m/s",
            "Speed above which an armed device brakes, with up to max_force_n; at 1.5 times it the peer faults.";
        workspace_m: f64 = 100.0, number(0.001, 1000.0), "m",
            "Farthest that an axis may be from where the encoders were first read, while armed.";
        max_rms_force_n: f64 = 40.0, number(0.01, 200.0), "N",
            "Largest force on the hand over rms_s, as a leaky root-mean-square over all axes; what is asked beyond it neither hand nor object gets.";
        max_rms_power_w: f64 = 100.0, number(0.01, 1000.0), "W",
            "Most power that the device may give the hand over rms_s, as a leaky root-mean-square; near it the device has less force.";
        rms_s: f64 = 1.0, number(0.01, 100.0), "s", "Time over which force and power on the hand are averaged.";
        saturated_ticks: u32 = 100, whole(1, 10000), "ticks",
            "Ticks of a motor at motor.max_duty, counted up while at it and down while off it, before the peer faults.";
        fade_s: f64 = 0.024, number(0.0, 100.0), "s",
            "Silence through which the last packet stands.";
        disengage_s: f64 = 0.096, number(1e-5, 100.0), "s",
            "Silence after which the peer disengages.";
        peer_lost_s: f64 = 10.0, number(1e-5, 1000.0), "s",
            "Silence of a peer that was heard before, after which the peer faults.";
        max_delay_s: f64 = 0.25, number(0.001, 1.0), "s",
            "Longest delay of the other peer's packets, one way, as measured by half of the way there and back; older ones \
             are as silence.";
        operator_lost_s: f64 = 0.2, number(0.1, 100.0), "s",
            "Lease: how long a board's motors stay on after its operator last let them, at the most, unless it was armed alone; \
             an operator whose round trip is longer cannot arm.";
        clutch_s: f64 = 0.1, number(0.01, 10.0), "s", "Time over which the clutch opens, and closes.";
        stuck_duty: f64 = 0.25, number(0.01, 0.5), "",
            "Change of a motor's duty, as a fraction of full scale, under which its encoder must count; at most half of max_force_n.";
        max_hand_power_w: f64 = 100.0, number(0.1, 1000.0), "W",
            "Most power that a hand can feed the device; above it the peer faults.";
    }

    /// Limits of what a motor does open loop, for calibration and for the check before arming.
    probe: Probe {
        max_duty: f64 = 0.1, number(0.001, 0.5), "", "Largest duty of a probe, as a fraction of full scale.";
        max_travel_counts: u32 = 4000, whole(10, 30000), "counts",
            "Farthest that a probe may move its joint from where it began.";
        max_speed_counts_per_s: f64 = 200000.0, number(100.0, 3e7), "counts/s",
            "Fastest that a probe may move its joint.";
        max_s: f64 = 3.0, number(0.01, 10.0), "s", "Longest probe.";
        check_duty: f64 = 0.02, number(0.001, 0.1), "",
            "Duty of the check before arming, as a fraction of full scale; at most probe.max_duty.";
        check_s: f64 = 0.04, number(0.02, 0.4), "s", "Time that the check before arming takes, for one joint.";
        check_counts: u32 = 20, whole(16, 1000), "counts",
            "Counts that the motor must move its joint by for the check to tell which way.";
    }
}

impl Settings {
    /// Tables whose values two coupled peers must share; the rest belongs to each device.
    const SHARED: [&'static str; 3] = ["timing", "object", "coordination"];

    /// Value of a key that a law declares itself, or its default, in the key's unit; of a flag 1 or 0.
    pub fn own(&self, key: &Key) -> f64 {
        self.own.get(key)
    }

    /// The value of a law's own key as a flag or a number.
    pub(crate) fn own_value(&self, key: &Key) -> Value<'static> {
        let number = self.own(key);
        if key.allowed == Allowed::Flag { Value::Flag(number != 0.0) } else { Value::Number(number) }
    }

    /// Refuses the first of these values that does not fit where they are to be run: its key, whether it fits, what would.
    ///
    /// # Errors
    /// That one.
    pub fn all_fit(&self, values: &[(&'static str, bool, &'static str)]) -> Result<(), Refused<'static>> {
        let wrong = values.iter().find(|(_, fits, _)| !fits);
        wrong.map_or(Ok(()), |(key, _, only)| Err(Refused { unit: "", ..self.refuses(key, Allowed::Only(only)) }))
    }

    /// That the value of a key of these tables is not `allowed` beside the others.
    pub fn refuses(&self, name: &'static str, allowed: Allowed) -> Refused<'static> {
        let unit = <Self as Tables>::KEYS.iter().find(|key| key.name == name).map_or("", |key| key.unit);
        Refused { key: name, value: Tables::get(self, name).unwrap_or(Value::Flag(false)), allowed, unit }
    }

    /// Refuses the value of the number called `name` if it is not `allowed` beside the others.
    pub(crate) fn within(&self, name: &'static str, allowed: Allowed) -> Result<(), Refused<'static>> {
        let (min, max) = match allowed {
            Allowed::Number { min, max } => (min, max),
            Allowed::Whole { min, max } => (f64::from(min), f64::from(max)),
            _ => return Ok(()),
        };
        match Tables::get(self, name) {
            Some(Value::Number(number)) if !(number >= min && number <= max) => Err(self.refuses(name, allowed)),
            _ => Ok(()),
        }
    }

    /// The settings that two coupled peers must share: of each key its table, its name there and its value, table by
    /// table; of laws' own keys those that are not at their default; and how many axes are shared, where that is not one.
    pub fn common(&self) -> impl Iterator<Item = (&'static str, &'static str, Value<'static>)> + '_ {
        let tables = <Self as Tables>::KEYS.iter().filter_map(|key| {
            let (table, short) = key.name.split_once('.').filter(|(table, _)| Self::SHARED.contains(table))?;
            Some((table, short, Tables::get(self, key.name)?))
        });
        let own = self.own.iter().filter_map(|(key, number)| {
            key.name.split_once('.').map(|(table, short)| (table, short, Value::Number(number)))
        });
        let several = (self.axis.shared > 1).then(|| ("axis", "shared", Value::Number(self.axis.shared.into())));
        tables.chain(own).chain(several)
    }
}
