//! `update`: sends another image to a board, which checks it, installs it with a reset, and returns to the former one unless the new one serves.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use firmware::board::command::{Command, Reply};
use firmware::board::update::{CHUNK, Standing, UpdateDefect, UpdateReport, UpdateState, UpdateVerb};
use nucleo_g474re::options;
use update::key;
use update::manifest::{MANIFEST, Manifest};

use crate::answer::Answer;
use crate::client::unexpected;
use crate::link_error::LinkError;
use crate::session::Session;
use crate::update_file::pack;

/// How long the board may check what it has received, and how long the first stage may take to install it.
const CHECKED_WITHIN: Duration = Duration::from_secs(20);
const INSTALLED_WITHIN: Duration = Duration::from_secs(90);
/// Messages of the progress.
const STEPS: usize = 10;

/// Arguments of `update`.
#[derive(Args, Clone, Debug, Default)]
pub struct UpdateArgs {
    /// The update; with the port `file:OUT`, the ELF file that it is made of. Without it: what runs, and how an update stands.
    pub file: Option<PathBuf>,
    /// With `file:OUT`: a file with the 64 hexadecimal digits of the secret key that signs; without it, the development key, which is public.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
}

/// Shows how the board stands, or updates it.
pub fn run(args: &UpdateArgs, session: &mut Session) -> Result<Answer, LinkError> {
    if args.key.is_some() {
        return Err(LinkError::Usage("--key signs a file: `sim-host link file:OUT update ELF --key FILE`".into()));
    }
    let Some(file) = &args.file else { return Ok(shown(&ask(UpdateVerb::Report, session)?)) };
    let bytes = read(file)?;
    let manifest = whole(&bytes)?;
    let before = ask(UpdateVerb::Report, session)?;
    if before.standing == Standing::Alone {
        let why = "this board has no first stage, and cannot be updated over the link: flash it by a probe (docs/update.md)";
        return Err(LinkError::Failed(why.into()));
    }
    session.client.note(&format!("update: {}, {} bytes", named(&manifest), bytes.len()));
    send(&bytes, session)?;
    session.client.note("update: all bytes are there; the board checks checksum and signature");
    match checked(session)?.state {
        UpdateState::Complete => {}
        state => return Err(refused(state)),
    }
    ask(UpdateVerb::Install, session)?;
    session
        .client
        .note("update: the board restarts, and installs it; this takes about ten seconds. A power cut now does no harm");
    session.client.order(Command::Reset)?;
    session.is_silent();
    let after = installed(session)?;
    session.scale = None;
    session.agree_on_host_timeout()?;
    if after.standing == Standing::RolledBack || after.running != Some(manifest.identity.version) {
        let why = format!("the new image did not start or did not serve: the board runs {} again", version(after.running));
        return Err(LinkError::Failed(why));
    }
    let line = format!("firmware {} runs, and is confirmed; before, it was {}", version(after.running), version(before.running));
    Ok(fields(Answer::to("update").line(line), &after))
}

/// Makes the file of an update of an ELF file: `sim-host link file:OUT update ELF`.
pub fn make(args: &UpdateArgs, out: &Path) -> Result<Answer, LinkError> {
    let elf = args.file.as_deref().ok_or_else(|| LinkError::Usage("an update is made of an ELF file: `update ELF`".into()))?;
    let seed = args.key.as_deref().map(seed).transpose()?;
    let bytes = pack(&read(elf)?, Some(&seed.unwrap_or(key::DEVELOPMENT_SEED)))
        .map_err(|error| LinkError::Input(format!("{}: {error}", elf.display())))?;
    fs::write(out, &bytes).map_err(|io| LinkError::Write { path: out.to_owned(), io })?;
    let manifest = whole(&bytes)?;
    let signer = match seed {
        None => "signed by the development key, which is public: for the laboratory only".to_owned(),
        Some(seed) => format!("signed by the key {}", digits(&key::public(&seed))),
    };
    let line = format!("{}: {}, {} bytes, {signer}", out.display(), named(&manifest), bytes.len());
    Ok(Answer::to("update").line(line).field("bytes", bytes.len()).field("version", version(Some(manifest.identity.version))))
}

fn read(file: &Path) -> Result<Vec<u8>, LinkError> {
    fs::read(file).map_err(|error| LinkError::Input(format!("{} cannot be read: {error}", file.display())))
}

/// The seed in a key's file.
fn seed(file: &Path) -> Result<[u8; 32], LinkError> {
    let text = String::from_utf8_lossy(&read(file)?).trim().to_owned();
    let bytes: Option<Vec<u8>> = (0..text.len()).step_by(2).map(|n| u8::from_str_radix(text.get(n..n + 2)?, 16).ok()).collect();
    let seed = bytes.and_then(|bytes| <[u8; 32]>::try_from(bytes).ok());
    seed.ok_or_else(|| LinkError::Input(format!("{} is not a secret key: it needs 64 hexadecimal digits", file.display())))
}

fn digits(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The manifest of an update whose bytes are whole. Whether it is for the board, and rightly signed, is for the board to say.
fn whole(bytes: &[u8]) -> Result<Manifest, LinkError> {
    let no = |why: &str| LinkError::Input(format!("this is not an update: {why}"));
    if bytes.starts_with(b"\x7fELF") {
        return Err(no("it is an ELF file. Make one of it: `sim-host link file:OUT update ELF`"));
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

/// Sends all bytes, in order.
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
        let sent = (n * CHUNK + piece.len()) * STEPS / bytes.len();
        if sent > step {
            step = sent;
            session.client.note(&format!("update: {} % sent", 100 * step / STEPS));
        }
    }
    Ok(())
}

/// Has the board check what it has received. It answers nothing while it computes.
fn checked(session: &mut Session) -> Result<UpdateReport, LinkError> {
    let until = session.client.now() + CHECKED_WITHIN;
    let mut report = ask(UpdateVerb::Check, session)?;
    while report.state == UpdateState::Checking {
        match ask(UpdateVerb::Report, session) {
            Ok(next) => report = next,
            // Another session does not become this one again.
            Err(error @ LinkError::Displaced { .. }) => return Err(error),
            Err(error) if error.is_lost() && session.client.now() < until => {}
            Err(error) => return Err(error),
        }
        if session.client.now() >= until {
            return Err(LinkError::Failed("the board has not finished its check of the update; `reset`, and try again".into()));
        }
    }
    Ok(report)
}

/// Waits until the board is back and its image is confirmed, or the former one has been brought back.
fn installed(session: &mut Session) -> Result<UpdateReport, LinkError> {
    let until = session.client.now() + INSTALLED_WITHIN;
    loop {
        let report = session.client.connect().and_then(|identity| {
            session.identity = identity;
            ask(UpdateVerb::Report, session)
        });
        match report {
            Ok(report) if report.standing != Standing::Trial && report.state != UpdateState::Marked => return Ok(report),
            // On trial: it confirms itself once it has served blocks for 0.1 s and has answered.
            Ok(_) => {}
            Err(error) if !error.is_lost() => return Err(error),
            Err(_) => {}
        }
        if session.client.now() >= until {
            return Err(LinkError::Failed("the board has not come back; power it off and on: the former image starts".into()));
        }
    }
}

fn shown(report: &UpdateReport) -> Answer {
    let standing = match report.standing {
        Standing::Alone => "it was flashed without a first stage, and cannot be updated over the link",
        Standing::Confirmed => "it is the one that the first stage starts",
        Standing::Trial => "it is on trial: a reset before it is confirmed brings the former image back",
        Standing::RolledBack => "the first stage has brought it back, because the image of the last update was not confirmed",
    };
    let mut answer = Answer::to("update").line(format!("firmware by its manifest: {}; {standing}", version(report.running)));
    if report.standing != Standing::Alone {
        answer = answer.line(format!("room for an update: {} bytes; {}", report.room, state(report.state)));
    }
    let wrong: Vec<&str> = options::names(report.option_bytes).collect();
    let bytes =
        if wrong.is_empty() { "as they should be".into() } else { format!("not as they should be: {}", wrong.join(", ")) };
    fields(answer.line(format!("option bytes: {bytes}")), report).field("option_bytes_wrong", wrong)
}

fn fields(answer: Answer, report: &UpdateReport) -> Answer {
    let standing = match report.standing {
        Standing::Alone => "alone",
        Standing::Confirmed => "confirmed",
        Standing::Trial => "trial",
        Standing::RolledBack => "rolled_back",
    };
    answer.field("version", report.running.map(|_| version(report.running))).field("standing", standing)
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
        UpdateState::Nothing => "none was received since the start".into(),
        UpdateState::Receiving(bytes) => format!("{bytes} bytes of one were received"),
        UpdateState::Checking => "one was received, and is being checked".into(),
        UpdateState::Complete => "one was received and checked, and is not installed".into(),
        UpdateState::Marked => "one is installed by the next reset".into(),
        UpdateState::Refused(defect) => format!("the last one was refused: {}", reason(defect)),
        UpdateState::FlashFailed => "the flash has failed".into(),
    }
}

fn refused(state: UpdateState) -> LinkError {
    let why = match state {
        UpdateState::Refused(defect) => reason(defect),
        UpdateState::FlashFailed => "its flash has failed; try again after `reset`".into(),
        other => format!("it says that {}", self::state(other)),
    };
    LinkError::Failed(format!("the board refuses the update, and goes on as it was: {why}"))
}

/// Why an update is refused.
pub fn reason(defect: UpdateDefect) -> String {
    match defect {
        UpdateDefect::NotAnUpdate => "it does not begin as an update does".into(),
        UpdateDefect::Format(format) => format!("its manifest has format {format}, which is not known here"),
        UpdateDefect::OtherBoard => "it is for another board".into(),
        UpdateDefect::OlderProtocol(protocol) => {
            format!("its link protocol, {protocol}, is older than that of the image that runs")
        }
        UpdateDefect::OtherOrigin(origin) => format!("it is linked for {origin:#010x}, which is not the slot"),
        UpdateDefect::Length(bytes) => {
            format!("its length, {bytes} bytes, is not the one announced, or more than there is room for")
        }
        UpdateDefect::Damaged => "it is damaged: a checksum is wrong".into(),
        UpdateDefect::Unsigned => "it is not signed".into(),
        UpdateDefect::WrongSignature => "it is not signed by the key of this board".into(),
    }
}
