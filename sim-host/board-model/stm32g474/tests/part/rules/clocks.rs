//! Rules of clocks, and of accesses in general.

use cortex_m4::{Fault, Width};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Bare, Rule, Verdict};

use super::{check, up};
use crate::rig::{Rig, Setup};

#[test]
fn unclocked() {
    check(
        Rule::Unclocked,
        |rig| {
            rig.write(RCC + at::rcc::AHB2ENR, 1);
            rig.wait(4);
            rig.write(GPIOA + at::gpio::ODR, 1);
        },
        |rig| rig.write(GPIOA + at::gpio::ODR, 1),
    );
}

#[test]
fn clock_settle() {
    check(
        Rule::ClockSettle,
        |rig| {
            rig.write(RCC + at::rcc::AHB2ENR, 1);
            rig.write(GPIOA + at::gpio::ODR, 1);
        },
        |rig| {
            rig.write(RCC + at::rcc::AHB2ENR, 1);
            rig.now -= 1;
            rig.write(GPIOA + at::gpio::ODR, 1);
        },
    );
}

#[test]
fn reserved() {
    check(
        Rule::Reserved,
        |rig| {
            up(rig);
            rig.write(TIM3 + at::timgp16::PSC, 0xffff);
        },
        |rig| {
            up(rig);
            rig.write(TIM3 + at::timgp16::PSC, 0x1_0000);
        },
    );
}

#[test]
fn read_only() {
    check(
        Rule::ReadOnly,
        |rig| {
            up(rig);
            rig.read(GPIOA + at::gpio::IDR);
        },
        |rig| {
            up(rig);
            rig.write(GPIOA + at::gpio::IDR, 1);
        },
    );
}

#[test]
fn width() {
    check(
        Rule::Width,
        |rig| {
            up(rig);
            rig.try_write(GPIOA + at::gpio::ODR, 1, Width::Half).unwrap();
            rig.write(DAC1 + at::dac::DHR12R_0, 100);
        },
        |rig| {
            up(rig);
            rig.try_write(DAC1 + at::dac::DHR12R_0, 100, Width::Half).unwrap();
        },
    );
}

#[test]
fn wait_states() {
    check(Rule::WaitStates, up, |rig| rig.clocks(Setup { latency: 3, ..Setup::default() }));
}

#[test]
fn wait_states_are_reduced_after_the_clock() {
    check(
        Rule::WaitStates,
        |rig| {
            up(rig);
            rig.write(RCC + at::rcc::CFGR, 1);
            rig.write(FLASH + at::flash::ACR, 0x0004_0700);
        },
        |rig| {
            up(rig);
            rig.write(FLASH + at::flash::ACR, 0x0004_0703);
        },
    );
}

#[test]
fn boost() {
    check(Rule::Boost, up, |rig| {
        // Without boost, five wait states are enough, so only the voltage is wrong.
        rig.clocks(Setup { boost: false, latency: 5, ..Setup::default() });
    });
}

#[test]
fn half_frequency() {
    check(Rule::HalfFrequency, up, |rig| rig.clocks(Setup { half_us: None, ..Setup::default() }));
    check(Rule::HalfFrequency, up, |rig| rig.clocks(Setup { half_us: Some(0), ..Setup::default() }));
}

#[test]
fn pll_running() {
    check(
        Rule::PllRunning,
        |rig| {
            up(rig);
            // The enable of an output may change.
            rig.write(RCC + at::rcc::PLLCFGR, 2 | 3 << 4 | 85 << 8 | 1 << 24 | 1 << 16);
        },
        |rig| {
            up(rig);
            rig.write(RCC + at::rcc::PLLCFGR, 2 | 3 << 4 | 84 << 8 | 1 << 24);
        },
    );
}

#[test]
fn pll_range() {
    check(
        Rule::PllRange,
        |rig| {
            rig.write(RCC + at::rcc::PLLCFGR, 2 | 3 << 4 | 85 << 8 | 1 << 24);
            rig.set(RCC + at::rcc::CR, 1 << 24);
        },
        |rig| {
            // 16 MHz / 8 is below 2.66 MHz.
            rig.write(RCC + at::rcc::PLLCFGR, 2 | 7 << 4 | 85 << 8 | 1 << 24);
            rig.set(RCC + at::rcc::CR, 1 << 24);
        },
    );
}

#[test]
fn clock_not_ready() {
    check(
        Rule::ClockNotReady,
        |rig| {
            rig.set(RCC + at::rcc::CR, 1 << 16);
            rig.poll(RCC + at::rcc::CR, 1 << 17, 1 << 17);
            rig.write(FLASH + at::flash::ACR, 0x0004_0601);
            rig.write(RCC + at::rcc::CFGR, 2);
        },
        |rig| {
            rig.set(RCC + at::rcc::CR, 1 << 16);
            rig.write(FLASH + at::flash::ACR, 0x0004_0601);
            rig.write(RCC + at::rcc::CFGR, 2);
        },
    );
}

#[test]
fn a_finding_names_fields_manual_and_instruction() {
    let mut rig = Rig::bare();
    rig.part.lint.set(Rule::WaitStates, Verdict::Stop);
    rig.clocks_up_to_switch();
    let Err(Fault::Stop(finding)) = rig.try_write(RCC + at::rcc::CFGR, 2, Width::Word) else { panic!("no finding") };
    let text = finding.to_string();
    for part in ["RCC_CFGR.SW", "RM0440 3.3.3", "0x08000400", "too few wait states"] {
        assert!(text.contains(part), "{text}");
    }
}

impl Rig<Bare> {
    /// Starts the crystal without selecting it, in voltage range 2, where 24 MHz need a wait state.
    fn clocks_up_to_switch(&mut self) {
        self.set(RCC + at::rcc::APB1ENR1, 1 << 28);
        self.wait(4);
        self.write(FLASH + at::flash::ACR, 0x0004_0601);
        self.write(PWR + at::pwr::CR1, 2 << 9);
        self.set(RCC + at::rcc::CR, 1 << 16);
        self.poll(RCC + at::rcc::CR, 1 << 17, 1 << 17);
        self.part.lint.set_all(Verdict::Stop);
        self.part.lint.set(Rule::WaitStates, Verdict::Collect);
        self.write(FLASH + at::flash::ACR, 0x0004_0600);
        self.part.lint.set(Rule::WaitStates, Verdict::Stop);
    }
}
