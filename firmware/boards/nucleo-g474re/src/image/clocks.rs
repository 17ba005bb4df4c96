//! The clock tree: 170 MHz for everything.
//!
//! ```text
//! crystal     24 MHz / 6 = 4 MHz --+
//!                                  +-- * 85 = 340 MHz, / 2 = 170 MHz = SYSCLK = HCLK = PCLK1 = PCLK2
//! HSI16       16 MHz / 4 = 4 MHz --+
//! ```
//!
//! The crystal is the Nucleo's own (X3, UM2505). Where it does not start, or has stopped in the last run, the internal oscillator takes its place: it is
//! within 1 % (DS12288), and so is every frequency that the controller names, and no ratio. Oscillators, clock security system and PLL: RM0440 7.2;
//! voltage range 1 boost, which 170 MHz needs: RM0440 6.1.5; wait states: RM0440 3.3.3.

use cortex_m::asm::delay;
use stm32_metapac::flash::vals::Latency;
use stm32_metapac::pwr::vals::Vos;
use stm32_metapac::rcc::vals::{Hpre, Pllm, Plln, Pllr, Pllsrc, Sw};
use stm32_metapac::{FLASH, PWR, RCC};

/// The processor's clock, Hz.
pub const SYSTEM_HZ: u32 = 170_000_000;
/// PWR_CR5.R1MODE (6.4.5), 1 after reset.
const R1MODE: u32 = 1 << 8;
/// Cycles of a microsecond.
pub const CYCLES_PER_US: u32 = SYSTEM_HZ / 1_000_000;

/// Waits of 10 us, at the 16 MHz after reset, in which the crystal must start: 20 ms. 2 ms are usual (DS12288, HSE oscillator).
const CRYSTAL_WAITS: usize = 2000;

/// What the clock is derived from.
#[derive(Clone, Copy, PartialEq, Eq, defmt::Format)]
pub enum Source {
    /// The crystal, watched by the clock security system.
    Crystal,
    /// The internal oscillator.
    Internal,
}

/// Starts the crystal; returns whether it runs. From then on its failure raises the non-maskable interrupt and the break of TIM1.
fn crystal() -> bool {
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

/// Starts the clocks, of the processor and of every peripheral that is used; from the crystal only where it may be tried. Called once, after reset.
pub fn start(may_try_crystal: bool) -> Source {
    // RCC_CR.HSION, HSIRDY (7.4.1): the oscillator that reset has started.
    RCC.cr().modify(|w| w.set_hsion(true));
    while !RCC.cr().read().hsirdy() {}
    // RCC_APB1ENR1.PWREN (7.4.17), and the two cycles until PWR can be accessed (7.2.17).
    RCC.apb1enr1().modify(|w| w.set_pwren(true));
    delay(8);
    // PWR_CR1.VOS = 01, range 1 (6.4.1); PWR_CR5.R1MODE = 0, boost (6.4.5); PWR_SR2.VOSF clears when it is there (6.4.7).
    PWR.cr1().modify(|w| w.set_vos(Vos::RANGE1));
    // By number, as the description that `stm32-metapac` was made from has the bit at the wrong place.
    PWR.cr5().modify(|w| w.0 &= !R1MODE);
    while PWR.sr2().read().vosf() {}
    // FLASH_ACR.LATENCY = 4 wait states for up to 170 MHz in boost; prefetch and both caches (3.7.1).
    FLASH.acr().modify(|w| {
        w.set_latency(Latency::WS4);
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
    while FLASH.acr().read().latency() != Latency::WS4 {}
    let source = if may_try_crystal && crystal() { Source::Crystal } else { Source::Internal };
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
    // RCC_CFGR.HPRE, SW, SWS (7.4.3): over 80 MHz by way of half the frequency, for a microsecond at least (6.1.5).
    RCC.cfgr().modify(|w| {
        w.set_hpre(Hpre::DIV2);
        w.set_sw(Sw::PLL1_R);
    });
    while RCC.cfgr().read().sws() != Sw::PLL1_R {}
    delay(2 * CYCLES_PER_US);
    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV1));
    enable();
    source
}

/// Lets the clock through to what is used: RCC_AHB1ENR (7.4.14), AHB2ENR (7.4.15), APB1ENR1 (7.4.17), APB1ENR2 (7.4.18), APB2ENR (7.4.19).
fn enable() {
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
    // The comparators and op-amps have the clock of SYSCFG.
    RCC.apb2enr().modify(|w| {
        w.set_syscfgen(true);
        w.set_tim1en(true);
    });
    // RM0440 7.2.17: two cycles until a peripheral that has just been enabled can be written.
    delay(8);
}
