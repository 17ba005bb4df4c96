//! Every rule of the lint: a program that is right, and one that trips just this rule.

mod common;

use common::{ADC_RING, DAC_RING, Rig, Setup};
use cortex_m4::{Fault, Width};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Bare, Defect, Rule, Verdict};

type Program = fn(&mut Rig<Bare>);

/// Runs both programs: the first one has no finding, the second one just this one.
#[track_caller]
fn check(rule: Rule, right: Program, wrong: Program) {
    for (program, expected) in [(right, &[][..]), (wrong, &[rule][..])] {
        let mut rig = Rig::bare();
        rig.part.lint.set(Rule::IwdgMissing, if rule == Rule::IwdgMissing { Verdict::Collect } else { Verdict::Ignore });
        program(&mut rig);
        assert_eq!(rig.rules(), expected, "{:#?}", rig.findings());
    }
}

/// A part that runs at 170 MHz with all that the board uses clocked.
fn up(rig: &mut Rig<Bare>) {
    rig.clocks(Setup::default());
}

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
fn wait_states_come_down_after_the_clock() {
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
        // Five wait states would be needed without boost: with them only the voltage is wrong.
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

/// ADC1 with its clock.
fn adc_clock(rig: &mut Rig<Bare>) {
    up(rig);
    rig.write(ADC12_COMMON + at::adccommon::CCR, 3 << 16);
}

#[test]
fn adc_power() {
    check(
        Rule::AdcPower,
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
        },
        |rig| {
            adc_clock(rig);
            rig.write(ADC1 + at::adc::CR, 3 << 28);
        },
    );
}

#[test]
fn adc_regulator() {
    fn start(rig: &mut Rig<Bare>, us: u64) {
        adc_clock(rig);
        rig.write(ADC1 + at::adc::CR, 0);
        rig.write(ADC1 + at::adc::CR, 1 << 28);
        rig.us(us);
        rig.set(ADC1 + at::adc::CR, 1 << 31);
    }
    check(Rule::AdcRegulator, |rig| start(rig, 20), |rig| start(rig, 19));
}

#[test]
fn adc_calibration() {
    fn enable(rig: &mut Rig<Bare>, calibrates: bool, waits: u64) {
        adc_clock(rig);
        rig.write(ADC1 + at::adc::CR, 0);
        rig.write(ADC1 + at::adc::CR, 1 << 28);
        rig.us(21);
        if calibrates {
            rig.set(ADC1 + at::adc::CR, 1 << 31);
            rig.wait(116 * 4 + 2);
        }
        rig.wait(waits);
        rig.set(ADC1 + at::adc::CR, 1);
    }
    check(Rule::AdcCalibration, |rig| enable(rig, true, 16), |rig| enable(rig, false, 16));
    check(Rule::AdcCalibration, |rig| enable(rig, true, 16), |rig| enable(rig, true, 4));
}

#[test]
fn adc_not_ready() {
    check(
        Rule::AdcNotReady,
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
            rig.write(ADC1 + at::adc::SQR1, 1 << 6);
            rig.set(ADC1 + at::adc::CR, 4);
        },
        |rig| {
            adc_clock(rig);
            rig.wake_adc(ADC1);
            rig.write(ADC1 + at::adc::SQR1, 1 << 6);
            // Disabled again.
            rig.set(ADC1 + at::adc::CR, 2);
            rig.set(ADC1 + at::adc::CR, 4);
        },
    );
}

#[test]
fn adc_started() {
    check(
        Rule::AdcStarted,
        |rig| {
            up(rig);
            rig.streams(Setup::default());
            rig.set(ADC1 + at::adc::CR, 1 << 4);
            rig.write(ADC1 + at::adc::SMPR, 3);
        },
        |rig| {
            up(rig);
            rig.streams(Setup::default());
            rig.write(ADC1 + at::adc::SMPR, 3);
        },
    );
}

#[test]
fn adc_common_enabled() {
    check(Rule::AdcCommonEnabled, adc_clock, |rig| {
        adc_clock(rig);
        rig.wake_adc(ADC2);
        rig.write(ADC12_COMMON + at::adccommon::CCR, 2 << 16);
    });
}

#[test]
fn adc_internal_off() {
    fn measure(rig: &mut Rig<Bare>, on: u32) {
        up(rig);
        rig.write(ADC345_COMMON + at::adccommon::CCR, 3 << 16 | on);
        rig.wake_adc(ADC5);
        rig.write(ADC5 + at::adc::SQR1, 4 << 6);
        rig.set(ADC5 + at::adc::CR, 4);
    }
    check(Rule::AdcInternalOff, |rig| measure(rig, 1 << 23), |rig| measure(rig, 0));
}

fn stream(rig: &mut Rig<Bare>, setup: Setup) {
    rig.clocks(setup);
    rig.streams(setup);
    rig.us(10);
}

#[test]
fn adc_trigger_lost() {
    // 12.5 + 12.5 cycles of 4 are more than the 85 from one trigger to the next.
    check(
        Rule::AdcTriggerLost,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { sampling: 2, ..Setup::default() }),
    );
}

#[test]
fn adc_trigger_margin() {
    // 2.125 + 6.5 + 12.5 cycles of 4 are 84.5 of 85.
    check(
        Rule::AdcTriggerMargin,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { sampling: 1, ..Setup::default() }),
    );
}

#[test]
fn adc_overrun() {
    check(Rule::AdcOverrun, |rig| stream(rig, Setup::default()), |rig| stream(rig, Setup { adc_dma: false, ..Setup::default() }));
}

#[test]
fn dac_enabled() {
    check(
        Rule::DacEnabled,
        |rig| {
            up(rig);
            rig.write(DAC1 + at::dac::MCR, 2 << 14 | 3);
            rig.write(DAC1 + at::dac::CR, 1);
        },
        |rig| {
            up(rig);
            rig.write(DAC1 + at::dac::MCR, 2 << 14);
            rig.write(DAC1 + at::dac::CR, 1);
            rig.write(DAC1 + at::dac::MCR, 2 << 14 | 3);
        },
    );
}

#[test]
fn dac_bus_clock() {
    check(Rule::DacBusClock, |rig| stream(rig, Setup::default()), |rig| stream(rig, Setup { hfsel: 1, ..Setup::default() }));
}

#[test]
fn dac_underrun() {
    check(
        Rule::DacUnderrun,
        |rig| stream(rig, Setup::default()),
        |rig| stream(rig, Setup { dac_dma: false, ..Setup::default() }),
    );
}

#[test]
fn dma_enabled() {
    fn reprogram(rig: &mut Rig<Bare>, off: bool) {
        up(rig);
        rig.dma(0, 5, ADC12_COMMON + at::adccommon::CDR, ADC_RING, 64, 0x3aa1);
        if off {
            rig.write(DMA1 + at::dma::CH_0_CR, 0);
        }
        rig.write(DMA1 + at::dma::CH_0_MAR, DAC_RING);
    }
    check(Rule::DmaEnabled, |rig| reprogram(rig, true), |rig| reprogram(rig, false));
}

#[test]
fn dma_error() {
    fn play(rig: &mut Rig<Bare>, ring: u32) {
        up(rig);
        rig.streams(Setup::default());
        rig.write(DMA1 + at::dma::CH_1_CR, 0);
        rig.dma(1, 6, DAC1 + at::dac::DHR12RD, ring, 64, 0x2ab1);
        rig.us(1);
    }
    check(Rule::DmaError, |rig| play(rig, DAC_RING), |rig| play(rig, 0x3000_0000));
}

#[test]
fn tim_locked() {
    fn breaks(rig: &mut Rig<Bare>, lock: u32) {
        up(rig);
        rig.write(TIM1 + at::timadv::BDTR, lock << 8 | 1 << 12 | 1 << 13);
        rig.write(TIM1 + at::timadv::AF1, 2);
    }
    check(Rule::TimLocked, |rig| breaks(rig, 0), |rig| breaks(rig, 1));
}

#[test]
fn locked() {
    fn comparator(rig: &mut Rig<Bare>, locks: u32) {
        up(rig);
        rig.write(COMP1, 1 | locks << 31);
        rig.write(COMP1, 3 << 16 | 1 | locks << 31);
    }
    check(Rule::Locked, |rig| comparator(rig, 0), |rig| comparator(rig, 1));
    check(
        Rule::Locked,
        |rig| {
            up(rig);
            rig.write(SYSCFG + at::syscfg::CFGR2, 1);
            rig.write(SYSCFG + at::syscfg::CFGR2, 5);
        },
        |rig| {
            up(rig);
            rig.write(SYSCFG + at::syscfg::CFGR2, 1);
            rig.write(SYSCFG + at::syscfg::CFGR2, 4);
        },
    );
}

/// A double word of the second bank.
const WORD: u32 = 0x0807_c000;

/// Unlocks the flash, with its data cache off.
fn open(rig: &mut Rig<Bare>) {
    up(rig);
    rig.write(FLASH + at::flash::ACR, 0x0004_0304);
    rig.write(FLASH + at::flash::KEYR, 0x4567_0123);
    rig.write(FLASH + at::flash::KEYR, 0xcdef_89ab);
}

fn program(rig: &mut Rig<Bare>) {
    rig.write(FLASH + at::flash::CR, 1 | 1 << 30);
    rig.write(WORD, 0x1234_5678);
    rig.write(WORD + 4, 0x9abc_def0);
    rig.poll(FLASH + at::flash::SR, 1 << 16, 0);
    rig.write(FLASH + at::flash::CR, 1 << 30);
}

fn erase(rig: &mut Rig<Bare>) {
    rig.write(FLASH + at::flash::CR, 2 | 120 << 3 | 1 << 11 | 1 << 30);
    rig.set(FLASH + at::flash::CR, 1 << 16);
}

#[test]
fn flash_locked() {
    check(
        Rule::FlashLocked,
        |rig| {
            open(rig);
            program(rig);
        },
        |rig| {
            up(rig);
            rig.write(FLASH + at::flash::CR, 1 | 1 << 30);
        },
    );
}

#[test]
fn a_wrong_key_is_a_bus_error() {
    let mut rig = Rig::bare();
    let fault = rig.try_write(FLASH + at::flash::KEYR, 0x1234, Width::Word);
    assert!(matches!(fault, Err(Fault::Bus)));
    assert_eq!(rig.rules(), [Rule::FlashLocked]);
}

#[test]
fn flash_busy() {
    check(
        Rule::FlashBusy,
        |rig| {
            open(rig);
            erase(rig);
            rig.us(22_100);
            program(rig);
        },
        |rig| {
            open(rig);
            erase(rig);
            rig.us(21_900);
            rig.write(FLASH + at::flash::CR, 1 | 1 << 30);
        },
    );
}

#[test]
fn flash_sequence() {
    check(
        Rule::FlashSequence,
        |rig| {
            open(rig);
            program(rig);
        },
        |rig| {
            open(rig);
            rig.write(WORD, 1);
        },
    );
    check(
        Rule::FlashSequence,
        |_| {},
        |rig| {
            open(rig);
            rig.write(FLASH + at::flash::CR, 1 | 1 << 30);
            rig.write(WORD, 1);
            rig.write(WORD + 8, 1);
        },
    );
}

#[test]
fn flash_not_erased() {
    check(
        Rule::FlashNotErased,
        |rig| {
            open(rig);
            program(rig);
            erase(rig);
            rig.us(22_100);
            program(rig);
        },
        |rig| {
            open(rig);
            program(rig);
            program(rig);
        },
    );
}

#[test]
fn flash_data_cache() {
    check(
        Rule::FlashDataCache,
        |rig| {
            open(rig);
            program(rig);
        },
        |rig| {
            open(rig);
            rig.write(FLASH + at::flash::ACR, 0x0004_0704);
            program(rig);
        },
    );
}

#[test]
fn cache_reset() {
    check(
        Rule::CacheReset,
        |rig| {
            rig.write(FLASH + at::flash::ACR, 0x0004_0200);
            rig.write(FLASH + at::flash::ACR, 0x0004_1200);
        },
        |rig| rig.write(FLASH + at::flash::ACR, 0x0004_1600),
    );
}

#[test]
fn ecc_double() {
    use cortex_m4::{Chip, Ports};
    fn read(rig: &mut Rig<Bare>, bits: u8) {
        rig.part.inject(rig.now + 1, Defect::FlashBits { address: WORD + 2, bits });
        rig.wait(10);
        let ports = Ports { memory: &mut rig.memory, interrupts: &mut rig.interrupts };
        rig.part.damaged(WORD, ports).unwrap();
        // ADDR_ECC, BK_ECC, ECCC or ECCD.
        let expected = 0x3_c000 | 1 << 21 | if bits == 1 { 1 << 30 } else { 1 << 31 };
        assert_eq!(rig.read(FLASH + at::flash::ECCR), expected);
    }
    check(Rule::EccDouble, |rig| read(rig, 1), |rig| read(rig, 2));
}

#[test]
fn iwdg_locked() {
    check(
        Rule::IwdgLocked,
        |rig| {
            rig.write(IWDG + at::iwdg::KR, 0x5555);
            rig.write(IWDG + at::iwdg::RLR, 79);
        },
        |rig| {
            rig.write(IWDG + at::iwdg::KR, 0x5555);
            rig.write(IWDG + at::iwdg::KR, 0xaaaa);
            rig.write(IWDG + at::iwdg::RLR, 79);
        },
    );
}

#[test]
fn iwdg_updating() {
    check(
        Rule::IwdgUpdating,
        |rig| {
            rig.write(IWDG + at::iwdg::KR, 0x5555);
            rig.write(IWDG + at::iwdg::RLR, 79);
            rig.write(IWDG + at::iwdg::PR, 1);
            rig.poll(IWDG + at::iwdg::SR, 7, 0);
            rig.write(IWDG + at::iwdg::RLR, 80);
        },
        |rig| {
            rig.write(IWDG + at::iwdg::KR, 0x5555);
            rig.write(IWDG + at::iwdg::RLR, 79);
            rig.write(IWDG + at::iwdg::RLR, 80);
        },
    );
}

#[test]
fn iwdg_missing() {
    fn blocks(rig: &mut Rig<Bare>, starts: bool) {
        if starts {
            rig.write(IWDG + at::iwdg::KR, 0xcccc);
        }
        stream(rig, Setup::default());
        rig.us(40);
    }
    check(Rule::IwdgMissing, |rig| blocks(rig, true), |rig| blocks(rig, false));
}

#[test]
fn uart_divider() {
    fn start(rig: &mut Rig<Bare>, brr: u32) {
        rig.clocks(Setup::default());
        rig.uart(Setup { brr, ..Setup::default() });
    }
    check(Rule::UartDivider, |rig| start(rig, 47_222), |rig| start(rig, 0x2ff));
}

#[test]
fn uart_enabled() {
    check(
        Rule::UartEnabled,
        |rig| {
            rig.clocks(Setup::default());
            rig.uart(Setup::default());
            rig.clear(LPUART1 + at::lpuart::CR1, 1);
            rig.write(LPUART1 + at::lpuart::BRR, 50_000);
        },
        |rig| {
            rig.clocks(Setup::default());
            rig.uart(Setup::default());
            rig.write(LPUART1 + at::lpuart::BRR, 50_000);
        },
    );
}

#[test]
fn uart_lost() {
    fn send(rig: &mut Rig<Bare>, bytes: u32) {
        rig.clocks(Setup::default());
        rig.uart(Setup::default());
        // One is shifted out, eight wait.
        (0..bytes).for_each(|byte| rig.write(LPUART1 + at::lpuart::TDR, byte));
    }
    check(Rule::UartLost, |rig| send(rig, 9), |rig| send(rig, 10));
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
    /// The crystal runs and is not selected yet, in voltage range 2: 24 MHz need a wait state.
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
