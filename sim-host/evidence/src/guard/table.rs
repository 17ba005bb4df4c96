//! The campaign as tables.

use super::{Passed, Stopped, Undetected};
use report::{TableBlock, verdict};
use sim::study::monte_carlo::statistics::Spread;

/// A welder's power, W.
const WELDER_W: f64 = 2500.0;
/// Contact of 46 by 10 mm, and the layer of it that melts first, m (thesis 3.2: the belt's width, the tip's length).
const LAYER_M: [f64; 3] = [46e-3, 10e-3, 100e-6];
/// Nylon 6.6: density, kg/m^3, specific heat, J/(kg K), and what it takes from a room to 230 degrees Celsius, K.
const NYLON: (f64, f64, f64) = (1140.0, 1700.0, 205.0);

/// All tables; `power_w` is the drive's power into the motional branch.
pub fn tables(power_w: f64, events: &[Stopped], faults: &[Undetected], belts: &[Passed]) -> Vec<TableBlock> {
    vec![stopped(power_w, events), undetected(power_w, faults), passed(belts)]
}

/// Energy that melts the layer, J.
fn layer_j() -> f64 {
    let (density, specific_heat, rise_k) = NYLON;
    LAYER_M.iter().product::<f64>() * density * specific_heat * rise_k
}

fn three(spread: &Spread) -> String {
    format!("{:.2}, {:.2}, {:.2}", spread.median, spread.p95, spread.max)
}

fn stopped(power_w: f64, events: &[Stopped]) -> TableBlock {
    let row = |found: &Stopped| {
        let ends: Vec<String> =
            found.ends.iter().map(|&code| if code == 0 { "muted".into() } else { code.to_string() }).collect();
        vec![
            found.event.name.to_owned(),
            found.runs.to_string(),
            found.missed.to_string(),
            three(&found.off_ms),
            found.event.at_most_ms.map_or_else(|| "–".into(), |ms| ms.to_string()),
            found.event.at_most_ms.map_or_else(String::new, |_| verdict(found.holds()).to_owned()),
            ends.join(", "),
            format!("{:.4}", found.exposure_j.max),
            format!("{:.1}", found.exposure_j.max / power_w * WELDER_W),
            format!("{:.2}", found.ring_down_ms.max),
        ]
    };
    let caption = format!(
        "Each run at another speed of 10 to 70 mm/s with a ripple of 10 % rms at 10 Hz, another phase of the encoder and another moment; 100 counts/mm, \
         and {} ms until a mute where no other time is named. Times from the moment that the belt is slower than 1 / (n T), or that its encoder fails, \
         to the first block without drive: median, 95 %, largest. Exposure: electrical energy into the motional branch in \
         that time, all of it into one millimetre, at {:.2} W and, in proportion, at {WELDER_W} W; the same millimetre at 10 mm/s gets {:.3} J/mm as it \
         passes. A layer of 100 um of \
         nylon under 46 x 10 mm takes {:.1} J to 230 degrees Celsius, which {WELDER_W} W give in {:.1} ms. Ring-down: to 5 % of the tip velocity, after \
         that.",
        super::cases::STOP_MS,
        power_w,
        1e-3 / 0.01 * power_w,
        layer_j(),
        1e3 * layer_j() / WELDER_W,
    );
    let header = [
        "what happens",
        "runs",
        "missed",
        "drive OFF after [ms]",
        "at most",
        "",
        "ends",
        "exposure [J/mm]",
        "at 2.5 kW [J/mm]",
        "ring-down [ms]",
    ];
    TableBlock::new("stopped", "The belt stops, slows, or its encoder fails", caption, &header, events.iter().map(row).collect())
}

fn undetected(power_w: f64, faults: &[Undetected]) -> TableBlock {
    let row = |found: &Undetected| {
        let limit = |limit: Option<f64>| limit.map_or_else(|| "–".into(), |limit| limit.to_string());
        vec![
            format!("{}", 1e3 * found.encoder.pace_m_per_s),
            limit(found.encoder.energy_j_per_m),
            limit(found.encoder.on_time_s),
            found.undetected_s.map_or_else(|| "for good".into(), |s| format!("{s:.2} s")),
            if found.fault == 0 { "none".into() } else { found.fault.to_string() },
            format!("{:.2}", found.exposure_j),
        ]
    };
    let caption = format!(
        "The belt stands under {:.2} W from the beginning, its encoder counts at an even pace, and there is no force channel. A budget of e J/m ends only a \
         pace below P / e, after L e / (P - e v) with the contact's L of 10 mm; a faster one only `on_time_s` ends.",
        power_w
    );
    let header = ["pace [mm/s]", "energy_j_per_m", "on_time_s", "lasts", "fault", "exposure [J/mm]"];
    TableBlock::new(
        "undetected",
        "Encoder faults that only energy or time can end",
        caption,
        &header,
        faults.iter().map(row).collect(),
    )
}

fn passed(belts: &[Passed]) -> TableBlock {
    let row = |found: &Passed| {
        let belt = found.belt;
        let rate = |rate: f64| match rate {
            0.0 => "0".into(),
            rate if rate < 1e-6 => format!("{rate:.0e}"),
            rate if rate < 1e-2 => format!("{rate:.1e}"),
            rate if rate.is_finite() => format!("{rate:.3}"),
            _ => "always".into(),
        };
        vec![
            belt.counts_per_mm.to_string(),
            belt.stop_ms.to_string(),
            format!("{:.1}", 1e3 * super::cases::slowest_m_per_s(belt.counts_per_mm, belt.stop_ms)),
            format!("{}", 1e3 * belt.speed_m_per_s),
            format!("{}", 100.0 * belt.ripple_rms),
            format!("{:.0}", found.seconds),
            found.trips.to_string(),
            rate(f64::from(found.trips) / found.seconds),
            rate(belt.expected_per_s()),
            if belt.must_pass { verdict(found.holds()) } else { "" }.to_owned(),
        ]
    };
    let header =
        ["counts/mm", "T [ms]", "1 / (n T) [mm/s]", "speed [mm/s]", "ripple [%]", "seconds", "trips", "a second", "by Rice", ""];
    let caption = "Mutes and faults of a belt that moves, with the force channel listening. By Rice: how often a second the speed sinks below 1 / (n T) at \
                   all, `f exp(-L^2 / 2)` at L deviations down; a dip has to last for a count to be missing.";
    TableBlock::new("passed", "False trips", caption.to_owned(), &header, belts.iter().map(row).collect())
}
