//! The campaign as tables.

use super::cases::Way;
use super::{Found, TOLERANCE};
use report::TableBlock;

/// All tables.
pub fn tables(campaign: &[Found]) -> Vec<TableBlock> {
    vec![survey(campaign), amplitude(campaign), bursts(campaign), coulomb(campaign), refused(campaign)]
}

/// The same as Markdown, for the documentation.
pub fn markdown(campaign: &[Found]) -> String {
    report::markdown(&tables(campaign))
}

fn three(value: f64) -> String {
    format!("{value:.3}")
}

fn optional(value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), three)
}

fn contact(found: &Found) -> [String; 2] {
    [format!("{}", 1e6 * found.case.length_m), format!("{}", 1e3 * found.case.speed_m_per_s)]
}

fn told(found: &Found) -> String {
    format!("{:+.0} %", 1e2 * (found.case.told - 1.0))
}

fn survey(campaign: &[Found]) -> TableBlock {
    let of = campaign.iter().filter(|found| matches!(found.case.way, Way::Amplitude));
    let row = |found: &Found| {
        let deviation = found.metrics.get("kappa_deviation").map_or("–".into(), |part| format!("{:.0} %", 1e2 * part));
        let floors = [three(found.case.floor()), optional(found.metrics.get("friction_floor_estimate"))];
        let kappas = [three(found.case.kappa()), optional(found.metrics.get("kappa_estimate")), deviation];
        [contact(found).to_vec(), vec![told(found)], kappas.to_vec(), floors.to_vec()].concat()
    };
    TableBlock::new(
        "survey",
        "What the survey finds",
        "Kappa is the vibration amplitude in Dahl lengths at the loudest drive; the floor is the ratio there, by the closed form and as the controller \
         believes. Of a soft contact kappa is not known well, because it hardly matters.",
        &["Fc / Kt [um]", "speed [mm/s]", "told", "kappa", "found", "its deviation", "floor", "believed"],
        of.map(row).collect(),
    )
}

/// One row a case: the truth at each wanted ratio.
fn ratios(found: &Found) -> Vec<String> {
    let cell = |step: &sim::instruments::friction_switch::Step| match step.is_refused() {
        true => format!("{:.3}: refused", step.wanted),
        false => format!("{:.3}: {:+.4}", step.wanted, step.error()),
    };
    found.steps.iter().map(cell).collect()
}

fn verdict(worst: f64) -> String {
    let miss = if worst > TOLERANCE { "MISS " } else { "" };
    format!("{miss}{worst:.4}")
}

fn amplitude(campaign: &[Found]) -> TableBlock {
    let of = campaign.iter().filter(|found| matches!(found.case.way, Way::Amplitude));
    let row = |found: &Found| {
        let believed = found.steps.iter().filter(|step| !step.is_refused());
        let estimates = believed.filter_map(|step| Some((step.estimate? - step.truth).abs())).fold(0.0, f64::max);
        let steps = ratios(found).into_iter().take(7).collect();
        [contact(found).to_vec(), vec![told(found)], steps, vec![verdict(found.worst()), format!("{estimates:.4}")]].concat()
    };
    TableBlock::new(
        "amplitude",
        "By amplitude",
        "Wanted ratio, and by how much the true one is off. The last columns: the largest error of the truth, and of what the controller believes.",
        &["Fc / Kt [um]", "speed [mm/s]", "told", "", "", "", "", "", "", "", "worst", "belief"],
        of.map(row).collect(),
    )
}

fn bursts(campaign: &[Found]) -> TableBlock {
    let of = campaign.iter().filter(|found| matches!(found.case.way, Way::Bursts(_) | Way::Plain(_)));
    let row = |found: &Found| {
        let way = match found.case.way {
            Way::Bursts(hz) => format!("boosted, {hz} Hz"),
            Way::Plain(hz) => format!("plain, {hz} Hz"),
            Way::Amplitude | Way::Coulomb => String::new(),
        };
        let by_bursts = found.steps.iter().filter(|step| step.bursts).count();
        let ends = vec![verdict(found.worst()), format!("{by_bursts} of {}", found.steps.len())];
        [contact(found).to_vec(), vec![told(found), way], ratios(found), ends].concat()
    };
    TableBlock::new(
        "bursts",
        "By bursts",
        "Wanted ratio, and by how much the true one is off, means over 70 ms of whole burst periods. From 0.15 of what lies above the floor to 0.8. The last \
         column: how many of these were had by bursts; the others by amplitude, because their duty would have been too large or too small.",
        &["Fc / Kt [um]", "speed [mm/s]", "told", "bursts", "", "", "", "", "", "worst", "by bursts"],
        of.map(row).collect(),
    )
}

fn coulomb(campaign: &[Found]) -> TableBlock {
    let of = campaign.iter().filter(|found| matches!(found.case.way, Way::Coulomb));
    let row = |found: &Found| [contact(found).to_vec(), ratios(found), vec![format!("{:.3}", found.worst())]].concat();
    TableBlock::new(
        "coulomb",
        "The reference: Coulomb's inverse law",
        "The same by `1 / sin(pi r / 2)`, which knows no stiffness: it drives too softly, and the friction stays too high.",
        &["Fc / Kt [um]", "speed [mm/s]", "", "", "", "", "", "worst"],
        of.map(row).collect(),
    )
}

fn refused(campaign: &[Found]) -> TableBlock {
    let all = campaign.iter().filter(|found| matches!(found.case.way, Way::Amplitude));
    let rows = all.flat_map(|found| {
        found.steps.iter().filter(|step| step.wanted < found.case.floor()).map(move |step| {
            let end = [three(step.wanted), three(found.case.floor()), step.limit.to_string(), three(step.truth)];
            [contact(found).to_vec(), vec![told(found)], end.to_vec()].concat()
        })
    });
    TableBlock::new(
        "refused",
        "What cannot be had",
        "A ratio below the floor: limit 103, and the loudest drive.",
        &["Fc / Kt [um]", "speed [mm/s]", "told", "wanted", "floor", "limit", "truth"],
        rows.collect(),
    )
}
