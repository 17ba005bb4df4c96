//! Registers in GDB's order: R0 to R12, SP, LR, PC, xPSR, D0 to D15, FPSCR; each little-endian.

use cortex_m4::{Chip, Machine};
use gdbstub::arch::{self, Arch};

/// Number of core registers: R0 to R15 and xPSR.
const CORE: usize = 17;
/// Number of floating-point registers: S0 to S31, two to a D register.
const FLOAT: usize = 32;

/// Cortex-M4 with its floating-point unit.
pub(super) enum CortexM4F {}

impl Arch for CortexM4F {
    type Usize = u32;
    type Registers = Registers;
    /// Length of the instruction, bytes.
    type BreakpointKind = usize;
    type RegId = ();

    fn target_description_xml() -> Option<&'static str> {
        Some(include_str!("target.xml"))
    }
}

/// All registers that GDB accesses.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Registers {
    core: [u32; CORE],
    float: [u32; FLOAT],
    fpscr: u32,
}

impl Registers {
    pub(super) fn read<C: Chip>(machine: &Machine<C>) -> Registers {
        let core = std::array::from_fn(|n| if n < 16 { machine.register(n as u8) } else { machine.xpsr() });
        Registers { core, float: std::array::from_fn(|n| machine.float_register(n as u8)), fpscr: machine.fpscr() }
    }

    pub(super) fn write<C: Chip>(&self, machine: &mut Machine<C>) {
        let present = Registers::read(machine);
        // An unchanged program counter is not written, so that one outside Thumb state is kept.
        for n in (0..16).filter(|n| self.core[*n] != present.core[*n]) {
            machine.set_register(n as u8, self.core[n]);
        }
        machine.set_xpsr(self.core[16]);
        (0..FLOAT).for_each(|n| machine.set_float_register(n as u8, self.float[n]));
        machine.set_fpscr(self.fpscr);
    }

    fn words(&mut self) -> impl Iterator<Item = &mut u32> {
        self.core.iter_mut().chain(&mut self.float).chain(std::iter::once(&mut self.fpscr))
    }
}

impl arch::Registers for Registers {
    type ProgramCounter = u32;

    fn pc(&self) -> u32 {
        self.core[15]
    }

    fn gdb_serialize(&self, mut write: impl FnMut(Option<u8>)) {
        let words = self.clone().words().map(|word| *word).collect::<Vec<_>>();
        words.iter().flat_map(|word| word.to_le_bytes()).for_each(|byte| write(Some(byte)));
    }

    fn gdb_deserialize(&mut self, bytes: &[u8]) -> Result<(), ()> {
        let (words, rest) = bytes.as_chunks();
        if words.len() != CORE + FLOAT + 1 || !rest.is_empty() {
            return Err(());
        }
        self.words().zip(words).for_each(|(word, bytes)| *word = u32::from_le_bytes(*bytes));
        Ok(())
    }
}
