//! Key files: 32 random bytes as 64 hexadecimal digits in a file that only its owner may read.
//!
//! **Roles**: a file of peers, or of one line to a hub or server, has the digits alone; the operator's of a board says `operator`
//! before them. Whoever reads one says which it has to be, and the other is refused by name.
//!
//! **Reading** takes no more than [`LONGEST`] bytes of a regular file, and judges owner and mode of the file that was read, not of
//! whatever its name means a moment later. **Writing** is all or nothing, and an existing file is never touched ([`cohold_io`]).

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use cohold_io::{Kind, Most};
use cohold_protocol::key::{Key, Role};
use cohold_sim::Error;

/// Longest key file, bytes: the digits, what they are for, and some space around them.
pub const LONGEST: usize = 2 * Key::LEN + 64;
/// What stands before the digits of the operator's.
const OPERATOR: &str = "operator ";

/// Randomness from the system, mixed with what differs from draw to draw, so that a source that repeats itself repeats nothing here.
///
/// # Errors
/// The system gives no random bytes.
pub fn entropy() -> Result<[u8; Key::LEN], Error> {
    let mut bytes = [0; Key::LEN];
    getrandom::fill(&mut bytes).map_err(|cause| format!("no randomness: {cause}"))?;
    Ok(hedged(bytes))
}

/// [`entropy`] from the bytes that the system's source gave.
#[doc(hidden)]
pub fn hedged(noise: [u8; Key::LEN]) -> [u8; Key::LEN] {
    static DRAWN: AtomicU64 = AtomicU64::new(0);
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let (process, drawn) = (std::process::id(), DRAWN.fetch_add(1, Ordering::Relaxed));
    Key::new(noise).hedged(&[&since.to_le_bytes(), &process.to_le_bytes(), &drawn.to_le_bytes()])
}

/// Makes a new key file; an existing file is never overwritten.
///
/// # Errors
/// The file exists or cannot be written, or the system gives no random bytes.
pub fn generate(path: &Path, role: Role) -> Result<(), Error> {
    write(path, role, &Key::new(entropy()?))
}

/// Writes a key to a new file that only its owner may read; an existing file is never overwritten.
///
/// # Errors
/// The file exists or cannot be written.
pub fn write(path: &Path, role: Role, key: &Key) -> Result<(), Error> {
    let digits: String = key.bytes().iter().map(|byte| format!("{byte:02x}")).collect();
    let word = if role == Role::Operator { OPERATOR } else { "" };
    write_secret(path, format!("{word}{digits}\n").as_bytes())
}

/// Writes a secret in any form to a new file that only its owner may read; an existing file is never overwritten.
///
/// # Errors
/// The file exists or cannot be written.
pub fn write_secret(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    cohold_io::write(path, bytes, Kind::Secret).map_err(Error::cannot("make the key file", &path.display()))
}

/// Reads the key file of a role.
///
/// # Errors
/// The file cannot be read, may be read by others, or holds no key of this role.
pub fn read(path: &Path, role: Role) -> Result<Key, Error> {
    let place = path.display();
    let most = Most::new(LONGEST as u64, "a key file");
    let (bytes, file) = cohold_io::read_with(path, most).map_err(Error::cannot("read the key file", &place))?;
    let (is, key) = parse(&bytes).ok_or_else(|| {
        format!("{place} is no key file: it must hold 64 hexadecimal digits, as `cohold key generate` writes them")
    })?;
    if is != role {
        let said = match role {
            Role::Peers => format!(
                "{place} is an operator's key file, and one of peers is needed here: `cohold key generate` makes them"
            ),
            Role::Operator => format!(
                "{place} is a key file of peers, and the operator's is needed here: `cohold key generate --operator` makes them"
            ),
        };
        return Err(said.into());
    }
    #[cfg(unix)]
    own(path, &file)?;
    // Windows has access-control lists in place of owner and mode. They are not checked.
    #[cfg(not(unix))]
    let _ = file;
    Ok(key)
}

/// The key in a file of these bytes, and what it is for.
fn parse(bytes: &[u8]) -> Option<(Role, Key)> {
    let text = std::str::from_utf8(bytes).ok().filter(|_| bytes.len() <= LONGEST)?.trim();
    let (role, digits) = match text.strip_prefix(OPERATOR) {
        Some(digits) => (Role::Operator, digits),
        None => (Role::Peers, text),
    };
    if digits.len() != 2 * Key::LEN || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let mut key = [0; Key::LEN];
    for (byte, at) in key.iter_mut().zip((0..).step_by(2)) {
        *byte = u8::from_str_radix(digits.get(at..at + 2)?, 16).ok()?;
    }
    Some((role, Key::new(key)))
}

/// Nobody else can read the file, or put another key into it.
#[cfg(unix)]
fn own(path: &Path, file: &std::fs::Metadata) -> Result<(), Error> {
    use std::os::unix::fs::MetadataExt;
    let (place, mode, owner) = (path.display(), file.mode() & 0o7777, file.uid());
    let user = rustix::process::geteuid();
    // Whoever asks for root's rights to run this, for its priority, keeps his keys.
    let asked = std::env::var("SUDO_UID").ok().and_then(|user| user.parse().ok()).filter(|_| user.is_root());
    if owner != user.as_raw() && Some(owner) != asked {
        let user = user.as_raw();
        return Err(Error::Refused(format!(
            "the key file {place} belongs to user {owner} and not to user {user}, who runs this: chown {user} {place}"
        )));
    }
    cohold_sim::refuse_if!(
        mode & 0o077 != 0,
        "the key file {place} (mode {mode:03o}) is open to others than its owner: chmod 600 {place}"
    );
    Ok(())
}
