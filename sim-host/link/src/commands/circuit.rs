//! Output of the transducer that the board has identified, as text and fields.

use firmware::seam::telemetry::Telemetry;
use firmware::seam::transducer::{LockQuality, Transducer};

use crate::answer::{Answer, quantity, short};

/// Adds the identified transducer of a report to an answer.
pub fn in_words(report: &Telemetry, answer: Answer) -> Answer {
    let Some(found) = &report.transducer else { return answer };
    let scatter = &found.deviations;
    let answer = answer.line(format!(
        "series resonance {:.2} +- {:.2} Hz, parallel {:.2} Hz, Q {:.1}, Rm {}, Lm {}, Cm {}, C0 {}, coupling {:.3}",
        found.series_resonance_hz,
        scatter.series_resonance_hz,
        found.parallel_resonance_hz,
        found.q,
        quantity(found.rm_ohm.into(), "ohm"),
        quantity(found.lm_h.into(), "H"),
        quantity(found.cm_f.into(), "F"),
        quantity(found.c0_f.into(), "F"),
        found.coupling,
    ));
    fields(found, answer).field("series_resonance_deviation_hz", short(scatter.series_resonance_hz))
}

/// Adds the quality of the lock on the identified transducer of a report.
pub(super) fn quality(report: &Telemetry, answer: Answer) -> Answer {
    let Some(LockQuality { loss, others, misfit }) = report.transducer.map(|found| found.quality) else { return answer };
    let loss = if loss < 1.0 { format!("{:.2} % of the tip velocity may be lost", 100.0 * loss) } else { "unknown loss".into() };
    answer.line(format!(
        "quality of the lock: {loss}; other resonances have {:.2} % of the conductance; residual {misfit:.1} times the expected one",
        100.0 * others
    ))
}

/// Adds the values of an identified transducer to an answer, as fields.
pub fn fields(found: &Transducer, answer: Answer) -> Answer {
    answer
        .field("series_resonance_hz", short(found.series_resonance_hz))
        .field("parallel_resonance_hz", short(found.parallel_resonance_hz))
        .field("q", short(found.q))
        .field("rm_ohm", short(found.rm_ohm))
        .field("lm_h", short(found.lm_h))
        .field("cm_f", short(found.cm_f))
        .field("c0_f", short(found.c0_f))
        .field("coupling", short(found.coupling))
        .field("lock_loss", short(found.quality.loss))
        .field("lock_others", short(found.quality.others))
        .field("lock_misfit", short(found.quality.misfit))
}
