//! Clock tree: 170 MHz for all buses.
//!
//! ```text
//! crystal     24 MHz / 6 = 4 MHz --+
//!                                  +-- * 85 = 340 MHz, / 2 = 170 MHz = SYSCLK = HCLK = PCLK1 = PCLK2
//! HSI16       16 MHz / 4 = 4 MHz --+
//! ```
//!
//! The crystal is on the Nucleo board (X3, UM2505). If it does not start, or if it stopped in the
//! last run, the internal oscillator replaces it. That oscillator has an error of up to 1 %
//! (DS12288). The frequencies that the controller reports then have the same error, but their
//! ratios do not.
//!
//! Oscillators, clock security system and PLL: RM0440 7.2; voltage range 1 boost, which 170 MHz
//! needs: RM0440 6.1.5; wait states: RM0440 3.3.3.

use cortex_m::asm::delay;
use firmware::board::hardware::Clock;
use stm32_metapac::flash::vals::Latency;
use stm32_metapac::pwr::vals::Vos;
use stm32_metapac::rcc::vals::{Hpre, Pllm, Plln, Pllr, Pllsrc, Sw};
use stm32_metapac::{FLASH, PWR, RCC};

/// Clock of the processor, Hz.
pub const SYSTEM_HZ: u32 = 170_000_000;
/// Mask of PWR_CR5.R1MODE (6.4.5), which is 1 after reset.
const R1MODE_MASK: u32 = 1 << 8;
/// Processor cycles per microsecond.
pub const CYCLES_PER_US: u32 = SYSTEM_HZ / 1_000_000;

/// Number of waits of 10 us within which the crystal must start, at the 16 MHz after reset: 20 ms.
/// It usually takes 2 ms (DS12288, HSE oscillator).
const CRYSTAL_WAITS: usize = 2000;

/// Source of the clock.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Source {
    /// The crystal, watched by the clock security system.
    Crystal,
    /// The internal oscillator.
    Internal,
}

impl From<Source> for Clock {
    fn from(source: Source) -> Self {
        match source {
            Source::Crystal => Clock::Crystal,
            Source::Internal => Clock::Internal,
        }
    }
}

/// Starts the crystal and returns `true` if it runs. Its failure then raises the non-maskable
/// interrupt and the break of TIM1.
fn start_crystal() -> bool {
    // RCC_CR.HSEON, HSERDY, CSSON (7.4.1); CSSON needs an oscillator that is ready (7.2.8).
    RCC.cr().modify(|w| w.set_hseon(true));
    let runs = (0..CRYSTAL_WAITS).any(|_| {
        delay(160);
        RCC.cr().read().hserdy()
    });
    RCC.cr().modify(|w| {
        w.set_hseon(runs);
        w.set_csson(runs);
    });
    runs
}

/// Starts the clocks of the processor and of all peripherals in use. Tries the crystal only if
/// `may_try_crystal`. Called once, after reset.
pub fn start(may_try_crystal: bool) -> Source {
    // RCC_CR.HSION, HSIRDY (7.4.1): the oscillator that runs after reset.
    RCC.cr().modify(|w| w.set_hsion(true));
    while !RCC.cr().read().hsirdy() {}
    // RCC_APB1ENR1.PWREN (7.4.17), and the two cycles until PWR can be accessed (7.2.17).
    RCC.apb1enr1().modify(|w| w.set_pwren(true));
    delay(8);
    // PWR_CR1.VOS = 01, range 1 (6.4.1); PWR_CR5.R1MODE = 0, boost (6.4.5); PWR_SR2.VOSF
    // clears when the range is reached (6.4.7).
    PWR.cr1().modify(|w| w.set_vos(Vos::RANGE1));
    // By mask, because the register description used by `stm32-metapac` has the bit at the wrong
    // position.
    PWR.cr5().modify(|w| w.0 &= !R1MODE_MASK);
    while PWR.sr2().read().vosf() {}
    // FLASH_ACR.LATENCY = 4 wait states for up to 170 MHz in boost; prefetch and both caches
    // (3.7.1).
    FLASH.acr().modify(|w| {
        w.set_latency(Latency::WS4);
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
    while FLASH.acr().read().latency() != Latency::WS4 {}
    let source = if may_try_crystal && start_crystal() { Source::Crystal } else { Source::Internal };
    let (input, divider) = match source {
        Source::Crystal => (Pllsrc::HSE, Pllm::DIV6),
        Source::Internal => (Pllsrc::HSI, Pllm::DIV4),
    };
    // RCC_PLLCFGR (7.4.4), written while the PLL is off.
    RCC.pllcfgr().write(|w| {
        w.set_pllsrc(input);
        w.set_pllm(divider);
        w.set_plln(Plln::MUL85);
        w.set_pllr(Pllr::DIV2);
        w.set_pllren(true);
    });
    // RCC_CR.PLLON, PLLRDY (7.4.1).
    RCC.cr().modify(|w| w.set_pllon(true));
    while !RCC.cr().read().pllrdy() {}
    // RCC_CFGR.HPRE, SW, SWS (7.4.3): above 80 MHz the clock must first run at half the frequency
    // for at least a microsecond (6.1.5).
    RCC.cfgr().modify(|w| {
        w.set_hpre(Hpre::DIV2);
        w.set_sw(Sw::PLL1_R);
    });
    while RCC.cfgr().read().sws() != Sw::PLL1_R {}
    delay(2 * CYCLES_PER_US);
    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV1));
    enable_peripherals();
    source
}

/// Enables the clocks of the peripherals in use: RCC_AHB1ENR (7.4.14), AHB2ENR (7.4.15), APB1ENR1
/// (7.4.17), APB1ENR2 (7.4.18), APB2ENR (7.4.19).
fn enable_peripherals() {
    RCC.ahb1enr().modify(|w| {
        w.set_dma1en(true);
        w.set_dma2en(true);
        w.set_dmamux1en(true);
    });
    RCC.ahb2enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpioben(true);
        w.set_gpiocen(true);
        w.set_adc12en(true);
        w.set_adc345en(true);
        w.set_dac1en(true);
        w.set_dac3en(true);
        w.set_dac4en(true);
    });
    RCC.apb1enr1().modify(|w| {
        w.set_tim3en(true);
        w.set_tim4en(true);
        w.set_tim5en(true);
    });
    RCC.apb1enr2().modify(|w| w.set_lpuart1en(true));
    // The comparators and op-amps use the clock of SYSCFG.
    RCC.apb2enr().modify(|w| {
        w.set_syscfgen(true);
        w.set_tim1en(true);
    });
    // RM0440 7.2.17: a newly enabled peripheral can be written after two cycles.
    delay(8);
}
