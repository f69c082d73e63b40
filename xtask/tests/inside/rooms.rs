//! Tests of `src/rooms.rs` from inside.

use super::*;

/// A house of two groups.
const HOUSE: &str = "# why\nheart core 100:\nheart sim 200: core\n\nguests page 50: sim\n";

/// The faults of this file, if these were the ones before it, newest first, and everything measures what it allows but for `sizes`.
fn judged(text: &str, earlier: &[&str], sizes: &[(&str, usize)]) -> Vec<String> {
    let read = |text: &&str| rows(text).expect("good rows");
    let now = read(&text);
    let mut measured: Sizes = now.iter().map(|(name, row)| (name.clone(), row.most)).collect();
    measured.extend(sizes.iter().map(|(name, size)| ((*name).to_owned(), *size)));
    let leans = now.iter().map(|(name, row)| (name.clone(), row.leans.clone())).collect();
    faults(&now, &earlier.iter().map(read).collect::<Vec<_>>(), &measured, &leans)
}

#[test]
fn who_leans_on_whom_is_read_from_what_cargo_says() {
    let tree = "0one v0.1.0 (/house/one)\n1serde v1.0.0\n1two v0.1.0 (/house/inside/two) (*)\n1two v0.1.0 (/house/inside/two)\n\n\
                0two v0.1.0 (/house/inside/two)\n1three v0.1.0 (/elsewhere/three)\n";
    let found = leaning(tree, Path::new("/house"));
    assert_eq!(found.keys().collect::<Vec<_>>(), ["inside/two", "one"]);
    assert_eq!(found["one"].iter().collect::<Vec<_>>(), ["inside/two"]);
    assert!(found["inside/two"].is_empty());
}

#[test]
fn rows_are_read_and_a_line_that_is_not_one_is_named() {
    let read = rows(HOUSE).expect("good rows");
    assert_eq!(read["sim"], Row { group: "heart".to_owned(), most: 200, leans: ["core".to_owned()].into() });
    for line in ["heart core many: sim", "heart core 100", "core 100:"] {
        let wrong = rows(line).expect_err("not a row").to_string();
        assert!(wrong.contains(&format!("`{line}` is not")), "{wrong}");
    }
}

#[test]
fn a_first_commit_and_one_without_changes_pass() {
    assert_eq!(judged(HOUSE, &[], &[]), [""; 0]);
    assert_eq!(judged(HOUSE, &[HOUSE, HOUSE], &[]), [""; 0]);
}

#[test]
fn a_row_rises_only_if_others_of_its_group_fall_by_as_much() {
    let paid = HOUSE.replace("core 100", "core 90").replace("sim 200", "sim 210");
    assert_eq!(judged(&paid, &[HOUSE], &[]), [""; 0]);
    let rises = |text: &str, earlier: &[&str], group: &str| {
        let wrong = judged(text, earlier, &[]);
        let said = format!("{group}: the sum of ceilings rises");
        assert!(wrong.iter().any(|wrong| wrong.starts_with(&said)), "{wrong:?}");
    };
    rises(&HOUSE.replace("sim 200", "sim 201"), &[HOUSE], "heart");
    rises(&HOUSE.replace("page 50", "page 51"), &[HOUSE], "heart and guests");
    // What the heart loses, guests may take.
    let moved = HOUSE.replace("core 100", "core 90").replace("page 50", "page 60");
    assert_eq!(judged(&moved, &[HOUSE], &[]), [""; 0]);
    rises(&moved.replace("page 60", "page 61"), &[HOUSE], "heart and guests");
    // A guest's lines buy the heart nothing, nor may a package change its group, nor does a new one come free.
    rises(&HOUSE.replace("sim 200", "sim 210").replace("page 50", "page 40"), &[HOUSE], "heart");
    rises(&HOUSE.replace("guests page", "heart page"), &[HOUSE], "heart");
    rises(&format!("{HOUSE}heart new 1:\n"), &[HOUSE], "heart");
    assert_eq!(judged(&format!("{}heart new 1:\n", HOUSE.replace("core 100", "core 99")), &[HOUSE], &[]), [""; 0]);
    // A fall that an earlier commit made pays for nothing.
    rises(&paid, &[&HOUSE.replace("core 100", "core 90"), HOUSE], "heart");
}

#[test]
fn a_row_stays_below_its_ceiling_and_near_it() {
    assert_eq!(judged(HOUSE, &[], &[("core", 98), ("sim", 195)]), [""; 0]);
    assert_eq!(judged(HOUSE, &[], &[("core", 101)]), ["core: 101 is above its ceiling of 100"]);
    assert_eq!(judged(HOUSE, &[], &[("core", 97)]), ["core: lower its ceiling from 100 to 97, as --bless does"]);
    let sizes = [("core", 97), ("sim", 195), ("page", 60)].map(|(name, size)| (name.to_owned(), size)).into();
    assert_eq!(lowered(HOUSE, &sizes).expect("good rows"), HOUSE.replace("core 100", "core 97"));
}

#[test]
fn the_heart_never_leans_anew_on_a_guest() {
    let leans = HOUSE.replace("core 100:", "core 100: page");
    assert_eq!(judged(&leans, &[&leans], &[]), [""; 0]);
    assert_eq!(judged(&leans, &[HOUSE], &[]), ["core: the heart newly leans on the guest page"]);
    assert_eq!(judged(&leans, &[&leans, HOUSE], &[]).len(), 1);
    assert_eq!(judged(&HOUSE.replace("page 50: sim", "page 50: core sim"), &[HOUSE], &[]), [""; 0]);
}

#[test]
fn the_file_and_the_workspace_agree() {
    let rows = rows(HOUSE).expect("good rows");
    let sizes = [("core", 100), ("sim", 200), ("new", 1)].map(|(name, size)| (name.to_owned(), size)).into();
    let leans =
        [("core", "sim"), ("sim", "core")].map(|(name, leant)| (name.to_owned(), [leant.to_owned()].into())).into();
    let wrong = faults(&rows, &[], &sizes, &leans).join("\n");
    for name in ["new: ", "page: "] {
        assert!(wrong.contains(&format!("{name}{FILE} and the workspace differ")), "{wrong}");
    }
    assert!(wrong.contains(&format!("core: {FILE} and cargo differ on whether it leans on sim")), "{wrong}");
    assert!(!wrong.contains("\nsim: "), "{wrong}");
}
