//! Files, read within bounds and written whole.
//!
//! **Reading** takes regular files alone: a pipe, a terminal or a device may have no end, or keep whoever opens it waiting. It
//! stops at as many bytes as what is read can have, and says so.
//!
//! **Writing** is all or nothing: the bytes go into a new file of the same folder whose name nobody can know before, and only once all
//! of them are on the disk does it get its own name. What is there and is no regular file, such as a link, stays and is named.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

/// How long a file of some kind may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Most {
    /// Largest number of bytes.
    pub bytes: u64,
    /// What has at most so many, with its article: `a scene`.
    pub of: &'static str,
}

impl Most {
    /// So many bytes, of a file that is called so.
    pub const fn new(bytes: u64, of: &'static str) -> Self {
        Self { bytes, of }
    }
}

/// What a file is written over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The file that the user named: what is there is replaced.
    Named,
    /// A file beside it: one that holds the same stays, and anything else there is an error.
    Beside,
    /// Whatever is there is an error.
    New,
    /// As [`Kind::New`], and only its owner may read it, from the first byte on.
    Secret,
}

/// Opens a regular file for reading; never waits.
///
/// # Errors
/// It cannot be opened, or is no regular file.
pub fn open(path: &Path) -> io::Result<File> {
    opened(OpenOptions::new().read(true), path, false)
}

/// Opens a regular file to write at its end, which is made if it is not there; never through a link, and never waits.
///
/// # Errors
/// It cannot be opened or made, is a link, or is no regular file.
pub fn append(path: &Path) -> io::Result<File> {
    opened(OpenOptions::new().create(true).append(true), path, true)
}

/// Begins a file that must not be there yet, for what is written over hours. What is whole in it, its own format tells.
///
/// # Errors
/// Something of this name is there, or the file cannot be made.
pub fn begin(path: &Path) -> io::Result<File> {
    OpenOptions::new().write(true).create_new(true).open(path)
}

fn opened(options: &mut OpenOptions, path: &Path, no_link: bool) -> io::Result<File> {
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
        let flags = if no_link { flags | OFlags::NOFOLLOW } else { flags };
        options.custom_flags(flags.bits() as i32);
    }
    if no_link {
        free_of_links(path)?;
    }
    let file = options.open(path)?;
    regular(&file.metadata()?).map(|()| file)
}

fn regular(what: &Metadata) -> io::Result<()> {
    let is = if what.is_file() {
        return Ok(());
    } else if what.is_dir() {
        "a folder"
    } else if what.is_symlink() {
        "a link"
    } else {
        "a pipe or a device"
    };
    Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {is}: it must be a regular file")))
}

/// What is there of this name, if anything is: a regular file, and no link to one.
fn free_of_links(path: &Path) -> io::Result<Option<Metadata>> {
    match path.symlink_metadata() {
        Ok(what) => regular(&what).map(|()| Some(what)),
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(None),
        Err(cause) => Err(cause),
    }
}

/// The bytes of a regular file.
///
/// # Errors
/// It cannot be read, is no regular file, or is longer than it may be.
pub fn read(path: &Path, most: Most) -> io::Result<Vec<u8>> {
    read_with(path, most).map(|(bytes, _)| bytes)
}

/// The bytes of a regular file, and whose it was when they were read.
///
/// # Errors
/// It cannot be read, is no regular file, or is longer than it may be.
pub fn read_with(path: &Path, most: Most) -> io::Result<(Vec<u8>, Metadata)> {
    let file = open(path)?;
    Ok((all(&file, most)?, file.metadata()?))
}

/// Everything that comes from there.
///
/// # Errors
/// It cannot be read, or is longer than it may be.
pub fn all(from: impl Read, most: Most) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most.bytes.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most.bytes {
        let Most { bytes, of } = most;
        return Err(io::Error::new(
            ErrorKind::FileTooLarge,
            format!("{of} has at most {bytes} bytes, and it has more"),
        ));
    }
    Ok(bytes)
}

/// The text in a regular file.
///
/// # Errors
/// It cannot be read, is no regular file, is longer than it may be, or is no UTF-8.
pub fn text(path: &Path, most: Most) -> io::Result<String> {
    String::from_utf8(read(path, most)?).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8"))
}

/// Whether there is a regular file of just these bytes.
pub fn is(path: &Path, bytes: &[u8]) -> bool {
    read(path, Most::new(bytes.len() as u64, "the same")).is_ok_and(|there| there == bytes)
}

/// Writes a file whole or not at all.
///
/// # Errors
/// It cannot be written, or what is there may not be written over: a link, a pipe, a device or a folder never.
pub fn write(path: &Path, bytes: &[u8], kind: Kind) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let there = free_of_links(path)?;
    match kind {
        Kind::Beside if is(path, bytes) => return Ok(()),
        Kind::Beside | Kind::New | Kind::Secret if there.is_some() => {
            return Err(io::Error::new(ErrorKind::AlreadyExists, "it exists, and is not written over"));
        }
        _ => {}
    }
    // Dropped under the name that it has at first, it is gone.
    let mut file = half(kind).tempfile_in(folder)?;
    if let Some(there) = there {
        file.as_file().set_permissions(there.permissions())?;
    }
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    if kind == Kind::Named { file.persist(path) } else { file.persist_noclobber(path) }
        .map_err(|refused| refused.error)?;
    // The name is on the disk as well, where a folder can be asked for that.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// How a file begins: its owner's alone if it is secret, else as the user's other files.
#[cfg_attr(not(unix), expect(unused_variables, reason = "only Unix has modes"))]
fn half(kind: Kind) -> tempfile::Builder<'static, 'static> {
    let mut half = tempfile::Builder::new();
    half.prefix(".half-");
    #[cfg(unix)]
    if kind != Kind::Secret {
        half.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    }
    half
}
