//! The energy ledger of a wave line (`coordination.ledger`), which makes it passive on any network: the receiver never
//! emits more wave energy than the sender is known to have absorbed.
//!
//! Every packet carries the sender's cumulative ½·T_c·Σu_out² up to its last tick. What is new in it is credit; every tick
//! of u_in spends ½·T_c·u_in² of it, and a tick that would overdraw is scaled down to what is left. So Σ emitted ≤ Σ sent
//! for any delay, jitter, loss, reorder and duplication, without a clock (THEORY §5): late, lost or repeated counters are
//! only conservative. Holding the last sample through a loss is allowed for as long as there is credit.
//!
//! What a loss still causes is drift: part of ∫u dt is missing. With **drift correction** packets carry that integral too;
//! what was sent and not yet emitted is added to u_in over the next packets. It may spend only what lies above a reserve:
//! the reserve holds the wave through the next loss, and a correction that spends it loses more than it restores (the
//! same integral in fewer ticks costs more energy). Measured by `cohold study networks`.
//!
//! Credit is capped at [`CAP_J`]: dissipation of minutes must not come back as one blow.

use super::{LawInfo, Packet};
use crate::num::{Scalar, Sum};
use crate::settings::{Allowed, Refused, Settings};

/// Most credit that is kept, J: what a hand feels as a light tap.
pub const CAP_J: f64 = 0.1;

/// Packets over which a missing part of the wave integral is made good.
const CORRECTION_PACKETS: f64 = 4.0;

/// Refuses a ledger for a law whose waves it cannot pay for.
pub(crate) fn check(settings: &Settings, law: &LawInfo) -> Result<(), Refused<'static>> {
    let coordination = &settings.coordination;
    if law.scatters {
        return Ok(());
    }
    for (key, on) in
        [("coordination.ledger", coordination.ledger), ("coordination.drift_correction", coordination.drift_correction)]
    {
        if on {
            return Err(settings.refuses(key, Allowed::Only("false, unless coordination.comm is a kind of wave")));
        }
    }
    Ok(())
}

/// Packets of the present wave that are kept for holding through losses before anything is corrected.
const RESERVE_PACKETS: f64 = 32.0;

/// Share of what lies above the reserve that one packet's correction may cost.
const SHARE: f64 = 0.1;

/// Parameters of the credit that pays for incoming waves.
#[derive(Clone, Copy, Debug)]
pub struct Credit<S: Scalar> {
    /// ½·T_c, s.
    half_period: S,
    /// 2/T_c, 1/s.
    twice_rate: S,
    period: S,
    /// M·T_c, s: what one sample held for a packet adds to the integral.
    packet_s: S::Counter,
    cap: S,
    corrects: bool,
}

configured!([S: Scalar] Credit<S> { half_period, twice_rate, period, packet_s, cap, corrects });

/// Credit left to spend, and the wave integral still to be made good.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Account<S: Scalar> {
    /// Sender's energy counter and wave integral in the newest packet, J and √W·s.
    seen: Option<(S::Counter, S::Counter)>,
    /// Wave energy that may still be emitted, J.
    left: S,
    /// ∫u_in dt emitted so far, √W·s.
    emitted: Sum<S>,
    /// ∫u dt of the sender at the point where `emitted` was 0, √W·s.
    origin: S::Counter,
    /// Added to u_in until the next packet, √W.
    correction: S,
}

impl<S: Scalar> Credit<S> {
    /// The scene's ledger, if it asks for one (`coordination.ledger`).
    pub fn build(settings: &Settings) -> Option<Self> {
        let (timing, coordination) = (&settings.timing, &settings.coordination);
        coordination.ledger.then(|| Self {
            half_period: S::from_f64(0.5 * timing.control_period_s),
            twice_rate: S::from_f64(2.0 / timing.control_period_s),
            period: S::from_f64(timing.control_period_s),
            packet_s: S::Counter::from_f64(timing.packet_period_s()),
            cap: S::from_f64(CAP_J),
            corrects: coordination.drift_correction,
        })
    }

    /// Adds the energy that a packet's counters newly announce to the credit.
    pub fn receive(&self, account: &mut Account<S>, packet: &Packet<S>) {
        let (nothing, half) = (S::Counter::ZERO, S::Counter::from_f64(0.5));
        let wave = packet.wave.to_counter();
        let (energy, integral) = (packet.energy_j, packet.wave_integral);
        let (seen, _) = *account.seen.get_or_insert_with(|| {
            // The first packet of a session pays for itself and brings no past.
            let own = half * self.packet_s * wave * wave;
            account.origin = integral - self.packet_s * wave;
            (if energy > own { energy - own } else { nothing }, integral)
        });
        if energy <= seen {
            // Nothing new: a packet that stands through silence has been paid for, and mends nothing.
            account.correction = S::ZERO;
            return;
        }
        account.seen = Some((energy, integral));
        account.left = (account.left + S::of_counter(energy - seen)).min(self.cap);
        if self.corrects {
            let [packets, reserve, share] = [CORRECTION_PACKETS, RESERVE_PACKETS, SHARE].map(S::Counter::from_f64);
            let missing = integral - account.origin - account.emitted.total().to_counter() - self.packet_s * wave;
            let target = wave + missing.over(packets * self.packet_s);
            let price = half * self.packet_s * wave * wave;
            let spare = share * (account.left.to_counter() - reserve * price);
            let more = if spare > nothing { spare.over(half * self.packet_s) } else { nothing };
            let most = (wave * wave + more).sqrt();
            account.correction = S::of_counter(target.limit(most) - wave);
        }
    }

    /// The wave (√W) that may be emitted this tick when `held` was received last.
    #[inline]
    pub fn spend(&self, account: &mut Account<S>, held: S) -> S {
        let wanted = held + account.correction;
        let price = self.half_period * wanted * wanted;
        let wave = if price <= account.left {
            account.left = account.left - price;
            wanted
        } else {
            let most = (account.left * self.twice_rate).sqrt();
            account.left = S::ZERO;
            wanted.limit(most)
        };
        account.emitted.add(self.period * wave);
        wave
    }
}
