//! Microcontroller with semihosting: the output of the program is collected, and its exit ends the
//! run.

use cortex_m4::{Access, Breakpoint, Chip, Cycle, Fault, Machine, Ports, Timing, Width};
use sonoglide_stm32g474::map::{at, base};
use sonoglide_stm32g474::{Bare, Config, Stm32g474};

/// Finding that the program has ended.
#[derive(Debug, thiserror::Error)]
#[error("the program has ended")]
struct Ended;

/// Microcontroller with the output of its program.
pub struct Hosted {
    part: Stm32g474<Bare>,
    written: Vec<u8>,
    /// `true` after SYS_EXIT with ADP_Stopped_ApplicationExit.
    succeeded: bool,
}

impl Chip for Hosted {
    fn read(&mut self, access: Access, ports: Ports) -> Result<u32, Fault> {
        self.part.read(access, ports)
    }
    fn write(&mut self, access: Access, value: u32, ports: Ports) -> Result<(), Fault> {
        self.part.write(access, value, ports)
    }
    fn due(&self) -> Cycle {
        self.part.due()
    }
    fn advance(&mut self, now: Cycle, ports: Ports) -> Result<(), Fault> {
        self.part.advance(now, ports)
    }
    fn fetch_wait(&mut self, address: u32, at: Cycle) -> u32 {
        self.part.fetch_wait(address, at)
    }
    fn load_wait(&mut self, address: u32, at: Cycle) -> u32 {
        self.part.load_wait(address, at)
    }
    fn access_wait(&mut self, address: u32) -> u32 {
        self.part.access_wait(address)
    }
    fn held_up(&mut self) -> u32 {
        self.part.held_up()
    }
    fn damaged(&mut self, address: u32, ports: Ports) -> Result<(), Fault> {
        self.part.damaged(address, ports)
    }
    fn lockup(&mut self, at: Cycle, ports: Ports) -> Result<(), Fault> {
        self.part.lockup(at, ports)
    }
    fn reset(&mut self, at: Cycle, ports: Ports) {
        self.part.reset(at, ports);
    }

    /// Serves SYS_WRITEC and SYS_EXIT of ARM's semihosting.
    fn breakpoint(&mut self, breakpoint: Breakpoint, ports: Ports) -> Result<Option<u32>, Fault> {
        match (breakpoint.number, breakpoint.r0) {
            (0xAB, 0x03) => {
                self.written.extend(ports.memory.get(breakpoint.r1, 1).unwrap_or_default());
                Ok(Some(0))
            }
            (0xAB, 0x18) => {
                self.succeeded = breakpoint.r1 == 0x2_0026;
                Err(Fault::Stop(Box::new(Ended)))
            }
            _ => Ok(None),
        }
    }
}

/// Setting of the flash: FLASH_ACR.
#[derive(Clone, Copy)]
pub struct Flash {
    pub name: &'static str,
    pub control: u32,
}

/// Output of a program, and its mean cost from start to end.
pub struct Run {
    pub text: String,
    pub cycles_per_instruction: f64,
}

/// Runs a program to its end.
pub fn run(elf: &[u8], flash: Flash, timing: Timing) -> Result<Run, Box<dyn std::error::Error>> {
    let part = Stm32g474::new(Config::default(), Bare);
    let chip = Hosted { part, written: Vec::new(), succeeded: false };
    let mut machine = Machine::new(elf, Stm32g474::<Bare>::memory(), chip, 4)?;
    machine.set_timing(timing);
    let access = Access { address: base::FLASH + at::flash::ACR, width: Width::Word, at: 0, pc: 0 };
    let ports = Ports { memory: &mut machine.memory, interrupts: &mut machine.interrupts };
    machine.chip.write(access, flash.control, ports).map_err(|fault| format!("FLASH_ACR: {fault:?}"))?;
    // CYCCNT has 32 bits, which limits the run.
    match machine.run_until(u64::from(u32::MAX)) {
        Err(stop) if stop.finding.is::<Ended>() && machine.chip.succeeded => {}
        Err(stop) => return Err(stop.into()),
        Ok(_) => return Err("the program does not end".into()),
    }
    let text = String::from_utf8(std::mem::take(&mut machine.chip.written))?;
    Ok(Run { text, cycles_per_instruction: machine.cycle() as f64 / machine.instructions() as f64 })
}
