//! The tables of the campaign.

use crate::campaign::{cells, columns, or_dash};

use super::cases::Event;
use super::{EventResult, MovingResult, Undetected};
use report::{TableBlock, verdict};
use sim::study::monte_carlo::statistics::Spread;

/// Power of a welder, W.
const WELDER_W: f64 = 2500.0;
/// Dimensions of the contact, 46 by 10 mm, and of its layer that melts first, m (thesis 3.2: the
/// belt's width, the tip's length).
const LAYER_M: [f64; 3] = [46e-3, 10e-3, 100e-6];
/// Density of nylon 6.6, kg/m^3.
const NYLON_KG_PER_M3: f64 = 1140.0;
/// Specific heat of nylon 6.6, J/(kg K).
const NYLON_J_PER_KG_K: f64 = 1700.0;
/// Temperature rise from room temperature to 230 degrees Celsius, K.
const MELTING_RISE_K: f64 = 205.0;

/// Returns all tables; `power_w` is the drive's power into the motional branch.
pub fn tables(power_w: f64, events: &[EventResult], faults: &[Undetected], belts: &[MovingResult]) -> Vec<TableBlock> {
    vec![stopped(power_w, events), undetected(power_w, faults), passed(belts)]
}

/// Returns the energy that melts the layer, J.
fn layer_j() -> f64 {
    LAYER_M.iter().product::<f64>() * NYLON_KG_PER_M3 * NYLON_J_PER_KG_K * MELTING_RISE_K
}

fn three(spread: &Spread) -> String {
    format!("{:.2}, {:.2}, {:.2}", spread.median, spread.p95, spread.max)
}

fn stopped(power_w: f64, events: &[EventResult]) -> TableBlock {
    let row = |found: &EventResult| {
        let ends: Vec<String> =
            found.ends.iter().map(|&code| if code == 0 { "muted".into() } else { code.to_string() }).collect();
        let Event { name, at_most_ms, .. } = found.event;
        cells![
            name,
            found.runs,
            found.missed,
            three(&found.off_ms),
            or_dash(*at_most_ms, |ms| ms.to_string()),
            at_most_ms.map_or("", |_| verdict(found.holds())),
            ends.join(", "),
            format!("{:.4}", found.exposure_j.max),
            format!("{:.1}", found.exposure_j.max / power_w * WELDER_W),
            format!("{:.2}", found.ring_down_ms.max),
        ]
    };
    let caption = format!(
        "Each run has another speed of 10 to 70 mm/s with a ripple of 10 % rms at 10 Hz, another phase of the encoder and \
         another moment; 100 counts/mm, and {} ms until a mute unless another time is given. Times from the moment when the belt \
         is slower than 1 / (n T), or its encoder fails, to the first block without drive: median, 95 %, largest. Exposure: \
         electrical energy into the motional branch in that time, all of it into one millimetre, at {:.2} W and, in proportion, \
         at {WELDER_W} W; the same millimetre receives {:.3} J/mm while it passes at 10 mm/s. A layer of 100 um of nylon under \
         46 x 10 mm needs {:.1} J to reach 230 degrees Celsius, which {WELDER_W} W deliver in {:.1} ms. Ring-down: to 5 % of the \
         tip velocity, after the drive is OFF.",
        super::cases::STOP_MS,
        power_w,
        1e-3 / 0.01 * power_w,
        layer_j(),
        1e3 * layer_j() / WELDER_W,
    );
    let header = columns(
        "event | runs | missed | drive OFF after [ms] | at most |  | ends | exposure [J/mm] | at 2.5 kW [J/mm] | ring-down [ms]",
    );
    TableBlock::new("stopped", "The belt stops, slows, or its encoder fails", caption, &header, events.iter().map(row).collect())
}

fn undetected(power_w: f64, faults: &[Undetected]) -> TableBlock {
    let row = |found: &Undetected| {
        let limit = |limit: Option<f64>| or_dash(limit, |limit| limit.to_string());
        vec![
            format!("{}", 1e3 * found.encoder.pace_m_per_s),
            limit(found.encoder.energy_j_per_m),
            limit(found.encoder.on_time_s),
            found.undetected_s.map_or_else(|| "forever".into(), |s| format!("{s:.2} s")),
            if found.fault == 0 { "none".into() } else { found.fault.to_string() },
            format!("{:.2}", found.exposure_j),
        ]
    };
    let caption = format!(
        "The belt stands still under {:.2} W from the beginning, its encoder counts at an even pace, and there is no force \
         channel. A budget of e J/m ends only a pace below P / e, after L e / (P - e v) with the contact's L of 10 mm; only \
         `on_time_s` ends a faster one.",
        power_w
    );
    let header = ["pace [mm/s]", "energy_j_per_m", "on_time_s", "lasts", "fault", "exposure [J/mm]"];
    let title = "Encoder faults that only energy or time can end";
    TableBlock::new("undetected", title, caption, &header, faults.iter().map(row).collect())
}

fn passed(belts: &[MovingResult]) -> TableBlock {
    let row = |found: &MovingResult| {
        let belt = found.belt;
        let rate = |rate: f64| match rate {
            0.0 => "0".into(),
            rate if rate < 1e-6 => format!("{rate:.0e}"),
            rate if rate < 1e-2 => format!("{rate:.1e}"),
            rate if rate.is_finite() => format!("{rate:.3}"),
            _ => "always".into(),
        };
        let slowest = format!("{:.1}", 1e3 * super::cases::slowest_m_per_s(belt.counts_per_mm, belt.stop_ms));
        let (speed, ripple, seconds) = (1e3 * belt.speed_m_per_s, 100.0 * belt.ripple_rms, format!("{:.0}", found.seconds));
        let (trips, expected) = (rate(f64::from(found.trips) / found.seconds), rate(belt.expected_per_s()));
        let verdict = if belt.must_pass { verdict(found.holds()) } else { "" };
        cells![belt.counts_per_mm, belt.stop_ms, slowest, speed, ripple, seconds, found.trips, trips, expected, verdict]
    };
    let header =
        ["counts/mm", "T [ms]", "1 / (n T) [mm/s]", "speed [mm/s]", "ripple [%]", "seconds", "trips", "a second", "by Rice", ""];
    let caption = "Mutes and faults of a moving belt, with a force channel. By Rice: the rate at which the speed falls below 1 / \
                   (n T), `f exp(-L^2 / 2)` for a margin of L standard deviations; a dip trips only if it lasts until a count is \
                   missing.";
    TableBlock::new("passed", "False trips", caption.to_owned(), &header, belts.iter().map(row).collect())
}
