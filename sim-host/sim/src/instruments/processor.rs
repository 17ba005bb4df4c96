//! Instructions and memory of a processor that runs the controller in an emulator.

use super::{Instrument, View};
use crate::metrics::Metrics;
use crate::numbers::number;
use crate::processor::InFunction;
use crate::record::Taken;
use report::TableBlock;

/// Instrument of runs in an emulator.
pub(super) struct ProcessorLoad;

/// Rows of the table: label, metric.
const ROWS: [(&str, &str); 14] = [
    ("instructions, all blocks", "instructions_total"),
    ("instructions per block, mean", "mean_block_instructions"),
    ("instructions of the worst block", "worst_block_instructions"),
    ("cycles per block, mean", "mean_block_cycles"),
    ("cycles of the worst block", "worst_block_cycles"),
    ("load per block, mean [%]", "mean_block_load_percent"),
    ("load of the worst block [%]", "worst_block_load_percent"),
    ("remaining for the background task [%]", "background_share_percent"),
    ("instruction fetches from flash [%]", "flash_fetches_percent"),
    ("longest time with interrupts masked [cycles]", "longest_masked_cycles"),
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
        let load = run.record.load.as_ref();
        let part = |of: f64| load.map(|load| 100.0 * of / f64::from(load.block_cycles));
        let mean_percent = metrics.get("mean_block_cycles").and_then(part);
        metrics.put("mean_block_load_percent", mean_percent);
        metrics.put("worst_block_load_percent", metrics.get("worst_block_cycles").and_then(part));
        metrics.put("background_share_percent", mean_percent.map(|percent| (100.0 - percent).max(0.0)));
        metrics.put("flash_fetches_percent", load.map(|load| 100.0 * load.flash_fetches));
        metrics.put("longest_masked_cycles", load.map(|load| f64::from(load.longest_masked)));
        let memory = run.record.memory;
        metrics.put("stack_power_up_bytes", memory.map(|memory| f64::from(memory.stack_power_up)));
        metrics.put("stack_blocks_bytes", memory.map(|memory| f64::from(memory.stack_blocks)));
        metrics.put("image_flash_bytes", memory.map(|memory| memory.flash as f64));
        metrics.put("image_ram_bytes", memory.map(|memory| memory.ram as f64));
    }

    fn tables(&self, run: &View, metrics: &Metrics) -> Vec<TableBlock> {
        let whole = |value: f64| if value >= 1e7 { number(value) } else { format!("{value:.0}") };
        let row = |(label, metric): (&str, &str)| Some(vec![label.to_owned(), whole(metrics.get(metric)?)]);
        let caption = if metrics.get("worst_block_cycles").is_some() {
            "Block interrupt of the flashed image, with its entry and return. Cycles are the maximum by the processor's manual, \
             including bus accesses by DMA, at the part's own speed, independent of the interrupt's duration in this run. A \
             sample of 1 us has 170 cycles at 170 MHz."
        } else {
            "Instructions, counted in an emulator to within 6 per block; cycles are not counted. The image is built for speed \
             and for any scene; the image of a board is smaller."
        };
        let taken =
            TableBlock::new("processor", "Processor", caption, &["", "value"], ROWS.into_iter().filter_map(row).collect());
        let functions = run.record.load.as_ref().map_or(&[][..], |load| &load.functions);
        [taken].into_iter().chain((!functions.is_empty()).then(|| profile(functions, run.record.cycles))).collect()
    }
}

/// Maximum number of rows of a profile.
const MAX_FUNCTIONS: usize = 25;

/// Returns the functions that take most of the longest block interrupt.
fn profile(functions: &[InFunction], blocks: Option<Taken>) -> TableBlock {
    let blocks = blocks.map_or(1.0, |taken| taken.blocks as f64);
    let row = |function: &InFunction| {
        let a_block = |count: u64| format!("{:.1}", count as f64 / blocks);
        let InFunction { name, instructions, cycles, flash_fetches, longest_instructions, longest_cycles } = function;
        let longest = [longest_cycles, longest_instructions].map(ToString::to_string);
        [name.clone()].into_iter().chain(longest).chain([*cycles, *instructions, *flash_fetches].map(a_block)).collect()
    };
    let caption = format!(
        "In the block with the most cycles, and the mean per block, without entry and return. The {} functions with the most \
         cycles in the longest block, of {}; an inlined function counts as part of its caller.",
        MAX_FUNCTIONS.min(functions.len()),
        functions.len()
    );
    let header = ["function", "longest block, cycles", "instructions", "mean, cycles", "instructions", "fetches from flash"];
    TableBlock::new(
        "profile",
        "Block interrupt by function",
        caption,
        &header,
        functions.iter().take(MAX_FUNCTIONS).map(row).collect(),
    )
}
