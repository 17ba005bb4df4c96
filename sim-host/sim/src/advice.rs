//! Advice: tracker settings for an identified transducer, and a prediction of the observer's
//! behaviour with them.
//!
//! ```text
//! scene or numbers --> case --> settings --> advised case --> prediction (rehearsed, with the bound) --> warnings
//!                                                   |
//!                                                   +--> verification (many runs of the whole controller)
//! ```
//!
//! The prediction uses no rule of thumb: the firmware's own tracker runs on the linear model of the
//! ring-up (`rehearsal.rs`). docs/your-transducer.md states its agreement with the whole controller
//! on the whole plant.

pub mod amplifier;
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

use report::TableBlock;
use serde::Serialize;

use amplifier::Amplifier;
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
    /// Measurements that verify the prediction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verified: Option<Verified>,
}

/// Reason that no advice can be given.
#[derive(Debug, thiserror::Error)]
pub enum AdviceError {
    /// The case does not permit advice.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The firmware refuses the settings.
    #[error("the firmware refuses these settings")]
    Refused,
}

/// Advises on a case; returns the advice, and the case with the advised settings.
pub fn advise(case: &Case) -> Result<(Advice, Case), AdviceError> {
    let (settings, advised) = settings::advise(case)?.ok_or(AdviceError::Refused)?;
    let parts = advised.parts().ok_or(AdviceError::Refused)?;
    let transducer = Full::from_circuit(&parts.circuit);
    let prediction = prediction::predict(&advised).ok_or(AdviceError::Refused)?;
    let warnings = warnings::collect(case, &parts, &transducer, &settings, &prediction);
    Ok((Advice { transducer, settings, prediction, warnings, verified: None }, advised))
}

/// Amplifier for a wanted tip velocity of a transducer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AmplifierAdvice {
    /// Full equivalent circuit of the transducer.
    pub transducer: Full,
    /// Amplifier for the wanted tip velocity.
    pub amplifier: Amplifier,
}

/// Computes the amplifier for a peak tip velocity, m/s; `None` takes that of the case's voltage.
/// States in the result if the force factor is assumed.
pub fn advise_amplifier(
    case: &Case,
    tip_m_per_s: Option<f64>,
    force_factor_is_assumed: bool,
) -> Result<AmplifierAdvice, AdviceError> {
    let parts = case.parts().ok_or(AdviceError::Refused)?;
    let amplifier = amplifier::amplifier(&parts, tip_m_per_s, force_factor_is_assumed);
    Ok(AmplifierAdvice { transducer: Full::from_circuit(&parts.circuit), amplifier })
}

impl AmplifierAdvice {
    /// Returns all tables, in order.
    pub fn tables(&self) -> Vec<TableBlock> {
        std::iter::once(table::transducer(&self.transducer)).chain(amplifier::tables(&self.amplifier)).collect()
    }
}
