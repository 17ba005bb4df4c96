//! Advice: from an identified transducer, settings for the tracker, and what the observer will do with them.
//!
//! ```text
//! scene or numbers --> case --> settings --> the case as advised --> prediction (rehearsed, with the bound) --> warnings
//!                                                   |
//!                                                   +--> verification (many runs of the whole controller)
//! ```
//!
//! Nothing is predicted by a rule of thumb: the firmware's own tracker is run on the linear model of the ring-up (`rehearsal.rs`). How well
//! that agrees with the whole controller on the whole plant is stated in docs/advise.md.

pub mod case;
pub mod prediction;
mod rehearsal;
mod response;
mod rig;
pub mod settings;
pub mod table;
pub mod transducer;
pub mod verification;
mod warnings;

#[cfg(test)]
mod tests;

use serde::Serialize;

use case::{Case, CaseError};
use prediction::Prediction;
use settings::Settings;
use transducer::Full;
use verification::Verified;

/// Advice on the settings of a stack's controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Advice {
    /// Full equivalent circuit of the transducer.
    pub transducer: Full,
    /// Advised settings of the controller.
    pub settings: Settings,
    /// Predicted behaviour of the observer with these settings.
    pub prediction: Prediction,
    /// Warnings about the case and its settings.
    pub warnings: Vec<String>,
    /// The prediction, put to the test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verified: Option<Verified>,
}

/// Why there is no advice.
#[derive(Debug, thiserror::Error)]
pub enum AdviceError {
    /// There is nothing to advise on.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The firmware would not take the settings.
    #[error("the firmware refuses these settings")]
    Refused,
}

/// Advises on a case, and gives the case with the settings that are advised.
pub fn advise(case: &Case) -> Result<(Advice, Case), AdviceError> {
    let (settings, advised) = settings::advise(case)?.ok_or(AdviceError::Refused)?;
    let parts = advised.parts().ok_or(AdviceError::Refused)?;
    let transducer = Full::of(&parts.circuit);
    let prediction = prediction::predict(&advised).ok_or(AdviceError::Refused)?;
    let warnings = warnings::of(case, &parts, &transducer, &settings, &prediction);
    Ok((Advice { transducer, settings, prediction, warnings, verified: None }, advised))
}
