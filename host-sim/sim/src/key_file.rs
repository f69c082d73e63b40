//! The key that two peers share: 32 random bytes as 64 hexadecimal digits in a file that only its owner may read.

use std::{fs::OpenOptions, io::Write, path::Path};

use haptic_protocol::key::Key;

#[cfg(unix)]
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};

/// Randomness from the system.
pub fn entropy() -> Result<[u8; Key::LEN], String> {
    let mut bytes = [0; Key::LEN];
    getrandom::fill(&mut bytes).map_err(|cause| format!("no randomness: {cause}"))?;
    Ok(bytes)
}

/// Makes a new key file; an existing file is never overwritten.
pub fn generate(path: &Path) -> Result<(), String> {
    write(path, &Key::new(entropy()?))
}

/// Writes a key to a new file that only its owner may read; an existing file is never overwritten.
pub fn write(path: &Path, key: &Key) -> Result<(), String> {
    let digits: String = key.bytes().iter().map(|byte| format!("{byte:02x}")).collect();
    write_secret(path, format!("{digits}\n").as_bytes())
}

/// The same for a key in another form.
pub fn write_secret(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let failed = |cause: std::io::Error| format!("cannot make the key file {}: {cause}", path.display());
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    options.mode(0o600);
    options.open(path).map_err(failed)?.write_all(bytes).map_err(failed)
}

/// Reads a key file.
pub fn read(path: &Path) -> Result<Key, String> {
    let place = path.display();
    let text = std::fs::read_to_string(path).map_err(|cause| format!("cannot read the key file {place}: {cause}"))?;
    #[cfg(unix)]
    {
        let mode =
            std::fs::metadata(path).map_err(|cause| format!("cannot read the key file {place}: {cause}"))?.mode();
        if mode & 0o077 != 0 {
            return Err(format!("the key file {place} can be read by others: chmod 600 {place}"));
        }
    }
    let digits = text.trim();
    let bytes: Option<Vec<u8>> = (digits.len() == 2 * Key::LEN && digits.is_ascii())
        .then(|| (0..Key::LEN).map(|at| u8::from_str_radix(&digits[2 * at..2 * at + 2], 16).ok()).collect())
        .flatten();
    match bytes.and_then(|bytes| <[u8; Key::LEN]>::try_from(bytes).ok()) {
        Some(bytes) => Ok(Key::new(bytes)),
        None => Err(format!(
            "{place} is no key file: it must hold 64 hexadecimal digits, as `host-sim key generate` writes them"
        )),
    }
}
