//! The same image on QEMU and on the interpreter: identical codes and telemetry, bit for bit, and
//! the same number of instructions.
//!
//! `cargo run --release -p sonoglide-board --example compare -- lock burst` compares any scenes.

use board::interpreter::Interpreter;
use firmware::seam::block::{DriveBlock, Orders, SenseBlock};
use firmware::seam::telemetry::Telemetry;
use pil::Qemu;
use scene::settings;
use sim::processor::{Lost, Processor};
use sim::run::{Watch, run_on};

use super::{bits, image, scene};

/// Tick of the timer with which the image counts, instructions: 125/21, rounded up.
const TICK_INSTRUCTIONS: u32 = 6;

/// QEMU and the interpreter, called one after the other.
struct Both {
    qemu: Qemu,
    interpreter: Interpreter,
    blocks: u32,
}

impl Processor for Both {
    fn silence(&self) -> DriveBlock {
        assert_eq!(self.qemu.silence(), self.interpreter.silence());
        self.qemu.silence()
    }

    fn process(&mut self, orders: &Orders, sense: &SenseBlock, drive: &mut DriveBlock) -> Result<Telemetry, Lost> {
        let mut also = DriveBlock::default();
        let there = self.qemu.process(orders, sense, drive)?;
        let here = self.interpreter.process(orders, sense, &mut also)?;
        assert_eq!((&*drive, bits(&there)), (&also, bits(&here)), "block {}", self.blocks);
        let counted = [self.qemu.instructions(), self.interpreter.instructions()].map(|count| count.expect("the image counts"));
        assert!(counted[0].abs_diff(counted[1]) <= TICK_INSTRUCTIONS, "block {}: {counted:?} instructions", self.blocks);
        self.blocks += 1;
        Ok(there)
    }
}

#[test]
fn a_scene_is_the_same_on_qemu_and_interpreter() {
    let Some(image) = image() else { return };
    let scene = scene("lock");
    let scene = scene.driven().expect("a driven scene");
    let config = settings::config(&scene);
    let qemu = Qemu::start(&image, &config).expect("QEMU starts");
    let interpreter = Interpreter::start(&image, &config).expect("the interpreter starts");
    let mut both = Both { qemu, interpreter, blocks: 0 };
    run_on(&mut both, &scene, Watch::default()).expect("a run on both");
    assert_eq!(both.blocks, 9375);
    let stacks = [both.qemu.memory(), both.interpreter.memory()].map(|memory| memory.expect("an answer"));
    assert_eq!(stacks[0], stacks[1], "stack, flash and static variables");
}
