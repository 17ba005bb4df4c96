//! Exit codes: one for each kind of error, the same in every command.

use std::error::Error;
use std::process::ExitCode;
use std::{fmt, io};

use super::Color;
use import::error::ImportError;
use import::signal::SignalError;
use link::link_error::LinkError;
use pil::PilError;
use scene::load::LoadError;
use sim::advice::AdviceError;
use sim::advice::verification::VerifyError;
use sim::compare::CompareError;
use sim::evidence::SuiteError;
use sim::output::OutputError;
use sim::output::sweep::FolderError;
use sim::run::RunError;
use sim::study::StudyError;
use sim::study::sweep::SweepError;

/// Exit codes, for the help of commands.
pub(super) const EXIT_CODES: &str = "Exit codes:
  0    success
  1    the command failed
  2    wrong usage
  3    an input is missing or invalid (scene, file, folder, key, metric or other name)
  4    the run finished, but missed an expectation
  5    QEMU or the board was not found, or the connection was lost
  130  interrupted; partial results are marked";

/// Outcome of a command; its number is the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    Done = 0,
    /// Command failed: a run without a result, a refused command, a file that cannot be written.
    Failed = 1,
    /// Wrong option, value or combination, or the result folder contains something else.
    Usage = 2,
    /// Missing or refused input: a scene, file, folder, key, metric or other name.
    Input = 3,
    /// Run finished, but an expectation was missed.
    Missed = 4,
    /// QEMU, board or link not found, or lost.
    Lost = 5,
    /// Interrupted; the results so far are written and marked.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// Error that a command detects itself.
#[derive(Debug)]
struct Mistake(Exit, String);

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.1)
    }
}

impl Error for Mistake {}

/// Returns an error with this exit code and message.
pub(super) fn mistake(exit: Exit, text: impl Into<String>) -> anyhow::Error {
    Mistake(exit, text.into()).into()
}

/// Prints an error to standard error and returns its outcome.
pub(super) fn report(error: &anyhow::Error, color: Color) -> Exit {
    // A closed reader (`sim-host list | head -1`) is not an error.
    if error.downcast_ref::<io::Error>().is_some_and(|io| io.kind() == io::ErrorKind::BrokenPipe) {
        return Exit::Done;
    }
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(LoadError::Invalid(report)), _) | (_, Some(LinkError::Script(report))) => {
            super::note_styled(&report.render(color.stderr))
        }
        (_, Some(LinkError::Interrupted)) => say!("interrupted"),
        _ => say!("error: {}", with_causes(error)),
    }
    error.chain().find_map(exit).unwrap_or(Exit::Failed)
}

/// Formats an error with its causes. A cause that the message already contains is left out.
fn with_causes(error: &anyhow::Error) -> String {
    error
        .chain()
        .map(ToString::to_string)
        .reduce(|text, cause| if text.contains(&cause) { text } else { format!("{text}: {cause}") })
        .unwrap_or_default()
}

/// Returns the outcome for a kind of error. `None`: the cause decides, or the command failed
/// although its arguments and inputs are right.
fn exit(error: &(dyn Error + 'static)) -> Option<Exit> {
    use Exit::{Input, Interrupted, Lost, Usage};
    if let Some(Mistake(exit, _)) = error.downcast_ref() {
        return Some(*exit);
    }
    if let Some(error) = error.downcast_ref() {
        use SweepError::{Axis, Draws, None, Points, Sample, Sampled, Twice};
        let usage = matches!(error, Axis { .. } | Draws(_) | None | Points(_) | Sample(_) | Sampled(_) | Twice(_));
        return Some(if usage { Usage } else { Input });
    }
    if let Some(error) = error.downcast_ref() {
        return Some(if matches!(error, CompareError::Tolerance { .. }) { Usage } else { Input });
    }
    if let Some(error) = error.downcast_ref() {
        return Some(if matches!(error, SignalError::Option(_)) { Usage } else { Input });
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            FolderError::Study(error) => exit(error),
            FolderError::Output(error) => exit(error),
            FolderError::Damaged { .. } | FolderError::Write { .. } | FolderError::Report(_) => None,
            FolderError::Other { .. } | FolderError::Strange { .. } | FolderError::Held { .. } | FolderError::Room { .. } => {
                Some(Usage)
            }
            _ => Some(Input),
        };
    }
    if let Some(error) = error.downcast_ref() {
        return matches!(error, OutputError::Taken { .. } | OutputError::Held { .. }).then_some(Usage);
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            StudyError::Run(RunError::Config(_)) => Some(Input),
            StudyError::Run(RunError::NoProcessor(error)) => exit(error.as_ref()).or(Some(Lost)),
            StudyError::Run(RunError::Lost(_)) => Some(Lost),
            StudyError::Cell(..) | StudyError::Grid(_) => Some(Input),
            StudyError::EmptyCell(_, error) => exit(error.as_ref()),
            StudyError::Interrupted => Some(Interrupted),
            _ => None,
        };
    }
    if let Some(error) = error.downcast_ref() {
        return Some(if matches!(error, PilError::Config(_)) { Input } else { Lost });
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            SuiteError::Study(error) => exit(error),
            SuiteError::Scene(_) => Some(Input),
        };
    }
    if let Some(error) = error.downcast_ref() {
        return match error {
            VerifyError::Study(error) => exit(error),
            VerifyError::Scene(_) => Some(Input),
        };
    }
    if let Some(error) = error.downcast_ref::<LinkError>() {
        return match error.cause() {
            _ if error.is_lost() => Some(Lost),
            LinkError::Interrupted => Some(Interrupted),
            LinkError::Usage(_) => Some(Usage),
            LinkError::Input(_) | LinkError::Script(_) => Some(Input),
            LinkError::Folder(error) => exit(error),
            _ => None,
        };
    }
    (error.is::<LoadError>() || error.is::<ImportError>() || error.is::<AdviceError>()).then_some(Input)
}
