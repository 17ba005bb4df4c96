//! Metrics of the transducer as scan or observer identified it; with `_sd`, the standard deviation that the controller states.

use crate::instruments::View;
use crate::metrics::Metrics;

/// Adds the metrics of the identified transducer, if there is one.
pub(super) fn add(run: &View, metrics: &mut Metrics) {
    let Some(transducer) = run.record.last.transducer else { return };
    let found_hz = f64::from(transducer.series_resonance_hz);
    metrics.put("series_resonance_hz", found_hz);
    metrics.put("series_resonance_error_hz", run.scan_ends().map(|row| found_hz - row.truth.series_resonance_hz));
    metrics.put("parallel_resonance_hz", f64::from(transducer.parallel_resonance_hz));
    metrics.put("q", f64::from(transducer.q));
    metrics.put("rm_ohm", f64::from(transducer.rm_ohm));
    metrics.put("lm_h", f64::from(transducer.lm_h));
    metrics.put("cm_f", f64::from(transducer.cm_f));
    metrics.put("c0_f", f64::from(transducer.c0_f));
    metrics.put("coupling", f64::from(transducer.coupling));
    let sd = transducer.deviations;
    metrics.put("series_resonance_sd_hz", f64::from(sd.series_resonance_hz));
    metrics.put("parallel_resonance_sd_hz", f64::from(sd.parallel_resonance_hz));
    metrics.put("q_sd", f64::from(sd.q));
    metrics.put("rm_sd_ohm", f64::from(sd.rm_ohm));
    metrics.put("lm_sd_h", f64::from(sd.lm_h));
    metrics.put("cm_sd_f", f64::from(sd.cm_f));
    metrics.put("c0_sd_f", f64::from(sd.c0_f));
    metrics.put("coupling_sd", f64::from(sd.coupling));
    metrics.put("modes_found", f64::from(transducer.modes));
}
