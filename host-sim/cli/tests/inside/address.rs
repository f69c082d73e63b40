use super::{endpoint, endpoint_at};

#[test]
fn an_address_is_a_number_a_name_or_has_a_zone() {
    for (text, port, found) in [
        ("192.168.77.1:7701", None, "192.168.77.1:7701"),
        ("192.168.77.1", Some(7702), "192.168.77.1:7702"),
        ("192.168.77.1:7701", Some(7702), "192.168.77.1:7701"),
        ("[::1]:7701", None, "[::1]:7701"),
        ("::1", Some(7702), "[::1]:7702"),
        ("localhost:7701", None, "127.0.0.1:7701"),
        ("localhost", Some(7702), "127.0.0.1:7702"),
        // The loopback's number is 1 on Linux.
        ("[fe80::1%lo]:7701", None, "[fe80::1%1]:7701"),
    ] {
        assert_eq!(endpoint_at(text, port).expect(text).to_string(), found);
    }
}

#[test]
fn what_is_none_is_refused_by_an_example() {
    for text in ["192.168.77:7701", "192.168.77.1", ":7701", "localhost:70000", "fe80::1:7701", ""] {
        let refused = endpoint(text).expect_err(text).to_string();
        assert!(refused.starts_with(&format!("{text} is no address: it must be like 192.168.77.1:7701")), "{refused}");
    }
    // A name that nobody has: RFC 6761 keeps this ending free.
    let refused = endpoint("nobody.invalid:7701").expect_err("no such name").to_string();
    assert!(refused.starts_with("nobody.invalid:7701 is no address: "), "{refused}");
}
