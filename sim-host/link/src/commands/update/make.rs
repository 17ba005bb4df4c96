//! Packs an ELF file as an update, and signs it.

use std::fs;
use std::path::Path;

use columns::file::{MAX_DATA_BYTES, MAX_TEXT_BYTES};
use nucleo_g474re::pages::FLASH;
use update::key;

use super::{UpdateArgs, named, undamaged, version};
use crate::answer::Answer;
use crate::files::read;
use crate::link_error::LinkError;
use crate::update_file::{PackError, flash_bytes, pack};

/// Packs an ELF file as an update: `sim-host link file:OUT update ELF`.
pub fn make(args: &UpdateArgs, out: &Path) -> Result<Answer, LinkError> {
    if args.allow_downgrade {
        return Err(LinkError::Usage("--allow-downgrade is for sending: `sim-host link PORT update FILE`".into()));
    }
    let elf = args.file.as_deref().ok_or_else(|| LinkError::Usage("the ELF file is missing: `update ELF`".into()))?;
    let unpacked = |error: PackError| LinkError::Input(format!("{}: {error}", elf.display()));
    if out.extension().is_some_and(|extension| extension == "bin") {
        return make_flash_file(args, out, flash_bytes(&read(elf, MAX_DATA_BYTES)?).map_err(unpacked)?);
    }
    let seed = args.key.as_deref().map(seed).transpose()?;
    let seed = seed.unwrap_or(key::DEVELOPMENT_SEED);
    let bytes = pack(&read(elf, MAX_DATA_BYTES)?, Some(&seed)).map_err(unpacked)?;
    fs::write(out, &bytes).map_err(|io| LinkError::Write { path: out.to_owned(), io })?;
    let manifest = undamaged(&bytes)?;
    let line = format!("{}: {}, {} bytes, {}", out.display(), named(&manifest), bytes.len(), signer(&seed));
    Ok(Answer::to("update").line(line).field("bytes", bytes.len()).field("version", version(Some(manifest.identity.version))))
}

/// Writes the flash of a board without a first stage: `sim-host link file:OUT.bin update ELF`.
fn make_flash_file(args: &UpdateArgs, out: &Path, bytes: Vec<u8>) -> Result<Answer, LinkError> {
    if args.key.is_some() {
        return Err(LinkError::Usage("--key signs an update; a .bin file is not signed".into()));
    }
    fs::write(out, &bytes).map_err(|io| LinkError::Write { path: out.to_owned(), io })?;
    let line = format!(
        "{}: {} bytes of flash from {FLASH:#010x}; copy it to the drive that the Nucleo's USB port shows",
        out.display(),
        bytes.len()
    );
    Ok(Answer::to("update").line(line).field("bytes", bytes.len()))
}

/// Returns the key that signs, with a warning if everybody has it.
fn signer(seed: &[u8; 32]) -> String {
    match *seed {
        key::DEVELOPMENT_SEED => "signed by the development key, which is public: for the laboratory only".to_owned(),
        _ => format!("signed by the key {}", digits(&key::public(seed))),
    }
}

/// Reads the seed of a key from a file.
fn seed(file: &Path) -> Result<[u8; 32], LinkError> {
    let text = String::from_utf8_lossy(&read(file, MAX_TEXT_BYTES)?).trim().to_owned();
    let bytes: Option<Vec<u8>> = (0..text.len()).step_by(2).map(|n| u8::from_str_radix(text.get(n..n + 2)?, 16).ok()).collect();
    let seed = bytes.and_then(|bytes| <[u8; 32]>::try_from(bytes).ok());
    seed.ok_or_else(|| LinkError::Input(format!("{} is not a secret key: it needs 64 hexadecimal digits", file.display())))
}

fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_development_key_from_a_file_is_named() {
        let file = std::env::temp_dir().join(format!("sonoglide-key-{}", std::process::id()));
        let signer = |text: String| {
            fs::write(&file, text).unwrap();
            signer(&seed(&file).unwrap())
        };
        assert!(signer(digits(&key::DEVELOPMENT_SEED)).contains("the development key, which is public"));
        assert!(signer("01".repeat(32)).starts_with("signed by the key "));
        fs::remove_file(&file).unwrap();
        assert!(seed(&std::env::temp_dir()).unwrap_err().to_string().contains("it is a folder"));
    }
}
