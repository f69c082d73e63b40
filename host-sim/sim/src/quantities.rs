//! What is told of one peer, with unit and meaning: simulated, live and board's columns call the same quantity the same.

/// A column: its name, which ends in its unit, and what it means.
pub type Named = (&'static str, &'static str);

/// Of a board's or a live peer's tick.
pub const TICK: Named = ("tick", "control periods since the recording began; of a board since it started");
/// See [`haptic_core::safety::Mode`].
pub const MODE: Named = ("mode", "0 disarmed, 1 armed, 2 faulted, 3 a board that probes its motors");
/// See [`haptic_core::safety::Fault`].
pub const FAULT: Named = ("fault", "number of the fault, 0 none");
/// Of the device.
pub const DEVICE: Named = ("device_m", "position of the device");
/// Of the device.
pub const DEVICE_SPEED: Named = ("device_m_per_s", "velocity of the device, as the peer measures it");
/// Of the copy.
pub const OBJECT: Named = ("object_m", "position of this peer's copy of the object");
/// Of the copy.
pub const OBJECT_SPEED: Named = ("object_m_per_s", "velocity of this copy");
/// Of the other copy.
pub const DECODED: Named = ("decoded_m", "where the peer believes the other copy to be, x_d");
/// Of the other copy.
pub const DECODED_SPEED: Named = ("decoded_m_per_s", "how fast the peer believes the other copy to move");
/// F_LC.
pub const CONTACT: Named = ("contact_n", "contact force F_LC on the copy");
/// F_T.
pub const COORDINATION: Named = ("coordination_n", "coordination force F_T on the copy");
/// From the network.
pub const ENERGY_RECEIVED: Named = ("energy_received_j", "energy that came in from the network, since arming");
/// To the network.
pub const ENERGY_SENT: Named = ("energy_sent_j", "energy that went out to the network, since arming");
/// To the copy.
pub const ENERGY_TO_OBJECT: Named =
    ("energy_to_object_j", "work of F_T on the copy, at the mean velocity of the copy over a tick, since arming");
/// From the copy.
pub const ENERGY_FROM_OBJECT: Named = (
    "energy_from_object_j",
    "work of the copy against F_T, at the mean velocity of the copy over a tick, since arming",
);
/// Of both.
pub const TRUE_DISCREPANCY: Named = ("true_discrepancy_m", "distance of the two copies at one instant, |x_o1 - x_o2|");
