//! Exit codes: one for each kind of error, in every command.

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
pub(super) const EXIT_CODES: &str = "Exit codes: 0 done; 1 the command failed; 2 usage; 3 an input is missing or refused: a scene, file, folder, key, \
metric or other name; 4 the run finished but an expectation was missed; 5 QEMU or board not found or lost; 130 interrupted, with the results so far \
written and marked.";

/// Outcome of a command. The number is the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exit {
    Done = 0,
    /// The command failed: a run without a result, a refused order, a file that cannot be written.
    Failed = 1,
    /// An option, a value or a combination is wrong, or the folder of the result holds something else.
    Usage = 2,
    /// An input is missing or refused: a scene, file, folder, key, metric or other name.
    Input = 3,
    /// The run finished, but an expectation was missed.
    Missed = 4,
    /// QEMU, board or link was not found, or was lost.
    Lost = 5,
    /// The results so far are written, and marked.
    Interrupted = 130,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(exit as u8)
    }
}

/// A mistake that a command finds by itself.
#[derive(Debug)]
struct Mistake(Exit, String);

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.1)
    }
}

impl Error for Mistake {}

/// A mistake of this kind.
pub(super) fn mistake(exit: Exit, text: impl Into<String>) -> anyhow::Error {
    Mistake(exit, text.into()).into()
}

/// Prints an error to standard error, and returns the outcome by its kind.
pub(super) fn report(error: &anyhow::Error, color: Color) -> Exit {
    // A reader that has gone away (`sim-host list | head -1`) is not an error.
    if error.downcast_ref::<io::Error>().is_some_and(|io| io.kind() == io::ErrorKind::BrokenPipe) {
        return Exit::Done;
    }
    match (error.downcast_ref(), error.downcast_ref()) {
        (Some(LoadError::Invalid(report)), _) | (_, Some(LinkError::Script(report))) => say!("{}", report.render(color.stderr)),
        (_, Some(LinkError::Interrupted)) => say!("interrupted"),
        _ => say!("error: {}", whole(error)),
    }
    error.chain().find_map(exit).unwrap_or(Exit::Failed)
}

/// An error with its causes, each once: some messages contain that of their cause.
fn whole(error: &anyhow::Error) -> String {
    error
        .chain()
        .map(ToString::to_string)
        .reduce(|text, cause| if text.contains(&cause) { text } else { format!("{text}: {cause}") })
        .unwrap_or_default()
}

/// The outcome by the kind of an error; `None` if its cause decides, or if the command failed although its arguments and inputs are right.
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
            FolderError::Write { .. } | FolderError::Report(_) => None,
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
