//! Files of a commissioning: report, settings and twin.

use realfft::num_complex::Complex64;

use super::drawing::{admittance, places};
use super::{Commissioned, table};
use crate::admittance::phases;
use crate::answer::quantity;
use crate::files::ResultFolder;
use crate::link_error::LinkError;
use crate::parameter::{parameter, shown};
use report::{self, Axis, Figure, Marker, Report, Series, Style, TableBlock};
use sim::advice::table::tables;
use sim::provenance::Provenance;

/// Returns the name, the value and the effect or uncertainty of each proposed setting.
pub fn worth(found: &Commissioned) -> Vec<[String; 3]> {
    let (it, proposal) = (&found.proposal.transducer, &found.proposal);
    let prediction = &found.advice.prediction;
    let lock = prediction.lock.iter().find(|lock| lock.within_hz == 20.0);
    let time = |value: Option<f64>| value.map_or_else(|| "not in time".to_owned(), |ms| format!("{ms:.2} ms"));
    let locks = lock.map_or_else(String::new, |lock| {
        format!("; rehearsed lock: within 20 Hz in {} (95 %: {})", time(lock.median_ms), time(lock.p95_ms))
    });
    let heated = |place: usize| {
        let deviation_rel = found.thermal.map_or(f64::NAN, |thermal| thermal.deviations_rel[place]);
        format!("+- {:.1} % as measured by the heating run", 100.0 * deviation_rel)
    };
    let worth = |name: &str| match name {
        "drive.amplitude_v" => format!("{} at the resonance", quantity(proposal.amperes, "A")),
        "drive.scan_volts" => "same voltage for self-test, scan and drive".into(),
        "limits.voltage_v" | "limits.current_a" => "as given; not exceeded once stored".into(),
        "tracking.mode" => format!("rehearsed jitter {:.3} Hz", prediction.jitter_hz),
        "tracking.span" => {
            format!("finds a resonance that has moved by up to {:.0} Hz", proposal.span * f64::from(it.series_resonance_hz))
        }
        "tracking.nominal_q" => format!("+- {:.2} as identified; reference for a loss of Q", it.deviations.q),
        "tracking.nominal_lm_h" => "another mode is not accepted as a lock (fault 34)".into(),
        "tracking.nominal_c0_f" => {
            format!("an error of 1 % moves the lock by {:+.2} Hz", prediction.bias_hz_per_percent_c0)
        }
        "drive.frequency_hz" => format!("+- {:.2} Hz as identified{locks}", it.deviations.series_resonance_hz),
        "thermometer.resistance_k_per_w" => heated(0),
        "thermometer.heat_capacity_j_per_k" => heated(1),
        "thermometer.tolerance" => "two standard deviations, at least 5 %".into(),
        _ => String::new(),
    };
    found
        .settings()
        .into_iter()
        .map(|(name, value)| {
            let value = parameter(name).map_or_else(|_| value.to_string(), |parameter| shown(parameter, value));
            [name.to_owned(), value, worth(name)]
        })
        .collect()
}

/// Returns the settings as a script; `sim-host link PORT script settings.txt` stores them.
fn settings(found: &Commissioned) -> String {
    let lines: String = worth(found).iter().map(|[name, value, _]| format!("settings set {name} {value}\n")).collect();
    format!(
        "# Settings for {}: `sim-host link PORT script` with this file stores them.\n{lines}settings store\nreset\n",
        found.name
    )
}

/// Writes all files into the folder.
pub fn write(found: &Commissioned, folder: ResultFolder, provenance: &Provenance) -> Result<(), LinkError> {
    folder.file("settings.txt", &settings(found))?;
    folder.file("twin.toml", &found.twin)?;
    folder.report(&Report { footer: provenance.footer(), ..page(found) })?;
    folder.finish()
}

fn page(found: &Commissioned) -> Report {
    let rows =
        |lines: Vec<String>| -> Vec<Vec<String>> { lines.into_iter().skip(1).map(|line| vec![line.trim().to_owned()]).collect() };
    let header = table(&found.modes, None).remove(0);
    let modes = TableBlock::new(
        "modes",
        "Modes",
        "The driven mode is marked with a star.",
        &[header.trim()],
        rows(table(&found.modes, Some(found.chosen))),
    );
    let proposed = TableBlock::new(
        "settings",
        "Proposed settings",
        "The effects are rehearsed on the twin, or follow from the identified circuit.",
        &["setting", "value", "effect or uncertainty"],
        worth(found).into_iter().map(Vec::from).collect(),
    );
    let places = places(found);
    let line = |name: &str, column: &str, style: Style, points: &[(f64, Complex64)]| Series {
        name: name.into(),
        csv_column: column.into(),
        x: points.iter().map(|(hz, _)| 1e-3 * hz).collect(),
        y: points.iter().map(|(_, y)| 1e3 * y.norm()).collect(),
        style,
    };
    let axis = |label: &str| Axis { label: label.into(), ..Axis::default() };
    let circuit: Vec<_> = places.iter().map(|&hz| (hz, admittance(found, hz))).collect();
    let tones: Vec<_> = found.load.tones.iter().map(|tone| (tone.hz, tone.siemens)).collect();
    let markers = found.modes.iter().enumerate().map(|(place, mode)| Marker {
        x: 1e-3 * mode.hz(),
        y: 1e3 * admittance(found, mode.hz()).norm(),
        label: format!("{}: {:.1} Hz", place + 1, mode.hz()),
    });
    let figure = Figure {
        id: "admittance_over_frequency".into(),
        title: "Admittance over frequency".into(),
        x: axis("frequency [kHz]"),
        y: Axis { log: true, ..axis("admittance [mS]") },
        series: vec![
            line("identified circuit", "admittance_identified", Style::Line, &circuit),
            line("measured small tones", "admittance_measured", Style::Points, &tones),
        ],
        along: Some(phases(&[&circuit, &tones])),
        markers: markers.collect(),
        ..Figure::default()
    };
    let verified = &found.verified;
    let (lower_hz, again_hz) = verified.stepped_hz;
    let tested = TableBlock::new(
        "test",
        "Test",
        "Frequency of the drive with the proposed settings.",
        &["", "Hz"],
        [
            ("locked", verified.locked_hz),
            ("at 0.7 of the amplitude", lower_hz),
            ("at full amplitude again", again_hz),
            ("after a burst", verified.after_burst_hz),
        ]
        .map(|(what, hz)| vec![what.to_owned(), format!("{hz:.2}")])
        .to_vec(),
    );
    Report {
        title: format!("Commissioning of {}", found.name),
        subtitle: format!("Band {:.0} to {:.0} Hz", found.band.low_hz, found.band.high_hz),
        tables: [vec![modes, proposed, tested], tables(&found.advice)].concat(),
        figures: vec![figure],
        ..Report::default()
    }
}
