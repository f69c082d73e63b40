//! Any text as a scene: no panic, and what is taken is taken again as the scene itself says it.

use cohold_sim::scene::Scene;

/// Runs one fuzz input.
pub(super) fn run(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    // Files of this machine are no part of it.
    if text.contains("trace") {
        return;
    }
    let mut scene = Scene::default();
    let taken = scene.apply(&text, "text", None).and_then(|()| scene.check("text"));
    if taken.is_err() {
        return;
    }
    let said: String = scene.settings().into_iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
    let mut again = Scene::default();
    let taken = again.apply(&said, "text", None).and_then(|()| again.check("text"));
    assert!(taken.is_ok(), "{}", taken.map_or_else(|why| why.to_string(), |()| String::new()));
    assert_eq!(again.settings(), scene.settings());
}
