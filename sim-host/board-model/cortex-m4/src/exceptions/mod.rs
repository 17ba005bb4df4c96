//! Exceptions, and registers of the processor (ARM DDI 0403, B1.5 and B3).

mod dwt;
mod entry;
mod fault;
mod mpu;
mod nvic;
mod private;
mod scb;
mod systick;

pub(crate) use dwt::Dwt;
pub(crate) use mpu::Mpu;
pub(crate) use nvic::Nvic;
pub use private::UnknownRegister;
pub(crate) use scb::Scb;
pub(crate) use systick::SysTick;

pub(crate) const NMI: u16 = 2;
pub(crate) const HARD_FAULT: u16 = 3;
pub(crate) const MEMORY_FAULT: u16 = 4;
pub(crate) const BUS_FAULT: u16 = 5;
pub(crate) const USAGE_FAULT: u16 = 6;
pub(crate) const SVCALL: u16 = 11;
pub(crate) const DEBUG_MONITOR: u16 = 12;
pub(crate) const PENDSV: u16 = 14;
pub(crate) const SYSTICK: u16 = 15;
/// Number of the first external interrupt.
pub(crate) const EXTERNAL: u16 = 16;
