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
    /// Texts of what the image can log, by number.
    pub statements: BTreeMap<u16, String>,
    /// Bytes of every section that has any, by address.
    contents: BTreeMap<u64, Vec<u8>>,
    /// Boards with it are not answered from what others did, and none from what they do.
    pub(crate) alone: bool,
}

/// Where `cargo build --release -p firmware --target thumbv7em-none-eabihf` leaves it; `COHOLD_FIRMWARE` names another.
pub fn path() -> PathBuf {
    std::env::var_os("COHOLD_FIRMWARE").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/thumbv7em-none-eabihf/firmware/firmware"),
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
            panic!("{}: {error}; `cargo xtask board` builds it, or COHOLD_FIRMWARE names it", path.display())
        });
        let file = object::File::parse(&*bytes).expect("the image is ELF");
        let symbols =
            (file.symbols().filter_map(|s| Some((s.name().ok()?.to_owned(), (s.address() & !1, s.size()))))).collect();
        let sections = (file.sections().filter(|s| s.size() > 0))
            .filter_map(|s| Some((s.name().ok()?.to_owned(), (s.address(), s.size()))))
            .collect();
        let text = |name: &str| {
            let statement: serde_json::Value = serde_json::from_str(name).ok()?;
            Some(statement.get("data")?.as_str()?.to_owned())
        };
        let statements =
            (file.symbols()).filter_map(|s| Some((u16::try_from(s.address()).ok()?, text(s.name().ok()?)?))).collect();
        let contents = (file.sections())
            .filter_map(|s| Some((s.address(), s.data().ok().filter(|data| !data.is_empty())?.to_vec())))
            .collect();
        Self {
            image: Image::read(path, None).expect("the emulator reads ELF"),
            symbols,
            sections,
            statements,
            contents,
            alone: false,
        }
    }

    /// The same for boards that are each emulated from power-on on, whatever others were told.
    #[must_use]
    pub fn alone(self) -> Self {
        Self { alone: true, ..self }
    }

    /// The image under test.
    pub fn release() -> Self {
        Self::read(&path())
    }

    /// The image for these features, or this board, which is next to it: `three-axes`, for example.
    pub fn with(features: &str) -> Self {
        Self::read(&path().with_file_name(format!("firmware-{features}")))
    }

    /// The address of a function or static.
    pub fn address(&self, symbol: &str) -> u64 {
        self.symbols.get(symbol).unwrap_or_else(|| panic!("the image has no {symbol}")).0
    }

    /// The code of a function, halfword by halfword.
    pub fn code(&self, symbol: &str) -> Vec<u16> {
        let (address, size) = *self.symbols.get(symbol).unwrap_or_else(|| panic!("the image has no {symbol}"));
        let (start, bytes) = self.contents.range(..=address).next_back().expect("the function lies in a section");
        let at = (address - start) as usize;
        let code = bytes.get(at..at + size as usize).expect("the function lies in its section");
        code.as_chunks().0.iter().map(|halfword| u16::from_le_bytes(*halfword)).collect()
    }

    /// A word of the image.
    pub fn word(&self, address: u64) -> u32 {
        let (start, bytes) = self.contents.range(..=address).next_back().expect("the word lies in a section");
        let at = (address - start) as usize;
        bytes
            .get(at..)
            .and_then(|bytes| bytes.first_chunk())
            .map(|bytes| u32::from_le_bytes(*bytes))
            .expect("all of it does")
    }

    /// Where a function returns: the addresses of its `bx lr` and of what loads the program counter from the stack.
    ///
    /// Constants between the instructions may look like one: an address that is never reached does no harm to a count.
    pub fn returns(&self, symbol: &str) -> Vec<u64> {
        let (code, start) = (self.code(symbol), self.address(symbol));
        let (mut at, mut found) = (0, Vec::new());
        while let Some(first) = code.get(at) {
            let wide = matches!(first >> 11, 0b11101..=0b11111);
            let second = if wide { code.get(at + 1).copied().unwrap_or(0) } else { 0 };
            let returns = match first {
                0x4770 => true,
                0xBD00..=0xBDFF => true,
                0xE8BD => second & 0x8000 != 0,
                0xF85D => second == 0xFB04,
                _ => false,
            };
            if returns {
                found.push(start + 2 * at as u64);
            }
            at += if wide { 2 } else { 1 };
        }
        found
    }
}
