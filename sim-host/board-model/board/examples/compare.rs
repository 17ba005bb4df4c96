//! Comparison of the same image on QEMU and on the interpreter: played codes, instructions, stack,
//! and the run time of each.
//!
//! ```text
//! cargo run --release -p sonoglide-board --example compare -- lock burst
//! ```

use std::time::Instant;

use pil::{Qemu, image, missing};
use scene::load::load;
use sim::processor::Processor;
use sim::run::{Watch, run_on};
use sonoglide_board::interpreter::Interpreter;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if let Some(missing) = missing() {
        return Err(missing.into());
    }
    let image = image()?;
    println!("| scene | blocks | hash on QEMU | on the interpreter | instructions on QEMU | on the interpreter | s | s |");
    println!("|---|---|---|---|---|---|---|---|");
    for name in std::env::args().skip(1) {
        let loaded = load(&name, &[])?;
        let scene = loaded.scene.driven().ok_or_else(|| format!("{name} has no [controller]"))?;
        let config = scene::settings::config(&scene);
        let play = |processor: &mut dyn Processor| {
            let begin = Instant::now();
            run_on(processor, &scene, Watch::default()).map(|run| (run, begin.elapsed().as_secs_f64()))
        };
        let (there, slow) = play(&mut Qemu::start(&image, &config)?)?;
        let (here, fast) = play(&mut Interpreter::start(&image, &config)?)?;
        let counts = [&there, &here].map(|run| run.instructions.map_or(0, |counted| counted.total));
        println!(
            "| {name} | {} | `{:016x}` | `{:016x}` | {} | {} | {slow:.1} | {fast:.1} |",
            here.rows.len(),
            there.drive_hash,
            here.drive_hash,
            counts[0],
            counts[1]
        );
    }
    Ok(())
}
