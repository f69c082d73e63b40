//! The lifted matrix of a cooperative environment against the sampled map, and against the world that it is the matrix of.

use cohold_analysis::rendering::{Renderer, Rendering};
use cohold_environments::cooperative::bounder::{Bound, Bounder};
use cohold_environments::cooperative::lifted::{Line, lines, verdict};
use cohold_environments::cooperative::limits::rendering;
use cohold_environments::cooperative::world::World;
use cohold_environments::cooperative::{Engine, Setup};

fn setup(one_way_s: f64, keys: &[&str]) -> Setup {
    let keys = [keys, &["safety.max_force_n=200", "safety.max_slew_n_per_s=1000000"]].concat();
    Setup { bounder: false, ..Setup::base(one_way_s, &keys).expect("a good scene") }
}

fn radius(setup: &Setup, lines: &[Line]) -> f64 {
    verdict(&setup.scene, lines).expect("eigenvalues").spectral_radius
}

/// With a packet each tick, two equal users are the sampled map of one device at half of the object, which shares no
/// code with this, and the same of one at an object that rests. Gains as the bounder would have them, and unbounded.
#[test]
fn with_a_packet_each_tick_it_is_the_map_of_one_device_and_one_object() {
    let mut renderer = Renderer::default();
    for ticks in [0_usize, 1, 4, 15] {
        let setup = setup(1e-3 * ticks as f64, &["contact.damping_n_s_per_m=3"]);
        let bounded = Bounder::new(1000.0, 3.0, 5.0, 1e-3).bound(2e-3 * ticks as f64);
        for gains in [Bound { stiffness: 1000.0, damping: 3.0, drag: 0.0 }, bounded] {
            let got = radius(&setup, &[Line { gains, delay_packets: Some([ticks, ticks]) }; 2]);
            let mut alike = rendering(&setup, 2e-3 * ticks as f64, gains.drag);
            alike.contact_damping_n_s_per_m = gains.damping;
            let rests = Rendering { object: None, ..alike };
            // The engine takes drag implicitly, the map exactly.
            let within = if gains.drag > 0.0 { 2e-3 } else { 1e-9 };
            let wanted = [alike, rests].map(|map| renderer.radius(&map, gains.stiffness).expect("eigenvalues"));
            let wanted = wanted[0].max(wanted[1]);
            assert!((got - wanted).abs() < within, "{ticks} ticks, {gains:?}: {got} is not {wanted}");
        }
    }
}

/// Slow packets, delay, an engine at either end: what a strike leaves grows in the simulated world as the eigenvalue says.
#[test]
fn the_world_grows_as_the_eigenvalue_says() {
    for (packet_ms, one_way_ms, stiffness, engine) in [
        (8_u64, 0.0, 690, Engine::Server),
        (8, 5.0, 150, Engine::Server),
        (4, 10.0, 150, Engine::Server),
        (8, 12.0, 50, Engine::Client),
        (8, 40.0, 50, Engine::Client),
    ] {
        let (packets, stiffness) =
            (format!("timing.ticks_per_packet={packet_ms}"), format!("contact.stiffness_n_per_m={stiffness}"));
        let strike =
            ["contact.damping_n_s_per_m=0", "user.1.pulse_n=0.01", "user.1.pulse_s=0.01", "user.1.pulse_every_s=1000"];
        let keys = [&[packets.as_str(), &stiffness][..], &strike].concat();
        let setup = Setup { engine, ..setup(1e-3 * one_way_ms, &keys) };
        let mut world = World::new(&setup).expect("a good scene");
        let mut largest = [0.0_f64; 2];
        // Long against an oscillation.
        let window = 400 * packet_ms;
        for tick in 0..3 * window {
            if engine == Engine::Client {
                world.ask();
            }
            world.step();
            if let Some(at) = (tick / window).checked_sub(1) {
                largest[at as usize] = world.forces().fold(largest[at as usize], |most, force| most.max(force.abs()));
            }
        }
        assert!(world.clients().all(|client| client.fault.is_none()) && largest[1] < 150.0, "{largest:?}");
        let grew = (largest[1] / largest[0]).ln() / 400.0;
        let wanted = radius(&setup, &lines(&world, &setup.scene)).ln();
        let what = format!("{packet_ms} ms, {one_way_ms} ms, {stiffness}: ln {grew:.5}, by eigenvalue {wanted:.5}");
        assert!(wanted > 0.002 && (grew / wanted - 1.0).abs() < 0.05, "{what}");
    }
}
