use super::wrapped;

#[test]
fn words_stay_whole_and_lines_within_the_width() {
    let text = "one of \"power\", \"wave\" – and a_very_long_name_that_does_not_fit_at_all, then more";
    let lines: Vec<String> = wrapped(text, 30, 4).lines().map(str::to_owned).collect();
    assert!(lines.iter().all(|line| line.starts_with("    ") && !line.ends_with(' ')), "{lines:?}");
    assert!(
        lines.iter().filter(|line| line.chars().count() > 30).eq(["    a_very_long_name_that_does_not_fit_at_all,"])
    );
    let words: Vec<&str> = lines.iter().flat_map(|line| line.split_whitespace()).collect();
    assert_eq!(words, text.split_whitespace().collect::<Vec<_>>());
}
