//! What the controller has taken of the processor that it ran on, where that is not this one.
//!
//! | metric | is |
//! |---|---|
//! | `instructions_total` | of all calls of `process`, each to within a tick of the emulated timer (6) |
//! | `mean_block_instructions`, `worst_block_instructions` | of one call |
//! | `stack_power_up_bytes` | the deepest that the image's stack was until the controller was built |
//! | `stack_blocks_bytes` | the deepest that it was in the blocks, with all of the image that stands above `process` |
//! | `image_flash_bytes`, `image_ram_bytes` | of the image: code, constants and what static variables begin with; static variables |

use crate::metrics::Metrics;
use crate::record::Record;

pub(super) fn add(record: &Record, metrics: &mut Metrics) {
    let instructions = record.instructions;
    metrics.put("instructions_total", instructions.map(|counted| counted.total as f64));
    metrics.put("mean_block_instructions", instructions.map(|counted| counted.total as f64 / counted.blocks as f64));
    metrics.put("worst_block_instructions", instructions.map(|counted| f64::from(counted.worst)));
    let memory = record.memory;
    metrics.put("stack_power_up_bytes", memory.map(|memory| f64::from(memory.stack_power_up)));
    metrics.put("stack_blocks_bytes", memory.map(|memory| f64::from(memory.stack_blocks)));
    metrics.put("image_flash_bytes", memory.map(|memory| memory.flash as f64));
    metrics.put("image_ram_bytes", memory.map(|memory| memory.ram as f64));
}
