//! What the peripherals do, one by one.

mod common;

use std::collections::VecDeque;

use common::{PC, Rig, Setup, UART_RING};
use cortex_m4::{Chip, Cycle, Fault, Ports, Width};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::map::line;
use sonoglide_stm32g474::{Bare, Defect, Drive, Level, NotModelled, Pin, Ram, Received, Rule, Verdict, Wires};

/// A board with settable levels and voltages.
struct Board {
    /// PA1, PA7, V.
    current: [f64; 2],
    stop_released: bool,
    due: Cycle,
    position: i32,
    bytes: VecDeque<u8>,
    sent: Vec<(Cycle, u8)>,
    enable: Vec<(Cycle, Level)>,
}

impl Default for Board {
    fn default() -> Self {
        Board {
            current: [1.65; 2],
            stop_released: true,
            due: Cycle::MAX,
            position: 0,
            bytes: VecDeque::new(),
            sent: Vec::new(),
            enable: Vec::new(),
        }
    }
}

impl Wires for Board {
    fn dac(&mut self, _at: Cycle, _dac: u8, _codes: [u16; 2]) {}

    fn volts(&mut self, _at: Cycle, pin: Pin) -> f64 {
        if pin == Pin::new('A', 7) { self.current[1] } else { self.current[0] }
    }

    fn celsius(&mut self, _at: Cycle) -> f64 {
        80.0
    }

    fn output(&mut self, at: Cycle, pin: Pin, level: Level) {
        if pin == Pin::new('A', 10) {
            self.enable.push((at, level));
        }
    }

    fn inputs(&mut self, _at: Cycle, port: u8) -> Drive {
        // The contact connects PC3 to the supply; its pull-down is the part's.
        if port == 2 && self.stop_released { Drive { driven: 8, high: 8 } } else { Drive::default() }
    }

    fn encoder(&mut self, _at: Cycle) -> i32 {
        self.position
    }

    fn due(&self) -> Cycle {
        self.due
    }

    fn byte_due(&self) -> Cycle {
        if self.bytes.is_empty() { Cycle::MAX } else { 0 }
    }

    fn receive(&mut self, _at: Cycle) -> Option<Received> {
        self.bytes.pop_front().map(|byte| Received { byte, ..Received::default() })
    }

    fn sent(&mut self, at: Cycle, byte: u8) {
        self.sent.push((at, byte));
    }
}

fn board() -> Rig<Board> {
    let mut rig = Rig::on(Board::default());
    rig.clocks(Setup::default());
    rig
}

/// Arms the protection of `docs/board.md`, and raises the enable.
fn armed() -> Rig<Board> {
    let mut rig = board();
    rig.write(DAC3 + at::dac::MCR, 3 | 3 << 16 | 2 << 14);
    // 3.05 V and 0.25 V of 3.3 V.
    rig.write(DAC3 + at::dac::DHR12R_0, 3786);
    rig.write(DAC3 + at::dac::DHR12R_1, 310);
    rig.write(DAC3 + at::dac::CR, 1 | 1 << 16);
    rig.write(COMP1, 4 << 4 | 3 << 16 | 1);
    rig.write(COMP2, 4 << 4 | 1 << 15 | 3 << 16 | 1);
    // PC3 is TIM1_BKIN2, PA10 TIM1_CH3, both alternate function 6.
    rig.write(GPIOC + at::gpio::AFR_0, 6 << 12);
    rig.write(GPIOC + at::gpio::PUPDR, 2 << 6);
    rig.clear(GPIOC + at::gpio::MODER, 1 << 6);
    rig.write(TIM1 + at::timadv::CCMR2, 4 << 4);
    rig.write(TIM1 + at::timadv::CCER, 1 << 8);
    rig.write(TIM1 + at::timadv::AF1, 6);
    rig.write(TIM1 + at::timadv::AF2, 1 | 1 << 9);
    rig.write(TIM1 + at::timadv::BDTR, 3 << 12 | 3 << 24 | 3 << 10 | 1 << 8);
    rig.write(GPIOA + at::gpio::AFR_1, 6 << 8);
    rig.clear(GPIOA + at::gpio::MODER, 1 << 20);
    raise(&mut rig);
    rig
}

fn raise(rig: &mut Rig<Board>) {
    rig.write(TIM1 + at::timadv::CCMR2, 5 << 4);
    rig.set(TIM1 + at::timadv::BDTR, 1 << 15);
}

fn last_level(rig: &Rig<Board>) -> Level {
    rig.part.wires.enable.last().expect("the enable was driven").1
}

#[test]
fn the_enable_follows_its_order() {
    let mut rig = armed();
    assert_eq!(last_level(&rig), Level::High);
    assert!(rig.part.enable_is_high());
    rig.clear(TIM1 + at::timadv::BDTR, 1 << 15);
    assert_eq!(last_level(&rig), Level::Low);
    assert_eq!(rig.findings(), []);
}

/// The voltage of a comparator changes by itself.
fn current(rig: &mut Rig<Board>, volts: [f64; 2]) {
    rig.part.wires.current = volts;
    rig.part.wires.due = rig.now + 5;
    rig.wait(10);
}

#[test]
fn a_comparator_drops_the_enable_and_keeps_it_down() {
    for volts in [[3.1, 1.65], [1.65, 0.2]] {
        let mut rig = armed();
        let before = rig.now;
        current(&mut rig, volts);
        assert_eq!(last_level(&rig), Level::Low);
        assert_eq!(rig.part.wires.enable.last().unwrap().0, before + 5);
        assert_eq!(rig.read(TIM1 + at::timadv::SR) & 0x180, 0x80);
        // While it stands, neither its flag can be cleared nor the enable be raised.
        rig.write(TIM1 + at::timadv::SR, !0x80);
        raise(&mut rig);
        assert_eq!(rig.read(TIM1 + at::timadv::SR) & 0x80, 0x80);
        assert_eq!(last_level(&rig), Level::Low);
        current(&mut rig, [1.65; 2]);
        assert_eq!(last_level(&rig), Level::Low);
        rig.write(TIM1 + at::timadv::SR, !0x80);
        raise(&mut rig);
        assert_eq!(last_level(&rig), Level::High);
    }
}

#[test]
fn hysteresis_holds_a_comparator() {
    let mut rig = armed();
    // The threshold is 3.0502 V, the hysteresis 30 mV.
    for (volts, above) in [(3.04, false), (3.06, true), (3.03, true), (3.01, false)] {
        current(&mut rig, [volts, 1.65]);
        assert_eq!(rig.read(COMP1) >> 30 & 1 == 1, above, "{volts}");
    }
}

#[test]
fn an_open_stop_contact_drops_the_enable() {
    let mut rig = armed();
    rig.part.wires.stop_released = false;
    rig.part.wires.due = rig.now + 3;
    rig.wait(10);
    assert_eq!(last_level(&rig), Level::Low);
    assert_eq!(rig.read(TIM1 + at::timadv::SR) & 0x180, 0x100);
    assert_eq!(rig.read(GPIOC + at::gpio::IDR) & 8, 0);
}

#[test]
fn a_debugger_halt_drops_the_enable_until_it_goes_on() {
    let mut rig = armed();
    rig.write(0xe004_2010, 1 << 11);
    for (halted, level) in [(true, Level::Low), (false, Level::High)] {
        let now = rig.now;
        let ports = Ports { memory: &mut rig.memory, interrupts: &mut rig.interrupts };
        rig.part.debugger(now, halted, ports).unwrap();
        assert_eq!(last_level(&rig), level);
    }
}

#[test]
fn a_lockup_drops_the_enable_only_if_syscfg_says_so() {
    for (cll, level) in [(0, Level::High), (1, Level::Low)] {
        let mut rig = armed();
        rig.write(SYSCFG + at::syscfg::CFGR2, cll);
        let now = rig.now;
        let ports = Ports { memory: &mut rig.memory, interrupts: &mut rig.interrupts };
        rig.part.lockup(now, ports).unwrap();
        assert_eq!(last_level(&rig), level);
    }
}

#[test]
fn a_reset_lets_the_enable_float() {
    let mut rig = armed();
    rig.reset();
    assert_eq!(last_level(&rig), Level::Floating);
    assert_eq!(rig.part.hz(), 16_000_000);
    assert_eq!(rig.read(RCC + at::rcc::CSR) >> 24, 0b0001_1100, "software reset, with the flags of power-on");
}

#[test]
fn the_watchdog_bites_after_its_time_unless_fed() {
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
    // 10.85 us a byte: five of them.
    assert_eq!(rig.memory.get(UART_RING, 6).unwrap(), b"sonog\0");
    assert_eq!(rig.read(DMA1 + at::dma::CH_2_NDTR), 512 - 5);
    rig.us(60);
    assert_eq!(rig.memory.get(UART_RING, 9).unwrap(), b"sonoglide");
    assert_eq!(rig.findings(), []);
}

#[test]
fn noise_flips_bits_and_sets_its_flag() {
    let mut rig = board();
    rig.uart(Setup::default());
    rig.part.inject(rig.now, Defect::UartNoise { bytes: 1 });
    rig.wait(1);
    rig.part.wires.bytes.extend([0x55, 0x55]);
    rig.us(30);
    let ring = rig.memory.get(UART_RING, 2).unwrap().to_vec();
    assert_eq!(((ring[0] ^ 0x55).count_ones(), ring[1]), (1, 0x55));
    assert_eq!(rig.read(LPUART1 + at::lpuart::ISR) & 0xe, 1 << 2);
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

/// A double word of the second bank, and what was written to it.
const WORD: u32 = 0x0807_c000;

fn begin_programming(rig: &mut Rig<Board>) {
    rig.write(FLASH + at::flash::ACR, 0x0004_0304);
    rig.write(FLASH + at::flash::KEYR, 0x4567_0123);
    rig.write(FLASH + at::flash::KEYR, 0xcdef_89ab);
    rig.write(FLASH + at::flash::CR, 1 | 1 << 30);
    rig.write(WORD, 0x0403_0201);
    rig.write(WORD + 4, 0x0807_0605);
}

#[test]
fn programming_takes_its_time_and_an_erase_undoes_it() {
    let mut rig = board();
    begin_programming(&mut rig);
    rig.us(81);
    assert_eq!(rig.read(FLASH + at::flash::SR), 1 << 16);
    rig.us(2);
    assert_eq!(rig.read(FLASH + at::flash::SR), 0);
    assert_eq!(rig.memory.get(WORD, 8).unwrap(), [1, 2, 3, 4, 5, 6, 7, 8]);
    rig.write(FLASH + at::flash::CR, 2 | 120 << 3 | 1 << 11 | 1 << 30);
    rig.set(FLASH + at::flash::CR, 1 << 16);
    rig.us(22_100);
    assert_eq!(rig.memory.get(WORD, 8).unwrap(), [0xff; 8]);
}

#[test]
fn only_the_bank_that_is_written_stalls() {
    let mut rig = board();
    begin_programming(&mut rig);
    let now = rig.now;
    assert!(rig.part.fetch_wait(PC, now) <= 4);
    let stall = rig.part.load_wait(0x0804_0000, now);
    assert!((13_900..=13_950).contains(&stall), "{stall}");
}

#[test]
fn a_power_cut_damages_the_word_that_is_written() {
    let mut rig = board();
    begin_programming(&mut rig);
    rig.memory.get_mut(0x2000_0000, 1).unwrap()[0] = 77;
    rig.part.inject(rig.now + 100, Defect::BrownOut { ram: Ram::Kept });
    rig.wait(200);
    rig.reset();
    assert_eq!(rig.memory.get(WORD, 8).unwrap(), [1, 2, 3, 4, 0xff, 0xff, 0xff, 0xff]);
    assert_eq!(rig.memory.get(0x2000_0000, 1).unwrap(), [77]);
    assert_eq!(rig.read(RCC + at::rcc::CSR) >> 24, 0b0000_1100, "power-on");
    assert!(format!("{:?}", rig.memory).contains(&WORD.to_string()), "the word is damaged");
}

#[test]
fn a_dead_crystal_falls_back_to_hsi_with_an_nmi() {
    let mut rig = Rig::on(Board::default());
    rig.write(FLASH + at::flash::ACR, 0x0004_0701);
    rig.set(RCC + at::rcc::CR, 1 << 16 | 1 << 19);
    rig.poll(RCC + at::rcc::CR, 1 << 17, 1 << 17);
    rig.write(RCC + at::rcc::CFGR, 2);
    assert_eq!(rig.part.hz(), 24_000_000);
    rig.part.inject(rig.now + 50, Defect::HseStops);
    rig.wait(100);
    assert_eq!(rig.part.hz(), 16_000_000);
    assert_eq!(rig.read(RCC + at::rcc::CFGR) & 0xf, 0b0101);
    assert_eq!(rig.read(RCC + at::rcc::CIFR), 1 << 8);
    assert!(format!("{:?}", rig.interrupts).contains("nmi: true"));
    rig.write(RCC + at::rcc::CICR, 1 << 8);
    assert_eq!(rig.read(RCC + at::rcc::CIFR), 0);
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
fn defects_of_the_stream_are_seen() {
    for (defect, rule) in [
        (Defect::DmaHalts { dma: 1, channel: 1 }, Some(Rule::AdcOverrun)),
        (Defect::DmaHalts { dma: 1, channel: 2 }, Some(Rule::DacUnderrun)),
        (Defect::TimerHalts { timer: 4 }, None),
        (Defect::AdcStuck { adc: 1, code: 7 }, None),
    ] {
        let mut rig = Rig::on(Board::default());
        rig.clocks(Setup::default());
        rig.streams(Setup::default());
        rig.us(20);
        let left = rig.read(DMA1 + at::dma::CH_0_NDTR);
        rig.part.inject(rig.now, defect);
        rig.us(20);
        assert_eq!(rig.rules(), Vec::from_iter(rule), "{defect:?}");
        let moved = left - rig.read(DMA1 + at::dma::CH_0_NDTR);
        match defect {
            Defect::TimerHalts { .. } => assert!(moved <= 1, "{moved}"),
            Defect::AdcStuck { .. } => {
                let place = common::ADC_RING + 4 * (64 - rig.read(DMA1 + at::dma::CH_0_NDTR) - 1);
                assert_eq!(rig.memory.get(place, 2).unwrap(), [14, 0]);
            }
            _ => {}
        }
    }
}

#[test]
fn an_input_pin_sticks() {
    let mut rig = armed();
    rig.part.inject(rig.now + 1, Defect::PinStuck { pin: Pin::new('C', 3), high: true });
    rig.wait(4);
    rig.part.wires.stop_released = false;
    rig.part.wires.due = rig.now + 3;
    rig.wait(10);
    assert_eq!(last_level(&rig), Level::High, "the stop is not seen");
}

#[test]
fn a_low_supply_breaks_if_it_is_connected() {
    let mut rig = armed();
    rig.write(PWR + at::pwr::CR2, 1);
    rig.write(SYSCFG + at::syscfg::CFGR2, 4);
    rig.part.inject(rig.now + 1, Defect::SupplyLow(true));
    rig.wait(4);
    assert_eq!(last_level(&rig), Level::Low);
    assert_eq!(rig.read(PWR + at::pwr::SR2) >> 11 & 1, 1);
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
fn a_peripheral_reset_takes_its_registers_back() {
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
fn what_is_not_known_is_refused_by_name() {
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
        rig.memory.get(common::ADC_RING, 256).unwrap().to_vec()
    };
    assert_eq!(run(), run());
}
