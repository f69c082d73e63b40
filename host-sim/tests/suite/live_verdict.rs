//! Live peers and the verdict on their scene at the delays that they measure: who arms, who does not and says why, and how both end.

use std::process::Child;

use serde_json::Value;

use crate::program::{Keys, cohold, free};

/// A relay of this network for so many seconds, and two peers over it that want this; all three run.
fn over(keys: &Keys, network: &[&str], relayed_s: &str, wanted: &[&str]) -> (Child, [Child; 2]) {
    let [one, two, for_one, for_two] = [(); 4].map(|()| free());
    let relay = cohold(&["network", "relay", "--json", "--seconds", relayed_s])
        .args(["--listen-1", &for_one, "--listen-2", &for_two, "--peer-1", &one, "--peer-2", &two])
        .args(["network.one_way_delay_packets=0"].iter().chain(network).flat_map(|setting| ["--set", setting]))
        .spawn()
        .expect("cohold runs");
    let peers = [("1", &one, &for_one), ("2", &two, &for_two)].map(|(number, listen, connect)| {
        cohold(&["peer", "--json", "--number", number, "--listen", listen, "--connect", connect])
            .args(["--key-file", &keys.file(0)])
            .args(wanted)
            .spawn()
            .expect("cohold runs")
    });
    (relay, peers)
}

/// The report of a peer, what it said meanwhile, and its exit status.
fn ended(peer: Child) -> (Value, String, Option<i32>) {
    let output = peer.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|cause| panic!("{cause}: {said}"));
    (report, said, output.status.code())
}

/// Ends a relay.
fn end(mut relay: Child) {
    relay.kill().expect("it runs");
    let _ = relay.wait();
}

/// The lines with the verdict that a report has.
fn verdicts(report: &Value) -> Vec<&str> {
    report["verdicts"].as_array().expect("a list").iter().filter_map(|one| one[1].as_str()).collect()
}

/// The paper's scene of 8 ms one way, at 2 ms, where it tears two hands apart: neither peer arms, both name the key; told to, they arm.
#[test]
fn a_scene_that_is_unstable_at_the_measured_delay_is_refused_by_name() {
    let keys = Keys::new("verdict-refused", 0);
    let scene = ["--scene", "paper-5.2-passive-wave-16ms", "--seconds", "2"];
    let anyway = [&scene[..], &["--anyway"]].concat();
    let [refused, armed] =
        [&scene[..], &anyway].map(|wanted| over(&keys, &["network.extra_delay_s=0.002"], "12", wanted));
    for peer in refused.1 {
        let (seen, said, status) = ended(peer);
        assert_eq!(
            (status, &seen["ticks"], &seen["refused"]),
            (Some(1), &Value::from(0), &true.into()),
            "{said}{seen}"
        );
        let line = said.lines().find(|line| line.contains("does not arm")).unwrap_or_else(|| panic!("{said}"));
        for part in ["unstable: spectral radius 1.", "Lower coordination.stiffness_n_per_m from 10620 to ", "--anyway"]
        {
            assert!(line.contains(part), "{part}: {line}");
        }
        let last = said.lines().last().unwrap_or_default();
        assert!(last.starts_with("cohold: never armed: unstable"), "{said}");
        assert_eq!((verdicts(&seen).as_slice(), &seen["verdict"]["stable"]), (&[line][..], &false.into()), "{seen}");
        let [least, most] = [0, 1].map(|at| seen["verdict"]["one_way_ms"][at].as_f64().expect("a number"));
        assert!((2.0..=most).contains(&least) && most < 20.0, "{seen}");
        // The other one was there, and its flow came all the time.
        assert!(seen["datagrams_taken"].as_f64().is_some_and(|taken| taken > 200.0), "{seen}");
    }
    for peer in armed.1 {
        let (seen, said, status) = ended(peer);
        assert!(verdicts(&seen)[0].ends_with("It arms all the same"), "{said}");
        assert!(seen["ticks"].as_u64() > Some(0) && seen["refused"].is_null(), "{said}{seen}");
        // Torn apart or not yet: a fault is no success.
        assert_eq!(status, Some(i32::from(!seen["fault"].is_null())), "{said}{seen}");
    }
    [refused.0, armed.0].into_iter().for_each(end);
}

/// The relay's delay steps: who was refused arms when it gets better, and who is armed is told when it gets worse, and both when it is good again.
#[test]
fn a_network_that_moves_is_looked_at_again() {
    let keys = Keys::new("verdict-moves", 0);
    let wanted = ["--scene", "paper-5.2-power-16ms", "--seconds", "5"];
    let [better, worse] = [["0.03", "-0.03"], ["0", "0.03"]].map(|[first, step]| {
        let (first, step) = (format!("network.extra_delay_s={first}"), format!("network.delay_step_s={step}"));
        over(&keys, &[&first, &step, "network.delay_step_at_s=3"], "20", &wanted)
    });
    for peer in better.1 {
        let (seen, said, status) = ended(peer);
        assert_eq!((status, &seen["ticks"], &seen["refused"]), (Some(0), &5000.into(), &Value::Null), "{said}{seen}");
        let [first, .., last] = &verdicts(&seen)[..] else { panic!("{seen}") };
        assert!(first.contains("does not arm") && last.contains("way: stable: "), "{seen}");
    }
    for peer in worse.1 {
        let (seen, said, _) = ended(peer);
        assert!(seen["ticks"].as_u64() > Some(0) && seen["refused"].is_null(), "{said}{seen}");
        let [first, second, ..] = &verdicts(&seen)[..] else { panic!("{seen}") };
        assert!(first.contains("way: stable: ") && second.ends_with("It stays armed"), "{seen}");
    }
    [better.0, worse.0].into_iter().for_each(end);
}
