//! The results as tables, and each file as a row of CSV.

use import::synthetic::NAMES;

use super::judged::{Damaged, ImportResult, Judged, Statistics, statistics};
use super::{MAX_BOUND_RATIO, MAX_COVERAGE, MIN_COVERAGE};
use crate::campaign::{self, cells, count, tally};
use crate::evidence::Error;
use report::{TableBlock, verdict};

/// Returns all tables.
pub(super) fn tables(set: &[Judged], ruined: &[Damaged]) -> Vec<TableBlock> {
    vec![by_number(set), by_kind(set), of_damaged(ruined)]
}

fn percent(part: f64) -> String {
    format!("{:.1}", 100.0 * part)
}

fn by_number(set: &[Judged]) -> TableBlock {
    let row = |of: Statistics| {
        let holds = (MIN_COVERAGE..=MAX_COVERAGE).contains(&of.within) && of.median <= MAX_BOUND_RATIO;
        let (within, worst) = (percent(of.within), format!("{:.1}", of.worst));
        let [rms, median, p95] = [of.rms, of.median, of.p95].map(|value| format!("{value:.2}"));
        cells![of.name, within, rms, worst, median, p95, verdict(holds)]
    };
    let found = set.iter().filter(|judged| judged.numbers.is_some()).count();
    let caption = format!(
        "Of {} files {found} gave a circuit. Within 2 sd: fraction of the truths within two stated standard deviations, required \
         {:.0} to {:.0} %; rms and worst: error over the stated deviation; over the bound: stated deviation over the Cramér-Rao \
         bound of the added noise, required at most {MAX_BOUND_RATIO} in the median.",
        set.len(),
        100.0 * MIN_COVERAGE,
        100.0 * MAX_COVERAGE
    );
    let header = ["number", "within 2 sd [%]", "rms", "worst", "over the bound, median", "95 %", ""];
    TableBlock::new("numbers", "Numbers of the working mode", caption, &header, statistics(set).into_iter().map(row).collect())
}

fn by_kind(set: &[Judged]) -> TableBlock {
    let mut forms: Vec<&'static str> = set.iter().map(|judged| judged.kind.form).collect();
    forms.sort_unstable();
    forms.dedup();
    type Choice<'a> = (&'a str, Box<dyn Fn(&Judged) -> bool + 'a>);
    let of_form = |form| -> Choice { (form, Box::new(move |judged| judged.kind.form == form)) };
    let others: [Choice; 6] = [
        ("correlated noise", Box::new(|judged| judged.kind.memory)),
        ("with a fixture to correct", Box::new(|judged| judged.kind.fixture)),
        ("one resonance", Box::new(|judged| judged.modes.0 == 1)),
        ("two or three resonances", Box::new(|judged| judged.modes.0 > 1)),
        ("101 points", Box::new(|judged| judged.points == 101)),
        ("1601 points", Box::new(|judged| judged.points == 1601)),
    ];
    let choices = forms.into_iter().map(of_form).chain(others);
    let row = |(name, of): Choice| {
        let part: Vec<&Judged> = set.iter().filter(|judged| of(judged)).collect();
        let rows = statistics(part.iter().copied());
        let mean = |value: fn(&Statistics) -> f64| rows.iter().map(value).sum::<f64>() / rows.len().max(1) as f64;
        let count = |is: fn(&Judged) -> bool| count(part.iter().copied(), is);
        let (refused, right) = (count(|judged| judged.refused.is_some()), count(|judged| judged.modes.0 == judged.modes.1));
        let (within, median) = (percent(mean(|row| row.within)), format!("{:.2}", mean(|row| row.median)));
        cells![name, part.len(), refused, right, within, median]
    };
    let caption = "Right number: files in which the number of resonances found is the true one; a resonance below the noise does \
                   not count. Within 2 sd and over the bound (median): means over the eight numbers.";
    let header = ["files", "number", "refused", "right number", "within 2 sd [%]", "over the bound"];
    TableBlock::new("kinds", "By form, noise, fixture and circuit", caption, &header, choices.map(row).collect())
}

fn of_damaged(ruined: &[Damaged]) -> TableBlock {
    let mut counts = tally(ruined.iter().map(|file| match file.end {
        ImportResult::Taken => "imported as a circuit".to_owned(),
        ImportResult::Refused(name) => format!("refused: {name}"),
        ImportResult::Panic => "panic".to_owned(),
    }));
    counts.entry("panic".to_owned()).or_default();
    let rows = counts.into_iter().map(|(name, count)| cells![name, count]).collect();
    let caption = "Bytes, fields and lines of files changed, doubled, lost or cut, one to six times each. If a damaged file \
                   still gives a circuit, the damage is outside the table, or it left a point that the fit counts as noise.";
    TableBlock::new("damaged", "Damaged files", caption, &["result", "files"], rows)
}

/// Returns one row of CSV per file.
pub(super) fn csv(set: &[Judged]) -> Result<String, Error> {
    let errors: String = NAMES.iter().map(|name| format!(",{name}_error_in_sd,{name}_sd_over_bound")).collect();
    let rows = set.iter().map(|judged| {
        let (kind, (modes, found)) = (&judged.kind, judged.modes);
        let refused = judged.refused.as_deref().unwrap_or_default();
        let own = cells![judged.number, kind.form, kind.memory, kind.fixture, judged.points, modes, found, refused];
        let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
        let numbers = (0..NAMES.len()).flat_map(|at| {
            let number = judged.numbers.map(|numbers| numbers[at]);
            [number.map(|number| number.deviations), number.map(|number| number.over_bound)].map(cell)
        });
        own.into_iter().chain(numbers).collect()
    });
    campaign::csv(&format!("number,form,memory,fixture,points,modes,modes_found,refused{errors}"), rows)
}
