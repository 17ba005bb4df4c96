//! Reports of the board for the page.

use std::time::Duration;

use firmware::seam::phasor::Phasor;
use firmware::seam::telemetry::Telemetry;
use link::answer::{Answer, short};
use link::commands::status::fields;
use link::words;
use serde_json::json;

use super::tell;

/// Passes a report to the page, with the measured admittance and the meaning of a fault.
pub fn pass(time: Duration, report: &Telemetry) {
    let Answer { mut fields, .. } = fields(report, Answer::default());
    fields.insert("time_s".into(), time.as_secs_f64().into());
    if let Some(ratio) = report.friction.and_then(|estimate| estimate.force_ratio) {
        fields.insert("friction_ratio".into(), short(ratio));
    }
    let volts: Phasor = report.v;
    let square = volts.re * volts.re + volts.im * volts.im;
    if square > 0.0 {
        let siemens = report.i * volts.conj();
        fields.insert("admittance_s".into(), json!([short(siemens.re / square), short(siemens.im / square)]));
    }
    if let Some(fault) = report.fault {
        fields.insert("fault_text".into(), words::fault(fault).into());
    }
    if let Some(limit) = report.limit {
        fields.insert("limit_text".into(), words::limit(limit).into());
    }
    tell(&json!({ "event": "report", "report": fields }));
}
