//! The board as a target of GDB: registers, memories, breakpoints and execution.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use cortex_m4::Region;
use gdbstub::common::Signal;
use gdbstub::outputln;
use gdbstub::target::ext::base::BaseOps;
use gdbstub::target::ext::base::singlethread::{
    SingleThreadBase, SingleThreadResume, SingleThreadResumeOps, SingleThreadSingleStep, SingleThreadSingleStepOps,
};
use gdbstub::target::ext::breakpoints::{
    Breakpoints, BreakpointsOps, HwBreakpoint, HwBreakpointOps, SwBreakpoint, SwBreakpointOps,
};
use gdbstub::target::ext::monitor_cmd::{ConsoleOutput, MonitorCmd, MonitorCmdOps};
use gdbstub::target::{self, TargetError, TargetResult};

use super::registers::{CortexM4F, Registers};
use crate::board::{Board, BoardError};

/// Addresses of the private peripheral bus (DDI 0403, B3.1).
const PROCESSOR: RangeInclusive<u32> = 0xE000_0000..=0xE00F_FFFF;

/// GDB command to a halted processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Resume {
    Continue,
    Step,
}

/// Board with its breakpoints.
pub(super) struct Target {
    pub(super) board: Board,
    breakpoints: BTreeSet<u32>,
    /// Command that is not executed yet.
    pub(super) resume: Option<Resume>,
    /// Address of the last halt; a breakpoint there does not halt again.
    halted_at: u32,
    /// `true` if a halt stops all time.
    frozen: bool,
}

impl Target {
    pub(super) fn new(board: Board) -> Self {
        Target { board, breakpoints: BTreeSet::new(), resume: None, halted_at: 0, frozen: false }
    }

    /// Halts the processor.
    pub(super) fn halt(&mut self) -> Result<(), BoardError> {
        self.halted_at = self.board.machine().register(15);
        if self.frozen {
            return Ok(());
        }
        self.board.hold(true)?;
        self.board.settle()
    }

    /// Resumes the processor, past a breakpoint or a breakpoint instruction at its address.
    pub(super) fn go(&mut self) -> Result<(), BoardError> {
        self.board.hold(false)?;
        let pc = self.board.machine().register(15);
        if pc != self.halted_at {
            return Ok(());
        }
        if self.breakpoints.contains(&pc) {
            return self.board.step();
        }
        self.board.machine_mut().skip_breakpoint();
        Ok(())
    }

    /// Runs one instruction and halts again; no time passes between steps.
    pub(super) fn step(&mut self) -> Result<(), BoardError> {
        self.board.hold(false)?;
        self.board.step()?;
        self.halted_at = self.board.machine().register(15);
        if self.frozen { Ok(()) } else { self.board.hold(true) }
    }

    /// Runs for a block, or to a breakpoint. Returns `true` at a breakpoint.
    pub(super) fn run_block(&mut self) -> Result<bool, BoardError> {
        if self.breakpoints.is_empty() {
            return self.board.run_block().map(|()| false);
        }
        self.board.run_block_to(&self.breakpoints)
    }

    /// Removes all breakpoints and halts after GDB has left.
    pub(super) fn detach(&mut self) {
        self.breakpoints.clear();
        self.resume = None;
        self.frozen = false;
        self.board.machine_mut().attach_debugger(false);
    }

    /// Reads registers of the processor as bytes from `start`. Returns the number of modelled
    /// bytes.
    fn read_processor(&mut self, start: u32, data: &mut [u8]) -> usize {
        let mut count = 0;
        for (address, byte) in (start..).zip(data) {
            let Some(word) = self.board.machine_mut().processor_register(address & !3) else { break };
            *byte = (word >> (8 * (address & 3))) as u8;
            count += 1;
        }
        count
    }
}

impl target::Target for Target {
    type Arch = CortexM4F;
    type Error = BoardError;

    fn base_ops(&mut self) -> BaseOps<'_, CortexM4F, BoardError> {
        BaseOps::SingleThread(self)
    }

    fn guard_rail_implicit_sw_breakpoints(&self) -> bool {
        true
    }

    fn support_breakpoints(&mut self) -> Option<BreakpointsOps<'_, Self>> {
        Some(self)
    }

    fn support_monitor_cmd(&mut self) -> Option<MonitorCmdOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadBase for Target {
    fn read_registers(&mut self, registers: &mut Registers) -> TargetResult<(), Self> {
        *registers = Registers::read(self.board.machine());
        Ok(())
    }

    fn write_registers(&mut self, registers: &Registers) -> TargetResult<(), Self> {
        registers.write(self.board.machine_mut());
        Ok(())
    }

    /// Reads memories and the processor's own registers. Peripherals are excluded, because a load
    /// can change them.
    fn read_addrs(&mut self, start: u32, data: &mut [u8]) -> TargetResult<usize, Self> {
        if PROCESSOR.contains(&start) {
            let count = self.read_processor(start, data);
            return if count > 0 { Ok(count) } else { Err(TargetError::NonFatal) };
        }
        let bytes = self.board.machine().memory.regions().find_map(|region| {
            let from = start.checked_sub(region.base)? as usize;
            region.bytes.get(from..).filter(|bytes| !bytes.is_empty())
        });
        let bytes = bytes.ok_or(TargetError::NonFatal)?;
        let count = bytes.len().min(data.len());
        data[..count].copy_from_slice(&bytes[..count]);
        Ok(count)
    }

    /// Writes to RAM only: the flash keeps the image.
    fn write_addrs(&mut self, start: u32, data: &[u8]) -> TargetResult<(), Self> {
        let memory = &mut self.board.machine_mut().memory;
        let holds = |region: &Region| start.checked_sub(region.base).is_some_and(|from| (from as usize) < region.bytes.len());
        if !memory.regions().any(|region| region.writable && holds(region)) {
            return Err(TargetError::NonFatal);
        }
        memory.get_mut(start, data.len()).ok_or(TargetError::NonFatal)?.copy_from_slice(data);
        Ok(())
    }

    fn support_resume(&mut self) -> Option<SingleThreadResumeOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadResume for Target {
    fn resume(&mut self, _signal: Option<Signal>) -> Result<(), BoardError> {
        self.resume = Some(Resume::Continue);
        Ok(())
    }

    fn support_single_step(&mut self) -> Option<SingleThreadSingleStepOps<'_, Self>> {
        Some(self)
    }
}

impl SingleThreadSingleStep for Target {
    fn step(&mut self, _signal: Option<Signal>) -> Result<(), BoardError> {
        self.resume = Some(Resume::Step);
        Ok(())
    }
}

impl Breakpoints for Target {
    fn support_sw_breakpoint(&mut self) -> Option<SwBreakpointOps<'_, Self>> {
        Some(self)
    }

    fn support_hw_breakpoint(&mut self) -> Option<HwBreakpointOps<'_, Self>> {
        Some(self)
    }
}

impl SwBreakpoint for Target {
    fn add_sw_breakpoint(&mut self, address: u32, _bytes: usize) -> TargetResult<bool, Self> {
        self.breakpoints.insert(address & !1);
        Ok(true)
    }

    fn remove_sw_breakpoint(&mut self, address: u32, _bytes: usize) -> TargetResult<bool, Self> {
        Ok(self.breakpoints.remove(&(address & !1)))
    }
}

/// Hardware breakpoints work as software breakpoints: addresses that the run checks, in any number.
impl HwBreakpoint for Target {
    fn add_hw_breakpoint(&mut self, address: u32, bytes: usize) -> TargetResult<bool, Self> {
        self.add_sw_breakpoint(address, bytes)
    }

    fn remove_hw_breakpoint(&mut self, address: u32, bytes: usize) -> TargetResult<bool, Self> {
        self.remove_sw_breakpoint(address, bytes)
    }
}

impl MonitorCmd for Target {
    fn handle_monitor_cmd(&mut self, command: &[u8], mut out: ConsoleOutput<'_>) -> Result<(), BoardError> {
        let words: Vec<&[u8]> = command.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
        match words.as_slice() {
            // `reset halt` and `reset init` are commands of OpenOCD.
            [b"reset"] | [b"reset", b"halt" | b"init"] => {
                self.board.machine_mut().reset();
                outputln!(
                    out,
                    "the chip is reset and halted at its first instruction; `maintenance flush register-cache` shows it"
                );
            }
            // Also of OpenOCD; only a halted processor receives commands here.
            [b"halt"] => outputln!(out, "the processor is halted"),
            [b"freeze", how @ (b"on" | b"off")] => {
                self.frozen = *how == b"on";
                let what = if self.frozen { "stops all time" } else { "lets the chip and the plant continue for 200 us" };
                outputln!(out, "a halt {what}");
            }
            _ => outputln!(out, "unknown command; use monitor reset, monitor freeze on or monitor freeze off"),
        }
        Ok(())
    }
}
