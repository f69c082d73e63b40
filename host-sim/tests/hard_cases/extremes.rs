//! x
use super::setup::{COMMS, scene};
use haptic_core::scalar::{Fixed, Scalar};
use host_sim::analysis::verdict;
use host_sim::experiment::{Options, run};
use host_sim::scene::SceneFile;

fn one<S: Scalar>(scene: &SceneFile) -> String {
    let out = run::<S>(scene, Options { duration_s: 6.0, record_every: 0 }, &|_| {}).unwrap();
    format!(
        "{}:{}{} pk {:.3}",
        S::NAME,
        if out.bounded { "ok" } else { "UNB" },
        out.fault.map_or(String::new(), |f| format!("{:?}", f.1)),
        out.peak_coordination_force_n
    )
}
fn show(name: &str, overrides: &[String]) {
    let s = scene(
        &[
            overrides,
            &[
                "user.1.push_n=0.5".to_owned(),
                "user.2.push_n=0.5".to_owned(),
                "user.1.pulse_n=0.5".to_owned(),
                "user.1.pulse_every_s=1".to_owned(),
            ][..],
        ]
        .concat(),
    );
    let v = verdict(&s).unwrap();
    println!(
        "{name:40} rho {:.8} {} states {} | {} | {} | {}",
        v.spectral_radius,
        v.stable,
        v.states,
        one::<f64>(&s),
        one::<f32>(&s),
        one::<Fixed>(&s)
    );
}
#[test]
fn gains() {
    for comm in COMMS {
        for decode in ["delayed", "implicit"] {
            if comm == "power" && decode == "implicit" {
                continue;
            }
            for e in -3..=7 {
                let mut o = vec![
                    format!("coordination.comm={comm}"),
                    format!("coordination.decode={decode}"),
                    format!("coordination.stiffness_n_per_m=1e{e}"),
                ];
                if decode == "implicit" {
                    o.push("object.force_delay_ticks=0".into());
                    o.push("object.integrator=semi-implicit".into());
                }
                show(&format!("{comm} {decode} K_T 1e{e}"), &o);
            }
        }
    }
}
#[test]
fn masses() {
    for comm in COMMS {
        for integ in ["forward-euler", "exact"] {
            for e in -4..=3 {
                let k = match comm {
                    "power" => 200.0,
                    "wave" => 1000.0,
                    _ => 2000.0,
                };
                show(
                    &format!("{comm} {integ} m 1e{e}"),
                    &[
                        format!("coordination.comm={comm}"),
                        format!("object.integrator={integ}"),
                        format!("object.mass_kg=1e{e}"),
                        format!("coordination.stiffness_n_per_m={k}"),
                    ],
                );
            }
        }
    }
}
#[test]
fn delays() {
    for comm in COMMS {
        for n in [0, 1, 2, 5, 10, 20, 50, 100, 125] {
            let k = match comm {
                "power" => 20.0,
                "wave" => 1000.0,
                _ => 2000.0,
            };
            show(
                &format!("{comm} n_t {n}"),
                &[
                    format!("coordination.comm={comm}"),
                    format!("network.one_way_delay_packets={n}"),
                    format!("coordination.stiffness_n_per_m={k}"),
                ],
            );
        }
    }
}
