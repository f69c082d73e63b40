//! Tests of `src/no_panic.rs` from inside.

use super::*;

#[test]
fn what_the_linker_has_no_place_for_is_named() {
    let said = "rust-lld: error: a.rcgu.o:(.text._RNvMs_4core3fmt) is being placed in '.text._RNvMs_4core3fmt'\n\
                rust-lld: error: b.rcgu.o:(.text.planted) is being placed in '.text.planted'\n\
                rust-lld: error: b.rcgu.o:(.comment) is being placed in '.comment'";
    assert_eq!(astray(said), ["_RNvMs_4core3fmt", "planted"]);
}
