//! The image's functions, by address: what they are called, how much stack each takes, whom it calls.
//!
//! From the unmodified release image: sizes and names are the symbol table's, and so is where data stand between the
//! instructions (`$d`, `$t`). The poll functions of tasks are all called alike there; which task each is of, say the names in
//! the debug information.

use std::collections::{BTreeMap, BTreeSet};

use gimli::{AttributeValue, EndianSlice, LittleEndian};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use super::thumb::Body;

/// A function of the image.
#[derive(Clone, Debug)]
pub struct Function {
    /// Its names, without hashes; several where equal ones were merged. A task's poll function is `task` and its path first.
    pub names: Vec<String>,
    /// Its instructions, as far as stack and calls go.
    pub body: Body,
}

/// The functions of an image.
#[derive(Debug)]
pub struct Code {
    /// Functions by their address.
    pub functions: BTreeMap<u64, Function>,
    /// Functions whose address stands in data or is made in code, the vector table's left out: what a call through a pointer
    /// may reach.
    pub taken: BTreeSet<u64>,
    /// Handlers in the vector table, but for Reset, which is thread mode, and HardFault, which takes a stack of its own.
    pub handlers: Vec<String>,
    /// Address and size of every static.
    pub statics: BTreeMap<String, (u64, u64)>,
}

type Bytes<'a> = EndianSlice<'a, LittleEndian>;

impl Code {
    /// Reads an image.
    ///
    /// # Panics
    /// It is not what the linker makes: no symbols, no debug information.
    pub fn read(elf: &[u8]) -> Self {
        let file = object::File::parse(elf).expect("the image is ELF");
        let mut names: BTreeMap<u64, (u64, Vec<String>)> = BTreeMap::new();
        let (mut data, mut statics) = (BTreeMap::new(), BTreeMap::new());
        for symbol in file.symbols() {
            let (Ok(name), address) = (symbol.name(), symbol.address()) else { continue };
            let plain = format!("{:#}", rustc_demangle::demangle(name));
            match (symbol.kind(), name.get(..2)) {
                (_, Some(mark @ ("$d" | "$t"))) => drop(data.insert(address, mark == "$d")),
                (SymbolKind::Text, _) if symbol.section_index().is_some() => {
                    let (size, all) = names.entry(address & !1).or_default();
                    *size = symbol.size().max(*size);
                    all.push(plain);
                }
                (SymbolKind::Data, _) => drop(statics.insert(plain, (address, symbol.size()))),
                _ => {}
            }
        }
        for (address, task) in polls(&file) {
            names.get_mut(&address).expect("a poll function is a symbol").1.insert(0, format!("task {task}"));
        }
        let sections: Vec<(u64, &[u8], SectionKind, &str)> = (file.sections())
            .filter(|section| section.kind() != SectionKind::Debug && section.size() > 0)
            .filter_map(|s| Some((s.address(), s.data().ok()?, s.kind(), s.name().ok()?)))
            .filter(|(_, data, kind, _)| {
                !data.is_empty() && !matches!(kind, SectionKind::Other | SectionKind::Metadata)
            })
            .collect();
        let is_data = |at: u64| data.range(..=at).next_back().is_some_and(|(_, data)| *data);
        let halfword = |at: u64| {
            let inside = |(start, data, kind, _): &&(u64, &[u8], SectionKind, &str)| {
                *kind == SectionKind::Text && (*start..start + data.len() as u64).contains(&at)
            };
            let (start, data, ..) = sections.iter().find(inside)?;
            let bytes = data.get((at - start) as usize..)?.first_chunk()?;
            (!is_data(at)).then(|| u16::from_le_bytes(*bytes))
        };
        let functions: BTreeMap<u64, Function> = names
            .into_iter()
            .map(|(start, (size, names))| {
                let body = Body::decode(start, start + size, halfword);
                (start, Function { names, body })
            })
            .collect();

        // What does not begin where a pointer may is a table of bytes: whatever four of them are.
        let tables = statics.values().filter(|(at, _)| at % 4 != 0);
        let tables: Vec<_> = tables.map(|(at, size)| *at..at + size).collect();
        let mut taken: BTreeSet<u64> =
            functions.values().flat_map(|function| function.body.constants.clone()).collect();
        let mut vectors = BTreeSet::new();
        for (start, data, kind, name) in &sections {
            let words = (*start..).step_by(4).zip(data.as_chunks().0).map(|(at, word)| (at, u32::from_le_bytes(*word)));
            if *name == ".vector_table" {
                vectors.extend(words.skip(1).map(|(_, word)| u64::from(word)));
            } else {
                let words = words.filter(|(at, _)| !tables.iter().any(|all| all.contains(at)));
                let data = words.filter(|(at, _)| *kind != SectionKind::Text || is_data(*at)).map(|(_, word)| word);
                let mut before = 0;
                taken.extend(
                    data.filter(|word| !ends_text(core::mem::replace(&mut before, *word), *word)).map(u64::from),
                );
            }
        }
        let function = |address: &u64| (address & 1 == 1).then(|| address - 1).filter(|at| functions.contains_key(at));
        let is_veneer = |function: &Function| function.names.iter().any(|name| veneer(name).is_some());
        let reached: BTreeSet<u64> =
            functions.values().filter(|f| is_veneer(f)).flat_map(|f| f.body.constants.clone()).collect();
        let taken = taken.difference(&reached).filter_map(function).collect();
        let handlers = (vectors.iter().filter_map(function))
            .map(|at| functions[&at].names[0].clone())
            .filter(|name| !["Reset", "HardFault"].contains(&&**name))
            .collect();
        Self { functions, taken, handlers, statics }
    }

    /// Every task, with address and size of its memory: its future, or several.
    pub fn tasks(&self) -> impl Iterator<Item = (String, (u64, u64))> + '_ {
        self.statics.iter().filter_map(|(name, place)| Some((short(name.strip_suffix("::POOL")?), *place)))
    }

    /// The function that a name stands for.
    pub fn find(&self, name: &str) -> Option<u64> {
        self.functions.iter().find(|(_, function)| function.names.iter().any(|known| known == name)).map(|(at, _)| *at)
    }
}

/// Whether a word after this one is the end of a text: "…al" looks like the address 0x6c61, which lies in ITCM.
fn ends_text(before: u32, word: u32) -> bool {
    before.to_le_bytes().iter().all(u8::is_ascii_graphic)
        && word.to_le_bytes().iter().all(|byte| *byte == 0 || byte.is_ascii_graphic())
}

/// The function that a veneer of the linker jumps to.
pub fn veneer(name: &str) -> Option<&str> {
    name.strip_prefix("__Thumbv7ABSLongThunk_")
}

/// The path without the package: `firmware::net::run` is `net::run`.
fn short(path: &str) -> String {
    path.trim_start_matches("firmware::").to_owned()
}

/// Address of every task's poll function, and the task.
fn polls(file: &object::File<'_>) -> Vec<(u64, String)> {
    let section = |id: gimli::SectionId| -> Result<Bytes<'_>, gimli::Error> {
        let data = file.section_by_name(id.name()).and_then(|section| section.data().ok()).unwrap_or_default();
        Ok(EndianSlice::new(data, LittleEndian))
    };
    let dwarf = gimli::Dwarf::load(section).expect("sections are read");
    let (mut found, mut units) = (Vec::new(), dwarf.units());
    while let Some(header) = units.next().expect("the debug information is sound") {
        let unit = dwarf.unit(header).expect("a unit");
        let mut entries = unit.entries();
        while let Some(entry) = entries.next_dfs().expect("an entry") {
            if entry.tag() != gimli::DW_TAG_subprogram {
                continue;
            }
            let Some(AttributeValue::Addr(address)) = entry.attr_value(gimli::DW_AT_low_pc) else { continue };
            let Some(name) = entry.attr_value(gimli::DW_AT_name) else { continue };
            let name = dwarf.attr_string(&unit, name).map(|name| name.to_string_lossy()).unwrap_or_default();
            // poll<firmware::net::__run_task::__run_task_inner_function::{async_fn_env#0}>
            let Some((path, _)) = name.strip_prefix("poll<").and_then(|name| name.split_once("_task::__")) else {
                continue;
            };
            found.push((address, short(&path.replacen("::__", "::", 1))));
        }
    }
    found
}
