//! A crash as a view that can be played.

use crate::instruments::View;
use report::{CrashView, Instant};
use scene::Occupant;

/// Frames of the view: one every so many, s.
const EVERY_S: f64 = 0.5e-3;

/// The crash as a view that can be played; none of another run.
pub fn view(run: &View) -> Option<CrashView> {
    let playback = super::playback(run)?;
    let dring = run.scene.dring()?;
    let block_s = run.record.sample_s * run.record.block_samples as f64;
    let every = ((EVERY_S / block_s) as usize).max(1);
    let instants = playback.frames.iter().step_by(every).map(|frame| Instant {
        ms: 1e3 * frame.time_s,
        low: frame.amplitude,
        pulse_g: frame.pulse_m_per_s2 / plant::dring::G_M_PER_S2,
        mm: [frame.passive, frame.switched].map(|belt| 1e3 * belt.x_m),
        newton: [frame.passive, frame.switched].map(|belt| belt.shoulder_n),
        payout_mm: [frame.passive, frame.switched].map(|belt| 1e3 * belt.payout_m),
    });
    Some(CrashView {
        occupant: match dring.occupant {
            Occupant::Light => "light occupant, 5th percentile",
            Occupant::Medium => "medium occupant, 50th percentile",
            Occupant::Heavy => "heavy occupant, 95th percentile",
        }
        .into(),
        torso_kg: playback.torso_kg,
        slack_mm: 1e3 * dring.slack_m,
        pulse_ms: 1e3 * dring.pulse_s(),
        low_ms: playback.low_s.map(|s| 1e3 * s),
        instants: instants.collect(),
    })
}
