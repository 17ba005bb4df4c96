//! The processor that ran the controller, where it is not this one: instructions and memory.

use super::{Instrument, View};
use crate::metrics::Metrics;
use crate::numbers::number;
use report::TableBlock;

/// The instrument of runs in an emulator.
pub(super) struct ProcessorLoad;

/// What is shown: label, metric.
const ROWS: [(&str, &str); 9] = [
    ("instructions, all blocks", "instructions_total"),
    ("instructions a block, mean", "mean_block_instructions"),
    ("instructions of the worst block", "worst_block_instructions"),
    ("cycles a block, mean", "mean_block_cycles"),
    ("cycles of the worst block", "worst_block_cycles"),
    ("stack, power-up [bytes]", "stack_power_up_bytes"),
    ("stack, blocks [bytes]", "stack_blocks_bytes"),
    ("flash of the image [bytes]", "image_flash_bytes"),
    ("static RAM of the image [bytes]", "image_ram_bytes"),
];

impl Instrument for ProcessorLoad {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        let instructions = run.record.instructions;
        metrics.put("instructions_total", instructions.map(|counted| counted.total as f64));
        metrics.put("mean_block_instructions", instructions.map(|counted| counted.total as f64 / counted.blocks as f64));
        metrics.put("worst_block_instructions", instructions.map(|counted| f64::from(counted.worst)));
        let cycles = run.record.cycles;
        metrics.put("mean_block_cycles", cycles.map(|counted| counted.total as f64 / counted.blocks as f64));
        metrics.put("worst_block_cycles", cycles.map(|counted| f64::from(counted.worst)));
        let memory = run.record.memory;
        metrics.put("stack_power_up_bytes", memory.map(|memory| f64::from(memory.stack_power_up)));
        metrics.put("stack_blocks_bytes", memory.map(|memory| f64::from(memory.stack_blocks)));
        metrics.put("image_flash_bytes", memory.map(|memory| memory.flash as f64));
        metrics.put("image_ram_bytes", memory.map(|memory| memory.ram as f64));
    }

    fn tables(&self, _: &View, metrics: &Metrics) -> Vec<TableBlock> {
        let whole = |value: f64| if value >= 1e7 { number(value) } else { format!("{value:.0}") };
        let row = |(label, metric): (&str, &str)| Some(vec![label.to_owned(), whole(metrics.get(metric)?)]);
        let caption = if metrics.get("worst_block_cycles").is_some() {
            "Of the block interrupt in the image that is flashed, with its entry and return. Cycles are the most that the processor's manual allows, \
             with what DMA can take of the buses; a block of 32 samples has 5440 of them at 170 MHz."
        } else {
            "Counted in an emulator: instructions, each block's to within 6, and not cycles. The image is built for speed and for any \
             scene; a board's is smaller."
        };
        vec![TableBlock::new("processor", "Processor", caption, &["", "taken"], ROWS.into_iter().filter_map(row).collect())]
    }
}
