//! Flash, and injected defects.

use cortex_m4::Chip;
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Defect, Ram, Rule};

use crate::board::{Board, board};
use crate::rig::{ADC_RING, PC, Rig, Setup, UART_RING};

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

/// Address of a double word of the second bank.
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
fn programming_takes_time_and_an_erase_reverts_it() {
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
fn only_the_bank_being_written_stalls() {
    let mut rig = board();
    begin_programming(&mut rig);
    let now = rig.now;
    assert!(rig.part.fetch_wait(PC, now) <= 4);
    let stall = rig.part.load_wait(0x0804_0000, now);
    assert!((13_900..=13_950).contains(&stall), "{stall}");
}

#[test]
fn a_power_cut_damages_the_word_being_written() {
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
fn defects_of_the_stream_are_detected() {
    for (defect, rule) in [
        (Defect::DmaHalts { dma: 1, channel: 1 }, Some(Rule::AdcOverrun)),
        (Defect::DmaHalts { dma: 1, channel: 2 }, Some(Rule::DacUnderrun)),
        (Defect::DmaMisses { dma: 1, channel: 1, requests: 1 }, Some(Rule::AdcOverrun)),
        (Defect::DmaMisses { dma: 1, channel: 2, requests: 1 }, Some(Rule::DacUnderrun)),
        (Defect::TimerHalts { timer: 4 }, None),
        (Defect::AdcStuck { adc: 1, code: 7 }, None),
        (Defect::AdcLate { adc: 2 }, None),
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
                let place = ADC_RING + 4 * (64 - rig.read(DMA1 + at::dma::CH_0_NDTR) - 1);
                assert_eq!(rig.memory.get(place, 2).unwrap(), [14, 0]);
            }
            _ => {}
        }
    }
}

#[test]
fn a_lost_trigger_loses_one_sample() {
    let moved = |triggers| {
        let mut rig = Rig::on(Board::default());
        rig.clocks(Setup::default());
        rig.streams(Setup::default());
        rig.us(20);
        rig.part.inject(rig.now, Defect::TriggersLost { timer: 3, triggers });
        let left = rig.read(DMA1 + at::dma::CH_1_NDTR);
        rig.us(20);
        (left - rig.read(DMA1 + at::dma::CH_1_NDTR), rig.rules())
    };
    let ((all, none), (fewer, also_none)) = (moved(0), moved(3));
    assert_eq!((all - fewer, none, also_none), (3, vec![], vec![]));
}

#[test]
fn a_failed_transfer_disables_its_channel_and_sets_a_flag() {
    let mut rig = Rig::on(Board::default());
    rig.clocks(Setup::default());
    rig.streams(Setup::default());
    rig.us(20);
    rig.part.inject(rig.now, Defect::DmaFails { dma: 1, channel: 2 });
    rig.us(3);
    assert_eq!(rig.read(DMA1 + at::dma::ISR) >> 4 & 9, 9, "error, and any flag");
    assert_eq!(rig.read(DMA1 + at::dma::CH_1_CR) & 1, 0);
    assert!(rig.rules().contains(&Rule::DmaError));
}

/// Starts a watchdog of ten milliseconds.
fn watchdog(rig: &mut Rig<Board>) {
    rig.write(IWDG + at::iwdg::KR, 0xcccc);
    rig.write(IWDG + at::iwdg::KR, 0x5555);
    rig.write(IWDG + at::iwdg::RLR, 79);
    rig.us(300);
    rig.write(IWDG + at::iwdg::KR, 0xaaaa);
}

#[test]
fn the_watchdog_follows_its_oscillator() {
    for (hz, milliseconds) in [(32_000, 10), (16_000, 20), (64_000, 5)] {
        let mut rig = board();
        watchdog(&mut rig);
        rig.part.inject(rig.now, Defect::LsiHz(hz));
        rig.us(1000 * milliseconds - 50);
        assert!(!format!("{:?}", rig.interrupts).contains("reset: true"), "{hz}");
        rig.us(100);
        assert!(format!("{:?}", rig.interrupts).contains("reset: true"), "{hz}");
    }
}

#[test]
fn without_its_pll_the_chip_stops_until_a_watchdog_reset() {
    let mut rig = Rig::on(Board::default());
    rig.clocks(Setup::default());
    watchdog(&mut rig);
    let began = rig.part.seconds(rig.now);
    rig.part.inject(rig.now, Defect::PllUnlocks);
    rig.wait(10);
    assert!(format!("{:?}", rig.interrupts).contains("reset: true"));
    let stood = rig.part.seconds(rig.now) - began;
    assert!((stood - 10e-3).abs() < 1e-6, "{stood}");
}
