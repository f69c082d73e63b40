//! The step `no-panic`: no panic is reachable from the 1 kHz interrupt, and all that is lies in ITCM, shown by the linker
//! (firmware/src/no_panic.rs).
//!
//! The proof must link, and must fail to link once a panic is planted outside ITCM, for the very reasons that it looks for.

use std::process::Command;

use crate::board;
use crate::run::{self, Failure};
use crate::setup::{Ready, THUMB_TARGET};

/// What the proof's panic handler calls, and nobody defines.
const NOWHERE: &str = "undefined symbol: a_panic_is_reachable_from_the_tick";

/// Links the proof of the image with these features, or the one with the mistake. The second board's has the laws of other papers as well,
/// so that those are proved, too.
pub(crate) fn link(ready: &Ready, feature: &str, image: &[&str]) -> Command {
    let words = ["build", "--locked", "--profile", "firmware", "--package", "firmware", "--bin", "no-panic"];
    let mut build = ready.cargo(&words);
    let image = image.join(" ").replace("h753zi", "h753zi,all-laws");
    build.args(["--features", feature, "--target", THUMB_TARGET]).args(image.split_whitespace());
    build
}

/// What the linker says of code that no place is for: the tick's, outside ITCM.
const ASTRAY: &str = ") is being placed in '.text";

/// Links the proof of each image, and with the mistake that of the first: linker and memory.x are one for all.
pub(crate) fn no_panic(ready: &Ready) -> Result<(), Failure> {
    board::IMAGES.into_iter().try_for_each(|image| proves(link(ready, "proof", image)))?;
    match run::told(&mut link(ready, "planted-panic", board::IMAGES[0]))? {
        (false, words) if words.contains(NOWHERE) && astray(&words).contains(&"planted") => Ok(()),
        (true, _) => Err(Failure::new("the proof links with a panic planted in it: it proves nothing")),
        (false, words) => {
            eprint!("{words}");
            Err(Failure::new("with a panic planted in it the proof fails for another reason (see above)"))
        }
    }
}

/// Links a proof, and says why it does not.
fn proves(mut proof: Command) -> Result<(), Failure> {
    let (linked, words) = run::told(&mut proof)?;
    if !linked {
        let reason = if words.contains(NOWHERE) {
            "a panic is reachable from the tick: look for an index, an unwrap, an integer division or a clamp"
                .to_owned()
        } else if words.contains(ASTRAY) {
            format!("the tick calls what is not in ITCM: put {} into memory.x", astray(&words).join(", "))
        } else {
            "the proof does not build".to_owned()
        };
        eprint!("{words}");
        return Err(Failure::new(format!("{reason} (`{}`)", run::spelled(&proof))));
    }
    Ok(())
}

/// Names of functions that the linker had no place for.
fn astray(words: &str) -> Vec<&str> {
    let sections = words.lines().filter(|line| line.contains(ASTRAY)).filter_map(|line| line.rsplit_once("'.text."));
    sections.map(|(_, name)| name.trim_end_matches('\'')).collect()
}

#[cfg(test)]
#[path = "../tests/inside/no_panic.rs"]
mod tests;
