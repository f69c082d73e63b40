use super::*;

const HERE: Ipv4Addr = Ipv4Addr::LOCALHOST;
const WIFI: Ipv4Addr = Ipv4Addr::new(192, 168, 1, 5);
const VIRTUAL: Ipv4Addr = Ipv4Addr::new(172, 17, 0, 1);
const PUBLIC: Ipv4Addr = Ipv4Addr::new(192, 0, 2, 2);

fn own(addresses: &[Ipv4Addr]) -> Vec<Named> {
    let name = |address: Ipv4Addr| match address {
        HERE => "lo",
        WIFI => "wlan0",
        VIRTUAL => "docker0",
        _ => "eth0",
    };
    addresses.iter().map(|address| (name(*address).to_owned(), *address)).collect()
}

#[test]
fn the_only_private_address_needs_no_name() {
    assert_eq!(chosen(None, &own(&[HERE, WIFI])), Ok(WIFI));
    assert_eq!(chosen(None, &own(&[HERE, PUBLIC, VIRTUAL])), Ok(VIRTUAL));
    for address in [HERE, WIFI, PUBLIC] {
        assert_eq!(chosen(Some(address), &own(&[HERE, WIFI, PUBLIC])), Ok(address));
    }
}

/// One error each, which says what the machine has.
#[test]
fn what_is_not_one_address_of_this_machine_is_refused_with_those_it_has() {
    let several = "192.168.1.5 (wlan0), 172.17.0.1 (docker0)";
    for (wanted, addresses, says) in [
        (None, &[HERE, WIFI, VIRTUAL][..], format!("--lan finds more than one address: name one of {several}")),
        (None, &[HERE, PUBLIC], "no private address of this machine: it has 192.0.2.2 (eth0)".to_owned()),
        (None, &[HERE], "no private address of this machine: no other is known".to_owned()),
        (Some(Ipv4Addr::UNSPECIFIED), &[HERE, WIFI], "every network of this machine".to_owned()),
        (
            Some(Ipv4Addr::new(10, 0, 0, 1)),
            &[HERE, WIFI, VIRTUAL],
            format!("no address of this machine: it has {several}"),
        ),
        (Some(Ipv4Addr::BROADCAST), &[HERE, WIFI], "no address of this machine".to_owned()),
    ] {
        let error = chosen(wanted, &own(addresses)).expect_err("refused");
        assert!(error.contains(&says) && !error.contains('\n'), "{error}: {says}");
    }
}

/// A listener hears at its own address only.
#[test]
fn each_door_is_one_address() {
    let (doors, listeners) = Doors::open(0, Some(Ipv4Addr::new(127, 0, 0, 2))).expect("two ports");
    let at = |way| doors.host(way).expect("a way in");
    let bound: Vec<_> = listeners
        .iter()
        .map(|(way, listener)| (at(*way), listener.local_addr().expect("an address").to_string()))
        .collect();
    assert!(bound.iter().all(|(named, bound)| named == bound), "{bound:?}");
    assert!(at(Way::Lan).starts_with("127.0.0.2:") && Doors::open(0, None).expect("a port").0.host(Way::Lan).is_none());
    assert!(Doors::open(0, Some(Ipv4Addr::new(198, 51, 100, 7))).is_err(), "it is another machine's");
}
