//! A scene of the transducer: its circuit as the truth, its rounded values as what the controller is told, and converters that suit both.

use std::fmt::Write as _;

use super::result::{Admittance, Mode};
use crate::stated::rounded;

/// Samples a second of the board's converters, Hz.
const SAMPLE_HZ: f64 = 1e6;
/// Resonances that a scene can have, Hz.
const RESONANCES_HZ: (f64, f64) = (100.0, 450e3);
/// Lengths of a block, samples.
const BLOCKS: [u16; 2] = [32, 64];
/// Least periods of the lowest frequency in a block.
const LEAST_PERIODS: f64 = 0.55;
/// Peak drive voltage, V.
const DRIVE_V: f64 = 2.0;
/// Range of the sensors over what the drive makes of the circuit.
const HEADROOM: f64 = 2.0;
/// Widest window about the nominal frequency, and steps of one bandwidth that a scan has at most.
const SPAN: f64 = 0.03;
const SCAN_STEPS: f64 = 360.0;

impl Admittance {
    /// The scene as TOML; nothing where its resonance is none that a scene can have. `source` is the file the circuit comes from.
    pub fn scene(&self, source: &str) -> Option<String> {
        let circuit = &self.circuit;
        let (hz, q) = (circuit.series_resonance_hz.value, circuit.q.value);
        let (rm, c0, lm) = (circuit.rm_ohm.value, circuit.c0_f.value, circuit.lm_h.value);
        if !(RESONANCES_HZ.0..=RESONANCES_HZ.1).contains(&hz) {
            return None;
        }
        let room = circuit.parallel_resonance_hz.value / hz - 1.0;
        let span = SPAN.min(SCAN_STEPS / (2.0 * q)).min(if room > 0.01 { 0.9 * room } else { SPAN });
        let span = rounded(span.max(1e-4), 2);
        let lowest = hz * (1.0 - span);
        let block = BLOCKS.into_iter().find(|block| f64::from(*block) * lowest / SAMPLE_HZ >= LEAST_PERIODS);
        let (block, sample_hz) = block.map_or((64, (64.0 * lowest / LEAST_PERIODS).max(1e5)), |block| (block, SAMPLE_HZ));
        let omega = std::f64::consts::TAU * hz;
        let current = DRIVE_V * ((1.0 / rm).powi(2) + (omega * c0).powi(2)).sqrt();
        let range_a = rounded(HEADROOM * current, 2).clamp(1e-6, 1e3);
        let ring_s = q / (std::f64::consts::PI * hz);
        let duration_s = rounded((0.3 + 300.0 * ring_s).min(10.0), 2);
        let title = format!("Measured transducer {}: cold start, identification, lock", self.name);
        let mut text = format!(
            "title = {}\nsource = {}\n",
            quoted(&title),
            quoted(&format!("equivalent circuit fitted to {source} by `sim-host import admittance`"))
        );
        let numbers = |text: &mut String, table: &str, keys: &[(&str, f64)]| {
            let _ = writeln!(text, "\n[{table}]");
            for (key, value) in keys {
                let _ = writeln!(text, "{key} = {value:?}");
            }
        };
        let nominal = |value: f64| rounded(value, 4);
        let _ = writeln!(text, "duration_s = {duration_s:?}\n\n[controller]\nblock_samples = {block}");
        numbers(&mut text, "controller.drive", &[("frequency_hz", nominal(hz)), ("amplitude_v", DRIVE_V)]);
        let _ = writeln!(text, "\n[controller.tracking]\nmode = \"observer\"");
        for (key, value) in
            [("span", span), ("nominal_q", nominal(q)), ("nominal_lm_h", nominal(lm)), ("nominal_c0_f", nominal(c0))]
        {
            let _ = writeln!(text, "{key} = {value:?}");
        }
        numbers(&mut text, "controller.limits", &[("current_a", range_a)]);
        let sensors = [("v_full_scale_v", 2.5 * DRIVE_V), ("i_full_scale_a", range_a), ("sample_hz", sample_hz)];
        numbers(&mut text, "sensors", &sensors[..if sample_hz == SAMPLE_HZ { 2 } else { 3 }]);
        numbers(&mut text, "amplifier", &[("full_scale_v", 2.5 * DRIVE_V)]);
        let exact = |value: f64| rounded(value, 7);
        numbers(
            &mut text,
            "stack.bvd",
            &[
                ("c0_f", exact(c0)),
                ("cm_f", exact(circuit.cm_f.value)),
                ("lm_h", exact(lm)),
                ("rm_ohm", exact(rm)),
                ("loss_tangent", rounded(circuit.loss_tangent.value.clamp(0.0, 1.0), 4)),
            ],
        );
        for mode in self.modes.iter().filter(|mode| !mode.working) {
            further(&mut text, mode);
        }
        Some(text)
    }
}

fn further(text: &mut String, mode: &Mode) {
    let numbers = [("series_resonance_hz", mode.series_resonance_hz), ("q", mode.q), ("lm_h", mode.lm_h)]
        .map(|(key, value)| (key, value.value));
    let _ = writeln!(text, "\n[[stack.mode]]");
    for (key, value) in numbers {
        let _ = writeln!(text, "{key} = {:?}", rounded(value, 7));
    }
}

/// A text as a string of TOML.
fn quoted(text: &str) -> String {
    let escaped: String = text
        .chars()
        .map(|c| match c {
            '"' => "\\\"".to_owned(),
            '\\' => "\\\\".to_owned(),
            c if c.is_control() => " ".to_owned(),
            c => c.to_string(),
        })
        .collect();
    format!("\"{escaped}\"")
}
