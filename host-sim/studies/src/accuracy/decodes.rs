//! The two decodes of the wave, each against the closed form of the line's end.
//!
//! The copy moves by x_o = 5 mm·sin(2π·2 Hz·t), whatever is decoded; u_in is a sine of the same frequency, 1 rad ahead,
//! held for each packet of 8 ticks. Between packets (b + B_T)·ṡ + K_T·s = √(2b)·u_in − b·ẋ_o for s = x_d − x_o, of which
//! the solution is an exponential of time constant (b + B_T)/K_T and a sine. The largest error of F_T comes at new packets,
//! so the mean square is what is compared. Two stiffnesses of the paper; b and B_T of its §5; f32; unit N and m.
//!
//! Alone like this the delayed decode is stable up to K_T = (b + B_T)/T_c, 12 000 N/m here, and rings below it.

use cohold_cases::line::{AMPLITUDE_M, ANGULAR_RAD_PER_S, local, wave};
use cohold_core::law::wave::Decode;
use cohold_core::law::{AnyLaw, Law, Observation};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::Staged;
use cohold_core::settings::{Choice, Refused, Settings};
use cohold_report::significant;

use super::{Comparison, Family, counts::Processor, rms};

pub use cohold_cases::line::{input, settings, ticks};

/// Coordination stiffnesses, N/m: those the paper found for the two wave communications.
const STIFFNESSES: [f64; 2] = [1590.0, 10_620.0];
/// s = x_d − x_o (m) and F_T (N) at every tick, in closed form.
pub fn closed_form(settings: &Settings) -> Vec<(f64, f64)> {
    let line = &settings.coordination;
    let (stiffness, damping, b) = (line.stiffness_n_per_m, line.damping_n_s_per_m, line.wave_impedance_n_s_per_m);
    let (root, lag) = ((2.0 * b).sqrt(), (b + damping) / stiffness);
    let turn = ANGULAR_RAD_PER_S * lag;
    // Answer to −b·ẋ_o alone: a sine that lags.
    let forced = |time_s: f64| {
        let (sine, cosine) = (ANGULAR_RAD_PER_S * time_s).sin_cos();
        -b * AMPLITUDE_M * ANGULAR_RAD_PER_S / stiffness * (cosine + turn * sine) / (1.0 + turn * turn)
    };
    let (mut stretch, mut held) = (0.0, 0.0);
    let period_s = settings.timing.control_period_s;
    let at = |tick: usize| {
        let time_s = tick as f64 * period_s;
        if tick.is_multiple_of(settings.timing.ticks_per_packet as usize) {
            held = wave(time_s);
        }
        let change = (root * held - stiffness * stretch - b * local(time_s).velocity) / (b + damping);
        let now = (stretch, stiffness * stretch + damping * change);
        let steady = root * held / stiffness;
        stretch = steady + forced(time_s + period_s) + (stretch - steady - forced(time_s)) * (-period_s / lag).exp();
        now
    };
    (0..ticks(settings)).map(at).collect()
}

/// RMS errors of x_d (m) and of F_T (N).
pub fn errors<S: Scalar>(settings: &Settings) -> (f64, f64) {
    let law = AnyLaw::<S>::build(settings).expect("good settings");
    let mut state = law.start(Motion::REST);
    let reference = closed_form(settings);
    let (positions, forces): (Vec<f64>, Vec<f64>) = reference
        .iter()
        .enumerate()
        .map(|(tick, (stretch, force))| {
            let (local, packet) = input::<S>(settings, tick);
            if let Some(packet) = packet {
                law.receive(&mut state, packet);
            }
            let coupled =
                law.couple(&mut state, &Observation { local, ..Observation::default() }, Staged(local.velocity));
            let position = coupled.desired.position.to_f64() - local.position.to_f64() - stretch;
            (position, coupled.force.to_f64() - force)
        })
        .unzip();
    (rms(positions), rms(forces))
}

pub(super) fn measure(processor: Processor) -> Result<Family, Refused<'static>> {
    let mut comparisons = Vec::new();
    for stiffness in STIFFNESSES {
        let measured = Decode::ALL
            .iter()
            .map(|&decode| {
                let count = processor.count(&format!("decode/{}", decode.name()), "f32");
                (decode.name().to_owned(), errors::<f32>(&settings(decode, stiffness)), count)
            })
            .collect::<Vec<_>>();
        let title = format!("K_T {stiffness} N/m");
        comparisons.push(Comparison::of(&title, "RMS error of F_T", "N", &measured, |errors| errors.1));
        comparisons.push(Comparison::of(&title, "RMS error of x_d", "m", &measured, |errors| errors.0));
    }
    let (soft, stiff) = (&comparisons[0], &comparisons[2]);
    let insight = format!(
        "At 1590 N/m the delayed decode errs by {} N and the implicit one by {} N, at 10620 N/m by {} N and {} N, for {:+} \
         instructions: near its own limit of 12000 N/m the delayed decode rings, the implicit one has no such limit.",
        significant(soft.error_of("delayed"), 2),
        significant(soft.error_of("implicit"), 2),
        significant(stiff.error_of("delayed"), 2),
        significant(stiff.error_of("implicit"), 2),
        stiff.instructions_of("implicit") as i64 - stiff.instructions_of("delayed") as i64,
    );
    Ok(Family {
        name: "decode",
        title: "Decode of the incoming wave",
        motion: "Copy moved 5 mm at 2 Hz, a sine of 0.3 √W arriving in packets of 8 ms, 4 s, f32".to_owned(),
        reference: "closed form of the line's end: an exponential of time constant (b + B_T)/K_T and a sine",
        instructions_per: "call of couple(): decode, force, outgoing wave, filter",
        comparisons,
        headline: 2,
        insight,
    })
}
