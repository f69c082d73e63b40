//! Parameters: whether the settings of two peers agree, and if not, in which table they differ.
//!
//! Two peers that couple with different gains are each stable in theory and not together. So every greeting carries a hash
//! of each table of parameters that must be equal, and a peer refuses another by naming the first that is not. What may
//! differ between the two ends (side of the object, motor, encoder) stays out. `FORMAT.md` says how the hash is made.
//!
//! **Limit**: 48 bits a table guard against accidents; against an enemy the greeting's tag does.

use heapless::Vec;

use crate::key::{Derivation, Key};
use crate::wire::{TABLES, TableHash};

/// One table on its way to a hash: name, then every key with its value, always in the same order.
#[derive(Clone)]
pub struct Table {
    name: &'static str,
    hash: Derivation,
}

impl Table {
    /// Begins the table called `name`.
    pub fn new(name: &'static str) -> Self {
        Self { name, hash: Key::new([0; Key::LEN]).derive("table") }.text_bytes(name)
    }

    fn text_bytes(self, text: &str) -> Self {
        let len = u32::try_from(text.len()).unwrap_or(u32::MAX);
        self.bytes(&len.to_le_bytes(), text.as_bytes())
    }

    fn bytes(self, first: &[u8], then: &[u8]) -> Self {
        Self { hash: self.hash.with(first).with(then), ..self }
    }

    /// A key whose value is a number, in the key's unit.
    pub fn number(self, key: &str, value: f64) -> Self {
        self.text_bytes(key).bytes(b"n", &value.to_le_bytes())
    }

    /// A key whose value is yes or no.
    pub fn flag(self, key: &str, value: bool) -> Self {
        self.text_bytes(key).bytes(b"f", &[u8::from(value)])
    }

    /// A key whose value is a name.
    pub fn text(self, key: &str, value: &str) -> Self {
        self.text_bytes(key).bytes(b"t", b"").text_bytes(value)
    }
}

/// Every table that both peers must agree on.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parameters {
    names: Vec<&'static str, TABLES>,
    hashes: Vec<TableHash, TABLES>,
}

/// There is no room for another table: a greeting names 16.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more than {TABLES} tables of parameters")]
pub struct TooManyTables;

impl Parameters {
    /// No table: peers agree whatever their settings are.
    pub fn new() -> Self {
        Self::default()
    }

    /// The tables of `keys`, each a table's name, a key's and its value, table by table; `put` says what kind of value it is.
    ///
    /// # Errors
    /// More tables than there is room for.
    pub fn of<V>(
        keys: impl IntoIterator<Item = (&'static str, &'static str, V)>,
        put: impl Fn(Table, &'static str, V) -> Table,
    ) -> Result<Self, TooManyTables> {
        let (mut all, mut last) = (Self::new(), None::<Table>);
        for (name, key, value) in keys {
            let table = match last.take() {
                Some(table) if table.name == name => table,
                other => {
                    other.map_or(Ok(()), |other| all.add(other))?;
                    Table::new(name)
                }
            };
            last = Some(put(table, key, value));
        }
        last.map_or(Ok(()), |table| all.add(table)).map(|()| all)
    }

    /// Adds a table; both peers add the same ones in the same order.
    ///
    /// # Errors
    /// More tables than there is room for.
    pub fn add(&mut self, table: Table) -> Result<(), TooManyTables> {
        self.names.push(table.name).map_err(|_| TooManyTables)?;
        self.hashes.push(table.hash.first()).map_err(|_| TooManyTables)
    }

    /// How many tables, and their hashes as a greeting carries them.
    pub(crate) fn hashes(&self) -> (u8, [TableHash; TABLES]) {
        let mut all = [TableHash::default(); TABLES];
        all.iter_mut().zip(&self.hashes).for_each(|(to, from)| *to = *from);
        (u8::try_from(self.hashes.len()).unwrap_or(u8::MAX), all)
    }

    /// The name of the first table in which a peer with `count` tables of these hashes differs.
    pub(crate) fn difference(&self, count: u8, tables: &[TableHash; TABLES]) -> Option<&'static str> {
        let theirs = tables.iter().take(usize::from(count));
        let mut differing =
            self.names.iter().zip(&self.hashes).zip(theirs).filter(|((_, ours), theirs)| ours != theirs);
        if let Some(((name, _), _)) = differing.next() {
            return Some(name);
        }
        match usize::from(count) {
            more if more > self.names.len() => Some("a table that this peer does not have"),
            fewer => self.names.get(fewer).copied(),
        }
    }
}
