//! Chapters 2 to 4 and appendix B of the thesis, recomputed: every figure, every claim in words,
//! every contradiction.
//!
//! ```text
//! experiments (3.1, 3.2) --> scenes --> run, including the controller --> curves, checks
//! case (Table 4.1) --> problems --> contact::solve, in parallel --> curves --> figures (numbered as in the thesis)
//!                                                                     `-----> checks --> claims with verdicts
//! ```
//!
//! A study covers one figure or a few: it computes once, and draws and judges from the same
//! numbers. Verdicts are computed, never entered by hand: [`claim`] derives each from checks.

pub mod case;
pub mod claim;
mod comparison;
mod contact_stiffness;
mod control_force;
pub(crate) mod driven;
pub mod errata;
pub(crate) mod experiment_1;
pub(crate) mod experiment_2;
mod frequencies;
mod friction_coefficient;
mod json;
mod kinematic_claims;
mod kinematic_waveforms;
mod load;
mod model_claims;
mod models;
mod motor;
mod oscillator_claims;
mod oscillator_waveforms;
mod parametric;
pub(crate) mod picture;
mod power_claims;
mod self_excitation;
mod spectrum;
mod steady;
pub(crate) mod sweep;
mod system_stiffness;
pub mod table;
mod trace;
mod transducers;
mod transient;
mod waveforms;

#[cfg(test)]
pub(crate) mod tests;

#[cfg(test)]
pub(crate) use experiment_2::tables as experiment_2_tables;

use contact::SolveError;
use report::{Figure, Report, TableBlock};

use crate::evidence::{Error, Evidence, Options};
pub use claim::{Claim, Verdict};
pub use errata::{Choice, Erratum};
#[cfg(test)]
pub(crate) use experiment_2::compliant::Belt;
pub use json::summary;

/// Figures and claims of one study.
pub(crate) struct StudyResult {
    figures: Vec<Figure>,
    claims: Vec<Claim>,
}

/// All results.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// Figures 2.5 to 2.13, 3.4 to 3.12, 4.6 to 4.26 and those of appendix B, in order.
    pub figures: Vec<Figure>,
    /// Claims, in the thesis's order.
    pub claims: Vec<Claim>,
    /// Contradictions within the thesis.
    pub errata: Vec<Erratum>,
    /// Choices that the thesis leaves open.
    pub choices: Vec<Choice>,
}

type Study = fn() -> Result<StudyResult, SolveError>;

/// Studies with their topics, in the thesis's order.
const STUDIES: [(&str, Study); 18] = [
    ("transducers: figures 2.5 to 2.13", transducers::study),
    ("experiment 1: figures 3.4, 3.5", experiment_1::study),
    ("experiment 2: figures 3.7-3.12", experiment_2::study),
    ("figures 4.6, 4.7", models::study),
    ("figures 4.8, 4.9", transient::study),
    ("figures 4.10", frequencies::study),
    ("power ratio (4.3.2)", power_claims::study),
    ("figures 4.11", control_force::study),
    ("figures 4.12", friction_coefficient::study),
    ("figures 4.13", load::study),
    ("figures 4.14", contact_stiffness::study),
    ("figures 4.15", system_stiffness::study),
    ("figures 4.16", comparison::study),
    ("figures 4.17-4.20", kinematic_claims::study),
    ("figures 4.21-4.26", oscillator_claims::study),
    ("appendix B: sheet, wave, particle", motor::wave_study),
    ("appendix B: electrodes, mode shapes", motor::shape_study),
    ("appendix B: rotor", motor::rotor_study),
];

/// Computes everything; `progress` is called with the next topic, its number and the total.
pub fn compute(progress: &mut dyn FnMut(&str)) -> Result<Findings, SolveError> {
    let steps = STUDIES.len() + 1;
    let mut findings = Findings::default();
    for (done, (what, study)) in STUDIES.into_iter().enumerate() {
        progress(&format!("[{:>2}/{steps}] {what}", done + 1));
        let part = study()?;
        findings.figures.extend(part.figures);
        findings.claims.extend(part.claims);
    }
    progress(&format!("[{steps}/{steps}] contradictions"));
    findings.errata = errata::all()?;
    findings.choices = errata::choices()?;
    Ok(findings)
}

impl Findings {
    /// Counts the claims with a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.claims.iter().filter(|claim| claim.verdict() == verdict).count()
    }

    /// Builds the tables of parameters, claims, contradictions and open choices.
    pub fn tables(&self) -> Vec<TableBlock> {
        let experiments = [vec![experiment_1::table()], experiment_2::tables()].concat();
        let parameters = [table::table_4_1(), motor::table(), errata::equations()];
        let found = [table::claims(self), table::errata(self), table::choices(self)];
        experiments.into_iter().chain(parameters).chain(found).collect()
    }

    /// Builds the report of all claims and figures.
    pub fn report(&self) -> Report {
        let count =
            |verdict: Verdict| (verdict.word().to_owned(), format!("{} of {} claims", self.count(verdict), self.claims.len()));
        Report {
            title: "Thesis, chapters 2 to 4 and appendix B: figures, claims and contradictions".into(),
            subtitle: "Both experiments simulated, every figure of the analytical model recomputed, every claim in words \
                       judged by numbers; the same for the ultrasonic motor"
                .into(),
            summary: [Verdict::Reproduced, Verdict::Conditional, Verdict::Refuted].map(count).to_vec(),
            paragraphs: vec![
                "The thesis leaves open the averaging window, the initial conditions, the velocity ratio of a velocity with \
                 two frequencies, the quantity that is equal among waveforms, the hold time of the random waveform and the \
                 end of the chirp. Its equations disagree on the sign of the vibration in the slip. Each figure states the \
                 choice made here; if a claim depends on the choice, each choice has a figure."
                    .into(),
            ],
            tables: self.tables(),
            figures: self.figures.clone(),
            footer: vec![("command".into(), "evidence thesis".into())],
            ..Report::default()
        }
    }
}

/// Computes all findings and builds their page.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let findings = compute(options.progress)?;
    let summary = summary(&findings);
    Ok(Evidence { report: findings.report(), docs: table::in_short(&findings), summary, ..Evidence::default() })
}
