//! Tables of the results.

use super::case::{LARGEST_FORCE_N, STEP_S, TABLE_4_1};
use super::claim::{Check, Claim};
use super::{Erratum, Findings};
use report::{TableBlock, significant};

/// Joins numbers as `name value; name value`.
pub fn numbers(numbers: &[(String, f64)]) -> String {
    numbers.iter().map(|(name, value)| format!("{name} {}", significant(*value))).collect::<Vec<_>>().join("; ")
}

/// Tabulates Table 4.1 and values computed from it.
pub fn table_4_1() -> TableBlock {
    let case = TABLE_4_1;
    let row = |name: &str, value: String, source: &str| vec![name.into(), value, source.into()];
    let rows = vec![
        row("mass m", format!("{} kg", case.mass_kg), "Table 4.1"),
        row("system stiffness Ks", format!("{}e6 N/m", case.stiffness_n_per_m / 1e6), "Table 4.1"),
        row("excitation frequency", format!("{} kHz", case.frequency_hz / 1e3), "Table 4.1"),
        row("piezo control force Fe", format!("0 to {LARGEST_FORCE_N} N; plots at {} N", case.force_n), "Table 4.1, 4.3.1"),
        row("tangential stiffness Kt", format!("{}e6 N/m", case.contact_n_per_m / 1e6), "Table 4.1"),
        row("coefficient of friction mu", format!("{}", case.mu), "Table 4.1"),
        row(
            "solver",
            "fourth order Runge-Kutta".into(),
            "Table 4.1; here the cheapest method with an error below 1e-6 at each point",
        ),
        row("time step", format!("{STEP_S:e} s"), "Table 4.1"),
        row("natural frequency", format!("{} Hz", significant(case.natural_hz())), "sqrt(Ks/m)/(2 pi)"),
        row("Coulomb force Fc", format!("{} N", significant(case.coulomb_n())), "mu m g"),
        row("vibration velocity Vv at 384 N", format!("{} m/s", significant(case.vibration_m_per_s())), "w F0/|Ks - m w^2|"),
        row("vibration amplitude at 384 N", format!("{} um", significant(1e6 * case.vibration_m_per_s() / case.omega())), "Vv/w"),
        row("Dahl length", format!("{} um", significant(1e6 * case.coulomb_n() / case.contact_n_per_m)), "Fc/Kt"),
        row("kappa at 384 N", significant(case.kappa()), "Kt Vv/(w Fc): amplitude in Dahl lengths"),
    ];
    let caption = "The upper eight rows are from the thesis; the others follow from them and determine the behaviour.";
    TableBlock::new("table-4-1", "Table 4.1: simulation parameters", caption, &["parameter", "value", "source"], rows)
}

/// Tabulates the claims with their verdicts; one row for each check.
pub fn claims(findings: &Findings) -> TableBlock {
    let mut rows = Vec::new();
    for claim in &findings.claims {
        for (index, check) in claim.checks.iter().enumerate() {
            let [says, section, verdict] = if index == 0 {
                [format!("{}: {}", claim.id, claim.says), claim.section.to_owned(), claim.verdict().word().to_owned()]
            } else {
                Default::default()
            };
            let Check { condition, holds, numbers: values } = check;
            let holds = if *holds { "holds" } else { "fails" };
            rows.push(vec![says, section, verdict, format!("{holds}: {condition}"), numbers(values)]);
        }
    }
    let caption = "Reproduced: holds in every check. Conditional: holds under some conditions. Refuted: holds in no check. \
                   The verdicts are computed from the numbers.";
    let header = ["claim", "thesis", "verdict", "check", "numbers"];
    TableBlock::new("claims", "Claims of chapters 2 to 4 and appendix B", caption, &header, rows)
}

/// Tabulates the contradictions.
pub fn errata(findings: &Findings) -> TableBlock {
    let row = |erratum: &Erratum| {
        let Check { condition, holds, numbers: values } = &erratum.evidence;
        let shown = if *holds { "shown" } else { "not shown" };
        let says = format!("{} Instead: {}", erratum.printed, erratum.instead);
        vec![format!("{} ({})", erratum.id, erratum.places), says, format!("{shown}: {condition}"), numbers(values)]
    };
    let rows = findings.errata.iter().map(row).collect();
    TableBlock::new("errata", "Contradictions", "", &["place", "printed and correct statement", "evidence", "numbers"], rows)
}

/// Tabulates the open choices.
pub fn choices(findings: &Findings) -> TableBlock {
    let rows =
        findings.choices.iter().map(|choice| vec![choice.what.into(), choice.here.into(), numbers(&choice.numbers)]).collect();
    let caption = "Friction ratio at Table 4.1, 384 N, velocity ratio 0.5, under each choice.";
    TableBlock::new("open", "Choices that the thesis leaves open", caption, &["open", "chosen here", "numbers"], rows)
}

/// Tabulates contradictions, open choices and verdicts for the documentation, without the numbers
/// of each check.
pub fn in_short(findings: &Findings) -> Vec<TableBlock> {
    let erratum = |erratum: &Erratum| {
        let Check { condition, numbers: values, .. } = &erratum.evidence;
        let Erratum { id, places, printed, instead, .. } = erratum;
        let cells = [format!("`{id}`: {places}"), (*printed).into(), (*instead).into()];
        [cells.to_vec(), vec![format!("{condition}: {}", numbers(values))]].concat()
    };
    let claim = |claim: &Claim| {
        let [holds, fails] = [true, false].map(|holds| claim.conditions(holds).join("; "));
        vec![
            format!("`{}`: {}", claim.id, claim.says),
            claim.section.into(),
            format!("**{}**", claim.verdict().word()),
            holds,
            fails,
        ]
    };
    let untitled = |header: &[&str], rows: Vec<Vec<String>>| TableBlock::new("", "", "", header, rows);
    vec![
        untitled(&["place", "printed", "instead", "evidence"], findings.errata.iter().map(erratum).collect()),
        untitled(&["open", "chosen here", "friction ratio"], choices(findings).rows),
        untitled(&["claim", "thesis", "verdict", "holds", "fails"], findings.claims.iter().map(claim).collect()),
    ]
}
