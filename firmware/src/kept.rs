//! What a board keeps from one start to the next: its scene's settings and its addresses, key by key.
//!
//! Keys are those of [`Settings`], as scene files spell them, and `network.*`: docs/guides/board/operate.md says what each means.
//! Addresses are taken at the next start. They are no secret and prove nothing: who the other peer is says the key.

use core::{fmt, net::Ipv4Addr};

use cohold_core::device::velocity::VelocityName;
use cohold_core::names::{KinematicsName, MotorDrive};
use cohold_core::settings::{Allowed, Refused, SetError, Settings, Value};

use crate::image::{CURRENT_LOOP, JOINTS, SHARED};

/// Where this board and the others are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Addresses {
    /// Ask the network for an address instead.
    pub dhcp: bool,
    /// This board, if not as strapped.
    pub own: Option<Ipv4Addr>,
    /// Who leads out of its network.
    pub gateway: Option<Ipv4Addr>,
    /// The other peer, if not as strapped.
    pub peer: Option<Ipv4Addr>,
}

/// Settings, addresses, and what is wired, that a board keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// The settings of the scene.
    pub settings: Settings,
    /// The addresses of the board.
    pub addresses: Addresses,
    /// Motors run only while its hold-to-run switch is held ([`crate::switch`]).
    pub hold_switch: bool,
}

/// The settings of a board that nobody has configured: the scene defaults, of a device that its image is for, with a
/// velocity that encoders can give, and the limits of a device that nobody knows yet, beside a hand. These are raised
/// at the board only ([`crate::ceiling`]).
pub fn defaults() -> Settings {
    let mut settings = Settings::default();
    if SHARED > 1 {
        (settings.axis.count, settings.axis.shared) = (JOINTS as u32, SHARED as u32);
        settings.kinematics.model = KinematicsName::Arm;
        settings.coordination.comm = "passive-wave";
    }
    if !CURRENT_LOOP {
        settings.motor.drive = MotorDrive::Amplifier;
    }
    settings.axis.velocity = VelocityName::Filtered;
    settings.safety.max_force_n = 3.0;
    settings.safety.max_slew_n_per_s = 60.0;
    settings.safety.max_speed_m_per_s = 0.5;
    settings.safety.max_hand_power_w = 5.0;
    settings.safety.peer_lost_s = 0.5;
    settings.safety.workspace_m = 0.2;
    settings.safety.max_rms_force_n = 10.0;
    settings.safety.max_rms_power_w = 5.0;
    settings
}

impl Default for Kept {
    fn default() -> Self {
        Self { settings: defaults(), addresses: Addresses::default(), hold_switch: false }
    }
}

/// A value as a line spells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spelled {
    /// The value of a setting.
    Value(Value<'static>),
    /// The value of an address.
    Address(Ipv4Addr),
}

impl fmt::Display for Spelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Value(Value::Text(name)) => f.write_str(name),
            Self::Value(value) => value.fmt(f),
            Self::Address(address) => address.fmt(f),
        }
    }
}

/// An address's key: its name, the word for having none, what it accepts.
type AddressKey = (&'static str, &'static str, Allowed);
const OWN: AddressKey = ("network.address", "strap", Allowed::Only("an address such as 192.168.77.1, or strap"));
const GATEWAY: AddressKey = ("network.gateway", "none", Allowed::Only("an address such as 192.168.77.254, or none"));
const PEER: AddressKey = ("network.peer", "strap", Allowed::Only("an address such as 192.168.77.2, or strap"));
const DHCP: &str = "network.dhcp";
/// The key of [`Kept::hold_switch`].
pub const HOLD_SWITCH: &str = "board.hold_switch";

impl Addresses {
    fn of(&mut self, key: &str) -> Option<(&mut Option<Ipv4Addr>, AddressKey)> {
        [(&mut self.own, OWN), (&mut self.gateway, GATEWAY), (&mut self.peer, PEER)]
            .into_iter()
            .find(|(_, (name, ..))| *name == key)
    }

    fn set<'a>(&mut self, key: &str, value: Value<'a>) -> Result<(), SetError<'a>> {
        let refused = |key, allowed| Err(SetError::Refused(Refused { key, value, allowed, unit: "" }));
        if key == DHCP {
            let Value::Flag(dhcp) = value else { return refused(DHCP, Allowed::Flag) };
            self.dhcp = dhcp;
            return Ok(());
        }
        let (address, (name, nothing, allowed)) = self.of(key).ok_or(SetError::Unknown)?;
        let usable = |host: &Ipv4Addr| !(host.is_unspecified() || host.is_multicast() || host.is_broadcast());
        *address = match value {
            Value::Text(text) if text == nothing => None,
            Value::Text(text) => match text.parse().ok().filter(usable) {
                None => return refused(name, allowed),
                host => host,
            },
            _ => return refused(name, allowed),
        };
        Ok(())
    }

    fn get(mut self, key: &str) -> Option<Spelled> {
        if key == DHCP {
            return Some(Spelled::Value(Value::Flag(self.dhcp)));
        }
        let (address, (_, nothing, _)) = self.of(key)?;
        Some(address.map_or(Spelled::Value(Value::Text(nothing)), Spelled::Address))
    }
}

impl Kept {
    /// Every key, in an order that lines can be read back in. First what must hold whatever becomes of the others.
    pub fn keys() -> impl Iterator<Item = &'static str> {
        [HOLD_SWITCH].into_iter().chain(Settings::keys().map(|key| key.name)).chain([DHCP, OWN.0, GATEWAY.0, PEER.0])
    }

    /// Sets the key, if it accepts the value; otherwise nothing changes.
    ///
    /// # Errors
    /// A key that does not exist, or a value that it does not accept.
    pub fn set<'a>(&mut self, key: &str, value: Value<'a>) -> Result<(), SetError<'a>> {
        if key == HOLD_SWITCH {
            let Value::Flag(hold_switch) = value else {
                return Err(SetError::Refused(Refused { key: HOLD_SWITCH, value, allowed: Allowed::Flag, unit: "" }));
            };
            self.hold_switch = hold_switch;
            return Ok(());
        }
        match self.settings.set(key, value) {
            Err(SetError::Unknown) => self.addresses.set(key, value),
            done => done,
        }
    }

    /// The value of the key.
    pub fn get(&self, key: &str) -> Option<Spelled> {
        if key == HOLD_SWITCH {
            return Some(Spelled::Value(Value::Flag(self.hold_switch)));
        }
        self.settings.get(key).map(Spelled::Value).or_else(|| self.addresses.get(key))
    }
}
