//! Correctness of the controller's lock reports, from the record's rows and the resonance of the
//! plant.
//!
//! A drive is **near** if it is within half a bandwidth, `f_s / (2 Q)`, of the true series
//! resonance; its motional phase is then within 45 degrees. From the lock stage on:
//!
//! | term | definition |
//! |---|---|
//! | true lock | a block under drive that is near and is reported locked |
//! | false lock | at least 1 ms reported locked without a break, in which no block is near |
//! | undetected loss | after a true lock, under drive: reported locked but not near for longer than the time allowed for fault 32 (3 ms, or 4 time constants of the true resonance, `Q / (pi f_s)`, if longer) plus 1 ms |
//!
//! Blocks without drive do not count towards an undetected loss, and do not end one.

use std::f64::consts::PI;

use firmware::seam::mode::Mode;

use crate::instruments::View;
use crate::record::Row;
use plant::circuit_of;
use plant::disturbance::Change;
use scene::{Disturbance, DisturbedKey};

/// Minimum time reported locked without being near, of a false lock, s.
pub const FALSE_LOCK_S: f64 = 1e-3;
/// Time within which a loss of lock must be detected, s, as docs/dev/control.md states for fault
/// 32.
pub const NOTICED_S: f64 = 3e-3;
/// Number of time constants within which a loss of lock must be detected, if that is longer.
pub const NOTICED_TIME_CONSTANTS: f64 = 4.0;
/// Additional time, s: the drive leaves the half bandwidth before the phase leaves its 45 degrees.
pub const GRACE_S: f64 = 1e-3;
/// Tolerance of a sum of block lengths against rounding, blocks.
const ROUNDING: f64 = 1e-3;

/// Result for the lock reports of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LockClaims {
    /// `true` if the controller reported a lock at the resonance.
    pub true_lock: bool,
    /// `true` if the controller reported a lock away from the resonance.
    pub false_lock: bool,
    /// `true` if the controller still reported a lock after it was lost.
    pub undetected_loss: bool,
}

/// Evaluates a run; `None` if it never reached the lock stage.
pub fn evaluate(run: &View) -> Option<LockClaims> {
    let first = run.rows.iter().position(|row| row.mode == Mode::Lock)?;
    let quality = true_q(circuit_of(&run.scene).q(), &run.scene.disturbance, run.rows, run.block_s);
    Some(judge(&run.rows[first..], &quality[first..], run.block_s))
}

/// Returns the stack's own quality factor in each block, including the scene's disturbances.
fn true_q(own: f64, disturbances: &[Disturbance], rows: &[Row], block_s: f64) -> Vec<f64> {
    let of_q = disturbances.iter().filter(|change| change.key == DisturbedKey::Q);
    let mut changes: Vec<Change> = of_q.cloned().map(Change::new).collect();
    let mut present = own;
    let at = |row: &Row| {
        for change in &mut changes {
            present = change.next(row.time_s - block_s, present).unwrap_or(present);
        }
        present
    };
    rows.iter().map(at).collect()
}

/// Evaluates the rows from the lock stage on; `quality` is the true Q of each.
fn judge(rows: &[Row], quality: &[f64], block_s: f64) -> LockClaims {
    let mut found = LockClaims::default();
    let (mut stretch_s, mut was_near, mut lost_s) = (0.0, false, 0.0);
    let longer = |than: f64| than - ROUNDING * block_s;
    for (row, q) in rows.iter().zip(quality) {
        if !row.locked {
            found.false_lock |= !was_near && stretch_s >= longer(FALSE_LOCK_S);
            (stretch_s, was_near, lost_s) = (0.0, false, 0.0);
            continue;
        }
        let resonance_hz = row.truth.series_resonance_hz;
        let near = (row.frequency_hz - resonance_hz).abs() <= resonance_hz / (2.0 * q);
        stretch_s += block_s;
        was_near |= near;
        if row.drive_v > 0.0 {
            found.true_lock |= near;
            lost_s = if near { 0.0 } else { lost_s + block_s };
        }
        let noticed_s = NOTICED_S.max(NOTICED_TIME_CONSTANTS * q / (PI * resonance_hz));
        found.undetected_loss |= found.true_lock && lost_s > noticed_s + GRACE_S + ROUNDING * block_s;
    }
    found.false_lock |= !was_near && stretch_s >= longer(FALSE_LOCK_S);
    found
}

#[cfg(test)]
mod tests {
    use firmware::seam::telemetry::Telemetry;

    use super::*;
    use crate::record::Command;
    use crate::swing::Swing;
    use plant::truth::Truth;

    const BLOCK_S: f64 = 32e-6;
    /// Resonance with a half bandwidth of 400 Hz and a time constant of 0.4 ms at Q 50.
    const RESONANCE_HZ: f64 = 40e3;
    const Q: f64 = 50.0;

    /// Returns `count` equal blocks: frequency offset, Hz, lock report, and drive, V.
    fn blocks(count: usize, off_hz: f64, locked: bool, drive_v: f64) -> Vec<Row> {
        let truth = Truth { series_resonance_hz: RESONANCE_HZ, ..Truth::default() };
        let played = (Swing::default(), Default::default(), &truth);
        let row = Row::new(0, (0.0, 1e6), &Command::default(), &Telemetry::default(), played);
        let row = Row { mode: Mode::Run, frequency_hz: RESONANCE_HZ + off_hz, locked, drive_v, ..row };
        vec![row; count]
    }

    fn judged(parts: &[Vec<Row>]) -> LockClaims {
        let rows = parts.concat();
        judge(&rows, &vec![Q; rows.len()], BLOCK_S)
    }

    fn claims(true_lock: bool, false_lock: bool, undetected_loss: bool) -> LockClaims {
        LockClaims { true_lock, false_lock, undetected_loss }
    }

    #[test]
    fn good_run_has_no_false_lock_and_no_loss() {
        let pulls_in = blocks(20, 900.0, false, 3.0);
        assert_eq!(judged(&[pulls_in, blocks(1000, -399.0, true, 3.0)]), claims(true, false, false));
        assert_eq!(judged(&[blocks(1000, 3000.0, false, 3.0)]), claims(false, false, false));
    }

    /// 32 blocks are 1.024 ms, 31 are 0.992 ms.
    #[test]
    fn one_millisecond_off_resonance_is_a_false_lock() {
        let [short, long] = [31, 32].map(|count| blocks(count, 401.0, true, 3.0));
        let seeks = || blocks(5, 401.0, false, 3.0);
        assert_eq!(judged(&[seeks(), short.clone(), seeks(), short]), claims(false, false, false));
        assert_eq!(judged(&[seeks(), long.clone(), seeks()]), claims(false, true, false));
        // The last section counts like any other. One that is near at its end is not a false lock.
        assert_eq!(judged(&[seeks(), long.clone()]), claims(false, true, false));
        assert_eq!(judged(&[long, blocks(1, 0.0, true, 3.0)]), claims(true, false, false));
    }

    /// 125 blocks are 4 ms: the limit of 3 ms plus 1 ms.
    #[test]
    fn late_loss_report_is_an_undetected_loss() {
        let locks = || blocks(40, 10.0, true, 3.0);
        assert_eq!(judged(&[locks(), blocks(125, 500.0, true, 3.0)]), claims(true, false, false));
        assert_eq!(judged(&[locks(), blocks(126, 500.0, true, 3.0)]), claims(true, false, true));
        // The loss is detected, is recovered from, or occurs without drive.
        let noticed = [locks(), blocks(100, 500.0, true, 3.0), blocks(100, 500.0, false, 3.0)];
        assert_eq!(judged(&noticed), claims(true, false, false));
        let back = [locks(), blocks(100, 500.0, true, 3.0), locks(), blocks(100, 500.0, true, 3.0)];
        assert_eq!(judged(&back), claims(true, false, false));
        assert_eq!(judged(&[locks(), blocks(1000, 500.0, true, 0.0)]), claims(true, false, false));
        // With bursts, the time under drive adds up.
        let bursts = [locks(), blocks(63, 500.0, true, 3.0), blocks(9, 500.0, true, 0.0), blocks(63, 500.0, true, 3.0)];
        assert_eq!(judged(&bursts), claims(true, false, true));
    }

    #[test]
    fn high_q_allows_four_time_constants() {
        let rows = [blocks(40, 1.0, true, 3.0), blocks(300, 500.0, true, 3.0)].concat();
        // Q 500: the time constant is 4 ms, 16 ms plus 1 ms are allowed, and 300 blocks are 9.6 ms.
        assert!(!judge(&rows, &vec![500.0; rows.len()], BLOCK_S).undetected_loss);
        assert!(judge(&rows, &vec![Q; rows.len()], BLOCK_S).undetected_loss);
    }

    #[test]
    fn q_step_widens_the_band_from_its_time_on() {
        let step = Disturbance {
            at_s: 1e-3,
            key: DisturbedKey::Q,
            to: Some(20.0),
            rate_per_s: None,
            sine_amplitude: None,
            sine_hz: None,
            profile: None,
        };
        let timed = |n: u32| Row { time_s: f64::from(n + 1) * 1e-3, ..blocks(1, 0.0, true, 1.0)[0] };
        assert_eq!(true_q(65.0, &[step], &[timed(0), timed(1), timed(2)], 1e-3), [65.0, 20.0, 20.0]);
    }
}
