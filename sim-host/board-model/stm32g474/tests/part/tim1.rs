//! TIM1 in one-pulse mode with PWM: RM0440 28.3.12 and 28.3.22.

use cortex_m4::{Cycle, Ports};
use sonoglide_stm32g474::map::at::timadv as reg;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::map::{at, line};
use sonoglide_stm32g474::{Defect, Level};

use crate::board::{Board, board};
use crate::rig::Rig;

/// Last count of the counter.
const LAST: u32 = 99;
const CR1: u32 = TIM1 + reg::CR1;
const CNT: u32 = TIM1 + reg::CNT;
const SR: u32 = TIM1 + reg::SR;
const ONCE: u32 = 1 << 3;
const CEN: u32 = 1;

/// Starts channel 3 (PA10) in the mode OC3M = `mode` with the compare value `compare`. Returns the
/// cycle of the start.
fn started(mode: u32, compare: u32) -> (Rig<Board>, Cycle) {
    let mut rig = board();
    rig.write(TIM1 + reg::ARR, LAST);
    rig.write(TIM1 + reg::CCR_0 + 8, compare);
    rig.write(TIM1 + reg::CCMR2, mode << 4);
    rig.write(TIM1 + reg::CCER, 1 << 8);
    rig.write(GPIOA + at::gpio::AFR_1, 6 << 8);
    rig.clear(GPIOA + at::gpio::MODER, 1 << 20);
    rig.write(TIM1 + reg::BDTR, 1 << 15 | 3 << 10);
    rig.write(CR1, ONCE | CEN);
    let at = rig.now;
    (rig, at)
}

/// Returns the edges since the start, in cycles from the first count.
fn edges(rig: &Rig<Board>, started: Cycle) -> Vec<(Cycle, Level)> {
    let after = |(at, _): &&(Cycle, Level)| *at > started;
    rig.part.wires.enable.iter().filter(after).map(|(at, level)| (at - started - 1, *level)).collect()
}

#[test]
fn pwm_mode_2_is_high_from_the_compare_value_to_the_end() {
    let (mut rig, at) = started(7, 30);
    assert!(!rig.part.enable_is_high());
    rig.wait(1000);
    assert_eq!(edges(&rig, at), [(30, Level::High), (100, Level::Low)]);
    assert_eq!(rig.findings(), []);
}

#[test]
fn pwm_mode_1_is_high_below_the_compare_value() {
    let (mut rig, at) = started(6, 30);
    rig.wait(1000);
    assert_eq!(edges(&rig, at), [(30, Level::Low), (100, Level::High)]);
}

#[test]
fn the_end_stops_the_counter_at_zero_and_sets_uif() {
    let (mut rig, at) = started(7, 1);
    rig.wait(50);
    assert_eq!(u64::from(rig.read(CNT)), rig.now - at - 1);
    assert_eq!((rig.read(SR) & 1, rig.read(CR1)), (0, ONCE | CEN));
    rig.wait(100);
    assert_eq!((rig.read(CNT), rig.read(SR) & 1, rig.read(CR1)), (0, 1, ONCE));
    rig.write(SR, !1);
    rig.wait(1000);
    assert_eq!(rig.read(SR) & 1, 0, "no second update");
}

#[test]
fn a_counter_that_is_set_back_in_time_does_not_end() {
    let (mut rig, at) = started(7, 1);
    for _ in 0..20 {
        rig.wait(90);
        rig.write(CNT, 1);
    }
    assert_eq!(edges(&rig, at), [(1, Level::High)]);
    let last = rig.now;
    rig.wait(1000);
    assert_eq!(edges(&rig, last - 1), [(99, Level::Low)]);
}

#[test]
fn the_comparison_sets_its_flag() {
    let (mut rig, _) = started(7, 30);
    rig.wait(20);
    assert_eq!(rig.read(SR) & 0x1e, 0);
    rig.wait(20);
    assert_eq!(rig.read(SR) & 0x1e, 1 << 3);
    rig.write(SR, !(1 << 3));
    rig.wait(20);
    assert_eq!(rig.read(SR) & 0x1e, 0);
}

#[test]
fn the_prescaler_counts_after_an_update() {
    let mut rig = board();
    rig.write(TIM1 + reg::PSC, 9);
    rig.write(TIM1 + reg::ARR, LAST);
    assert!(rig.try_write(CR1, ONCE | CEN, cortex_m4::Width::Word).is_err(), "a prescaler that was not loaded");
    rig.write(TIM1 + reg::EGR, 1);
    rig.write(CR1, ONCE | CEN);
    rig.wait(10 * 50);
    assert_eq!(rig.read(CNT), 49);
}

#[test]
fn the_update_raises_its_interrupt() {
    let (mut rig, _) = started(7, 1);
    rig.write(TIM1 + reg::DIER, 1);
    rig.wait(50);
    assert!(!rig.line(line::TIM1_UP_TIM16));
    rig.wait(100);
    assert!(rig.line(line::TIM1_UP_TIM16));
    rig.write(SR, !1);
    assert!(!rig.line(line::TIM1_UP_TIM16));
}

#[test]
fn a_halt_stops_the_counter_only_if_dbgmcu_selects_it() {
    for (stop, edge) in [(0, true), (1 << 11, false)] {
        let (mut rig, _) = started(7, 1);
        rig.write(0xe004_2010, stop);
        rig.wait(10);
        let now = rig.now;
        rig.part.debugger(now, true, Ports { memory: &mut rig.memory, interrupts: &mut rig.interrupts }).unwrap();
        let before = rig.read(CNT);
        rig.wait(1000);
        assert_eq!(rig.read(SR) & 1 == 1, edge);
        assert_eq!(rig.read(CNT) == before, !edge);
    }
}

#[test]
fn repeated_counting_is_refused() {
    let mut rig = board();
    rig.write(TIM1 + reg::ARR, LAST);
    assert!(rig.try_write(CR1, CEN, cortex_m4::Width::Word).is_err());
}

#[test]
fn a_low_supply_raises_the_interrupt_of_pvd() {
    let mut rig = board();
    rig.write(PWR + at::pwr::CR2, 1);
    rig.write(EXTI + at::exti::RTSR_0, 1 << 16);
    rig.write(EXTI + at::exti::IMR_0, 1 << 16);
    assert!(!rig.line(line::PVD_PVM));
    rig.part.inject(rig.now + 1, Defect::SupplyLow(true));
    rig.wait(4);
    assert!(rig.line(line::PVD_PVM));
    rig.write(EXTI + at::exti::PR_0, 1 << 16);
    assert!(!rig.line(line::PVD_PVM));
    rig.part.inject(rig.now + 1, Defect::SupplyLow(false));
    rig.wait(4);
    assert!(!rig.line(line::PVD_PVM), "the falling edge is not enabled");
}
