//! Options and errors of a bench.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use crate::precision::reference::NoReference;
use report::Report;
use scene::load::LoadError;
use scene::suite;
pub use sim::evidence::Evidence;
use sim::evidence::run_suite;
use sim::study::StudyError;
use sim::study::suite::SuiteResult;

/// Options of a bench, with the inputs that its caller provides.
pub struct Options<'a> {
    /// `true` for fewer runs and cases.
    pub quick: bool,
    /// Number of runs of each kind and place (`faults`), of transducers (`commission`, `drift`, the
    /// wider set of `transducers`), of files to import (`import`), of millions of bytes sent
    /// (`fuzz`) or of millions of samples driven (`soak`); `None` for the default.
    pub count: Option<u32>,
    /// Seed of a single input to run alone (`fuzz`, `soak`), or of another set (`contacts`).
    pub seed: Option<u64>,
    /// Program whose instructions are counted, and the options that make it run one method alone
    /// (`precision`).
    pub counted: Option<(&'a Path, &'a [&'a str])>,
    /// Flag that the caller sets to stop the cases of a suite.
    pub stop: Option<&'a AtomicBool>,
    /// Callback that receives the name of each step before it runs.
    pub progress: &'a mut (dyn FnMut(&str) + Send),
}

/// Reason why a bench has no result.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene or a suite is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// A case has no result.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// A contact study has no answer.
    #[error(transparent)]
    Contact(#[from] contact::SolveError),
    /// The reference of the methods is not reliable.
    #[error(transparent)]
    Reference(#[from] NoReference),
    /// The firmware refuses a case.
    #[error("the firmware refuses a case: {0}")]
    Config(#[from] firmware::seam::error::Error),
    /// The image of the emulator could not be built or run.
    #[error(transparent)]
    Pil(#[from] pil::PilError),
    /// The image stopped early, or its output is not counts.
    #[error("the image gives no counts: {0}")]
    Counts(String),
    /// A campaign against the flashed image cannot start a board.
    #[error(transparent)]
    Campaign(#[from] crate::campaign_error::CampaignError),
    /// A simulated board has not answered.
    #[error("a simulated board has failed: {0}")]
    Board(String),
    /// The published data do not fit the models that they are compared with.
    #[error("the published data: {0}")]
    Data(String),
    /// A table of numbers cannot be written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
}

/// Runs a built-in suite, given by its name and text.
pub(crate) fn built_in(
    (name, text): (&str, &str),
    options: &mut Options,
    more: impl FnOnce(&SuiteResult, &mut Report) -> Result<(), Error>,
) -> Result<Evidence, Error> {
    run_suite(&suite::load_text(name, text, options.quick)?, options.stop, options.progress, more)
}
