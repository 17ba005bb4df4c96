//! The results as tables, and each file as a line of numbers.

use std::collections::BTreeMap;

use import::synthetic::NAMES;

use super::judged::{Damaged, End, Judged, statistics};
use super::{COVERAGE, EFFICIENCY};
use crate::evidence::Error;
use report::{TableBlock, verdict};

/// All tables.
pub(super) fn tables(set: &[Judged], ruined: &[Damaged]) -> Vec<TableBlock> {
    vec![by_number(set), by_kind(set), of_damaged(ruined)]
}

fn percent(part: f64) -> String {
    format!("{:.1}", 100.0 * part)
}

fn by_number(set: &[Judged]) -> TableBlock {
    let row = |of: super::judged::Statistics| {
        let holds = (COVERAGE.0..=COVERAGE.1).contains(&of.within) && of.median <= EFFICIENCY;
        vec![
            of.name.to_owned(),
            percent(of.within),
            format!("{:.2}", of.rms),
            format!("{:.1}", of.worst),
            format!("{:.2}", of.median),
            format!("{:.2}", of.p95),
            verdict(holds).to_owned(),
        ]
    };
    let found = set.iter().filter(|judged| judged.numbers.is_some()).count();
    let caption = format!(
        "Of {} files {found} gave a circuit. Within 2 sd: part of the truths that lie within two stated standard deviations, to be {:.0} to {:.0} %; rms and worst: error over \
         the stated deviation; over the bound: stated deviation over the Cramér-Rao bound of the noise that was put in, to be at most {EFFICIENCY} in the median.",
        set.len(),
        100.0 * COVERAGE.0,
        100.0 * COVERAGE.1
    );
    let header = ["number", "within 2 sd [%]", "rms", "worst", "over the bound, median", "95 %", ""];
    TableBlock::new("numbers", "Numbers of the working mode", caption, &header, statistics(set).into_iter().map(row).collect())
}

fn by_kind(set: &[Judged]) -> TableBlock {
    type Choice<'a> = (String, Box<dyn Fn(&Judged) -> bool + 'a>);
    let mut forms: Vec<&'static str> = set.iter().map(|judged| judged.kind.form).collect();
    forms.sort_unstable();
    forms.dedup();
    let mut choices: Vec<Choice> = Vec::new();
    for form in forms {
        choices.push((form.to_owned(), Box::new(move |judged| judged.kind.form == form)));
    }
    choices.push(("noise with memory".into(), Box::new(|judged| judged.kind.memory)));
    choices.push(("with a fixture to correct".into(), Box::new(|judged| judged.kind.fixture)));
    choices.push(("one resonance".into(), Box::new(|judged| judged.modes.0 == 1)));
    choices.push(("two or three resonances".into(), Box::new(|judged| judged.modes.0 > 1)));
    choices.push(("101 points".into(), Box::new(|judged| judged.points == 101)));
    choices.push(("1601 points".into(), Box::new(|judged| judged.points == 1601)));
    let row = |(name, of): &Choice| {
        let part: Vec<&Judged> = set.iter().filter(|judged| of(judged)).collect();
        let rows = statistics(part.iter().copied());
        let mean = |value: fn(&super::judged::Statistics) -> f64| rows.iter().map(value).sum::<f64>() / rows.len().max(1) as f64;
        let right = part.iter().filter(|judged| judged.modes.0 == judged.modes.1).count();
        vec![
            name.clone(),
            part.len().to_string(),
            part.iter().filter(|judged| judged.refused.is_some()).count().to_string(),
            right.to_string(),
            percent(mean(|row| row.within)),
            format!("{:.2}", mean(|row| row.median)),
        ]
    };
    let caption = "Right number: files of which as many resonances were found as there are; one that is lost in the noise is none to be found. Within 2 sd and over the bound (median): \
                   means over the eight numbers.";
    let header = ["files", "number", "refused", "right number", "within 2 sd [%]", "over the bound"];
    TableBlock::new("kinds", "By form, noise, fixture and circuit", caption, &header, choices.iter().map(row).collect())
}

fn of_damaged(ruined: &[Damaged]) -> TableBlock {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for file in ruined {
        let name = match file.end {
            End::Taken => "a circuit all the same".to_owned(),
            End::Refused(name) => format!("refused: {name}"),
            End::Panic => "panic".to_owned(),
        };
        *counts.entry(name).or_default() += 1;
    }
    counts.entry("panic".to_owned()).or_default();
    let rows = counts.into_iter().map(|(name, count)| vec![name, count.to_string()]).collect();
    let caption = "Bytes, fields and lines of files changed, doubled, lost or cut, one to six times each. Where a circuit comes all the same, the damage has not touched the table, or left a \
                   point that the fit counts as noise.";
    TableBlock::new("damaged", "Damaged files", caption, &["what it comes to", "files"], rows)
}

/// Each file as a line.
pub(super) fn csv(set: &[Judged]) -> Result<String, Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut header: Vec<String> =
        ["number", "form", "memory", "fixture", "points", "modes", "modes_found", "refused"].map(str::to_owned).into();
    for name in NAMES {
        header.extend([format!("{name}_error_in_sd"), format!("{name}_sd_over_bound")]);
    }
    writer.write_record(&header)?;
    for judged in set {
        let mut record = vec![
            judged.number.to_string(),
            judged.kind.form.to_owned(),
            judged.kind.memory.to_string(),
            judged.kind.fixture.to_string(),
            judged.points.to_string(),
            judged.modes.0.to_string(),
            judged.modes.1.to_string(),
            judged.refused.clone().unwrap_or_default(),
        ];
        for at in 0..NAMES.len() {
            let number = judged.numbers.map(|numbers| numbers[at]);
            let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.4}"));
            record.extend([cell(number.map(|number| number.deviations)), cell(number.map(|number| number.over_bound))]);
        }
        writer.write_record(&record)?;
    }
    let bytes = writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
