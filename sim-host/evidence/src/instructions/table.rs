//! The measurement as tables.

use super::budget::{Judged, Unit};
use super::target::Counted;
use super::{Measurement, Row};
use report::{TableBlock, verdict};

/// All tables, the generators first.
pub fn tables(measurement: &Measurement) -> Vec<TableBlock> {
    vec![generators(measurement), stages(measurement), process(measurement), budget(measurement)]
}

fn generators(measurement: &Measurement) -> TableBlock {
    let row = |row: &Row| {
        let quality = &row.quality;
        vec![
            row.generator.name.to_owned(),
            row.generator.how.to_owned(),
            format!("{:.1}", row.instructions),
            format!("{:.1e}", quality.largest_error),
            format!("{:.0}", quality.sfdr_db),
            format!("{:.0}", quality.sndr_db),
            format!("{:.1}", quality.sndr_12_bit_db),
        ]
    };
    TableBlock::new(
        "generators",
        "A sine with its cosine",
        "Instructions a sample of both, from a phase of 64 bits, in blocks of 32, less those of a loop that only hands numbers out. \
         Error: the largest of either, from 20 to 250 kHz at 1 Msps. SFDR, SNDR: of a sine at 40.4 kHz.",
        &["generator", "how", "instructions", "largest error", "SFDR [dB]", "SNDR [dB]", "SNDR at 12 bits [dB]"],
        measurement.generators.iter().map(row).collect(),
    )
}

fn stages(measurement: &Measurement) -> TableBlock {
    let row = |kernel: &Counted| {
        vec![kernel.kernel.clone(), format!("{:.0}", kernel.per_block()), format!("{:.1}", kernel.per_sample())]
    };
    let stages = measurement.counted.iter().filter(|kernel| kernel.group == "stage");
    TableBlock::new(
        "stages",
        "Stages of the controller",
        "Each called alone, with arguments that the compiler does not know.",
        &["stage", "instructions a block", "a sample"],
        stages.map(row).collect(),
    )
}

fn process(measurement: &Measurement) -> TableBlock {
    let of = |group: &'static str| measurement.counted.iter().filter(move |kernel| kernel.group == group);
    let row = |(mean, worst): (&Counted, &Counted)| {
        vec![
            mean.kernel.clone(),
            mean.repetitions.to_string(),
            format!("{:.0}", mean.per_block()),
            format!("{:.1}", mean.per_sample()),
            format!("{:.0}", worst.per_block()),
        ]
    };
    TableBlock::new(
        "process",
        "The whole controller, `Controller::process`",
        "A power-up on a stack of 40.5 kHz, tracked by the observer behind the calibration of the clamped branch (where it says so, by the phase \
         loop behind a scan), at constant motional current, in bursts with soft edges of 8 periods, and with codes of 12 bits. The load takes \
         200 Hz off the resonance at once. A block is counted to within a tick of the timer, 6 instructions.",
        &["blocks", "how many", "instructions a block, mean", "a sample", "worst block"],
        of("process").zip(of("worst block")).map(row).collect(),
    )
}

fn budget(measurement: &Measurement) -> TableBlock {
    let number = |unit: Unit, value: f64| match unit {
        Unit::Sample => format!("{value:.1}"),
        Unit::Block => format!("{value:.0}"),
        Unit::Error => format!("{value:.1e}"),
    };
    let row = |judged: &Judged| {
        let unit = judged.bound.unit;
        let name = match unit {
            Unit::Sample => "instructions a sample",
            Unit::Block => "instructions a block",
            Unit::Error => "of amplitude one",
        };
        let aim = judged.bound.aim.map_or_else(String::new, |aim| number(unit, aim));
        let numbers = [number(unit, judged.found), number(unit, judged.bound.at_most), aim];
        [vec![judged.bound.name.clone(), name.to_owned()], numbers.into(), vec![verdict(judged.holds()).to_owned()]].concat()
    };
    let caption = "Where less is aimed at, the bound follows as the controller gets there.";
    let header = ["what", "in", "found", "at most", "aimed at", "budget"];
    TableBlock::new("budget", "Budget", caption, &header, measurement.judged.iter().map(row).collect())
}
