use super::*;

#[test]
fn a_tag_is_of_the_version_that_is_built() {
    let manifest =
        "[workspace.package]\nversion = \"0.3.1\"\n\n[workspace.dependencies]\nlibm = { version = \"0.2\" }\n";
    assert!(is_of("v0.3.1", manifest).is_ok());
    for tag in ["0.3.1", "v0.3.2", "v0.3.1-rc"] {
        let why = is_of(tag, manifest).unwrap_err().to_string();
        assert!(why.contains(tag) && why.contains("v0.3.1 is"), "{why}");
    }
}

#[test]
fn every_image_has_a_name_of_its_own() {
    let names: Vec<String> = images("v0.3.1").collect();
    assert_eq!(names.len(), board::IMAGES.len());
    assert_eq!([&names[0], &names[5]], ["haptic-v0.3.1.elf", "haptic-v0.3.1-usb.elf"]);
    // Each is called as the feature that it is built with.
    for (features, name) in board::IMAGES.iter().zip(&names).skip(1) {
        let feature = features.last().expect("it has one");
        assert_eq!(*name, format!("haptic-v0.3.1-{feature}.elf"));
    }
}
