//! What the controller has taken of the processor that it ran on.

use crate::findings::number;
use crate::study::Study;
use crate::study::driven::{Level, Run};
use report::TableBlock;

/// What is shown: label, metric.
const ROWS: [(&str, &str); 7] = [
    ("instructions, all blocks", "instructions_total"),
    ("instructions a block, mean", "mean_block_instructions"),
    ("instructions of the worst block", "worst_block_instructions"),
    ("stack, power-up [bytes]", "stack_power_up_bytes"),
    ("stack, blocks [bytes]", "stack_blocks_bytes"),
    ("flash of the image [bytes]", "image_flash_bytes"),
    ("static RAM of the image [bytes]", "image_ram_bytes"),
];

/// The table, of a run on a processor of its own.
pub(super) fn table(study: &Study, run: &Run) -> Option<TableBlock> {
    if run.level != Level::Pil {
        return None;
    }
    let whole = |value: f64| if value >= 1e7 { number(value) } else { format!("{value:.0}") };
    let row = |(label, metric): (&str, &str)| Some(vec![label.to_owned(), whole(study.metrics.get(metric)?)]);
    let rows = ROWS.into_iter().filter_map(row).collect();
    Some(TableBlock::new(
        "processor",
        "Processor",
        "Counted in an emulator: instructions, each block's to within 6, and not cycles. The image is built for speed and for any scene; a board's is \
         smaller.",
        &["", "taken"],
        rows,
    ))
}
