//! The bench: which laws it has, in which scenes, and what its figures must be.

use super::*;

/// All of them in the order of the registry, or those that are named; a slip of the pen is distinguished from what
/// there is not.
#[test]
fn laws_are_asked_for_by_name() {
    let laws = cohold_guest_laws::laws();
    let names = |text: &str| asked_for(laws, text).map(|chosen| chosen.iter().map(|law| law.name).collect::<Vec<_>>());
    let all: Vec<&str> = laws.all().iter().map(|law| law.name).collect();
    assert_eq!(names("all").expect("laws"), all);
    assert_eq!(names("wave, power,wave").expect("laws"), ["wave", "power"]);
    let refusal = |text: &str| names(text).expect_err("no law").to_string();
    assert_eq!(refusal("power,wavee"), "there is no law called \"wavee\"; did you mean wave?");
    assert_eq!(refusal("input-gated"), "there is no law called \"input-gated\"; it is passivity-observer now");
    assert!(refusal("zzz").contains("the laws are power, p-plus-d, wave, "), "{}", refusal("zzz"));
    assert!(refusal("").contains("no law called \"\""));
}

/// Every law is tried in the same scene but for what it declares; what is set over that is set for all.
#[test]
fn every_law_has_the_same_scene_and_its_own_gains() {
    let laws = cohold_guest_laws::laws();
    let common: Vec<_> = law_scene(laws, &laws.all()[0], None, &[]).expect("a scene").settings();
    for law in laws.all() {
        let scene = law_scene(laws, law, None, &["user.1.push_n=0.5".to_owned()]).expect("a scene");
        let own = |key: &str| {
            let declared = |gain: &str| gain.split_once('=').is_some_and(|(name, _)| name == key);
            law.gains.iter().chain(laws.all()[0].gains).any(|gain| declared(gain))
        };
        for (key, value) in scene.settings() {
            match key.as_str() {
                // Not even where a law declares another.
                "safety.fade_s" | "safety.disengage_s" => {
                    assert!(LADDER.contains(&&*format!("{key}={value}")), "{}: {key} = {value}", law.name)
                }
                "coordination.comm" => assert_eq!(value.to_string(), format!("\"{}\"", law.name)),
                "user.1.push_n" => assert_eq!(value.to_string(), "0.5"),
                key if own(key) || !common.iter().any(|(known, _)| known == key) => {}
                key => assert!(common.contains(&(key.to_owned(), value)), "{}: {key}", law.name),
            }
        }
    }
}

/// A flow of 40 bytes, sealed.
#[test]
fn a_packet_has_116_bytes() {
    assert_eq!(PACKET_BYTES, 88 + 28);
    // FORMAT.md, under UDP and IP.
    assert_eq!([1, 2, 3].map(packet_bytes), [88, 120, 152].map(|sealed| sealed + 28));
}

mod outside {
    //! A crate outside, in small: the power-domain law under another name, which promises too much, and one that is not linear.

    use cohold_core::configured;
    use cohold_core::law::power::Power;
    use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet};
    use cohold_core::num::{Motion, Scalar};
    use cohold_core::object::{Port, Solve, Staged};
    use cohold_core::settings::{Promise, Refused, Settings};

    const LAWS: [LawInfo; 2] = [
        LawInfo {
            name: "pretends",
            gains: &["coordination.stiffness_n_per_m=310"],
            source: "nobody, never",
            promises: &[Promise::Passive, Promise::NoDrift],
            ..LawInfo::MOTION
        },
        LawInfo { name: "pushes-only", gains: &["coordination.stiffness_n_per_m=310"], ..LawInfo::MOTION },
    ];

    /// Power-domain, as it is or without its pulls.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Outside<S> {
        power: Power<S>,
        pushes_only: bool,
    }

    configured!([S: Scalar] Outside<S> { power, pushes_only });

    impl<S: Scalar> Law<S> for Outside<S> {
        const LAWS: &'static [LawInfo] = &LAWS;
        type State = Motion<S>;

        fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
            Ok(Self { power: Power::build(settings)?, pushes_only: settings.coordination.comm == "pushes-only" })
        }
        fn start(&self, local: Motion<S>) -> Motion<S> {
            local
        }
        fn receive(&self, desired: &mut Motion<S>, packet: Packet<S>) {
            *desired = packet.motion;
        }
        fn couple(&self, desired: &mut Motion<S>, seen: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
            if !self.pushes_only {
                return self.power.couple(desired, seen, solve);
            }
            let coupled = self.power.couple(desired, seen, Staged(seen.local.velocity));
            let force = coupled.force.max(S::ZERO);
            solve.velocity(Port::of_force(force));
            Coupled { force, ..coupled }
        }
        fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
            Packet { motion: local, ..Packet::default() }
        }
    }

    pub(super) struct Family;

    impl cohold_sim::Family for Family {
        type Of<S: Scalar> = Outside<S>;
    }
}

fn with_outside() -> Laws {
    cohold_guest_laws::laws().with::<outside::Family>()
}

/// The rows of these laws over a network that loses nothing and one that does.
fn rows(names: &str, networks: &[Named]) -> Vec<Row> {
    let laws = with_outside();
    let chosen = asked_for(laws, names).expect("laws");
    let scenes = law_scenes(laws, &chosen, None, &[]).expect("scenes");
    over(laws, &scenes, networks, &|| ()).expect("a bench")
}

const OWN: &[Named] = &[("none", "")];

/// Whatever is in the registry has a row and says of itself what it declares, laws from outside too; where the analyser calls the gains
/// stable with both hands on, the run is.
#[test]
fn every_law_has_a_row_and_runs_as_it_was_judged() {
    let rows = rows("all", OWN);
    let laws = with_outside();
    let names: Vec<&str> = laws.all().iter().map(|law| law.name).collect();
    assert_eq!(rows.iter().map(|row| row.law.name).collect::<Vec<_>>(), names);
    assert!(names.contains(&"pretends") && names.contains(&"power"));
    let table = tables::columns(&rows);
    for (at, row) in rows.iter().enumerate() {
        let told = table.row(at);
        assert_eq!(told["law"], row.law.name);
        assert_eq!(row.promises.len(), row.law.promises.len());
        assert!(
            told["packets_per_s"].as_f64().is_some_and(|packets| packets > 0.0 || row.law.name == "none"),
            "{told}"
        );
        let Ok(stability) = &row.stability else { continue };
        let stiffness = row.scene.peer.coordination.stiffness_n_per_m;
        let (verdict, name) = (row.own().verdict(), row.law.name);
        if stability.coordination[0].is_stable(stiffness) && row.law.sends != cohold_core::law::Sends::Nothing {
            // How far apart a soft law leaves the copies is no matter of stability.
            assert!(!verdict.starts_with("NO"), "{name}: {verdict}, {:?}", row.own().reason());
        }
    }
    let sections: Vec<String> = page::sections(&rows, &rows).into_iter().map(|(_, text)| text).collect();
    let lists = |section: &String| names.iter().all(|name| section.contains(&format!("\n{name} ")));
    assert!(sections.iter().take(3).all(lists), "{sections:?}");
    // A row for each network, and no law that nobody would use in it.
    assert_eq!(sections[3].lines().count(), 2 + rows[0].cells.len(), "{sections:?}");
    assert!(!sections[3].contains("`none`"), "{sections:?}");
}

/// A promise is held against what was measured: the power-domain law under another name is not passive on a bad network, whatever
/// it says; it does not drift. Nor is anything judged of a law that pushes and never pulls.
#[test]
fn a_false_promise_is_found_and_what_is_not_linear_is_not_judged() {
    let late: &[Named] = &[("none", ""), ("bursts", "loss=0.2 loss_burst_packets=100ms")];
    let rows = rows("pretends,power,pushes-only", late);
    let kept: Vec<bool> = rows[0].promises.iter().map(|kept| kept.kept).collect();
    assert_eq!(kept, [false, true], "{:?}", rows[0].promises);
    let limits = |row: &Row| {
        let stability = row.stability.as_ref().expect("linear");
        stability.coordination.iter().map(stability::stable_to).collect::<Vec<_>>()
    };
    assert_eq!(limits(&rows[0]), limits(&rows[1]), "the same law under two names");
    assert_eq!(rows[0].touch.width_db(), rows[1].touch.width_db());
    let why = rows[2].stability.as_ref().expect_err("not linear");
    assert!(why.contains("not linear"), "{why}");
}

/// What every law declares is kept where networks are worst: what is passive on any network makes no energy, what does not drift is together again.
#[test]
fn every_promise_is_kept_on_the_worst_networks() {
    const WORST: [&str; 4] = ["none", "bursts of 100 ms, 20 %", "delay step -100 ms", "all at once"];
    let worst: Vec<Named> = networks::IMPAIRMENTS.iter().copied().filter(|(name, _)| WORST.contains(name)).collect();
    assert_eq!(worst.len(), WORST.len());
    let laws = cohold_guest_laws::laws();
    let chosen = asked_for(laws, "all").expect("laws");
    let mut promised = 0;
    for scene in law_scenes(laws, &chosen, None, &[]).expect("scenes") {
        let entrant = Entrant { name: scene.law().name.to_owned(), scene: scene.clone() };
        let cells = over_networks(vec![entrant], &worst, 0).expect("runs");
        for kept in promises::kept(&scene, &cells, &worst).expect("a verdict") {
            assert!(kept.kept, "{}: {kept:?}", scene.law().name);
            promised += 1;
        }
    }
    assert!(promised > chosen.len() / 2, "{promised} promises");
}

/// THEORY §7: the largest K_LC of the midpoint peer at device delays of 0, 0.5 and 1 tick (K_T = 10⁴, mean of eight).
#[test]
fn the_largest_contact_is_that_of_the_theory() {
    let laws = cohold_guest_laws::laws();
    let chosen = asked_for(laws, "passive-mean").expect("a law");
    for (delay, want) in [("0", 7295.0), ("0.5", 3511.0), ("1", 2318.0)] {
        let set = [format!("device.force_delay_ticks={delay}"), "coordination.stiffness_n_per_m=10000".to_owned()];
        let scene = law_scenes(laws, &chosen, None, &set).expect("a scene").remove(0);
        let stability = stability::judged(&scene, true).expect("linear");
        let got = stability::stable_to(&stability.contact);
        assert!((got / want - 1.0).abs() < 0.01, "delay {delay}: {got} N/m, not {want}");
    }
}
