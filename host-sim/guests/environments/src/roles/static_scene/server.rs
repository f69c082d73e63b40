//! Server: answers questions about a world from its database, and remembers nothing about who asked.

use crate::records::{Database, Object, Region, Scope, checksum_of, in_scope};
pub(crate) use cohold_protocol::wire::{Ask, Error, Page, Part, Payload, Topic};

/// Most parts that one question is answered with; what else it wants is asked for again.
pub const BURST: usize = 16;

/// One server of a world.
#[derive(Clone, Debug)]
pub struct Server<const OBJECTS: usize> {
    database: Database<OBJECTS>,
    world: u64,
    region: Option<u8>,
}

impl<const OBJECTS: usize> Server<OBJECTS> {
    /// A server of the whole world, or of one region and the margin around it.
    ///
    /// # Errors
    /// A number of the world that cannot be encoded.
    pub fn new(database: Database<OBJECTS>, region: Option<u8>) -> Result<Self, Error> {
        Ok(Self { world: database.checksum()?, database, region })
    }

    /// The database of the world.
    pub fn database(&self) -> &Database<OBJECTS> {
        &self.database
    }

    /// Checksum of the world.
    pub fn world(&self) -> u64 {
        self.world
    }

    /// Replaces the world; clients notice with the next part they get.
    ///
    /// # Errors
    /// A number of the world that cannot be encoded.
    pub fn publish(&mut self, database: Database<OBJECTS>) -> Result<(), Error> {
        *self = Self::new(database, self.region)?;
        Ok(())
    }

    /// The object with this number, if this server holds it.
    fn object(&self, number: usize) -> Option<&Object> {
        let object = self.database.objects().get(number)?;
        self.region.is_none_or(|region| self.in_scope(Scope::Region(region), object)).then_some(object)
    }

    fn in_scope(&self, scope: Scope, object: &Object) -> bool {
        in_scope(scope, &object.shape.bounds(), self.database.regions(), self.database.margin_m)
    }

    fn page(&self, number: usize, scope: Scope) -> Option<Page> {
        let first = number.checked_mul(Page::OBJECTS)?;
        self.database.objects().get(first)?;
        let mut page = Page::default();
        for (at, checksum) in page.checksums.iter_mut().enumerate() {
            let object = self.object(first.saturating_add(at)).filter(|object| self.in_scope(scope, object));
            if let Some(record) = object.and_then(|object| object.emit().ok()) {
                *checksum = checksum_of(&record);
                page.mask |= 1 << at;
            }
        }
        Some(page)
    }

    fn payload(&self, ask: &Ask, number: usize) -> Option<Payload> {
        match ask.topic {
            Topic::Manifest => (number == 0).then(|| Payload::Manifest(self.database.manifest())),
            Topic::Region => {
                self.database.regions().get(number).and_then(|region: &Region| region.emit().ok()).map(Payload::Region)
            }
            Topic::Page => self.page(number, ask.scope).map(Payload::Page),
            Topic::Object => self.object(number).and_then(|object| object.emit().ok()).map(Payload::Object),
        }
    }

    /// The parts that answer a question, [`BURST`] at the most.
    pub fn answer<'a>(&'a self, ask: &'a Ask) -> impl Iterator<Item = Part> + 'a {
        ask.numbers().take(BURST).filter_map(|number| {
            let payload = self.payload(ask, number)?;
            Some(Part { number: u16::try_from(number).ok()?, tag: ask.tag, world: self.world, payload })
        })
    }
}
