//! Tests of `src/readme.rs` from inside.

use super::{markdown, shown};

#[test]
fn a_picture_is_where_its_link_says() {
    assert_eq!(shown("![a law, (or two)](../python/best.png)"), Some("../python/best.png"));
    assert_eq!(shown("<img src=\"docs/a.png\" width=\"500\" alt=\"a law\">"), Some("docs/a.png"));
    assert_eq!(["[no picture](a.png)", "words", "![a](b.png) and more"].map(shown), [None; 3]);
}

#[test]
fn an_aligned_table_becomes_markdown() {
    let printed =
        "a run\n\nname  unit  meaning\n----  ----  -------\nx_m   m     |x|, µm\nlong     -  \n\nname\n----\n";
    let expected = "| name | unit | meaning |\n|---|---|---|\n| `x_m` | m | \\|x\\|, µm |\n| `long` | – |  |\n";
    assert_eq!(markdown(printed).as_deref(), Some(expected));
    assert_eq!(markdown("no table\n- here\n"), None);
}
