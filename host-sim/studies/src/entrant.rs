//! What takes part in a comparison or a study: a scene, or a law in the scene for laws, with settings of its own.

use std::path::Path;

use cohold_report::Provenance;
use cohold_sim::peers::Laws;
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

use crate::Error;
use crate::campaign::laws::law_scene;

/// A scene that is compared.
#[derive(Clone, Debug)]
pub struct Entrant {
    /// Name of the scene in reports.
    pub name: String,
    /// The scene that is run.
    pub scene: Scene,
}

impl Entrant {
    /// `SCENE|LAW[,TABLE.KEY=VALUE…]`: a built-in scene, a file, or a law at the gains that it declares, in this scene or that of the
    /// campaign; `first` is set before what stands behind the name.
    ///
    /// # Errors
    /// A scene or law that there is not, or a setting that it does not accept.
    pub fn of(laws: Laws, text: &str, scene: Option<&Path>, first: &[String]) -> Result<Self, Error> {
        let mut parts = text.split(',').map(str::trim);
        let name = parts.next().unwrap_or_default();
        let settings: Vec<String> = first.iter().cloned().chain(parts.map(str::to_owned)).collect();
        let law = laws.all().iter().find(|law| law.name == name);
        let found = match law {
            Some(law) => law_scene(laws, law, scene, &settings),
            None => scenes::find(laws, Some(Path::new(name)), &settings).map_err(Error::from),
        };
        let scene = found.map_err(|error| match law {
            None if !Path::new(name).exists() && scenes::text(name).is_none() => {
                let laws: Vec<&str> = laws.all().iter().map(|law| law.name).collect();
                format!("{error}; the laws are {}", laws.join(", "))
            }
            _ => format!("{text}: {error}"),
        })?;
        Ok(Self { name: text.to_owned(), scene })
    }

    /// The first scene's settings, and in what each other one is not as it.
    pub fn told(entrants: &[Self], mut provenance: Provenance) -> Provenance {
        let Some((first, others)) = entrants.split_first() else { return provenance };
        let settings = first.scene.settings();
        provenance = provenance.with("scene_1", first.name.as_str());
        for (number, entrant) in (2..).zip(others) {
            let other = entrant.scene.settings();
            let changed = other.iter().filter(|setting| !settings.contains(setting));
            let gone = settings.iter().filter(|(key, _)| !other.iter().any(|(known, _)| known == key));
            let texts = changed.map(|(key, value)| format!("{key}={value}"));
            let texts: Vec<String> = texts.chain(gone.map(|(key, _)| format!("{key} as usual"))).collect();
            provenance = provenance.with(&format!("scene_{number}"), entrant.name.as_str());
            provenance = provenance.with(&format!("scene_{number}_differs"), texts.join(", "));
        }
        provenance.settings(settings)
    }
}
