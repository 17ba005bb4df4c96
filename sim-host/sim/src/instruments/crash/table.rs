//! Remarks on a crash, and a table of both belts.

use crate::instruments::View;
use crate::numbers::number;
use plant::dring::crash::Playback;
use plant::dring::motion::Extremes;
use report::TableBlock;
use scene::{ActuatorKind, Dring};

/// Returns the controller's decision and its effect, in sentences.
pub(super) fn remarks(run: &View, playback: &Playback) -> Vec<String> {
    let Some(dring) = run.scene.dring() else { return Vec::new() };
    let mut remarks = vec![decision(dring, playback)];
    let (fastest, gain) = (playback.switched.payout_m_per_s, 1.0 - playback.switched.shoulder_n / playback.passive.shoulder_n);
    if playback.low_s.is_some() && dring.actuator == ActuatorKind::Stack && gain < 0.01 {
        let tip = run.rows.iter().map(|row| row.truth.tip_velocity_m_per_s).fold(0.0, f64::max);
        remarks.push(format!(
            "The drive was ON but had no effect: the tip of the stack moves at {} m/s, and the webbing slides at up to {} m/s. \
             A vibration lowers friction only while it is faster than the sliding; this one would have to be {} times as fast.",
            number(tip),
            number(fastest),
            number((fastest / tip).ceil()),
        ));
    }
    remarks
}

/// Returns the reason for the friction state.
fn decision(dring: &Dring, playback: &Playback) -> String {
    let said = match dring.seat_reading_kg() {
        Some(kg) => format!("The seat reading was a torso of {} kg", number(kg)),
        None => "There was no seat reading".to_owned(),
    };
    match playback.low_s {
        Some(0.0) => format!("{said}. The drive was ON from the beginning: friction was always LOW."),
        Some(s) => {
            format!(
                "{said}, a light occupant. The drive came ON {} ms after the beginning of the crash, and friction became \
                     LOW.",
                number(1e3 * s)
            )
        }
        None => format!("{said}. The drive stayed OFF and friction stayed HIGH, as without a controller."),
    }
}

/// Returns the table of both belts.
pub(super) fn belts(playback: &Playback) -> TableBlock {
    let row = |what: &str, value: &dyn Fn(&Extremes) -> f64| {
        let (passive, switched) = (value(&playback.passive), value(&playback.switched));
        let change = format!("{:+.1} %", 100.0 * (switched / passive - 1.0));
        vec![what.to_owned(), number(passive), number(switched), change]
    };
    let rows = vec![
        row("peak force at the shoulder [N]", &|belt| belt.shoulder_n),
        row("chest acceleration by this force [g]", &|belt| playback.chest_g(belt.shoulder_n)),
        row("excursion of the torso [mm]", &|belt| 1e3 * belt.excursion_m),
        row("maximum payout speed [m/s]", &|belt| belt.payout_m_per_s),
    ];
    let caption = "The same crash with the passive belt, and with the drive as switched by the controller.";
    TableBlock::new("belts", "Passive belt and switched belt", caption, &["", "passive", "switched", "change"], rows)
}
