//! Rules of timers, locks, watchdog and UART.

use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Bare, Rule};

use super::converters::stream;
use super::{check, up};
use crate::rig::{Rig, Setup};

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
fn tim_blocked() {
    fn counter(rig: &mut Rig<Bare>, last: u32) {
        up(rig);
        rig.write(TIM1 + at::timadv::ARR, last);
        rig.write(TIM1 + at::timadv::CR1, 1 << 3 | 1);
    }
    check(Rule::TimBlocked, |rig| counter(rig, 1), |rig| counter(rig, 0));
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
        // One byte is being sent, and eight wait.
        (0..bytes).for_each(|byte| rig.write(LPUART1 + at::lpuart::TDR, byte));
    }
    check(Rule::UartLost, |rig| send(rig, 9), |rig| send(rig, 10));
}
