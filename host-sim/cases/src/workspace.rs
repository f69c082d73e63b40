//! Mechanisms and their workspaces.
//!
//! What is found there: [the mechanisms](../../mechanisms/index.html). Unit: rad.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use cohold_core::device::kinematics::{KinematicsName, Maths};
use cohold_core::settings::{Choice, Settings};

/// The mechanisms and functions that are compared.
pub const CHOICES: [(KinematicsName, Maths); 3] = [
    (KinematicsName::FiveBar, Maths::Micromath),
    (KinematicsName::FiveBar, Maths::Libm),
    (KinematicsName::Capstan, Maths::Libm),
];

/// A mechanism with these maths; two axes where it has them.
pub fn settings(model: KinematicsName, maths: Maths) -> Settings {
    let mut settings = Settings::default();
    settings.kinematics.model = model;
    settings.kinematics.maths = maths;
    settings.axis.count = if model == KinematicsName::FiveBar { 2 } else { 1 };
    settings
}

/// The joints of the workspace, rad.
pub fn joints(model: KinematicsName) -> Vec<[f64; 2]> {
    let steps = |most: i32, by: f64| (-most..=most).map(move |at| f64::from(at) * by / 32.0);
    match model {
        KinematicsName::FiveBar => steps(16, 1.0).flat_map(|a| steps(16, 1.0).map(move |b| [a, b])).collect(),
        _ => steps(40, 4.0).map(|motor| [motor, 0.0]).collect(),
    }
}

/// The case whose calls are counted.
pub fn case(model: KinematicsName, maths: Maths) -> String {
    format!("kinematics/{}/{}", model.name(), maths.name())
}
