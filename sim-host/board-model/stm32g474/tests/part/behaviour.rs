//! Behaviour of single peripherals.

use cortex_m4::{Chip, Cycle, Fault, Width};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::map::line;
use sonoglide_stm32g474::{Bare, NotModelled, Rule, Verdict};

use crate::board::{Board, board};
use crate::rig::{ADC_RING, Rig, Setup, UART_RING};

#[test]
fn the_watchdog_resets_after_its_time_unless_fed() {
    let mut rig = Rig::on(Board::default());
    rig.write(IWDG + at::iwdg::KR, 0xcccc);
    rig.write(IWDG + at::iwdg::KR, 0x5555);
    rig.write(IWDG + at::iwdg::PR, 0);
    rig.write(IWDG + at::iwdg::RLR, 79);
    rig.poll(IWDG + at::iwdg::SR, 7, 0);
    rig.write(IWDG + at::iwdg::KR, 0xaaaa);
    // 80 ticks of 125 us, 32 kHz / 4.
    let fed = rig.part.seconds(rig.now);
    rig.clocks(Setup::default());
    let due = rig.part.due();
    assert!((rig.part.seconds(due) - fed - 0.01).abs() < 1e-6, "{}", rig.part.seconds(due) - fed);
    rig.us(9_000);
    rig.write(IWDG + at::iwdg::KR, 0xaaaa);
    rig.us(9_000);
    rig.write(RCC + at::rcc::CSR, 1 << 23);
    rig.us(1_100);
    rig.reset();
    assert_eq!(rig.read(RCC + at::rcc::CSR) >> 24 & 0xf8, 0b0010_0000);
    assert_eq!(rig.part.due(), Cycle::MAX);
}

#[test]
fn bytes_are_received_into_the_ring() {
    let mut rig = board();
    rig.uart(Setup::default());
    rig.part.wires.bytes.extend(*b"sonoglide");
    rig.us(60);
    // 10.85 us per byte: five bytes.
    assert_eq!(rig.memory.get(UART_RING, 6).unwrap(), b"sonog\0");
    assert_eq!(rig.read(DMA1 + at::dma::CH_2_NDTR), 512 - 5);
    rig.us(60);
    assert_eq!(rig.memory.get(UART_RING, 9).unwrap(), b"sonoglide");
    assert_eq!(rig.findings(), []);
}

#[test]
fn an_overrun_is_flagged_without_dma() {
    let mut rig = board();
    rig.uart(Setup { rx_dma: false, ..Setup::default() });
    rig.part.wires.bytes.extend([7; 9]);
    rig.us(110);
    assert_eq!(rig.rules(), [Rule::UartLost]);
    assert_eq!(rig.read(LPUART1 + at::lpuart::ISR) & 1 << 3, 1 << 3);
}

#[test]
fn bytes_are_sent_one_after_the_other() {
    let mut rig = board();
    rig.uart(Setup::default());
    let begun = rig.now;
    rig.write(LPUART1 + at::lpuart::TDR, 0x41);
    rig.write(LPUART1 + at::lpuart::TDR, 0x42);
    assert_eq!(rig.read(LPUART1 + at::lpuart::ISR) & 0x40, 0);
    rig.us(25);
    let sent = &rig.part.wires.sent;
    assert_eq!(sent.iter().map(|(_, byte)| *byte).collect::<Vec<_>>(), [0x41, 0x42]);
    // 10 bits of 47222 / 256 cycles.
    assert!(sent[0].0.abs_diff(begun + 2 + 1845) <= 1, "{}", sent[0].0 - begun);
    assert_eq!(rig.read(LPUART1 + at::lpuart::ISR) & 0xc0, 0xc0);
}

#[test]
fn the_encoder_counts_edges_and_wraps() {
    let mut rig = board();
    rig.write(TIM5 + at::timgp32::SMCR, 3);
    rig.write(TIM5 + at::timgp32::ARR, u32::MAX);
    rig.write(TIM5 + at::timgp32::CR1, 1);
    rig.part.wires.position = -5;
    assert_eq!(rig.read(TIM5 + at::timgp32::CNT) as i32, -5);
}

#[test]
fn the_sensor_measures_the_temperature() {
    let mut rig = board();
    rig.write(ADC345_COMMON + at::adccommon::CCR, 3 << 16 | 3 << 22);
    rig.wake_adc(ADC5);
    rig.write(ADC5 + at::adc::SMPR, 7 << 12);
    rig.write(ADC5 + at::adc::SQR1, 4 << 6);
    rig.set(ADC5 + at::adc::CR, 4);
    let begun = rig.now;
    rig.poll(ADC5 + at::adc::ISR, 4, 4);
    // 2.125 + 640.5 + 12.5 cycles of 42.5 MHz.
    assert!((rig.now - begun).abs_diff(2621) < 14, "{}", rig.now - begun);
    let code = f64::from(rig.read(ADC5 + at::adc::DR)) * 3.3 / 3.0;
    let cal1 = f64::from(rig.read(0x1fff_75a8) & 0xffff);
    let cal2 = f64::from(rig.read(0x1fff_75c8) >> 16);
    let celsius = 30.0 + 100.0 * (code - cal1) / (cal2 - cal1);
    assert!((celsius - 80.0).abs() < 0.2, "{celsius}");
    assert_eq!(rig.findings(), []);
}

#[test]
fn a_board_without_a_crystal_never_gets_ready() {
    let config = sonoglide_stm32g474::Config { crystal_hz: None, ..Default::default() };
    let mut rig = Rig::bare();
    rig.part = sonoglide_stm32g474::Stm32g474::new(config, Bare);
    rig.set(RCC + at::rcc::CR, 1 << 16);
    rig.us(10_000);
    assert_eq!(rig.read(RCC + at::rcc::CR) & 1 << 17, 0);
}

#[test]
fn an_edge_pends_its_external_interrupt() {
    let mut rig = board();
    rig.write(GPIOC + at::gpio::PUPDR, 2 << 6);
    rig.clear(GPIOC + at::gpio::MODER, 3 << 6);
    rig.write(SYSCFG + at::syscfg::EXTICR_0, 2 << 12);
    rig.write(EXTI + at::exti::FTSR_0, 8);
    rig.set(EXTI + at::exti::IMR_0, 8);
    rig.write(EXTI + at::exti::PR_0, 8);
    assert!(!rig.line(line::EXTI3));
    for released in [true, false] {
        rig.part.wires.stop_released = released;
        rig.part.wires.due = rig.now + 3;
        rig.wait(10);
    }
    assert!(rig.line(line::EXTI3));
    rig.write(EXTI + at::exti::PR_0, 8);
    assert!(!rig.line(line::EXTI3));
}

#[test]
fn a_peripheral_reset_resets_its_registers() {
    let mut rig = board();
    rig.write(TIM3 + at::timgp16::ARR, 1000);
    rig.write(TIM3 + at::timgp16::CR1, 1);
    rig.set(RCC + at::rcc::APB1RSTR1, 2);
    rig.clear(RCC + at::rcc::APB1RSTR1, 2);
    assert_eq!(rig.read(TIM3 + at::timgp16::ARR), 0xffff);
    assert_eq!(rig.read(TIM3 + at::timgp16::CNT), 0);
}

#[test]
fn an_update_sets_its_flag_and_its_interrupt() {
    let mut rig = board();
    rig.write(TIM2 + at::timgp32::PSC, 169);
    rig.write(TIM2 + at::timgp32::ARR, 99);
    rig.write(TIM2 + at::timgp32::EGR, 1);
    rig.write(TIM2 + at::timgp32::SR, 0);
    rig.write(TIM2 + at::timgp32::DIER, 1);
    rig.write(TIM2 + at::timgp32::CR1, 1);
    rig.us(99);
    assert!(!rig.line(line::TIM2));
    assert_eq!(rig.read(TIM2 + at::timgp32::CNT), 99);
    rig.us(1);
    assert!(rig.line(line::TIM2));
    assert_eq!(rig.read(TIM2 + at::timgp32::SR), 1);
    rig.write(TIM2 + at::timgp32::SR, 0);
    assert!(!rig.line(line::TIM2));
}

#[test]
fn unmodelled_registers_are_refused_by_name() {
    let mut rig = board();
    rig.write(RCC + at::rcc::APB1ENR1, 1 << 28 | 0xf | 1 << 21);
    let cases: [(u32, u32, &str); 5] = [
        (I2C1, 1, "I2C1_CR1"),
        (0x4001_7000, 1, "not modelled"),
        (TIM3 + at::timgp16::CR1, 1 << 5, "CMS"),
        (ADC1 + at::adc::CFGR, 1 << 3, "RES"),
        (FLASH + at::flash::OPTR, 0, "FLASH_OPTR"),
    ];
    for (address, value, name) in cases {
        let Err(Fault::Stop(error)) = rig.try_write(address, value, Width::Word) else { panic!("{name} is taken") };
        assert!(error.downcast_ref::<NotModelled>().is_some(), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
    assert!(matches!(rig.try_read(0x6000_0000), Err(Fault::Bus)));
}

#[test]
fn a_finding_stops_the_run_unless_it_is_collected() {
    let mut rig = Rig::bare();
    rig.part.lint.set(Rule::Unclocked, Verdict::Stop);
    assert!(matches!(rig.try_write(GPIOA, 0, Width::Word), Err(Fault::Stop(_))));
    rig.part.lint.set(Rule::Unclocked, Verdict::Ignore);
    assert!(rig.try_write(GPIOA, 0, Width::Word).is_ok());
    assert_eq!(rig.findings(), []);
}

#[test]
fn equal_runs_are_equal() {
    let run = || {
        let mut rig = board();
        rig.streams(Setup::default());
        rig.us(200);
        rig.memory.get(ADC_RING, 256).unwrap().to_vec()
    };
    assert_eq!(run(), run());
}
