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
