//! `update`: sends another image to a board, which verifies it and installs it with a reset. If the
//! new image does not work, the board returns to the former one.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use columns::file::{MAX_DATA_BYTES, MAX_TEXT_BYTES};
use firmware::board::command::{Command, Reply};
use firmware::board::update::{CHUNK, Standing, UpdateDefect, UpdateReport, UpdateState, UpdateVerb};
use nucleo_g474re::options;
use nucleo_g474re::pages::FLASH;
use update::key;
use update::manifest::{MANIFEST, Manifest};

use crate::answer::Answer;
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::update_file::{PackError, flash_bytes, pack, read};

/// Maximum time for the board to verify the received image.
const VERIFY_TIMEOUT: Duration = Duration::from_secs(20);
/// Maximum time for the first stage to install it.
const INSTALL_TIMEOUT: Duration = Duration::from_secs(90);
/// Number of progress messages.
const PROGRESS_STEPS: usize = 10;

/// Arguments of `update`.
#[derive(Args, Clone, Debug, Default)]
pub struct UpdateArgs {
    /// Update file; with the port `file:OUT`, the ELF file to pack. Without it, show the running
    /// image and the state of an update.
    pub file: Option<PathBuf>,
    /// With `file:OUT`: file with the 64 hexadecimal digits of the secret signing key. The default
    /// is the development key, which is public.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Send a file with an older version than the running one. The board accepts it only while its
    /// user button is held.
    #[arg(long, requires = "file")]
    pub allow_downgrade: bool,
}

/// Shows the state of the board's image, or updates it.
pub fn run(args: &UpdateArgs, session: &mut Session) -> Result<Answer, LinkError> {
    if args.key.is_some() {
        return Err(LinkError::Usage("--key signs a file: `sim-host link file:OUT update ELF --key FILE`".into()));
    }
    let Some(file) = &args.file else { return Ok(shown(&ask(UpdateVerb::Report, session)?)) };
    let bytes = read(file, MAX_DATA_BYTES)?;
    let manifest = undamaged(&bytes)?;
    let before = ask(UpdateVerb::Report, session)?;
    if before.standing == Standing::Alone {
        let why =
            "this board has no first stage, and cannot be updated over the link: flash it with a probe (docs/dev/update.md)";
        return Err(LinkError::Failed(why.into()));
    }
    session.client.note(&format!("update: {}, {} bytes", named(&manifest), bytes.len()));
    let offered = manifest.identity.version;
    if let Some(running) = before.running.filter(|running| offered < *running) {
        if !args.allow_downgrade {
            let older = reason(UpdateDefect::OlderVersion { running, offered });
            return Err(LinkError::Failed(format!("nothing was sent: {older}")));
        }
        session.client.note("update: it is older than the running version: the user button of the board must be held now");
    }
    send(&bytes, session)?;
    session.client.note("update: all bytes have been received; the board verifies checksum and signature");
    match checked(session)?.state {
        UpdateState::Complete => {}
        state => return Err(refused(state)),
    }
    ask(UpdateVerb::Install, session)?;
    session.client.note("update: the board restarts and installs it, which takes about ten seconds. A power cut does no harm");
    session.client.order(Command::Reset)?;
    session.mark_silent();
    let after = installed(session)?;
    session.scale = None;
    session.agree_on_host_timeout()?;
    if after.standing == Standing::RolledBack || after.running != Some(manifest.identity.version) {
        let why = format!("the new image did not start or did not work: the board runs {} again", version(after.running));
        return Err(LinkError::Failed(why));
    }
    let line = format!(
        "firmware {} is running and confirmed; the former version was {}",
        version(after.running),
        version(before.running)
    );
    Ok(fields(Answer::to("update").line(line), &after))
}

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

/// Returns the manifest of an undamaged update. The board itself checks that the update is for this
/// board and correctly signed.
fn undamaged(bytes: &[u8]) -> Result<Manifest, LinkError> {
    let no = |why: &str| LinkError::Input(format!("this is not an update: {why}"));
    if bytes.starts_with(b"\x7fELF") {
        return Err(no("it is an ELF file. Pack it: `sim-host link file:OUT update ELF`"));
    }
    let head = bytes.first_chunk::<MANIFEST>().ok_or_else(|| no("it is too short"))?;
    let manifest = Manifest::decode(head).map_err(|defect| no(&reason(defect)))?;
    let image = &bytes[MANIFEST..];
    let same = Manifest::of(manifest.identity, manifest.origin, image);
    if same.length != manifest.length || same.checksum != manifest.checksum {
        return Err(no(&reason(UpdateDefect::Damaged)));
    }
    Ok(manifest)
}

fn ask(verb: UpdateVerb, session: &mut Session) -> Result<UpdateReport, LinkError> {
    match session.client.ask(Command::Update(verb))? {
        Reply::Update(report) => Ok(report),
        reply => Err(unexpected("update", &reply)),
    }
}

/// Sends all bytes in order.
fn send(bytes: &[u8], session: &mut Session) -> Result<(), LinkError> {
    match ask(UpdateVerb::Begin(bytes.len() as u32), session)?.state {
        UpdateState::Receiving(_) => {}
        state => return Err(refused(state)),
    }
    let mut step = 0;
    for (n, piece) in bytes.chunks(CHUNK).enumerate() {
        let mut chunk = [[0xff; 32]; CHUNK / 32];
        chunk.as_flattened_mut()[..piece.len()].copy_from_slice(piece);
        match ask(UpdateVerb::Write((n * CHUNK) as u32, chunk), session)?.state {
            UpdateState::Receiving(_) => {}
            state => return Err(refused(state)),
        }
        let sent = (n * CHUNK + piece.len()) * PROGRESS_STEPS / bytes.len();
        if sent > step {
            step = sent;
            session.client.note(&format!("update: {} % sent", 100 * step / PROGRESS_STEPS));
        }
    }
    Ok(())
}

/// Orders the board to verify the received bytes. It does not answer during the computation.
fn checked(session: &mut Session) -> Result<UpdateReport, LinkError> {
    let until = session.client.now() + VERIFY_TIMEOUT;
    let mut report = ask(UpdateVerb::Check, session)?;
    while report.state == UpdateState::Checking {
        match ask(UpdateVerb::Report, session) {
            Ok(next) => report = next,
            // The session of another client does not end by waiting.
            Err(error @ LinkError::Displaced { .. }) => return Err(error),
            Err(error) if error.is_lost() && session.client.now() < until => {}
            Err(error) => return Err(error),
        }
        if session.client.now() >= until {
            return Err(LinkError::Failed("the board has not finished verifying the update; send `reset` and try again".into()));
        }
    }
    Ok(report)
}

/// Waits until the board has restarted with a confirmed image, or with the former one.
fn installed(session: &mut Session) -> Result<UpdateReport, LinkError> {
    let until = session.client.now() + INSTALL_TIMEOUT;
    loop {
        let report = session.client.connect().and_then(|identity| {
            session.identity = identity;
            ask(UpdateVerb::Report, session)
        });
        match report {
            Ok(report) if report.standing != Standing::Trial && report.state != UpdateState::Marked => return Ok(report),
            // On trial: the image confirms itself after 0.1 s of blocks and an answer to the host.
            Ok(_) => {}
            Err(error) if !error.is_lost() => return Err(error),
            Err(_) => {}
        }
        if session.client.now() >= until {
            return Err(LinkError::Failed("the board does not answer; power it off and on to start the former image".into()));
        }
    }
}

fn shown(report: &UpdateReport) -> Answer {
    let standing = match report.standing {
        Standing::Alone => "it was flashed without a first stage and cannot be updated over the link",
        Standing::Confirmed => "it is confirmed: the first stage starts it",
        Standing::Trial => "it is on trial: a reset before it is confirmed restores the former image",
        Standing::RolledBack => "the first stage has restored it, because the image of the last update was not confirmed",
    };
    let mut answer =
        Answer::to("update").line(format!("firmware according to its manifest: {}; {standing}", version(report.running)));
    if report.standing != Standing::Alone {
        answer = answer.line(format!("room for an update: {} bytes; {}", report.room, state(report.state)));
    }
    let wrong: Vec<&str> = options::names(report.option_bytes).collect();
    let bytes = if wrong.is_empty() { "correct".into() } else { format!("not correct: {}", wrong.join(", ")) };
    fields(answer.line(format!("option bytes: {bytes}")), report).field("option_bytes_wrong", wrong)
}

fn fields(answer: Answer, report: &UpdateReport) -> Answer {
    let standing = match report.standing {
        Standing::Alone => "alone",
        Standing::Confirmed => "confirmed",
        Standing::Trial => "trial",
        Standing::RolledBack => "rolled_back",
    };
    keys(answer.field("version", report.running.map(|_| version(report.running))).field("standing", standing), report)
}

/// Adds a warning to an answer if the board accepts the development key.
fn keys(answer: Answer, report: &UpdateReport) -> Answer {
    let answer = answer.field("accepts_development_key", report.accepts_development_key);
    if !report.accepts_development_key {
        return answer;
    }
    answer.line("warning: this board accepts updates by the development key, which is public: anyone can sign for it")
}

/// Asks the board for its keys, and adds a warning to an answer if the development key is accepted.
pub(super) fn ask_keys(answer: Answer, session: &mut Session) -> Result<Answer, LinkError> {
    Ok(keys(answer, &ask(UpdateVerb::Report, session)?))
}

fn named(manifest: &Manifest) -> String {
    let board = String::from_utf8_lossy(&manifest.identity.board).trim_end_matches('\0').to_owned();
    let protocol = manifest.identity.protocol;
    format!("firmware {} for the board {board}, protocol {protocol}", version(Some(manifest.identity.version)))
}

fn version(version: Option<[u16; 3]>) -> String {
    version.map_or("none".into(), |[major, minor, patch]| format!("{major}.{minor}.{patch}"))
}

fn state(state: UpdateState) -> String {
    match state {
        UpdateState::Nothing => "no update was received since the start".into(),
        UpdateState::Receiving(bytes) => format!("{bytes} bytes of an update were received"),
        UpdateState::Checking => "an update was received and is being verified".into(),
        UpdateState::Complete => "an update was received and verified, but is not installed".into(),
        UpdateState::Marked => "an update is installed by the next reset".into(),
        UpdateState::Refused(defect) => format!("the last update was refused: {}", reason(defect)),
        UpdateState::FlashFailed => "the flash has failed".into(),
    }
}

fn refused(state: UpdateState) -> LinkError {
    let why = match state {
        UpdateState::Refused(defect) => reason(defect),
        UpdateState::FlashFailed => "its flash has failed; try again after `reset`".into(),
        other => format!("its state is: {}", self::state(other)),
    };
    LinkError::Failed(format!("the board refuses the update and keeps its image: {why}"))
}

/// Returns the reason why an update is refused.
pub fn reason(defect: UpdateDefect) -> String {
    match defect {
        UpdateDefect::NotAnUpdate => "it does not begin with a manifest".into(),
        UpdateDefect::Format(format) => format!("its manifest has the unknown format {format}"),
        UpdateDefect::OtherBoard => "it is for another board".into(),
        UpdateDefect::OlderProtocol(protocol) => {
            format!("its link protocol, {protocol}, is older than that of the running image")
        }
        UpdateDefect::OtherOrigin(origin) => format!("it is linked for {origin:#010x}, which is not the slot"),
        UpdateDefect::Length(bytes) => {
            format!("its length, {bytes} bytes, is not the announced one, or it does not fit")
        }
        UpdateDefect::Damaged => "it is damaged: a checksum is wrong".into(),
        UpdateDefect::Unsigned => "it is not signed".into(),
        UpdateDefect::WrongSignature => "it is not signed by a key of this board".into(),
        UpdateDefect::OlderVersion { running, offered } => format!(
            "the board runs {} and the update is the older {}. To go back, hold the user button of the board and send the \
             update with --allow-downgrade, or use a probe",
            version(Some(running)),
            version(Some(offered))
        ),
    }
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
