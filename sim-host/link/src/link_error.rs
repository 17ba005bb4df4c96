//! What goes wrong between a host and a board, each as a sentence that says what to do.

use std::io;
use std::path::PathBuf;

use firmware::seam::refusal::Refusal;

use crate::refusal;
use report::ReportError;
use scene::diagnostic::Report;
use sim::output::OutputError;

/// Errors of a dialogue with a board.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// The port cannot be opened.
    #[error("cannot open {port}: {why}")]
    Open {
        /// The port.
        port: String,
        /// Why, and what to do.
        why: String,
    },
    /// Nothing comes back.
    #[error(
        "{port} is open, but nothing answers there (asked {tries} times in {seconds:.1} s). Is the board powered and flashed (`cargo flash`), and \
         is this its port?"
    )]
    Silent {
        /// The port.
        port: String,
        /// How often it was asked.
        tries: u32,
        /// For how long, s.
        seconds: f64,
    },
    /// Something else comes back.
    #[error(
        "{port} answers, but not as a Sonoglide board: {count} bytes and no whole frame among them, beginning with {bytes}. Another device, or \
         another baud rate?"
    )]
    Stranger {
        /// The port.
        port: String,
        /// How many bytes have come.
        count: usize,
        /// The first of them, readable.
        bytes: String,
    },
    /// The board speaks another version.
    #[error("the board at {port} speaks version {board} of the link's protocol, this program version {ours}: {}", older(*board, *ours))]
    Version {
        /// The port.
        port: String,
        /// The board's.
        board: u8,
        /// Ours.
        ours: u8,
    },
    /// The connection is gone and does not come back.
    #[error("lost {port}: {why}")]
    Lost {
        /// The port.
        port: String,
        /// Why.
        why: String,
    },
    /// The board obeys another session.
    #[error(
        "the board at {port} obeys another session now: another client has connected since, or the board was reset (`fault log` says by what). \
         The command was not carried out. Connect again once the other client has ended"
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
        /// Why the board refuses it.
        refusal: Refusal,
    },
    /// The board answers something else than what was asked.
    #[error("the board has answered `{command}` with something else: {reply}. Is its firmware older than this program?")]
    Unexpected {
        /// What was asked.
        command: String,
        /// What came.
        reply: String,
    },
    /// An argument cannot be what is meant.
    #[error("{0}")]
    Usage(String),
    /// An input is missing or refused: a file, a scene or a name.
    #[error("{0}")]
    Input(String),
    /// The command was carried out, and has failed.
    #[error("{0}")]
    Failed(String),
    /// A script is wrong: a report with line and caret.
    #[error("{0}")]
    Script(Report),
    /// A line of a script has failed.
    #[error("{place}: {error}")]
    At {
        /// The script and its line.
        place: String,
        /// What has happened.
        error: Box<LinkError>,
    },
    /// A file cannot be written.
    #[error("cannot write {}: {io}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        io: io::Error,
    },
    /// The folder of a result cannot be written.
    #[error(transparent)]
    Folder(#[from] OutputError),
    /// A figure cannot be drawn.
    #[error("{}", whole(.0))]
    Figure(#[from] ReportError),
    /// Standard output is gone.
    #[error(transparent)]
    Output(#[from] io::Error),
    /// Ctrl-C has interrupted the command.
    #[error("interrupted")]
    Interrupted,
}

/// Which of the two is to be renewed.
fn older(board: u8, ours: u8) -> &'static str {
    if board < ours { "flash the board again (`cargo flash`)" } else { "take the program that belongs to its firmware" }
}

/// An error with its causes.
fn whole(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source());
    causes.fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}

impl LinkError {
    /// Whether board or link are not there, or not any more.
    pub fn is_lost(&self) -> bool {
        use LinkError::{Displaced, Lost, Open, Silent, Stranger, Version};
        matches!(self.cause(), Open { .. } | Silent { .. } | Stranger { .. } | Version { .. } | Lost { .. } | Displaced { .. })
    }

    /// What has happened, wherever that was.
    pub fn cause(&self) -> &LinkError {
        if let LinkError::At { error, .. } = self { error.cause() } else { self }
    }
}
