//! What the processor waits for on the buses: the bridges to the peripherals, and the DMA controllers.
//!
//! The bus matrix arbitrates round-robin (RM0440 2.1), and DMA accesses are single: the processor waits for the access under way at most, "one bus cycle (at
//! most two APB clock cycles)" (AN2548). A transfer is one access to a memory and one to a peripheral. That to a memory is taken to hit an access of the
//! processor to the same memory; that to a register of AHB2, where the converters are, can only hit one of the processor to AHB2, each of which is therefore
//! taken to be hit. An access through a bridge takes two cycles more than one to an AHB peripheral (AN4031, table 4), with the APB at the processor's clock.

/// Cycles of an access to a memory, or to a peripheral of an AHB bus.
const AHB: u32 = 1;
/// Cycles of the bridge.
const BRIDGE: u32 = 2;

/// Whether an address is behind a bridge: APB1 and APB2 (RM0440 2.2.2).
fn is_apb(address: u32) -> bool {
    (0x4000_0000..0x4002_0000).contains(&address)
}

/// Whether an address is a register of AHB2 (RM0440 2.2.2).
fn is_ahb2(address: u32) -> bool {
    (0x4800_0000..0x6000_0000).contains(&address)
}

/// Wait states of an access by the processor to a register, at most.
pub(crate) fn wait(address: u32) -> u32 {
    if is_apb(address) {
        BRIDGE
    } else if is_ahb2(address) {
        AHB
    } else {
        0
    }
}

/// Cycles for which one transfer of DMA with this peripheral can hold up the processor, at most, beside what [`wait`] counts.
pub(crate) fn of_transfer(peripheral: u32) -> u32 {
    if is_apb(peripheral) {
        AHB + BRIDGE
    } else if is_ahb2(peripheral) {
        AHB
    } else {
        AHB + AHB
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::base;

    #[test]
    fn the_bridges_and_the_converters_bus_add_wait_states() {
        assert_eq!([base::TIM3, base::LPUART1, base::TIM1].map(wait), [BRIDGE; 3]);
        assert_eq!([base::ADC1, base::DAC1, base::GPIOA].map(wait), [AHB; 3]);
        assert_eq!([base::DMA1, base::RCC].map(wait), [0; 2]);
    }

    #[test]
    fn a_transfer_takes_an_access_to_memory_and_one_through_a_bridge() {
        assert_eq!([base::ADC12_COMMON, base::DAC1, base::LPUART1].map(of_transfer), [1, 1, 3]);
    }
}
