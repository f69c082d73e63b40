use cohold_sim::scenes;

use super::*;

/// A contact that a device which is driven in its tick bears, one that is seven ticks late does not, however the scene simulates its own; what is
/// later than a device of a scene is judged as that, and said so. A device at the other end changes nothing here.
#[test]
fn a_verdict_is_about_the_device_that_is_there() {
    for name in ["any-network", "plane"] {
        let keys = ["contact.stiffness_n_per_m=1000".to_owned()];
        let scene = scenes::find(cohold_sim::Laws::built_in(), Some(Path::new(name)), &keys).expect("a scene");
        let find = judge(scene, 2, None, Ok(())).find;
        let at = |device_ticks| find(Measured { one_way_s: [0.002, 0.003], device_ticks });
        let [own, prompt, late, later] = [None, Some(1), Some(20), Some(21)].map(at);
        assert_eq!(
            [&own, &prompt, &late].map(|verdict| verdict.stable),
            [Some(true), Some(true), Some(false)],
            "{name}"
        );
        assert!(later.stable == late.stable && later.text == late.text, "{}", later.text);
        assert!(later.not_judged.contains(&LATER) && !late.not_judged.contains(&LATER), "{name}");
        assert_eq!(late.device_delay_ticks, Some(20));
        assert!(late.not_judged.contains(&DEVICE_S_OWN) && !own.not_judged.contains(&DEVICE_S_OWN), "{name}");
    }
}
