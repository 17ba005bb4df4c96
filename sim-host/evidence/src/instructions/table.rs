//! The tables of the measurement.

use super::budget::{Judged, Unit};
use super::target::Counted;
use super::{Measurement, Row};
use crate::campaign::cells;
use report::{TableBlock, verdict};

/// Returns all tables, the generators first.
pub fn tables(measurement: &Measurement) -> Vec<TableBlock> {
    vec![generators(measurement), stages(measurement), process(measurement), budget(measurement)]
}

fn generators(measurement: &Measurement) -> TableBlock {
    let row = |row: &Row| {
        let quality = &row.quality;
        let [instructions, of_12_bits] = [row.instructions, quality.sndr_12_bit_db].map(|value| format!("{value:.1}"));
        let [sfdr, sndr] = [quality.sfdr_db, quality.sndr_db].map(|value| format!("{value:.0}"));
        let error = format!("{:.1e}", quality.largest_error);
        cells![row.generator.name, row.generator.how, instructions, error, sfdr, sndr, of_12_bits]
    };
    TableBlock::new(
        "generators",
        "A sine with its cosine",
        "Instructions a sample of both, from a phase of 64 bits, in blocks of 32, less those of an empty loop. \
         Error: the largest of either, from 20 to 250 kHz at 1 Msps. SFDR, SNDR: of a sine at 40.4 kHz.",
        &["generator", "method", "instructions", "largest error", "SFDR [dB]", "SNDR [dB]", "SNDR at 12 bits [dB]"],
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
        let [of_block, worst] = [mean, worst].map(|counted| format!("{:.0}", counted.per_block()));
        cells![mean.kernel, mean.repetitions, of_block, format!("{:.1}", mean.per_sample()), worst]
    };
    TableBlock::new(
        "process",
        "The whole controller, `Controller::process`",
        "A power-up on a stack of 40.5 kHz, tracked by the observer after the calibration of the clamped branch (rows with \
         `phase loop`: by the phase loop after a scan), at constant motional current, in bursts with soft edges of 8 periods, \
         and with codes of 12 bits. The load lowers the resonance by 200 Hz at once. A block is counted to within a tick of the \
         timer, 6 instructions.",
        &["blocks", "number", "instructions a block, mean", "a sample", "worst block"],
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
    let caption = "Lines with a target: the bound is lowered as the controller approaches it.";
    let header = ["kernel", "unit", "counted", "at most", "target", "budget"];
    TableBlock::new("budget", "Budget", caption, &header, measurement.judged.iter().map(row).collect())
}
