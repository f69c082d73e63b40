//! Both users at the same time: each its own copy, one dynamics engine, or copies that a law holds together.

use crate::cooperative::world::World;
use crate::cooperative::{Engine, Setup, lifted};
use cohold_analysis::verdict;
use cohold_protocol::wire::{Flow, SEAL_LEN};
use cohold_sim::pair::Pair;

use super::account::{Account, End, presence_bytes_per_s};
use super::{Architecture, Error, Row, TASK, scene};

/// Two peers: static (no coordination law) or distributed.
pub(super) fn distributed(architecture: Architecture, delay_ms: f64) -> Result<Row, Error> {
    // The gains of the fault campaign.
    let (law, stiffness) = match architecture {
        Architecture::DistributedPower => ("power", 310.0),
        Architecture::DistributedWave => ("wave", 1590.0),
        Architecture::DistributedPassiveWave => ("passive-wave", 10_000.0),
        Architecture::DistributedPassiveMean => ("passive-mean", 10_000.0),
        _ => ("none", 0.0),
    };
    let scene = scene(&[
        format!("coordination.comm={law}"),
        format!("coordination.stiffness_n_per_m={stiffness}"),
        "coordination.decode=implicit".to_owned(),
        format!("network.extra_delay_s={}", 1e-3 * delay_ms),
    ])?;
    let mut pair = Pair::<f64>::new(&scene)?;
    let ticks = (TASK.duration_s / scene.peer.timing.control_period_s) as u64;
    let mut account = Account::new(ticks);
    for _ in 0..ticks {
        pair.step();
        let seen = pair.sides().map(|side| side.peer.observed()[0]);
        account.see(seen.map(|seen| seen.object.position), seen.map(|seen| seen.contact_force));
    }
    let bytes = if law == "none" {
        2.0 * presence_bytes_per_s() * TASK.duration_s
    } else {
        let packets: u64 = pair.sides().into_iter().map(|side| side.sent).sum();
        (packets * (SEAL_LEN + Flow::LEN) as u64) as f64
    };
    // A server of a static world tells everybody where the others are.
    let server = if law == "none" { bytes } else { 0.0 };
    let end = End {
        done: pair.fault().is_none(),
        // A slow oscillation would not grow visibly within the task; eigenvalues tell.
        spectral_radius: verdict(&scene)?.spectral_radius,
        contact_n_per_m: [scene.peer.contact.stiffness_n_per_m; 2],
        bytes: [bytes, server],
    };
    Ok(account.row(architecture, delay_ms, end))
}

pub(super) fn cooperative(architecture: Architecture, delay_ms: f64) -> Result<Row, Error> {
    // Half of the way to the server.
    let scene = scene(&[format!("network.extra_delay_s={}", 0.5e-3 * delay_ms)])?;
    let mut setup = Setup::new(scene);
    setup.bounder = architecture != Architecture::CooperativeServerUnbounded;
    if architecture == Architecture::CooperativeClient {
        setup.engine = Engine::Client;
    }
    let mut world = World::new(&setup)?;
    let ticks = (TASK.duration_s / setup.scene.peer.timing.control_period_s) as u64;
    let mut account = Account::new(ticks);
    for _ in 0..ticks {
        if setup.engine == Engine::Client {
            world.ask();
        }
        world.step();
        account.see(both(world.clients().map(|client| client.view().position)), both(world.forces()));
    }
    let end = End {
        done: world.clients().all(|client| client.fault.is_none()),
        spectral_radius: lifted::verdict(&setup.scene, &lifted::lines(&world, &setup.scene))?.spectral_radius,
        contact_n_per_m: both(world.clients().map(|client| client.bound.stiffness)),
        bytes: world.bytes().map(|bytes| bytes as f64),
    };
    Ok(account.row(architecture, delay_ms, end))
}

fn both(mut values: impl Iterator<Item = f64>) -> [f64; 2] {
    [(); 2].map(|()| values.next().unwrap_or(0.0))
}

/// The spectral radius of one packet period of the engine at the server, without delay and bounder, with a packet every so
/// many ticks: how slow packets may be for the scene's contact.
///
/// # Errors
/// A setup that cannot be analysed.
pub fn unbounded_radius(ticks_per_packet: u32) -> Result<f64, Error> {
    let scene = scene(&[format!("timing.ticks_per_packet={ticks_per_packet}")])?;
    let mut setup = Setup::new(scene);
    setup.bounder = false;
    let lines = lifted::lines(&World::new(&setup)?, &setup.scene);
    Ok(lifted::verdict(&setup.scene, &lines)?.spectral_radius)
}
