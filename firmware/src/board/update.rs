//! Field update over the link: commands of the host, reports of the board, and the interface to the
//! part of the board that stores an update.
//!
//! ```text
//! host: Begin ── Write, Write, … ── Check ────────── Install ── Reset
//!          |            |             |                 |
//! board: Receiving ─────┴─> Receiving ┴─> Complete ─────┴─> Marked    ──reset──> first stage: swap ──> Trial ──> Confirmed
//!          └────────────────── Refused(reason) <────────┘
//! ```
//!
//! The flash is changed in silence only. Nothing received is started before
//! [`UpdateVerb::Install`], which is refused unless board, protocol, version, checksum and
//! signature were checked. The crate `sonoglide-update` implements this for a board with a first
//! stage.

use serde::{Deserialize, Serialize};

use crate::seam::refusal::Refusal;

/// Length of the part of an update in one command, bytes.
pub const CHUNK: usize = 128;
/// Number of rows of a [`Chunk`].
const ROWS: usize = CHUNK / 32;
/// Part of an update, as rows of 32 bytes: serde supports arrays of up to 32 elements.
pub type Chunk = [[u8; 32]; ROWS];

/// Operation on the update.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum UpdateVerb {
    /// Requests the state of the update.
    Report,
    /// Discards the received part, and begins an update of this length, bytes.
    Begin(u32),
    /// Stores a chunk of the update at this offset, bytes. Chunks come in order, and the last one
    /// is filled up with 0xff.
    Write(u32, Chunk),
    /// Checks the received update. The answer comes at once and the result in a later report,
    /// because checking the signature takes up to a second.
    Check,
    /// Marks the checked update to be started by the next reset.
    Install,
}

/// Reason for the refusal of an update. Its number on the wire is its place in this list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpdateDefect {
    /// The data does not begin like an update.
    NotAnUpdate,
    /// The manifest has this format, which the board cannot read.
    Format(u16),
    /// The update is for another board.
    OtherBoard,
    /// The link protocol has this version, which is older than that of the running image.
    OlderProtocol(u8),
    /// The update is linked for this address, and would be started at another one.
    OtherOrigin(u32),
    /// The update is longer than the room for it, or differs in length from the announcement.
    Length(u32),
    /// The checksum of the manifest or of the image is wrong.
    Damaged,
    /// The update has no signature.
    Unsigned,
    /// The signature is not by a key of this board, or is not in its canonical form.
    WrongSignature,
    /// The firmware is older than the running one, and nobody has confirmed that at the board.
    OlderVersion {
        /// Version of the running image: major, minor, patch.
        running: [u16; 3],
        /// Version of the update.
        offered: [u16; 3],
    },
}

/// State of a received update.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum UpdateState {
    /// Nothing was received since the start.
    #[default]
    Nothing,
    /// This number of bytes was received.
    Receiving(u32),
    /// The whole update was received, and is being checked.
    Checking,
    /// The whole update was received, and has passed the checks.
    Complete,
    /// The update will be started by the next reset.
    Marked,
    /// The update is refused.
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
    /// By the first stage, as the confirmed image.
    Confirmed,
    /// By the first stage, on trial after an update: a reset brings the former image back, unless a
    /// host has used this one.
    Trial,
    /// By the first stage, which has brought this image back because its successor was not
    /// confirmed.
    RolledBack,
}

/// Report of the update, and of the option bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateReport {
    /// State of the received update.
    pub state: UpdateState,
    /// The way in which the running image was started.
    pub standing: Standing,
    /// Version of the running image from its manifest: major, minor, patch. `None` without a
    /// manifest.
    pub running: Option<[u16; 3]>,
    /// Largest update, bytes.
    pub room: u32,
    /// Option bytes with unexpected values, one bit each; the board's documentation names them.
    pub option_bytes: u16,
    /// `true` if the board accepts updates signed by the development key, which is public.
    pub accepts_development_key: bool,
}

/// Interface to the part of a board that receives, checks and installs updates.
pub trait Updates {
    /// Returns the present report, without the option bytes.
    fn report(&mut self) -> UpdateReport;

    /// Obeys an operation; called in silence only.
    fn obey(&mut self, verb: &UpdateVerb) -> Result<(), Refusal>;

    /// Runs a check that was begun, if any. Called in silence only. May take a second; the watchdog
    /// must allow for it.
    fn work(&mut self);

    /// Confirms the running image, which serves blocks and obeys its host. Called in silence only.
    fn confirm(&mut self);
}
