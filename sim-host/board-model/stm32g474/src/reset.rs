//! Reset values that are not zero (RM0440, register sections; checked against ST's SVD, except for
//! its errors).

use crate::map::at::{adc, exti, flash, gpio, iwdg, lpuart, pwr, rcc, syscfg, timadv, timgp16, timgp32};
use crate::map::base::*;

/// Addresses and reset values.
pub const RESETS: &[(u32, u32)] = &[
    // HSI16 runs and is the system clock; the SVD has other values for CR and CFGR.
    (RCC + rcc::CR, 0x0000_0500),
    (RCC + rcc::ICSCR, 0x4000_0000),
    (RCC + rcc::CFGR, 0x0000_0005),
    (RCC + rcc::PLLCFGR, 0x0000_1000),
    (RCC + rcc::AHB1ENR, 0x0000_0100),
    (RCC + rcc::APB1ENR1, 0x0000_0400),
    (RCC + rcc::AHB1SMENR, 0x0000_130f),
    (RCC + rcc::AHB2SMENR, 0x050f_667f),
    (RCC + rcc::AHB3SMENR, 0x0000_0101),
    (RCC + rcc::APB1SMENR1, 0xd2fe_cd3f),
    (RCC + rcc::APB1SMENR2, 0x0000_0103),
    (RCC + rcc::APB2SMENR, 0x0437_f801),
    (RCC + rcc::CSR, 0x0c00_0000),
    (PWR + pwr::CR1, 0x0000_0200),
    (PWR + pwr::CR3, 0x0000_8000),
    (PWR + pwr::CR5, 0x0000_0100),
    // Caches on, no wait state.
    (FLASH + flash::ACR, 0x0004_0600),
    (FLASH + flash::CR, 0xc000_0000),
    // Option bytes as delivered: two banks.
    (FLASH + flash::OPTR, 0xffef_f8aa),
    (FLASH + flash::PCROP1SR, 0xffff_ffff),
    (FLASH + flash::PCROP1ER, 0x0fff_0000),
    (FLASH + flash::SEC1R, 0xff00_ff00),
    (FLASH + flash::SEC2R, 0xff00_ff00),
    (SYSCFG + syscfg::CFGR1, 0x7c00_0001),
    // All pins analog except those of the debugger.
    (GPIOA + gpio::MODER, 0xabff_ffff),
    (GPIOA + gpio::OSPEEDR, 0x0c00_0000),
    (GPIOA + gpio::PUPDR, 0x6400_0000),
    (GPIOB + gpio::MODER, 0xffff_febf),
    (GPIOB + gpio::OSPEEDR, 0x0000_00c0),
    (GPIOB + gpio::PUPDR, 0x0000_0100),
    (GPIOC + gpio::MODER, 0xffff_ffff),
    (GPIOD + gpio::MODER, 0xffff_ffff),
    (GPIOE + gpio::MODER, 0xffff_ffff),
    (GPIOF + gpio::MODER, 0xffff_ffff),
    (GPIOG + gpio::MODER, 0xffff_ffff),
    (EXTI + exti::IMR_0, 0xff82_0000),
    (EXTI + exti::IMR_1, 0xffff_ff87),
    (IWDG + iwdg::RLR, 0x0000_0fff),
    (IWDG + iwdg::WINR, 0x0000_0fff),
    (LPUART1 + lpuart::ISR, 0x0000_00c0),
    (TIM1 + timadv::ARR, 0x0000_ffff),
    (TIM1 + timadv::AF1, 0x0000_0001),
    (TIM1 + timadv::AF2, 0x0000_0001),
    (TIM2 + timgp32::ARR, 0xffff_ffff),
    (TIM3 + timgp16::ARR, 0x0000_ffff),
    (TIM4 + timgp16::ARR, 0x0000_ffff),
    (TIM5 + timgp32::ARR, 0xffff_ffff),
    // In deep power-down, with the queue of injected conversions off.
    (ADC1 + adc::CR, 0x2000_0000),
    (ADC2 + adc::CR, 0x2000_0000),
    (ADC3 + adc::CR, 0x2000_0000),
    (ADC4 + adc::CR, 0x2000_0000),
    (ADC5 + adc::CR, 0x2000_0000),
    (ADC1 + adc::CFGR, 0x8000_0000),
    (ADC2 + adc::CFGR, 0x8000_0000),
    (ADC3 + adc::CFGR, 0x8000_0000),
    (ADC4 + adc::CFGR, 0x8000_0000),
    (ADC5 + adc::CFGR, 0x8000_0000),
];
