//! The release image: where it is, what it is called inside.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSection, ObjectSymbol};
use rigless::image::Image;

/// The image, ready to run, with its symbols and sections.
#[derive(Debug)]
pub struct Firmware {
    /// What the emulator loads.
    pub image: Image,
    /// Address and size of every named thing.
    pub symbols: BTreeMap<String, (u64, u64)>,
    /// Address and size of every section that takes memory.
    pub sections: BTreeMap<String, (u64, u64)>,
}

/// Where `cargo build --release -p firmware --target thumbv7em-none-eabihf` leaves it; `HAPTIC_FIRMWARE` names another.
pub fn path() -> PathBuf {
    std::env::var_os("HAPTIC_FIRMWARE").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/thumbv7em-none-eabihf/release/firmware"),
        PathBuf::from,
    )
}

impl Firmware {
    /// Reads an image.
    ///
    /// # Panics
    /// It is not there, with the command that makes it.
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|error| {
            panic!("{}: {error}; `cargo xtask board` builds it, or HAPTIC_FIRMWARE names it", path.display())
        });
        let elf = object::File::parse(&*bytes).expect("the image is ELF");
        let symbols =
            (elf.symbols().filter_map(|s| Some((s.name().ok()?.to_owned(), (s.address() & !1, s.size()))))).collect();
        let sections = (elf.sections().filter(|s| s.size() > 0))
            .filter_map(|s| Some((s.name().ok()?.to_owned(), (s.address(), s.size()))))
            .collect();
        Self { image: Image::read(path, None).expect("the emulator reads ELF"), symbols, sections }
    }

    /// The image under test.
    pub fn release() -> Self {
        Self::read(&path())
    }

    /// The address of a function or static.
    pub fn address(&self, symbol: &str) -> u64 {
        self.symbols.get(symbol).unwrap_or_else(|| panic!("the image has no {symbol}")).0
    }
}
