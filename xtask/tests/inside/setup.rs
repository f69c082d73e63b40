use super::*;

#[test]
fn only_a_yes_lets_a_package_be_installed() {
    for (answer, yes) in
        [("y\n", true), (" YES \n", true), ("\n", false), ("", false), ("n\ny\n", false), ("yikes\n", false)]
    {
        assert_eq!(is_yes(answer.as_bytes()), yes, "{answer:?}");
    }
}
