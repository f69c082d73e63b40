//! Tests of `src/svg.rs` from inside.

use super::*;

#[test]
fn paths_are_relative_and_do_not_drift() {
    assert_eq!(path(&[(1.0, 2.0), (1.5, 2.0), (1.5, 1.0), (11.54, 0.46), (12.0, 1.0)]), "M1 2h.5v-1l10-.5l.5 .5");
    assert_eq!(path(&[]), "");
}

#[test]
fn reserved_and_forbidden_characters_do_not_break_the_document() {
    assert_eq!(escape("a<b & \"c\">\u{1}d"), "a&lt;b &amp; &quot;c&quot;&gt;d");
}

/// What made it and its data stand in the document, with what XML reserves escaped, and only where there is something.
#[test]
fn a_figure_carries_what_made_it_and_its_data() {
    let document = render(&Sheet::default(), "# cohold paper\nkey = \"a < b\"");
    assert!(
        document.contains("<metadata id=\"made\">\n# cohold paper\nkey = &quot;a &lt; b&quot;\n</metadata>"),
        "{document}"
    );
    let data = "x,y\n1,2\n".to_owned();
    let document = render(&Sheet { data, ..Sheet::default() }, "");
    assert!(document.contains("<metadata id=\"data\">\nx,y\n1,2\n</metadata>"), "{document}");
    assert!(!render(&Sheet::default(), "").contains("metadata"));
}
