//! The campaign as tables.

use super::by_clock::Timed;
use super::many::{self, Class};
use super::mass::Known;
use super::single::{Case, Group, Single};
use super::{Campaign, Extent, Judged};
use plant::dring::motion::Extremes;
use report::TableBlock;
use sim::tables::number;

/// All tables.
pub fn tables(campaign: &Campaign) -> Vec<TableBlock> {
    vec![
        targets(campaign),
        single(campaign, &[Group::Occupant], "occupants", "Who sits there", OCCUPANTS),
        single(campaign, &[Group::Actuator, Group::Early], "actuators", "What lowers the friction", ACTUATORS),
        single(campaign, &[Group::Wrap], "wraps", "Angle of wrap", "Light occupant, ideal switch."),
        single(campaign, &[Group::Limiter], "limiters", "Load limiter", LIMITERS),
        timed(campaign),
        classes(campaign),
        known(campaign),
        single(campaign, &[Group::Doubt], "doubt", "In doubt", DOUBT),
    ]
}

const OCCUPANTS: &str = "Ideal switch; the firmware decides. Medium and heavy occupants have the passive belt to the last bit.";
const ACTUATORS: &str =
    "Light occupant; the firmware decides. Power is what the actuator gives to the contact at most, where its law knows it.";
const LIMITERS: &str = "Light occupant, ideal switch. A limiter that a light occupant does not reach leaves nothing to gain.";
const DOUBT: &str = "Light occupant unless said, ideal switch. Whatever is missing or cannot be leaves friction HIGH.";

/// The same as Markdown, for the documentation, with the commands behind.
pub fn markdown(campaign: &Campaign) -> String {
    report::markdown(&[tables(campaign), vec![commands()]].concat())
}

fn targets(campaign: &Campaign) -> TableBlock {
    let row = |judged: Judged| {
        let verdict = if judged.holds { "PASS" } else { "MISS" };
        vec![judged.what.to_owned(), judged.target, number(judged.found), verdict.to_owned()]
    };
    TableBlock::new("targets", "Targets", "", &["what", "target", "found", ""], campaign.judged().into_iter().map(row).collect())
}

/// A change in per cent, or none.
fn percent(part: f64) -> String {
    if part == 0.0 { "0".into() } else { unsigned(&format!("{:+.1} %", 100.0 * part)) }
}

/// A number of newton; whole.
fn whole(value: f64) -> String {
    format!("{value:.0}")
}

fn millimetres(metres: f64) -> String {
    format!("{:.0}", 1e3 * metres)
}

fn added(metres: f64) -> String {
    if metres == 0.0 { "0".into() } else { unsigned(&format!("{:+.1}", 1e3 * metres)) }
}

/// What rounds to nothing has no sign.
fn unsigned(text: &str) -> String {
    let digits = text.trim_start_matches(['+', '-']);
    if digits.starts_with("0.0") { digits.to_owned() } else { text.to_owned() }
}

fn single(campaign: &Campaign, groups: &[Group], id: &str, title: &str, caption: &str) -> TableBlock {
    let row = |single: &Single| {
        let get = |metric: &str| single.metrics.get(metric).unwrap_or(f64::NAN);
        let optional = |metric: &str, unit: f64| {
            single.metrics.get(metric).map_or_else(|| "–".into(), |value| format!("{:.1}", unit * value))
        };
        vec![
            single.case.name.to_owned(),
            optional("switch_time_ms", 1.0),
            whole(get("passive_peak_shoulder_force_n")),
            whole(get("peak_shoulder_force_n")),
            percent(-0.01 * get("shoulder_force_reduction_percent")),
            millimetres(get("passive_torso_excursion_m")),
            added(get("added_excursion_m")),
            format!("{:.1}", get("chest_acceleration_g")),
            format!("{:.2}", get("payout_speed_m_per_s")),
            optional("actuator_power_w", 1e-3),
        ]
    };
    let rows: Vec<Vec<String>> = campaign.single.iter().filter(|single| groups.contains(&single.case.group)).map(row).collect();
    let header = [
        "",
        "LOW after [ms]",
        "passive peak [N]",
        "peak [N]",
        "change",
        "passive excursion [mm]",
        "added [mm]",
        "chest [g]",
        "payout up to [m/s]",
        "power [kW]",
    ];
    TableBlock::new(id, title, caption, &header, rows)
}

fn timed(campaign: &Campaign) -> TableBlock {
    let row = |timed: &Timed| {
        let at = |ms: Option<f64>| ms.map_or_else(|| "never".into(), |ms| format!("{ms:.0}"));
        let Extremes { shoulder_n, excursion_m, .. } = timed.extremes;
        vec![
            timed.occupant.to_owned(),
            at(timed.low_ms),
            at(timed.high_ms),
            whole(shoulder_n),
            percent(shoulder_n / timed.passive.shoulder_n - 1.0),
            millimetres(excursion_m),
            added(excursion_m - timed.passive.excursion_m),
        ]
    };
    let caption = "An ideal switch thrown by a clock, on the plant alone. LOW that comes when the peak is over, or that goes back to HIGH, has the \
                   force of the passive belt and more way besides.";
    let header = ["occupant", "LOW at [ms]", "HIGH again at [ms]", "peak [N]", "change", "excursion [mm]", "added [mm]"];
    TableBlock::new("timing", "When to switch", caption, &header, campaign.timed.iter().map(row).collect())
}

fn classes(campaign: &Campaign) -> TableBlock {
    let row = |class: &Class| {
        let three = |metric: &str, scale: f64| {
            [0.05, 0.5, 0.95].map(|part| format!("{:.1}", scale * class.percentile(metric, part))).join(", ")
        };
        let latest = class.percentile("switch_time_ms", 1.0);
        vec![
            class.name.to_owned(),
            class.runs.len().to_string(),
            class.low().to_string(),
            class.faulted().to_string(),
            three("shoulder_force_reduction_percent", 1.0),
            three("added_excursion_m", 1e3),
            three("torso_excursion_m", 1e3),
            if latest.is_finite() { format!("{latest:.1}") } else { "–".into() },
        ]
    };
    let caption = "Pulse 15 to 25 g, shoulder belt 40 to 120 kN/m, slack 0 to 30 mm, and the seat up to 15 % off, all uniform. Three numbers: 5 % of the \
                   crashes have less, half, 95 %. Only the light occupant should be switched.";
    let header = [
        "occupant",
        "crashes",
        "switched LOW",
        "faults",
        "less force [%]",
        "added excursion [mm]",
        "excursion [mm]",
        "latest LOW [ms]",
    ];
    TableBlock::new("classes", "Many crashes of each class", caption, &header, campaign.classes.iter().map(row).collect())
}

fn known(campaign: &Campaign) -> TableBlock {
    let row = |known: &Known| {
        let what = known.at_ms.map_or_else(|| "the seat, before".into(), |ms| format!("the crash, up to {ms:.0} ms"));
        vec![what, format!("{:.2}", known.r2), format!("{:.1}", known.left_kg)]
    };
    let caption = "R2 is the part of the variance of the mass that is explained. Of a mass drawn evenly from 14 to 29 kg the deviation is 4.3 kg if nothing \
                   is known.";
    let header = ["who tells the mass", "R2", "deviation left [kg]"];
    TableBlock::new("mass", "Does the crash tell the mass?", caption, &header, campaign.known.iter().map(row).collect())
}

fn commands() -> TableBlock {
    let single = Case::ALL.iter().map(|case| vec![case.name.to_owned(), format!("`{}`", case.command())]);
    let many = ["5th", "50th", "95th"]
        .map(|occupant| vec![format!("{occupant}, many crashes"), format!("`{}`", many::command(occupant, Extent::FULL.runs))]);
    TableBlock::new("commands", "Each crash by itself", "", &["crash", "command"], single.chain(many).collect())
}
