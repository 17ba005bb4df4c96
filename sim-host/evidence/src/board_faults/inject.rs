//! Injects a fault, with its random parameters.

use board::Board;
use nucleo_g474re::pages;
use rand_core::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use stm32g474::map::{at::dma, base::DMA1};
use stm32g474::{Defect, Pin};

use super::kinds::Fault;
use super::limits::lsi_hz;
use crate::campaign_error::CampaignError;

/// Sense pin of the voltage.
const VOLTAGE: Pin = Pin::new('A', 0);
/// Sense pins of the current: at the converter, and at the negative trip.
const CURRENT: [Pin; 2] = [Pin::new('A', 1), Pin::new('A', 7)];
/// Address of NVIC_ICER0 in the interrupt controller.
const ICER: u32 = 0xE000_E180;
/// Bit of the block interrupt in NVIC_ICER0 (DMA1 channel 1 is line 11).
const BLOCK_INTERRUPT: u32 = 1 << 11;
/// Address of RAM that the image does not use, below the guard of its stack.
const UNUSED: u32 = 0x2000_7ff0;
/// Two `nop` instructions.
const NOPS: u32 = 0xbf00_bf00;
/// Two `b .` instructions.
const LOOP: u32 = 0xe7fe_e7fe;
/// Address at which the part has no memory.
const NO_MEMORY: u32 = 0x3000_0000;
/// Core clock cycles in a millisecond.
const MS_CYCLES: u64 = 170_000;

/// Random numbers of a run.
pub struct Draw(pub Xoshiro256PlusPlus);

impl Draw {
    /// Draws an integer below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        ((u64::from(self.0.next_u32()) * u64::from(count)) >> 32) as u32
    }

    /// Draws a number from 0 to 1.
    fn fraction(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }
}

/// Injects a fault now, and returns a description of its random parameters.
pub fn inject(board: &mut Board, fault: Fault, draw: &mut Draw) -> Result<String, CampaignError> {
    if corrupts_program(fault) {
        // A program that was corrupted may break any rule; its findings do not count.
        board.machine_mut().chip.lint.set_all(stm32g474::Verdict::Collect);
    }
    let at = board.machine().cycle() + 1;
    let adc = 1 + draw.below(2) as u8;
    let defect = match fault {
        Fault::Part(defect) => defect,
        Fault::StuckAny => Defect::AdcStuck { adc, code: draw.below(4096) as u16 },
        Fault::StuckMiddle => Defect::AdcStuck { adc, code: 2048 },
        Fault::StuckEnd => Defect::AdcStuck { adc, code: draw.pick(&[0, 4095]) },
        Fault::ComparatorActs => Defect::ComparatorStuck { comparator: adc, high: true },
        Fault::ComparatorDead => Defect::ComparatorStuck { comparator: adc, high: false },
        Fault::DacTriggers => Defect::TriggersLost { timer: 3, triggers: 2 + draw.below(4) },
        Fault::AdcTriggers => Defect::TriggersLost { timer: 4, triggers: 2 + draw.below(3) },
        Fault::LinkStream => Defect::DmaHalts { dma: 2, channel: 1 },
        Fault::Pll => {
            draw_lsi(board, at, draw);
            Defect::PllUnlocks
        }
        Fault::SupplyFalls => {
            board.inject(at + MS_CYCLES + u64::from(draw.below(5 * MS_CYCLES as u32)), Defect::SupplyLow(false));
            Defect::SupplyLow(true)
        }
        Fault::CodeTwoBits | Fault::CodeOneBit => {
            let code = symbol(board, "__sidata")? - pages::FLASH;
            let address = pages::FLASH + draw.below(code);
            Defect::FlashBits { address, bits: if fault == Fault::CodeTwoBits { 2 } else { 1 } }
        }
        Fault::SettingsTwoBits => Defect::FlashBits { address: pages::START + draw.below(pages::SIZE), bits: 2 },
        Fault::StaticBit => bit_between(board, ("__sdata", "__ebss"), draw)?,
        Fault::FastCodeBit => bit_between(board, ("__sccmram", "__eccmram"), draw)?,
        Fault::StackBit => {
            let address = board.machine().stack_pointer(false) + draw.below(1024);
            Defect::RamBit { address, bit: draw.below(8) as u8 }
        }
        Fault::Noise => Defect::UartNoise { bytes: 1 + draw.below(40) },
        other => return act(board, other, at, draw),
    };
    board.inject(at, defect);
    Ok(format!("{defect:?}"))
}

/// Returns `true` if a fault corrupts the program, its memory or its registers.
fn corrupts_program(fault: Fault) -> bool {
    use Fault::{CodeTwoBits, FastCodeBit, HardFault, Lockup, RegisterBit, StackBit, StaticBit};
    matches!(fault, CodeTwoBits | FastCodeBit | HardFault | Lockup | RegisterBit | StackBit | StaticBit)
}

/// Injects a fault that is not a defect of the part.
fn act(board: &mut Board, fault: Fault, at: u64, draw: &mut Draw) -> Result<String, CampaignError> {
    match fault {
        Fault::OpenSense => {
            let (pin, volts) = (draw.pick(&[VOLTAGE, CURRENT[0]]), draw.pick(&[0.0, 1.65, 3.3]));
            board.bench_mut().tie(at, pin, volts);
            return Ok(format!("{pin} at {volts} V"));
        }
        Fault::CurrentUp | Fault::CurrentDown => {
            let volts = 0.21 * draw.fraction();
            let volts = if fault == Fault::CurrentUp { 3.3 - volts } else { volts };
            CURRENT.into_iter().for_each(|pin| board.bench_mut().tie(at, pin, volts));
            return Ok(format!("{volts:.3} V"));
        }
        Fault::Stop => board.bench_mut().press_stop(at),
        Fault::Framing => board.bench_mut().bad_stop_bits = 1 + draw.below(40),
        Fault::RegisterBit => {
            let (register, bit) = (draw.below(16) as u8, draw.below(32));
            let machine = board.machine_mut();
            machine.set_register(register, machine.register(register) ^ 1 << bit);
            return Ok(format!("R{register} bit {bit} in exception {}", machine.exception()));
        }
        Fault::HardFault => board.machine_mut().set_register(15, NO_MEMORY + 2 * draw.below(1 << 20)),
        Fault::Lockup => board.machine_mut().set_register(13, NO_MEMORY + 4 * draw.below(1 << 20)),
        Fault::AdcChannelOff | Fault::DacChannelOff => {
            let control = if fault == Fault::AdcChannelOff { dma::CH_0_CR } else { dma::CH_1_CR };
            let value = board.machine().chip.peek(DMA1 + control);
            board.machine_mut().poke(DMA1 + control, value & !1)?;
        }
        Fault::Masked => {
            draw_lsi(board, at, draw);
            board.machine_mut().mask_interrupts();
        }
        Fault::BlockMasked => {
            draw_lsi(board, at, draw);
            board.machine_mut().poke(ICER, BLOCK_INTERRUPT)?;
        }
        Fault::BackgroundLoops => {
            draw_lsi(board, at, draw);
            while board.machine().exception() != 0 {
                board.run_for(std::time::Duration::from_nanos(100))?;
            }
            // The background may be within an IT block, of which at most four instructions remain.
            board.machine_mut().poke(UNUSED, NOPS)?;
            board.machine_mut().poke(UNUSED + 4, NOPS)?;
            board.machine_mut().poke(UNUSED + 8, LOOP)?;
            board.machine_mut().set_register(15, UNUSED);
        }
        Fault::Debugger => {
            let seconds = 0.2e-3 + 19.8e-3 * draw.fraction();
            board.halt_for(std::time::Duration::from_secs_f64(seconds))?;
            return Ok(format!("{:.1} ms", 1e3 * seconds));
        }
        // The others are defects of the part.
        _ => {}
    }
    Ok(String::new())
}

/// Draws the frequency of the watchdog's oscillator from its tolerance.
fn draw_lsi(board: &mut Board, at: u64, draw: &mut Draw) {
    let hz = lsi_hz(2.0 * draw.fraction() - 1.0);
    board.inject(at, Defect::LsiHz(hz));
}

fn symbol(board: &Board, name: &'static str) -> Result<u32, CampaignError> {
    board.machine().symbols().address(name).ok_or(CampaignError::Symbol(name))
}

/// Draws a bit of the memory between two symbols of the linker.
fn bit_between(board: &Board, (first, end): (&'static str, &'static str), draw: &mut Draw) -> Result<Defect, CampaignError> {
    let (first, end) = (symbol(board, first)?, symbol(board, end)?);
    Ok(Defect::RamBit { address: first + draw.below(end - first), bit: draw.below(8) as u8 })
}
