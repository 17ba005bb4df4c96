//! Scene of a measured transducer: its circuit as the plant, rounded values as nominal values of
//! the controller, and suitable converters.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use super::result::{Admittance, Mode};
use report::rounded;

/// Sampling rate of the board's converters, Hz.
const SAMPLE_HZ: f64 = 1e6;
/// Resonance that a scene can have, Hz.
pub(super) const SCENE_HZ: RangeInclusive<f64> = 100.0..=450e3;
/// Block lengths, samples.
const BLOCK_SAMPLES: [u16; 2] = [32, 64];
/// Minimum number of periods of the lowest frequency per block.
const MIN_PERIODS: f64 = 0.55;
/// Maximum number of further modes of a scene.
pub(super) const MAX_FURTHER_MODES: usize = 3;
/// Peak drive voltage, V.
const DRIVE_V: f64 = 2.0;
/// Range of the current sensor relative to the expected current.
const CURRENT_RANGE_RATIO: f64 = 2.0;
/// Largest half-width of the window, relative to the nominal frequency.
const MAX_SPAN_REL: f64 = 0.03;
/// Maximum width of the window, bandwidths.
const MAX_WINDOW_BANDWIDTHS: f64 = 360.0;

impl Admittance {
    /// Returns the scene as TOML; `None` if a scene cannot have its resonance. `source` is the file
    /// of the measurement.
    pub fn scene(&self, source: &str) -> Option<String> {
        let circuit = &self.circuit;
        let (hz, q) = (circuit.series_resonance_hz.value, circuit.q.value);
        let (rm, c0, lm) = (circuit.rm_ohm.value, circuit.c0_f.value, circuit.lm_h.value);
        if !SCENE_HZ.contains(&hz) {
            return None;
        }
        let room = circuit.parallel_resonance_hz.value / hz - 1.0;
        let span = MAX_SPAN_REL.min(MAX_WINDOW_BANDWIDTHS / (2.0 * q)).min(if room > 0.01 { 0.9 * room } else { MAX_SPAN_REL });
        let span = rounded(span.max(1e-4), 2);
        let lowest = hz * (1.0 - span);
        let block = BLOCK_SAMPLES.into_iter().find(|block| f64::from(*block) * lowest / SAMPLE_HZ >= MIN_PERIODS);
        let (block, sample_hz) = block.map_or((64, (64.0 * lowest / MIN_PERIODS).max(1e5)), |block| (block, SAMPLE_HZ));
        let range_a = self.current_limit_a();
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
        text.push_str(
            "\n# With the covariance of the fit: c0_f = { samples = \"samples.csv\", column = \"c0_f\" }; the same for cm_f, lm_h, rm_ohm.",
        );
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
        for mode in self.further_modes().into_iter().take(MAX_FURTHER_MODES) {
            further(&mut text, mode);
        }
        Some(text)
    }

    /// Returns the limit of the current in the scene, A peak.
    fn current_limit_a(&self) -> f64 {
        let (c, omega) = (&self.circuit, std::f64::consts::TAU * self.circuit.series_resonance_hz.value);
        let current = DRIVE_V * ((1.0 / c.rm_ohm.value).powi(2) + (omega * c.c0_f.value).powi(2)).sqrt();
        rounded(CURRENT_RANGE_RATIO * current, 2).clamp(1e-6, 1e3)
    }

    /// Returns the drive and the limit of the scene, and the command for its amplifier.
    pub fn next_step(&self, scene: &str) -> String {
        format!(
            "it drives with {DRIVE_V} V peak and limits the current to {} A peak\namplifier for an amplitude and a force factor: \
             `sim-host advise {scene} --amplifier --tip-m 3e-6 --set stack.bvd.force_factor_n_per_v=1`",
            self.current_limit_a()
        )
    }

    /// Returns the modes other than the working one, the strongest first.
    fn further_modes(&self) -> Vec<&Mode> {
        let mut modes: Vec<&Mode> = self.modes.iter().filter(|mode| !mode.working).collect();
        modes.sort_by(|a, b| b.merit.total_cmp(&a.merit));
        modes
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

/// Quotes a text as a string of TOML.
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
