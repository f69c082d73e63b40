//! A page whose one hand is at a device: what it shows and steers is what a peer without a page does with that device.

use std::time::Duration;

use cohold_devices::emulators::hand::HAND_N_PER_M;
use cohold_devices::emulators::inverse3::Fault;

use super::emulated::haply;
use super::{BUSY_S, Running, SETTINGS, SILENT_S, fault_of, mean, peer, sets};
use crate::program::{Keys, cohold, free, signal};

/// How far the hand at the device reaches, m, and the scene's contact, N/m.
const REACH_M: f64 = 0.02;
const CONTACT_N_PER_M: f64 = 1000.0;

/// The hand at the device and a simulated one hold one object: what is felt is what the springs between them give in statics. When the device
/// falls silent its force is gone in time, and the other end learns why.
#[test]
fn a_page_s_device_holds_an_object_and_lets_go() {
    let emulator = haply(0.0);
    let (keys, one, two) = (Keys::new("devices-page", 0), free(), free());
    let device = format!("haply:{}", emulator.at);
    let key = keys.file(0);
    let mut page = cohold(&["play", "--scene", "any-network", "--listen", &one, "--key-file", &key, "--seconds", "60"]);
    page.args(["--device", &device, "--device-lets-go-s", "0.02", "--device-origin-m", "0,0,0"]);
    page.args(sets(&SETTINGS));
    let mut second = peer("any-network", "2", &two, &one, &key);
    second.args(["--seconds", "60"]);
    let [mut page, mut second] = [page, second].map(Running::start);
    page.until("operator:");
    assert!(!page.said().contains("hand 1"), "a hand of the page's: {}", page.said());
    second.until(" s  armed, ");
    emulator.world().reach([REACH_M, 0.0, 0.0]);
    std::thread::sleep(Duration::from_secs(4));
    let (felt_n, failed_s) = {
        let mut world = emulator.world();
        (mean(&world.asked, world.time_s(), 1.0)[0], world.fail(Fault::Silent))
    };
    let wanted_n = -REACH_M / (2.0 / HAND_N_PER_M + 2.0 / CONTACT_N_PER_M);
    assert!((felt_n / wanted_n - 1.0).abs() < 0.05, "{felt_n} N, {wanted_n} N in statics");
    std::thread::sleep(Duration::from_secs_f64(SILENT_S + BUSY_S));
    {
        let mut world = emulator.world();
        let last = world.asked.iter().rev().find(|(_, force)| *force != [0.0; 3]).expect("a force").0;
        assert!(last - failed_s < SILENT_S + BUSY_S, "a force {} s later", last - failed_s);
        assert_eq!(world.advance(), [0.0; 3]);
    }
    // The page stays and says so; the other one goes on and has been told.
    std::thread::sleep(Duration::from_secs(1));
    signal(&second.child, "INT");
    let (_, live, said) = second.end();
    assert_eq!(fault_of(&live["other"]), Some(23), "{said}\n{live}");
    page.asked_to_end();
}

/// A device needs another end, and one that must not be armed is refused by name.
#[test]
fn a_device_needs_one_peer_of_two() {
    let emulator = haply(0.0);
    let device = format!("haply:{}", emulator.at);
    let keys = Keys::new("devices-page-refused", 0);
    let (key, listen) = (keys.file(0), free());
    let refusal = |more: &[&str]| {
        let output = cohold(&["play", "--seconds", "5", "--device", &device]).args(more).output().expect("cohold runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = refusal(&[]);
    assert!(code == Some(2) && said.contains("--device is for one peer of two"), "{said}");
    let (code, said) = refusal(&["--listen", &listen, "--key-file", &key]);
    assert!(code != Some(0) && said.contains("how long Inverse3 049D holds a force"), "{said}");
}
