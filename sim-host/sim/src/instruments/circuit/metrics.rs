//! Metrics of the transducer as identified by scan or observer; `_sd` marks the standard deviation
//! that the controller states.

use firmware::seam::transducer::Deviations;

use crate::instruments::View;
use crate::metrics::Metrics;

/// Adds the metrics of the identified transducer, if there is one.
pub(super) fn add(run: &View, metrics: &mut Metrics) {
    let Some(transducer) = run.record.last.transducer else { return };
    let found_hz = f64::from(transducer.series_resonance_hz);
    metrics.put("series_resonance_hz", found_hz);
    metrics.put("series_resonance_error_hz", run.scan_ends().map(|row| found_hz - row.truth.series_resonance_hz));
    let Deviations { series_resonance_hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling } = transducer.deviations;
    metrics.put("series_resonance_sd_hz", f64::from(series_resonance_hz));
    for (name, value, sd_name, sd) in [
        ("parallel_resonance_hz", transducer.parallel_resonance_hz, "parallel_resonance_sd_hz", parallel_resonance_hz),
        ("q", transducer.q, "q_sd", q),
        ("rm_ohm", transducer.rm_ohm, "rm_sd_ohm", rm_ohm),
        ("lm_h", transducer.lm_h, "lm_sd_h", lm_h),
        ("cm_f", transducer.cm_f, "cm_sd_f", cm_f),
        ("c0_f", transducer.c0_f, "c0_sd_f", c0_f),
        ("coupling", transducer.coupling, "coupling_sd", coupling),
    ] {
        metrics.put(name, f64::from(value));
        metrics.put(sd_name, f64::from(sd));
    }
    for (name, value) in [
        ("lock_loss", transducer.quality.loss),
        ("lock_others", transducer.quality.others),
        ("lock_misfit", transducer.quality.misfit),
    ] {
        metrics.put(name, f64::from(value));
    }
    metrics.put("modes_found", f64::from(transducer.modes));
}
