use super::*;

fn refused(line: &str) -> String {
    apply(&Scene::new(cohold_guest_laws::laws()), line).expect_err(line).to_string()
}

#[test]
fn orders_are_all_or_none() {
    let scene = Scene::new(cohold_guest_laws::laws());
    assert!(refused("set network.loss=0.2 coordination.comm=nonsense").contains("coordination.comm"));
    let set = apply(&scene, "set network.loss=0.2 coordination.stiffness_n_per_m=310").expect("good");
    assert_eq!((set.world.network.loss, set.peer.coordination.stiffness_n_per_m), (0.2, 310.0));
    // Each is within its range, and the two do not go together.
    assert!(refused("set coordination.drift_correction=true").contains("drift_correction"));
}

/// A page must not read files of this machine, not even learn whether they are there.
#[test]
fn a_page_names_no_file() {
    for line in [
        "set user.1.trace=/etc/passwd",
        "set network.trace=/etc/passwd",
        "set network.trace = /etc/passwd",
        "file [network]\ntrace = \"/etc/passwd\"",
        "file [user.2]\ntrace = \"/nowhere\"",
        "scene any-network user.1.trace=/nowhere",
        "law power user.1.trace=/nowhere",
    ] {
        let why = refused(line);
        assert!(why.contains("a page reads none") || why.contains("write it as table.key=value"), "{line}: {why}");
    }
}

#[test]
fn real_time_is_a_millisecond() {
    assert!(refused("set timing.control_period_s=0.00001").contains("it must be 0.001 s"));
    assert!(refused("dance").contains("there is no such order"));
    assert!(refused("scene any-netwrok").contains("did you mean any-network?"));
    assert!(refused("file [network\n").contains("line 1"));
}

/// Every click and every law is a scene that can be played; a saved scene is the scene again.
#[test]
fn clicks_laws_and_files_are_scenes() {
    let mut scene = Scene::new(cohold_guest_laws::laws());
    for (name, built_in, keys) in CLICKS {
        scene = apply(&scene, format!("scene {built_in} {keys}").trim_end()).expect(name);
        for kind in scene.laws.all() {
            let changed = apply(&scene, &format!("law {}", kind.name)).expect(kind.name);
            assert_eq!(changed.law().name, kind.name);
            assert!((one_way_s(&changed) - one_way_s(&scene)).abs() < 1e-9, "{name}, {}", kind.name);
        }
    }
    let file: String = scene.settings().iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    let again = apply(&Scene::new(scene.laws), &format!("file {file}")).expect("its own settings");
    assert_eq!(again.settings(), scene.settings());
}

fn one_way_s(scene: &Scene) -> f64 {
    let network = &scene.world.network;
    f64::from(network.one_way_delay_packets) * scene.peer.timing.packet_period_s() + network.extra_delay_s
}

/// What one law's settings were refuses no other: every law can be chosen after every other, and what a law declares holds nothing of the
/// one before.
#[test]
fn every_law_can_be_chosen_after_every_other() {
    let begun = scenes::load(cohold_guest_laws::laws(), "any-network").expect("a scene");
    for first in begun.laws.all() {
        let one = apply(&begun, &format!("law {}", first.name)).expect(first.name);
        for second in begun.laws.all() {
            let two = apply(&one, &format!("law {}", second.name))
                .unwrap_or_else(|why| panic!("{} after {}: {why}", second.name, first.name));
            let alone = apply(&begun, &format!("law {}", second.name)).expect(second.name);
            assert_eq!(two.settings(), alone.settings(), "{} after {}", second.name, first.name);
        }
    }
}

/// Lines put together from what orders are made of, and from what they are not: nothing fails but in one line that a page can show, no
/// file is read, and what is taken can be played.
#[test]
fn whatever_a_page_says_is_refused_or_can_be_played() {
    const PIECES: [&str; 28] = [
        "set",
        "scene",
        "law",
        "file",
        "show",
        " ",
        " ",
        " ",
        "\n",
        "=",
        ".",
        "\"",
        "[",
        "]",
        "#",
        "\u{1b}",
        "\u{202e}",
        "default",
        "any-network",
        "wave",
        "user.1.trace=/dev/zero",
        "network.trace",
        "trace",
        "network.loss=0.5",
        "object.mass_kg=1e308",
        "axis.shared=3",
        "[user.2]\ntrace = \"/dev/zero\"",
        "coordination.comm=",
    ];
    let scene = Scene::new(cohold_guest_laws::laws());
    let mut random = 29_u64;
    let mut next = |below: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % below
    };
    let mut taken = 0;
    for _ in 0..20_000 {
        let line: String = (0..=next(9)).map(|_| PIECES[next(PIECES.len())]).collect();
        let Ok(scene) = apply(&scene, &line) else { continue };
        taken += 1;
        assert!(scene.check("s").is_ok() && check(&scene).is_ok(), "{line:?}");
        assert!(scene.network_trace.is_none() && scene.users.iter().all(|user| user.trace.is_none()), "{line:?}");
    }
    assert!(taken > 20, "{taken}");
}
