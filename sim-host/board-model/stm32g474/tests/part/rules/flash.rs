//! Rules of the flash.

use cortex_m4::{Chip, Fault, Ports, Width};
use sonoglide_stm32g474::map::at;
use sonoglide_stm32g474::map::base::*;
use sonoglide_stm32g474::{Bare, Defect, Rule};

use super::{check, up};
use crate::rig::Rig;

/// Address of a double word of the second bank.
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
