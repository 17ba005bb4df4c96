//! Animated view of a crash.

use crate::instruments::View;
use report::{CrashView, Instant};
use scene::Occupant;

/// Interval between the frames of the view, s.
const EVERY_S: f64 = 0.5e-3;

/// Returns the animated view of a crash; `None` for another run.
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
