//! What a board keeps: keys and values, and back.

use cohold_core::settings::{SetError, Value};
use firmware_parts::kept::Kept;

#[test]
fn every_key_leads_back_to_what_was_set() {
    let mut kept = Kept::default();
    for (key, text) in [
        ("board.hold_switch", "true"),
        ("network.dhcp", "true"),
        ("network.address", "10.1.2.3"),
        ("network.gateway", "10.1.2.254"),
        ("network.peer", "192.0.2.7"),
        ("coordination.comm", "power"),
        ("object.mass_kg", "0.30000000000000004"),
        ("contact.one_sided", "true"),
    ] {
        kept.set(key, Value::of_text(text)).unwrap();
        assert_eq!(kept.get(key).unwrap().to_string(), text);
    }
    let mut copy = Kept::default();
    for key in Kept::keys() {
        let text = kept.get(key).unwrap().to_string();
        copy.set(key, Value::of_text(&text)).unwrap();
    }
    assert_eq!(copy, kept);
    kept.set("network.gateway", Value::of_text("none")).unwrap();
    assert_eq!(kept.addresses.gateway, None);
}

#[test]
fn what_is_no_address_is_refused_with_what_would_be_one() {
    let mut kept = Kept::default();
    for text in ["10.1.2", "10.1.2.300", "board", "7", "true", "0.0.0.0", "255.255.255.255", "224.0.0.1"] {
        let Err(SetError::Refused(refused)) = kept.set("network.peer", Value::of_text(text)) else {
            panic!("{text} taken")
        };
        assert!(refused.to_string().ends_with("it must be an address such as 192.168.77.2, or strap"), "{refused}");
    }
    assert_eq!(kept.set("network.mask", Value::of_text("1")), Err(SetError::Unknown));
    assert_eq!(kept, Kept::default());
}
