//! Events that switch the amplifier's enable off.

use cortex_m4::{Chip, Ports};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Defect, Level, Pin};

use crate::board::{Board, board};
use crate::rig::Rig;

/// Arms the protection of `docs/board.md`, and sets the enable.
fn armed() -> Rig<Board> {
    let mut rig = board();
    rig.write(DAC3 + at::dac::MCR, 3 | 3 << 16 | 2 << 14);
    // 3.05 V and 0.25 V at a reference of 3.3 V.
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
fn the_enable_follows_its_command() {
    let mut rig = armed();
    assert_eq!(last_level(&rig), Level::High);
    assert!(rig.part.enable_is_high());
    rig.clear(TIM1 + at::timadv::BDTR, 1 << 15);
    assert_eq!(last_level(&rig), Level::Low);
    assert_eq!(rig.findings(), []);
}

/// Changes the voltage of a comparator without an access.
fn current(rig: &mut Rig<Board>, volts: [f64; 2]) {
    rig.part.wires.current = volts;
    rig.part.wires.due = rig.now + 5;
    rig.wait(10);
}

#[test]
fn a_comparator_clears_the_enable_and_keeps_it_low() {
    for volts in [[3.1, 1.65], [1.65, 0.2]] {
        let mut rig = armed();
        let before = rig.now;
        current(&mut rig, volts);
        assert_eq!(last_level(&rig), Level::Low);
        assert_eq!(rig.part.wires.enable.last().unwrap().0, before + 5);
        assert_eq!(rig.read(TIM1 + at::timadv::SR) & 0x180, 0x80);
        // While the break is active, its flag cannot be cleared and the enable cannot be set.
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
fn an_open_stop_contact_clears_the_enable() {
    let mut rig = armed();
    rig.part.wires.stop_released = false;
    rig.part.wires.due = rig.now + 3;
    rig.wait(10);
    assert_eq!(last_level(&rig), Level::Low);
    assert_eq!(rig.read(TIM1 + at::timadv::SR) & 0x180, 0x100);
    assert_eq!(rig.read(GPIOC + at::gpio::IDR) & 8, 0);
}

#[test]
fn a_debugger_halt_clears_the_enable_until_it_resumes() {
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
fn a_lockup_clears_the_enable_only_if_syscfg_selects_it() {
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
fn an_input_pin_sticks() {
    let mut rig = armed();
    rig.part.inject(rig.now + 1, Defect::PinStuck { pin: Pin::new('C', 3), high: true });
    rig.wait(4);
    rig.part.wires.stop_released = false;
    rig.part.wires.due = rig.now + 3;
    rig.wait(10);
    assert_eq!(last_level(&rig), Level::High, "the stop is not detected");
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
fn a_crystal_failure_clears_the_enable_with_css() {
    for (csson, level) in [(0, Level::High), (1 << 19, Level::Low)] {
        let mut rig = armed();
        rig.set(RCC + at::rcc::CR, 1 << 16);
        rig.poll(RCC + at::rcc::CR, 1 << 17, 1 << 17);
        rig.set(RCC + at::rcc::CR, csson);
        rig.part.inject(rig.now + 1, Defect::HseStops);
        rig.wait(4);
        assert_eq!(last_level(&rig), level);
        assert_eq!(rig.read(TIM1 + at::timadv::SR) >> 13 & 1 == 1, level == Level::Low);
    }
}

#[test]
fn a_fault_of_the_part_breaks_only_with_bke() {
    let mut rig = board();
    rig.write(SYSCFG + at::syscfg::CFGR2, 1);
    rig.write(TIM1 + at::timadv::BDTR, 1 << 15);
    let now = rig.now;
    rig.part.lockup(now, Ports { memory: &mut rig.memory, interrupts: &mut rig.interrupts }).unwrap();
    assert_eq!(rig.read(TIM1 + at::timadv::BDTR) >> 15 & 1, 1);
    rig.set(TIM1 + at::timadv::BDTR, 1 << 12);
    assert_eq!(rig.read(TIM1 + at::timadv::BDTR) >> 15 & 1, 0);
}
