//! Ticks of a whole peer, replayed as `core/benches` does.

use alloc::boxed::Box;
use alloc::format;

use haptic_core::scene::Models;

use super::{Case, Meter, scenes};

#[path = "../../../../core/benches/cases/recording.rs"]
mod recording;

pub(super) use recording::Named;
use recording::{Recording, TICKS, step};

/// The ticks of a scene.
pub(super) fn case<M: Models, R: Meter>(scene: &scenes::Scene) -> Case {
    let settings = scene.settings();
    let replay = move || {
        let recording = Recording::<M>::new(&settings);
        recording.replay(|scene, state, input| R::call(&mut |input| step(scene, state, input), input));
    };
    Case { name: format!("tick/{}", scene.name), calls: TICKS, replay: Box::new(replay) }
}
