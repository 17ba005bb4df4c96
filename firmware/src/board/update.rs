//! Field update over the link: what the host sends, what the board reports, and the interface to the board that stores it.
//!
//! ```text
//! host: Begin ── Write, Write, … ── Check ────────── Install ── Reset
//!          |            |             |                 |
//! board: Receiving ─────┴─> Receiving ┴─> Complete ─────┴─> Marked    ──reset──> first stage: swap ──> Trial ──> Confirmed
//!          └────────────────── Refused(reason) <────────┘
//! ```
//!
//! Whatever changes the flash is done in silence only. Nothing that was received is started before [`UpdateVerb::Install`], and that is refused unless all of it was
//! checked: board, protocol, checksum, signature. The crate `sonoglide-update` implements this for a board with a first stage.

use serde::{Deserialize, Serialize};

use crate::seam::refusal::Refusal;

/// Bytes of an update in one command, as rows of 32.
pub const CHUNK: usize = 128;
/// Rows of a [`Chunk`].
const ROWS: usize = CHUNK / 32;
/// Bytes of an update; serde has arrays of up to 32 elements.
pub type Chunk = [[u8; 32]; ROWS];

/// Operation on the update.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum UpdateVerb {
    /// Asks for the state of the update.
    Report,
    /// Forgets what was received, and waits for an update of so many bytes.
    Begin(u32),
    /// Stores bytes of the update at this offset: in order, whole chunks. The last one is filled up with 0xff.
    Write(u32, Chunk),
    /// Checks what was received. The answer comes at once, the result with a later report: the signature takes the processor up to a second.
    Check,
    /// Marks the checked update to be started by the next reset.
    Install,
}

/// Why an update is refused. Its number on the wire is its place in this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpdateDefect {
    /// It does not begin as an update does.
    NotAnUpdate,
    /// Its manifest has another format than this board reads.
    Format(u16),
    /// It is for another board.
    OtherBoard,
    /// Its link protocol is older than that of the running image.
    OlderProtocol(u8),
    /// It is not linked for the place where it would be started.
    OtherOrigin(u32),
    /// It is longer than the room for it, or its length is not the one announced.
    Length(u32),
    /// The checksum of its manifest or of its image is wrong.
    Damaged,
    /// It has no signature.
    Unsigned,
    /// Its signature is not one by the key of this board.
    WrongSignature,
}

/// State of the update that is received.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpdateState {
    /// Nothing was received since the start.
    #[default]
    Nothing,
    /// So many bytes were received.
    Receiving(u32),
    /// All was received, and is being checked.
    Checking,
    /// All was received and is as it must be.
    Complete,
    /// It will be started by the next reset.
    Marked,
    /// It is refused.
    Refused(UpdateDefect),
    /// The flash has failed.
    FlashFailed,
}

/// The way in which the running image was started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Standing {
    /// Without a first stage: this image cannot be updated over the link.
    #[default]
    Alone,
    /// By the first stage, as the image that is to be started.
    Confirmed,
    /// By the first stage, after an update that no host has spoken to yet: a reset brings the former image back.
    Trial,
    /// By the first stage, which has brought this image back because its successor was not confirmed.
    RolledBack,
}

/// Report of the update, and of what the board finds in its option bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateReport {
    /// State of the update that is received.
    pub state: UpdateState,
    /// The way in which the running image was started.
    pub standing: Standing,
    /// Version of the running image by its manifest: major, minor, patch. `None` without a manifest.
    pub running: Option<[u16; 3]>,
    /// Largest update, bytes.
    pub room: u32,
    /// Option bytes that are not as they should be, one bit each; the board's documentation names them.
    pub option_bytes: u16,
}

/// What receives, checks and installs updates on a board.
pub trait Updates {
    /// The present report, without the option bytes.
    fn report(&mut self) -> UpdateReport;

    /// Obeys an operation; called in silence only.
    fn obey(&mut self, verb: &UpdateVerb) -> Result<(), Refusal>;

    /// Does what was begun, if anything was. Called in silence only; may take a second, and lets the watchdog wait for it.
    fn work(&mut self);

    /// Confirms the running image: it serves blocks and obeys its host. Called in silence only.
    fn confirm(&mut self);
}
