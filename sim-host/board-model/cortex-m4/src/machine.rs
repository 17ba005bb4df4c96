//! Processor, memories and chip as one machine, and its run loop.

use std::sync::Arc;

use crate::chip::{Chip, Cycle, Ports};
use crate::cpu::{Cpu, INVALID, Sleep, Trap};
use crate::elf::{self, ImageError, Symbols};
use crate::interrupts::Interrupts;
use crate::memory::Memory;
use crate::op::Decoded;
use crate::profile::Profile;
use crate::timing::Timing;
use crate::watch::Passage;

/// Error that has stopped a run before its end.
#[derive(Debug, thiserror::Error)]
#[error("{finding}, at {pc:#010x} in {function}, cycle {cycle}")]
pub struct Stop {
    /// Address of the current instruction.
    pub pc: u32,
    /// Name of its function, or a note that the code has no symbol.
    pub function: String,
    /// Cycle at which the instruction began.
    pub cycle: Cycle,
    /// Finding of the chip or the processor.
    #[source]
    pub finding: Arc<dyn std::error::Error + Send + Sync>,
}

/// Processor with its memories and the chip around it. A clone continues from the same state.
#[derive(Clone, Debug)]
pub struct Machine<C> {
    pub(crate) cpu: Cpu,
    /// Flash and RAM.
    pub memory: Memory,
    /// Lines from the chip to the processor.
    pub interrupts: Interrupts,
    /// Chip around the processor.
    pub chip: C,
    pub(crate) symbols: Arc<Symbols>,
    /// Address that is mapped to 0 after reset.
    pub(crate) boot: u32,
    /// `true` during an unprivileged load or store.
    pub(crate) as_user: bool,
    pub(crate) profile: Option<Box<Profile>>,
    /// `true` if a debugger is attached.
    pub(crate) debugged: bool,
}

impl<C: Chip> Machine<C> {
    /// Loads an ELF file into the memories and resets the processor. `priority_bits` is the number
    /// of implemented bits of an interrupt priority.
    pub fn new(elf: &[u8], mut memory: Memory, chip: C, priority_bits: u8) -> Result<Machine<C>, ImageError> {
        let (symbols, boot) = elf::load(elf, &mut memory)?;
        Ok(Machine { symbols: Arc::new(symbols), ..Machine::from_memory(memory, chip, boot, priority_bits) })
    }

    /// Creates a machine whose program is already in the memories, with its vector table at `boot`.
    pub fn from_memory(memory: Memory, chip: C, boot: u32, priority_bits: u8) -> Machine<C> {
        let mut machine = Machine {
            cpu: Cpu::new(priority_bits),
            memory,
            interrupts: Interrupts::default(),
            chip,
            symbols: Arc::default(),
            boot,
            as_user: false,
            profile: None,
            debugged: false,
        };
        machine.start();
        machine
    }

    /// Starts from the vector table. The counts of cycles and instructions continue.
    fn start(&mut self) {
        let Cpu { cycle, instructions, mut watch, timing, ref nvic, .. } = self.cpu;
        watch.mask(false, cycle);
        self.cpu = Cpu { cycle, instructions, watch, timing, ..Cpu::new(nvic.priority_bits()) };
        self.cpu.r[14] = u32::MAX;
        let (stack, entry) = (self.vector(0), self.vector(1));
        self.cpu.cost = 0;
        match (stack, entry) {
            (Ok(stack), Ok(entry)) => {
                self.cpu.set(13, stack);
                self.cpu.pc = if entry & 1 == 1 { entry & !1 } else { entry | INVALID };
            }
            _ => self.lock_up(),
        }
    }

    /// Selects the cycles that are counted if the manual gives a range; [`Timing::Longest`] by
    /// default.
    pub fn set_timing(&mut self, timing: Timing) {
        self.cpu.timing = timing;
    }

    /// Sets the core clock of SysTick to `counts` counts in `cycles` cycles; one per cycle by
    /// default.
    pub fn set_systick_clock(&mut self, counts: u32, cycles: u32) {
        self.cpu.systick.set_core_clock(counts, cycles);
    }

    /// Resets the chip and the processor, as the reset line does.
    pub fn reset(&mut self) {
        let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
        self.chip.reset(self.cpu.cycle, ports);
        let _ = (self.interrupts.take_reset(), self.interrupts.take_nmi());
        self.start();
    }

    /// Runs to the first instruction that ends at or after `until`, or to the next passage of the
    /// [watched](Machine::watch) exception.
    pub fn run_until(&mut self, until: Cycle) -> Result<Option<Passage>, Stop> {
        self.cpu.schedule_check();
        let ended = if self.profile.is_some() { self.run::<true>(until) } else { self.run::<false>(until) };
        ended.map_err(|_| self.stop())?;
        Ok(self.cpu.watch.take_passage())
    }

    /// Runs one instruction, or sleeps until the next event, at most until `until`.
    pub fn step(&mut self, until: Cycle) -> Result<(), Stop> {
        self.cpu.schedule_check();
        let stepped = match self.check_events(until) {
            Ok(true) => {
                let before = self.cpu.instructions;
                let mut done = Ok(());
                while done.is_ok() && self.cpu.instructions == before {
                    done = self.instruction::<true>();
                }
                done
            }
            Ok(false) => Ok(()),
            Err(trap) => Err(trap),
        };
        stepped.map_err(|_| self.stop())
    }

    pub(crate) fn stop(&mut self) -> Stop {
        let pc = self.cpu.pc;
        let function =
            self.symbols.function(pc).map_or_else(|| "code without a symbol".to_owned(), |function| function.name.clone());
        let finding = self
            .cpu
            .stop
            .take()
            .unwrap_or_else(|| Box::<dyn std::error::Error + Send + Sync>::from("the run was stopped").into());
        Stop { pc, function, cycle: self.cpu.cycle, finding }
    }

    fn run<const PROFILE: bool>(&mut self, until: Cycle) -> Result<(), Trap> {
        loop {
            if self.cpu.cycle >= self.cpu.deadline && !self.check_events(until)? {
                return Ok(());
            }
            self.instruction::<PROFILE>()?;
        }
    }

    /// Handles events: the chip, the timer, exceptions, sleep. Returns `false` at the end of the
    /// run.
    #[inline(never)]
    pub(crate) fn check_events(&mut self, until: Cycle) -> Result<bool, Trap> {
        loop {
            self.settle()?;
            let now = self.cpu.cycle;
            if now >= until || self.cpu.watch.has_passed() {
                return Ok(false);
            }
            let event = self.chip.due().min(self.cpu.systick.due()).min(until);
            if self.cpu.locked || self.sleeps() {
                self.cpu.cycle = event.max(now);
                continue;
            }
            let priority = self.cpu.execution_priority();
            if let Some(exception) = self.cpu.enters(priority) {
                self.enter(exception);
                continue;
            }
            self.cpu.deadline = event;
            return Ok(true);
        }
    }

    /// Executes due events and reads the interrupt lines.
    pub(crate) fn settle(&mut self) -> Result<(), Trap> {
        let now = self.cpu.cycle;
        if self.cpu.stop.is_some() {
            return Err(Trap::Stop);
        }
        if self.chip.due() <= now {
            let ports = Ports { memory: &mut self.memory, interrupts: &mut self.interrupts };
            self.chip.advance(now, ports).map_err(|fault| self.cpu.trap(fault))?;
        }
        self.hold_up();
        if self.cpu.systick.advance(now) {
            self.cpu.nvic.pend_system(crate::exceptions::SYSTICK);
        }
        if self.interrupts.take_changed() {
            if self.interrupts.take_reset() {
                self.reset();
                return Ok(());
            }
            self.cpu.nvic.update(&mut self.interrupts);
            self.cpu.event |= self.cpu.scb.events_on_pend();
        }
        Ok(())
    }

    /// Returns `true` if the processor stays asleep. An interrupt wakes it even if PRIMASK blocks
    /// it (B1.5.19).
    fn sleeps(&mut self) -> bool {
        let Some(sleep) = self.cpu.asleep else { return false };
        let masked = std::mem::take(&mut self.cpu.primask);
        let wakes = self.cpu.preempting(self.cpu.execution_priority()).is_some();
        self.cpu.primask = masked;
        let wakes = wakes || sleep == Sleep::Event && std::mem::take(&mut self.cpu.event);
        if wakes {
            self.cpu.asleep = None;
        }
        !wakes
    }

    /// Executes one instruction. An instruction that is not decoded yet is only decoded; the next
    /// call executes it.
    #[inline(always)]
    pub(crate) fn instruction<const PROFILE: bool>(&mut self) -> Result<(), Trap> {
        let pc = self.cpu.pc;
        // A single copy from a single place; otherwise the compiler splits and rebuilds the value.
        let (decoded, waits) = match self.cached(pc) {
            Some((decoded, waits)) => (*decoded, waits),
            None => return self.prepare(pc),
        };
        let cpu = &mut self.cpu;
        cpu.cost = u32::from(decoded.cycles);
        cpu.next = pc.wrapping_add(decoded.len.into());
        cpu.r[15] = pc.wrapping_add(4);
        let before = cpu.fetched;
        let last = cpu.next.wrapping_sub(1) & !7;
        if last != before {
            cpu.fetched = last;
            cpu.watch.fetches.all += 1;
            if waits {
                cpu.watch.fetches.waiting += 1;
                self.fetch_wait(pc & !7, before, last);
            }
            if !self.memory.damaged.is_empty() {
                self.report_damage(pc, decoded.len.into())?;
            }
        }
        let cpu = &mut self.cpu;
        if decoded.bases & 15 == cpu.computed || decoded.bases >> 4 == cpu.computed {
            cpu.cost += 1;
        }
        if decoded.len == 4 && pc & 2 != 0 {
            cpu.fetch_unaligned(decoded.bases != Decoded::NO_BASES);
        } else {
            cpu.unaligned = 0;
        }
        cpu.computed = decoded.computes;
        let in_block = cpu.it;
        let done = if in_block != 0 && !cpu.flags.hold(in_block >> 4) {
            cpu.cost = 1;
            Ok(())
        } else {
            self.execute(decoded.op)
        };
        let cpu = &mut self.cpu;
        let cost = cpu.cost;
        cpu.instructions += 1;
        match done {
            Ok(()) => {
                cpu.pc = cpu.next;
                if in_block != 0 {
                    cpu.advance_it();
                }
                cpu.spend();
            }
            Err(Trap::Stop) => return Err(Trap::Stop),
            Err(trap) => {
                cpu.spend();
                self.take(trap)?;
            }
        }
        if PROFILE {
            self.profile_instruction(pc, cost, u32::from(waits && before != self.cpu.fetched));
        }
        if let Some(link) = self.cpu.exception_return.take()
            && let Err(trap) = self.leave(link)
        {
            self.take(trap)?;
        }
        Ok(())
    }
}
