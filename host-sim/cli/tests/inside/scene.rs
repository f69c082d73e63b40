use cohold_sim::{Laws, scene::Scene};

use super::START;

/// The file that is written loads, with each of its comments taken away too, and is its base but for what it says.
#[test]
fn the_file_to_start_from_is_a_scene() {
    let text = START.replace("BASE", "any-network");
    let folder = tempfile();
    let file = folder.join("scene.toml");
    for text in [text.clone(), text.replace("# stiffness", "stiffness").replace("# loss", "loss")] {
        std::fs::write(&file, text).expect("a file");
        let scene = Scene::load(Laws::default(), Some(&file), &[]).expect("a scene");
        assert_eq!(scene.law().name, "self-timed");
        assert_eq!(scene.users.each_ref().map(|user| user.settings.user.push_n), [1.0; 2]);
    }
    std::fs::remove_dir_all(folder).expect("it was there");
}

fn tempfile() -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("cohold-scene-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Only a built-in scene is a base, and one that is misspelt is named.
#[test]
fn a_base_that_there_is_none_of_is_refused() {
    let mut scene = Scene::new(Laws::default());
    let refused =
        |text: &str, scene: &mut Scene| scene.apply(text, "mine.toml", None).expect_err("it is refused").to_string();
    let said = refused("base = \"any-netwrok\"\n", &mut scene);
    assert!(said.contains("mine.toml:1") && said.contains("did you mean any-network?"), "{said}");
    let said = refused("\nbase = 3\n", &mut scene);
    assert!(said.contains("mine.toml:2") && said.contains("name of a built-in scene"), "{said}");
}
