//! Registers of an STM32G474RE in software, with checks of their use by a program.
//!
//! ```text
//! processor ── Chip ──> bus ──> RCC PWR FLASH SYSCFG EXTI GPIO DMA TIM ADC DAC COMP OPAMP LPUART IWDG
//!                        │                                            │
//!                       Lint (Finding)                              Wires: the board at the pins
//! ```
//!
//! [`Stm32g474`] is the [`Chip`](cortex_m4::Chip) around the processor of the crate `cortex-m4`. An
//! implementation of [`Wires`] is connected to its pins. Names, fields and addresses of the
//! registers come from the metadata of `stm32-metapac` at build time ([`map`]). Their behaviour is
//! written from RM0440, the data sheet DS12288 and the errata ES0430.
//!
//! Nothing is stepped: the value of a counter, and the time of the next trigger, conversion, byte
//! or watchdog reset, follow from the time of each start. The processor reads the cycle of its next
//! call by [`due`](cortex_m4::Chip::due). Time is counted in cycles of the core clock; events in
//! seconds move when that clock changes.
//!
//! An address, register or feature that the model lacks stops the run ([`NotModelled`]). An error
//! of the program stops it too ([`Finding`]), unless its [`Rule`] is set to be collected. A
//! [`Defect`] makes something fail. The source calls the microcontroller the chip or the part.
//!
//! ```
//! use cortex_m4::{Access, Chip, Fault, Interrupts, Ports, Width};
//! use sonoglide_stm32g474::map::{at, base};
//! use sonoglide_stm32g474::{Bare, Config, Finding, Rule, Stm32g474};
//!
//! let mut part = Stm32g474::new(Config::default(), Bare);
//! let (mut memory, mut interrupts) = (Stm32g474::<Bare>::memory(), Interrupts::default());
//! let mut write = |address, value, at| {
//!     let access = Access { address, width: Width::Word, at, pc: 0x0800_0200 };
//!     part.write(access, value, Ports { memory: &mut memory, interrupts: &mut interrupts })
//! };
//!
//! // Output to a port whose clock is off.
//! let Err(Fault::Stop(error)) = write(base::GPIOA + at::gpio::BSRR, 1 << 5, 10) else { panic!("it is not found") };
//! assert_eq!(error.downcast_ref::<Finding>().unwrap().rule, Rule::Unclocked);
//!
//! write(base::RCC + at::rcc::AHB2ENR, 1, 12).unwrap();
//! write(base::GPIOA + at::gpio::BSRR, 1 << 5, 20).unwrap();
//! ```
//!
//! # Simplifications
//!
//! DMA serves a request at once. Comparators have no delay, and are evaluated when a DAC, a
//! conversion or the wires change. The regulator follows PWR_CR1 at once. An encoder is a position,
//! not two wires. Timers 2 to 5 count up, and the counter of TIM1 counts up once, in one-pulse
//! mode.
#![forbid(unsafe_code)]

mod adc;
mod adc_control;
mod adc_inputs;
mod adc_timing;
mod art;
mod bus;
mod clock_rules;
mod comp;
mod contention;
mod dac;
mod defect;
mod dma;
mod factory;
mod finding;
mod flash;
mod gpio;
mod iwdg;
pub mod map;
mod part;
mod pwr;
mod rcc;
mod reset;
mod resets;
mod syscfg;
mod tim1;
mod tim1_counter;
mod time;
mod timer;
mod triggers;
mod uart;
mod wires;

pub use defect::{Defect, Ram};
pub use finding::{Finding, Lint, NotModelled, Rule, Verdict};
pub use flash::FlashOperation;
pub use part::{Config, Stm32g474};
pub use wires::{Bare, Drive, Level, Pin, Received, Wires};
