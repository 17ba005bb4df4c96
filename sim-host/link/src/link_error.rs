//! Errors between a host and a board, each with a remedy.

use std::io;
use std::path::PathBuf;

use firmware::seam::refusal::Refusal;

use crate::refusal;
use report::ReportError;
use scene::diagnostic::Report;
#[cfg(feature = "host")]
use sim::output::OutputError;

/// Error of a dialogue with a board.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The port cannot be opened.
    #[error("cannot open {port}: {why}")]
    Open {
        /// The port.
        port: String,
        /// Reason and remedy.
        why: String,
    },
    /// No byte arrives.
    #[error(
        "{port} is open, but nothing answers there (asked {tries} times in {seconds:.1} s). Is the board powered and flashed \
         (`cargo flash`), and is this the right port?"
    )]
    Silent {
        /// The port.
        port: String,
        /// Number of requests.
        tries: u32,
        /// Duration of the requests, s.
        seconds: f64,
    },
    /// Bytes arrive that are not frames.
    #[error(
        "{port} answers, but not as a Sonoglide board: {count} bytes without a valid frame, beginning with {bytes}. Is it \
         another device, or another baud rate?"
    )]
    Stranger {
        /// The port.
        port: String,
        /// Number of received bytes.
        count: usize,
        /// First bytes, as readable text.
        bytes: String,
    },
    /// The board has another protocol version.
    #[error("the board at {port} speaks version {board} of the link's protocol, this program version {ours}: \
             {}", older(*board, *ours))]
    Version {
        /// The port.
        port: String,
        /// Version of the board.
        board: u8,
        /// Version of this program.
        ours: u8,
    },
    /// The connection is lost and could not be restored.
    #[error("lost {port}: {why}")]
    Lost {
        /// The port.
        port: String,
        /// Reason.
        why: String,
    },
    /// The board obeys another session.
    #[error(
        "the board at {port} obeys another session now: another client has connected since, or the board was reset (`fault log` \
         shows the cause). The command was not carried out. Connect again once the other client has ended"
    )]
    Displaced {
        /// The port.
        port: String,
    },
    /// The board refuses a command.
    #[error("{}", refusal::sentence(command, *refusal))]
    Refused {
        /// The refused command.
        command: String,
        /// Reason of the board.
        refusal: Refusal,
    },
    /// The answer of the board does not belong to the command.
    #[error("the board has answered `{command}` with an unexpected reply: {reply}. Is its firmware older than this program?")]
    Unexpected {
        /// The command.
        command: String,
        /// The reply.
        reply: String,
    },
    /// An argument is not valid.
    #[error("{0}")]
    Usage(String),
    /// An input is missing or not valid: a file, a scene or a name.
    #[error("{0}")]
    Input(String),
    /// The command was carried out and has failed.
    #[error("{0}")]
    Failed(String),
    /// A script is not valid: a report with line and caret.
    #[error("{0}")]
    Script(Report),
    /// A line of a script has failed.
    #[error("{place}: {error}")]
    At {
        /// The script and its line.
        place: String,
        /// The error of that line.
        error: Box<LinkError>,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {io}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Reason.
        io: io::Error,
    },
    /// The folder of a result cannot be written.
    #[cfg(feature = "host")]
    #[error(transparent)]
    Folder(#[from] OutputError),
    /// A figure cannot be drawn.
    #[error("{}", with_causes(.0))]
    Figure(#[from] ReportError),
    /// Standard output is closed.
    #[error(transparent)]
    Output(#[from] io::Error),
    /// Ctrl-C has interrupted the command.
    #[error("interrupted")]
    Interrupted,
}

/// Returns the remedy for two different protocol versions.
fn older(board: u8, ours: u8) -> &'static str {
    if board < ours { "flash the board again (`cargo flash`)" } else { "use the program that belongs to its firmware" }
}

/// Returns an error with its causes.
fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

impl LinkError {
    /// Returns `true` if the board or the link is missing or lost.
    pub fn is_lost(&self) -> bool {
        use LinkError::{Displaced, Lost, Open, Silent, Stranger, Version};
        matches!(self.cause(), Open { .. } | Silent { .. } | Stranger { .. } | Version { .. } | Lost { .. } | Displaced { .. })
    }

    /// Returns the error without the line of the script.
    pub fn cause(&self) -> &LinkError {
        if let LinkError::At { error, .. } = self { error.cause() } else { self }
    }
}
