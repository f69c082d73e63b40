//! A name of a network is one network.

use super::*;

/// What two lists call alike is the same network, so that a name says which.
#[test]
fn a_name_is_one_network() {
    for (name, settings) in IMPAIRMENTS.iter().chain(TUNING).chain(TEST) {
        let found = named().into_iter().find(|(known, _)| known == name);
        assert!(settings.is_empty() || found == Some((name, settings)), "{name}");
    }
    assert!(named().len() > 40 && !Network::names().any(|name| name == ALL));
}
