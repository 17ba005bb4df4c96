//! A study in words and tables: the same for the terminal and for the report.

use firmware::supervisor::{Limit, Mode};

use crate::figures;
use crate::metrics::View;
use crate::plant::circuit::Circuit;
use crate::record::Row;
use crate::report::{Report, TableBlock};
use crate::study::Study;

/// Version of this program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The report of a study.
pub fn report(study: &Study) -> Report {
    let scene = &study.scene;
    Report {
        title: scene.title.clone(),
        subtitle: if scene.source.is_empty() { String::new() } else { format!("Source: {}", scene.source) },
        summary: headline(study),
        paragraphs: [
            remarks(study),
            scene.notes.clone(),
            vec![format!(
                "{}, against a simulated stack and contact. Command is what the controller played, estimate what it believed, \
                     truth what the simulated plant did; the controller sees converter codes only.",
                study.level
            )],
        ]
        .concat(),
        tables: tables(study),
        figures: figures::of(study),
        appendix: vec![all_metrics(study)],
        footer: footer(study),
        interrupted: study.record.interrupted,
    }
}

/// The tables that answer the scene's question: expectations, three ways, grid.
pub fn tables(study: &Study) -> Vec<TableBlock> {
    let mut tables = vec![expectations(study), three_ways(study)];
    tables.extend(grid(study));
    tables.retain(|table| !table.rows.is_empty());
    tables
}

/// What a reader must know before the numbers.
pub fn remarks(study: &Study) -> Vec<String> {
    let mut remarks = Vec::new();
    if !study.changes.is_empty() {
        let changes = study.changes.join(", ");
        remarks.push(format!("Changed by hand: {changes}. Title, notes and expectations are those of the unchanged scene."));
    }
    if let Some(fault) = study.record.last.fault {
        remarks.push(format!("The controller ended in fault {}: {fault:?}.", fault.code()));
    }
    let limit = study.record.rows.iter().rfind(|row| row.drive_v > 0.0).map(|row| row.limit);
    if let Some(limit) = limit.and_then(|code| Limit::try_from(code).ok()) {
        remarks.push(format!("In its last block under drive the controller was under limit {}: {limit:?}.", limit as u8));
    }
    let view = View::new(&study.scene, &study.record);
    if study.record.last.fault.is_none() && view.steady().next().is_none() {
        let running = view.plays_from(Mode::Run).map_or("was not reached".to_owned(), |s| format!("began at {s:.3} s"));
        remarks.push(format!("There is no steady block with the drive ON, so most metrics are missing: the run {running}."));
    }
    remarks
}

/// The numbers that come first.
pub fn headline(study: &Study) -> Vec<(String, String)> {
    let tile = |label: &str, metric: &str, unit: &str| {
        study.metrics.get(metric).map(|value| (label.to_owned(), format!("{} {unit}", number(value)).trim_end().to_owned()))
    };
    let fault =
        study.record.rows.last().filter(|row| row.fault != 0).map(|row| ("ended in fault".to_owned(), row.fault.to_string()));
    [
        fault,
        tile("friction reduction", "reduction_percent", "%"),
        tile("friction, drive OFF", "friction_off_n", "N"),
        tile("friction, drive ON", "friction_on_n", "N"),
        tile("frequency bias", "frequency_bias_hz", "Hz"),
        tile("acquired in", "acquire_time_ms", "ms"),
        tile("relocked to 20 Hz in", "relock_time_20hz_ms", "ms"),
        tile("tip velocity", "tip_velocity_m_per_s", "m/s"),
        tile("simulated s per wall s", "simulated_s_per_wall_s", ""),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn footer(study: &Study) -> Vec<(String, String)> {
    [
        ("scene", study.name.clone()),
        ("seed", study.scene.seed.to_string()),
        ("drive hash", format!("{:016x}", study.record.drive_hash)),
        ("plant states", study.record.plant_states.to_string()),
        ("sim-host", VERSION.to_owned()),
        ("level", study.level.to_string()),
    ]
    .map(|(label, value)| (label.to_owned(), value))
    .to_vec()
}

fn table(id: &str, title: &str, caption: &str, header: &[&str], rows: Vec<Vec<String>>) -> TableBlock {
    let header = header.iter().map(|&cell| cell.to_owned()).collect();
    TableBlock { id: id.into(), title: title.into(), caption: caption.into(), header, rows }
}

fn expectations(study: &Study) -> TableBlock {
    let rows = study
        .judged
        .iter()
        .map(|judged| {
            let value = judged.value.map_or_else(|| "no such value in this run".to_owned(), number);
            let verdict = if judged.pass { "PASS" } else { "MISS" };
            vec![verdict.into(), judged.metric.clone(), value, judged.limit.clone(), judged.source.clone()]
        })
        .collect();
    table("expectations", "Expected", "", &["", "metric", "value", "expected", "source"], rows)
}

/// Command (or what the controller was told), estimate, truth.
fn three_ways(study: &Study) -> TableBlock {
    let view = View::new(&study.scene, &study.record);
    let steady: Vec<&Row> = view.steady().collect();
    let mean = |value: &dyn Fn(&Row) -> f64| {
        (!steady.is_empty()).then(|| steady.iter().map(|row| value(row)).sum::<f64>() / steady.len() as f64)
    };
    let controller = &study.scene.controller;
    let tracking = &controller.tracking;
    let found = study.record.last.transducer;
    let truth = Circuit::of(&study.scene.stack.bvd);
    let identified = |value: fn(&firmware::identify::Transducer) -> f32| found.as_ref().map(|found| f64::from(value(found)));
    let velocity_estimate =
        tracking.nominal_force_factor_n_per_v.and_then(|told| mean(&|row| row.motional_current_a).map(|amperes| amperes / told));
    let mut rows = vec![
        (
            "drive frequency, steady [Hz]",
            mean(&|row| row.frequency_hz),
            mean(&|row| row.resonance_estimate_hz),
            mean(&|row| row.truth.series_resonance_hz),
        ),
        (
            "tip velocity, steady [m/s]",
            controller.drive.velocity_m_per_s,
            velocity_estimate,
            study.metrics.get("tip_velocity_m_per_s"),
        ),
        (
            "series resonance [Hz]",
            Some(controller.drive.frequency_hz),
            identified(|t| t.series_resonance_hz),
            Some(truth.series_resonance_hz()),
        ),
        ("Q", Some(tracking.nominal_q), identified(|t| t.q), Some(truth.q())),
        ("Rm [ohm]", None, identified(|t| t.rm_ohm), Some(truth.rm_ohm)),
        ("Lm [mH]", None, identified(|t| t.lm_h * 1e3), Some(truth.lm_h * 1e3)),
        ("Cm [nF]", None, identified(|t| t.cm_f * 1e9), Some(truth.cm_f * 1e9)),
        ("C0 [nF]", Some(tracking.nominal_c0_f * 1e9), identified(|t| t.c0_f * 1e9), Some(truth.c0_f * 1e9)),
    ];
    rows.retain(|row| row.2.is_some());
    let cell = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), precise);
    let rows =
        rows.into_iter().map(|(what, told, found, truth)| vec![what.into(), cell(told), cell(found), cell(truth)]).collect();
    table(
        "three-ways",
        "Command, estimate, truth",
        "The circuit is the stack's by itself, at the beginning of the run; a contact adds its stiffness and loss.",
        &["", "command, or told", "controller's estimate", "plant's truth"],
        rows,
    )
}

fn grid(study: &Study) -> Option<TableBlock> {
    let result = study.grid.as_ref()?;
    let grid = &result.grid;
    let header: Vec<String> = std::iter::once(grid.row_key.clone())
        .chain(grid.columns.iter().map(|value| format!("{} = {value}", grid.column_key.rsplit('.').next().unwrap_or(""))))
        .collect();
    let row = |(value, cells): (&f64, &Vec<Option<f64>>)| {
        let cells = cells.iter().map(|cell| cell.map_or_else(|| "–".to_owned(), |value| format!("{value:.2}")));
        std::iter::once(value.to_string()).chain(cells).collect()
    };
    let rows = grid.rows.iter().zip(&result.cells).map(row).collect();
    let caption =
        format!("{}; each cell is a run of its own, with these two keys set and the controller on the host (SIL)", grid.metric);
    Some(TableBlock { id: "grid".into(), title: grid.title.clone(), caption, header, rows })
}

/// Every metric of a study.
pub fn all_metrics(study: &Study) -> TableBlock {
    let rows = study.metrics.iter().map(|(name, value)| vec![name.to_owned(), number(value)]).collect();
    table("metrics", "All metrics", "", &["metric", "value"], rows)
}

/// Four significant digits.
pub fn number(value: f64) -> String {
    digits(value, 4)
}

/// Seven significant digits, for what is compared.
fn precise(value: f64) -> String {
    digits(value, 7)
}

fn digits(value: f64, digits: usize) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e7).contains(&size) {
        return format!("{value:.*e}", digits - 1);
    }
    // Digits after the point such that there are as many in all; whole numbers keep none.
    let before = size.log10().floor() as i32 + 1;
    let after = (digits as i32 - before).max(0) as usize;
    let text = format!("{value:.after$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(number(67.440_118), "67.44");
        assert_eq!(number(0.144), "0.144");
        assert_eq!(number(2.0008e-8), "2.001e-8");
        assert_eq!(number(-5.2), "-5.2");
        assert_eq!(precise(39_999.290_1), "39999.29");
        assert_eq!(number(8.0), "8");
    }
}
