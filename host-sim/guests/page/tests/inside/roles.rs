use super::*;
use crate::Model;
use crate::boards_line::Line;

fn keys() -> Keys {
    Keys(["00ff", "01ff", "02ff", "03ff"].map(str::to_owned))
}

const WATCH: Rights = Rights { hand: None, operates: false };
const OPERATOR: Rights = Rights { hand: None, operates: true };

fn hand(index: usize) -> Rights {
    Rights { hand: Some(index), operates: false }
}

#[test]
fn a_ring_opens_what_its_keys_open_together() {
    for (roles, rights) in [
        (&[Role::Watch][..], WATCH),
        (&[Role::Hand1], hand(0)),
        (&[Role::Hand2], hand(1)),
        (&[Role::Operator], OPERATOR),
        (&[Role::Hand2, Role::Operator], Rights { hand: Some(1), operates: true }),
        (&[Role::Watch, Role::Hand1], hand(0)),
    ] {
        assert_eq!(keys().opened_by(&keys().ring(roles)), Some(rights), "{roles:?}");
    }
}

/// No key opens another role, however its address is changed, and what is no key opens nothing, whatever stands beside it.
#[test]
fn a_key_opens_its_own_role_and_no_other() {
    let keys = keys();
    for role in Role::ALL {
        let own = keys.ring(&[*role]);
        let (_, key) = own.split_once('-').expect("a role");
        for other in Role::NAMES.iter().filter(|name| **name != role.name()) {
            assert_eq!(keys.opened_by(&format!("{other}-{key}")), None, "{role:?} as {other}");
            assert_eq!(keys.opened_by(&format!("{own}+{other}-{key}")), None, "{role:?} and {other}");
        }
        for bad in ["", "-", "+", &format!("-{key}"), &format!("{own}+"), &format!("+{own}"), &format!("{own}0")] {
            assert_eq!(keys.opened_by(bad), None, "{bad}");
        }
        for (name, number) in [("0", 0), ("1", 1), ("2", 2)] {
            assert_eq!(keys.opened_by(&format!("{name}-{key}")), None, "{number}");
        }
    }
    assert_eq!(keys.opened_by(&keys.ring(&[Role::Hand1, Role::Hand2])), None);
}

#[test]
fn keys_are_new_in_each_run_and_all_different() {
    let runs = [Keys::new().expect("keys"), Keys::new().expect("keys")];
    let mut all: Vec<_> = runs.iter().flat_map(|keys| keys.0.clone()).collect();
    assert!(all.iter().all(|key| key.len() == 32), "{all:?}");
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 2 * Role::ALL.len());
}

#[test]
fn the_operator_orders_a_hand_stops_and_who_watches_does_nothing() {
    let orders = [
        Some(Command::Start),
        Some(Command::Cut(true)),
        Some(Command::Cut(false)),
        Some(Command::Partner(Model::Absent)),
        Some(Command::Board(1, Line::Arm)),
        Some(Command::Board(1, Line::Clear)),
        Some(Command::Board(2, Line::Check(1))),
        None,
    ];
    for order in orders {
        assert!(OPERATOR.may(order.as_ref()), "{order:?}");
        for rights in [WATCH, hand(0), hand(1)] {
            assert!(!rights.may(order.as_ref()), "{rights:?} {order:?}");
        }
    }
    let stop = Some(Command::Stop);
    assert_eq!([OPERATOR, hand(0), WATCH].map(|rights| rights.may(stop.as_ref())), [true, true, false]);
}
