//! The world around the peers, as settings: devices and their imperfections, and the network.

use cohold_core::device::motor::Duty;
use cohold_core::settings::{Allowed, Choice, number};

use crate::network::fitted::Like;

crate::choices! {
    /// How the delay varies.
    Jitter {
        "none" => None, "The delay does not vary.";
        "uniform" => Uniform, "Uniformly from 0 to jitter_s.";
        "gamma" => Gamma, "Gamma-distributed with shape 2 and mean jitter_s.";
        "pareto" => Pareto, "Heavy-tailed: Pareto-distributed (Lomax) with shape 2, cut at 100 times its mean jitter_s.";
    }

    /// What a motor's duty means to a simulated winding.
    DriveName {
        "voltage" => Voltage, "A voltage, as a share of the supply.";
        "current" => Current, "A current: the reference of cohold-core's current loop.";
    }

    /// A simulated failure of the first joint of the first device, its motor, power stage or encoder.
    PlantFault {
        "none" => None, "No failure.";
        "open-motor" => OpenMotor, "A wire of the motor is disconnected.";
        "shorted-motor" => ShortedMotor, "The wires of the motor are short-circuited.";
        "dead-sense" => DeadSense, "The current's sensor reads zero.";
        "reversed-sense" => ReversedSense, "The two wires of the current's sensor are swapped.";
        "sense-at-end" => SenseAtEnd, "The current's sensor reads the end of its range.";
        "conducting-bridge" => ConductingBridge, "The bridge gives a fifth of its supply while it is off.";
        "ignored-enable" => IgnoredEnable, "The bridge drives its motor whether or not it is enabled.";
        "low-supply" => LowSupply, "The supply voltage of the bridges falls to 0.6 of its value.";
        "high-supply" => HighSupply, "The supply voltage of the bridges rises to 1.4 of its value.";
        "held" => Held, "The device is held fast, so that it cannot move.";
        "encoder-stuck" => EncoderStuck, "The encoder does not count any more.";
        "encoder-without-a" => EncoderWithoutA, "Channel A of the encoder is dead.";
        "encoder-without-b" => EncoderWithoutB, "Channel B of the encoder is dead.";
        "encoder-dithers" => EncoderDithers, "The encoder does not follow the joint, but alternates by one count from tick to tick.";
        "encoder-reversed" => EncoderReversed, "The encoder counts in the wrong direction.";
        "encoder-halved" => EncoderHalved, "The encoder counts only half of the edges.";
        "encoder-loses" => EncoderLoses, "The encoder loses 40 counts, once.";
    }
}

cohold_core::settings! {
    /// Settings of the world around the peers: devices and their imperfections, and the network.
    pub struct World;

    /// The haptic device, of which each user holds one, unless one end has its own.
    device: Device {
        mass_kg: f64 = 0.1, number(1e-4, 1e3), "kg", "Moving mass m_HD.";
        damping_n_s_per_m: f64 = 1.0, number(0.0, 1e4), "N·s/m", "Viscous damping b_HD.";
        force_delay_ticks: f64 = 1.0, number(0.0, Device::MOST_DELAY_TICKS), "ticks",
            "Delay from sensing to the new motor force, in control periods.";
        joint_inertia: f64 = 0.0, number(0.0, 1e3), "kg or kg·m²",
            "What slides or turns with every joint beside that, with axis.shared of 2 or 3: at the hand it weighs as the mechanism at home has it,              which couples the axes.";
    }

    /// Imperfections of the device; each is off unless asked for.
    plant: PlantSettings {
        encoder: bool = false, Allowed::Flag, "",
            "The peer reads encoder counts (tables encoder, kinematics) instead of the exact position.";
        coulomb_n: f64 = 0.0, number(0.0, 100.0), "N", "Coulomb friction; 0 is none.";
        cogging_n_or_n_m: f64 = 0.0, number(0.0, 100.0), "N or N·m",
            "Amplitude of the motor's cogging at the joint of a device of one axis; its period is motor.cogging_period_m_or_rad.";
        cogging_at_m_or_rad: f64 = 0.0, number(-10.0, 10.0), "m or rad",
            "The place of this cogging, as motor.cogging_at_m_or_rad is where the motor takes it to be.";
        motor: bool = false, Allowed::Flag, "",
            "The device is driven by motor duties (table motor), saturation included, instead of the exact force.";
        pwm_steps: u32 = 0, Allowed::Whole { min: 0, max: 32767 }, "",
            "PWM steps from zero to full duty, with plant.motor; 0 is as fine as the duty register.";
        winding: bool = false, Allowed::Flag, "",
            "The motors have windings (R, L and back-EMF of table motor) behind a bridge that is a voltage, with plant.motor; the delay \
             of the force is theirs then, and device.force_delay_ticks says nothing.";
        drive: DriveName = DriveName::Voltage, Allowed::Names(DriveName::NAMES), "",
            "What a duty is to a winding: a share of the supply, or the reference of the current loop.";
        supply_v: f64 = 24.0, number(6.0, 60.0), "V", "Supply of the bridges.";
        dead_time_s: f64 = 0.0, number(0.0, 5e-6), "s", "Time at each edge in which neither switch of a leg is on.";
        resistance_ratio: f64 = 1.0, number(0.5, 2.0), "",
            "Resistance of the windings over motor.resistance_ohm; 1.24 is 60 K warmer copper.";
        current_bits: u32 = 12, Allowed::Whole { min: 8, max: 16 }, "bits",
            "Converter of the current, from -motor.sense_a to motor.sense_a.";
        current_noise_a: f64 = 0.0032, number(0.0, 1.0), "A", "Noise of the current's sensor, root mean square.";
        current_zero_a: f64 = 0.0, number(-1.0, 1.0), "A", "What the current's sensor reads while none flows.";
        fault: PlantFault = PlantFault::None, Allowed::Names(PlantFault::NAMES), "",
            "What goes wrong with the first joint of device 1: its motor and power stage (with plant.drive = \"current\"), its encoder, or its hand.";
        fault_at_s: f64 = 1.0, number(0.0, 1e6), "s", "When it does.";
    }

    /// The network between the peers.
    network: Network {
        one_way_delay_packets: u32 = 1, Allowed::Whole { min: 0, max: 1000 }, "packets",
            "One-way delay n_t in packet periods.";
        extra_delay_s: f64 = 0.0, number(0.0, 2.0), "s", "Constant time on top of the delay, both ways.";
        asymmetry_s: f64 = 0.0, number(0.0, 2.0), "s", "Constant time on top of the delay, from peer 2 to peer 1 only.";
        delay_step_s: f64 = 0.0, number(-2.0, 2.0), "s",
            "From network.delay_step_at_s on, the delay is longer (or shorter) by this.";
        delay_step_at_s: f64 = 0.0, number(0.0, 1e6), "s", "When the delay steps.";
        like: Like = Like::None, Allowed::Names(Like::NAMES), "",
            "A network that was measured, whose delay varies and which loses as that one did; of the other keys only constant delays, drift and seed count then.";
        jitter: Jitter = Jitter::None, Allowed::Names(Jitter::NAMES), "", "How the delay varies from packet to packet.";
        jitter_s: f64 = 0.0, number(0.0, 2.0), "s", "Uniform jitter: the most; gamma and Pareto jitter: the mean.";
        loss: f64 = 0.0, number(0.0, 0.95), "", "Fraction of the packets that are lost.";
        loss_burst_packets: f64 = 1.0, number(1.0, 1e4), "packets",
            "Mean length of a run of losses (Gilbert-Elliott); 1 is independent losses.";
        reorder: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that are held back and overtaken.";
        reorder_depth_packets: u32 = 4, Allowed::Whole { min: 1, max: 1000 }, "packets",
            "How far a packet is held back at the most.";
        reverse_block_packets: u32 = 0, Allowed::Whole { min: 0, max: 64 }, "packets",
            "Every block of this many packets arrives in reverse order, once its last is sent; 0 and 1 change nothing.";
        duplicate: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that arrive twice.";
        corrupt: f64 = 0.0, number(0.0, 1.0), "", "Fraction of the packets that arrive broken.";
        clock_drift_ppm: f64 = 0.0, number(-10000.0, 10000.0), "ppm", "How much slower peer 2's clock runs.";
        bandwidth_bit_per_s: f64 = 0.0, number(0.0, 1e12), "bit/s", "Rate of the line; 0 is unlimited.";
        playout_packets: u32 = 0, Allowed::Whole { min: 0, max: 32 }, "packets",
            "Play-out buffer: packets wait until they are this much later than the fastest, so that the delay is constant.";
        seed: u32 = 1, Allowed::Whole { min: 0, max: u32::MAX }, "", "Seed of everything random in a run.";
    }
}

impl PlantSettings {
    /// Timer counts of full duty, at which a bridge gives its whole supply.
    pub fn timer_counts(&self) -> u16 {
        match self.pwm_steps {
            0 => Duty::FULL_SCALE.unsigned_abs(),
            // At most 15 bits.
            steps => steps as u16,
        }
    }
}

impl Device {
    /// The longest delay from sensing to force that a device may have, in control periods.
    pub const MOST_DELAY_TICKS: f64 = 20.0;

    /// Its delay as whole control periods for which a force is held back, and the part of the next one that passes before it acts.
    pub fn delay(&self) -> (usize, f64) {
        let whole = (self.force_delay_ticks.ceil() - 1.0).max(0.0);
        (whole as usize, self.force_delay_ticks - whole)
    }
}
