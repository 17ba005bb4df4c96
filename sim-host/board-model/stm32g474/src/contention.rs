//! Delays of the processor on the buses: by the bridges to the peripherals, and by the DMA
//! controllers.
//!
//! The bus matrix arbitrates round-robin (RM0440 2.1), and DMA accesses are single. The processor
//! waits for at most the current access, "one bus cycle (at most two APB clock cycles)" (AN2548).
//!
//! A transfer is one access to a memory and one to a peripheral. The access to a memory is assumed
//! to delay an access of the processor to the same memory. An access to a register of AHB2, which
//! has the converters, can only delay an access of the processor to AHB2, and all of these are
//! assumed to be delayed. An access through a bridge takes two cycles more than one to an AHB
//! peripheral (AN4031, table 4), with the APB at the processor's clock.

/// Cycles of an access to a memory, or to a peripheral of an AHB bus.
const AHB_CYCLES: u32 = 1;
/// Cycles of the bridge.
const BRIDGE_CYCLES: u32 = 2;

/// Returns `true` if an address is on APB1 or APB2, and accessed through a bridge (RM0440 2.2.2).
fn is_apb(address: u32) -> bool {
    (0x4000_0000..0x4002_0000).contains(&address)
}

/// Returns `true` if an address is a register of AHB2 (RM0440 2.2.2).
fn is_ahb2(address: u32) -> bool {
    (0x4800_0000..0x6000_0000).contains(&address)
}

/// Returns the maximum wait states of an access by the processor to a register.
pub(crate) fn wait(address: u32) -> u32 {
    if is_apb(address) {
        BRIDGE_CYCLES
    } else if is_ahb2(address) {
        AHB_CYCLES
    } else {
        0
    }
}

/// Returns the maximum delay of the processor by one DMA transfer with this peripheral, cycles, in
/// addition to [`wait`].
pub(crate) fn transfer_delay(peripheral: u32) -> u32 {
    if is_apb(peripheral) {
        AHB_CYCLES + BRIDGE_CYCLES
    } else if is_ahb2(peripheral) {
        AHB_CYCLES
    } else {
        AHB_CYCLES + AHB_CYCLES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::base;

    #[test]
    fn bridges_and_ahb2_add_wait_states() {
        assert_eq!([base::TIM3, base::LPUART1, base::TIM1].map(wait), [BRIDGE_CYCLES; 3]);
        assert_eq!([base::ADC1, base::DAC1, base::GPIOA].map(wait), [AHB_CYCLES; 3]);
        assert_eq!([base::DMA1, base::RCC].map(wait), [0; 2]);
    }

    #[test]
    fn a_transfer_accesses_memory_and_a_bridge() {
        assert_eq!([base::ADC12_COMMON, base::DAC1, base::LPUART1].map(transfer_delay), [1, 1, 3]);
    }
}
