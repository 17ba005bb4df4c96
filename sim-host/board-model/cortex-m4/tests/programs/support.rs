//! Chip with memory, wait states and one interrupt line, for programs as machine code.

use sonoglide_cortex_m4::{Access, Breakpoint, Chip, Cycle, Fault, Machine, Memory, Ports, Region};

/// Address of the code.
pub const CODE: u32 = 0x0800_0000;
/// Address of the RAM.
pub const RAM: u32 = 0x2000_0000;
/// Address of the first register of the chip.
pub const PART: u32 = 0x4000_0000;

/// Chip with settings of a test and records for its assertions.
#[derive(Clone, Debug)]
pub struct Part {
    /// Cycle at which line 0 rises.
    pub rises: Cycle,
    /// Cycle at which line 0 falls.
    pub falls: Cycle,
    /// Wait states of a fetch and of a load.
    pub waits: (u32, u32),
    /// Wait states of a register access.
    pub register_wait: u32,
    /// Delay by other bus masters, cycles.
    pub held_up: u32,
    pub lockups: u32,
    pub resets: u32,
    pub damaged: Vec<u32>,
    /// Stores to the chip's registers: address, value, cycle.
    pub stores: Vec<(u32, u32, Cycle)>,
    /// Answer to a breakpoint, if any.
    pub answer: Option<u32>,
}

impl Default for Part {
    fn default() -> Part {
        Part {
            rises: Cycle::MAX,
            falls: Cycle::MAX,
            waits: (0, 0),
            register_wait: 0,
            held_up: 0,
            lockups: 0,
            resets: 0,
            damaged: Vec::new(),
            stores: Vec::new(),
            answer: None,
        }
    }
}

impl Chip for Part {
    fn read(&mut self, access: Access, _: Ports) -> Result<u32, Fault> {
        if access.address >> 28 == 4 { Ok(access.address & 0xFF) } else { Err(Fault::Bus) }
    }

    fn write(&mut self, access: Access, value: u32, ports: Ports) -> Result<(), Fault> {
        if access.address >> 28 != 4 {
            return Err(Fault::Bus);
        }
        self.stores.push((access.address, value, access.at));
        // The first register acknowledges the line, the second ends the run.
        match access.address - PART {
            0 => ports.interrupts.set(0, false),
            4 => return Err(Fault::Stop("end".into())),
            _ => {}
        }
        Ok(())
    }

    fn due(&self) -> Cycle {
        self.rises.min(self.falls)
    }

    fn advance(&mut self, now: Cycle, ports: Ports) -> Result<(), Fault> {
        for (due, level) in [(&mut self.rises, true), (&mut self.falls, false)] {
            if *due <= now {
                *due = Cycle::MAX;
                ports.interrupts.set(0, level);
            }
        }
        Ok(())
    }

    fn fetch_wait(&mut self, _: u32, _: Cycle) -> u32 {
        self.waits.0
    }

    fn load_wait(&mut self, _: u32, _: Cycle) -> u32 {
        self.waits.1
    }

    fn access_wait(&mut self, _: u32) -> u32 {
        self.register_wait
    }

    fn held_up(&mut self) -> u32 {
        std::mem::take(&mut self.held_up)
    }

    fn damaged(&mut self, address: u32, ports: Ports) -> Result<(), Fault> {
        self.damaged.push(address);
        ports.interrupts.pend_nmi();
        Ok(())
    }

    fn lockup(&mut self, _: Cycle, _: Ports) -> Result<(), Fault> {
        self.lockups += 1;
        Ok(())
    }

    fn breakpoint(&mut self, _: Breakpoint, _: Ports) -> Result<Option<u32>, Fault> {
        Ok(self.answer)
    }

    fn reset(&mut self, _: Cycle, _: Ports) {
        self.resets += 1;
    }
}

/// Returns the address of a handler in the vector table of [`machine`].
pub const fn handler(exception: u32) -> u32 {
    CODE + 0x200 + 0x40 * exception
}

/// Returns a machine with 64 KiB each of code and RAM and its stack at the end of the RAM.
/// `program` is at the entry, and the handlers are at their addresses.
pub fn machine(program: &[u16], handlers: &[(u32, &[u16])]) -> Machine<Part> {
    let mut code = vec![0; 0x1_0000];
    let mut put = |at: u32, halves: &[u16]| {
        for (place, half) in code[at as usize..].chunks_exact_mut(2).zip(halves) {
            place.copy_from_slice(&half.to_le_bytes());
        }
    };
    let words: Vec<u32> = (2..48).map(|number| handler(number) | 1).collect();
    let vectors: Vec<u32> = [vec![RAM + 0x1_0000, CODE + 0x1001], words].concat();
    put(0, &vectors.iter().flat_map(|word| [*word as u16, (*word >> 16) as u16]).collect::<Vec<_>>());
    put(0x1000, program);
    for (exception, halves) in handlers {
        put(handler(*exception) - CODE, halves);
    }
    let mut memory = Memory::default();
    memory.add(Region { base: CODE, bytes: code, writable: false, waits: true });
    memory.add(Region { base: RAM, bytes: vec![0; 0x1_0000], writable: true, waits: false });
    Machine::from_memory(memory, Part::default(), CODE, 4)
}

/// Returns `MOVW`, `MOVT` that load a constant to R0 to R7.
pub fn constant(register: u16, value: u32) -> Vec<u16> {
    let half = |opcode: u16, value: u16| {
        let (i, high) = (value >> 11 & 1, value >> 12);
        [opcode | i << 10 | high, (value >> 8 & 7) << 12 | register << 8 | value & 0xFF]
    };
    [half(0xF240, value as u16), half(0xF2C0, (value >> 16) as u16)].concat()
}

/// Returns code that stores a constant at an address, through R0 and R1.
pub fn store(address: u32, value: u32) -> Vec<u16> {
    [constant(0, address), constant(1, value), vec![0x6001]].concat()
}
