//! Comparators and op-amps. RM0440 24 and 25.
//!
//! A comparator is evaluated when one of its inputs may have changed: at a new DAC code, at a
//! conversion, or at a change of the wires. Its delay is not modelled.

use std::sync::LazyLock;

use cortex_m4::{Cycle, Fault, Ports};
use stm32_metapac::comp::regs::Csr;
use stm32_metapac::opamp::regs::Csr as OpampCsr;

use crate::factory::reference_volts;
use crate::finding::Rule;
use crate::map::SIGNALS;
use crate::map::base::{COMP1, OPAMP1};
use crate::part::{Now, Stm32g474};
use crate::wires::{Pin, Wires};

const COUNT: u32 = 7;
const VALUE: u32 = 1 << 30;
const LOCK: u32 = 1 << 31;

/// DAC channels of INMSEL = 4 and 5 of each comparator: DAC from 1, channel from 0 (24.3.2, table
/// of the inverting inputs).
const DACS: [[(usize, usize); 2]; 7] = [
    [(3, 0), (1, 0)],
    [(3, 1), (1, 1)],
    [(3, 0), (1, 0)],
    [(3, 1), (1, 0)],
    [(4, 0), (1, 1)],
    [(4, 1), (2, 0)],
    [(4, 0), (2, 0)],
];

/// Names of the signals with their own pin.
const INPUTS: [&str; 4] = ["INP0", "INP1", "INM0", "INM1"];

/// Pins of these signals, of each comparator.
static PINS: LazyLock<[[Option<Pin>; 4]; COUNT as usize]> = LazyLock::new(|| {
    std::array::from_fn(|comparator| {
        let name = format!("COMP{}", comparator + 1);
        INPUTS.map(|signal| {
            let found = SIGNALS.iter().find(|(peripheral, input, ..)| *peripheral == name && *input == signal);
            found.and_then(|(.., pin, _)| Pin::named(pin))
        })
    })
});

impl<W: Wires> Stm32g474<W> {
    pub(crate) fn write_comp(&mut self, now: Now, address: u32, value: u32, ports: &mut Ports) -> Result<(), Fault> {
        let old = self.regs[address];
        if old & LOCK != 0 {
            let bits = (value ^ old) & !VALUE;
            return if bits == 0 { Ok(()) } else { self.report(now, address, bits, value, Rule::Locked) };
        }
        // Blanking would need the outputs of the timers.
        self.refuse_bits(now, address, value, 7 << 19)?;
        let csr = Csr(value);
        let comparator = (address - COMP1) / 4;
        if csr.en()
            && (self.plus_pin(comparator, csr).is_none()
                || (csr.inmsel().to_bits() > 5 && self.minus_pin(comparator, csr).is_none()))
        {
            return self.refuse(now, address, "an input");
        }
        self.regs[address] = value & !VALUE | old & VALUE;
        self.compare(now.at, ports);
        self.update_breaks(now.at, ports);
        Ok(())
    }

    fn plus_pin(&self, comparator: u32, csr: Csr) -> Option<Pin> {
        PINS[comparator as usize][usize::from(csr.inpsel())]
    }

    fn minus_pin(&self, comparator: u32, csr: Csr) -> Option<Pin> {
        PINS[comparator as usize][if csr.inmsel().to_bits() == 6 { 2 } else { 3 }]
    }

    /// Returns the voltage at the inverting input, V (24.3.2).
    fn threshold(&mut self, at: Cycle, comparator: u32, csr: Csr) -> f64 {
        match csr.inmsel().to_bits() {
            // Divider of the reference: a quarter to the whole.
            quarter @ 0..=3 => reference_volts() * f64::from(quarter + 1) / 4.0,
            way @ 4..=5 => {
                let (dac, channel) = DACS[comparator as usize][usize::from(way - 4)];
                self.dacs[dac - 1].volts(channel, self.config.vdda)
            }
            _ => match self.minus_pin(comparator, csr) {
                Some(pin) => self.wires.volts(at, pin),
                None => 0.0,
            },
        }
    }

    /// Evaluates all comparators, and updates the breaks if an output has changed.
    pub(crate) fn compare(&mut self, at: Cycle, ports: &mut Ports) {
        let before = self.compared;
        for comparator in 0..COUNT {
            let address = COMP1 + 4 * comparator;
            let csr = Csr(self.regs[address]);
            if !csr.en() {
                self.compared &= !(1 << comparator);
                self.regs[address] &= !VALUE;
                continue;
            }
            let threshold = self.threshold(at, comparator, csr);
            let Some(pin) = self.plus_pin(comparator, csr) else { continue };
            let plus = self.wires.volts(at, pin);
            let inverted = csr.polarity().to_bits() != 0;
            let was = (before >> comparator & 1 != 0) ^ inverted;
            // Rises above the threshold, falls below it by the hysteresis: steps of 10 mV (24.6.1,
            // HYST).
            let hysteresis = f64::from(csr.hyst().to_bits()) * 0.01;
            let above = plus > if was { threshold - hysteresis } else { threshold };
            let output = self.stuck_comparators[comparator as usize].unwrap_or(above ^ inverted);
            self.compared = self.compared & !(1 << comparator) | u8::from(output) << comparator;
            self.regs[address] = self.regs[address] & !VALUE | if output { VALUE } else { 0 };
        }
        if self.compared != before {
            self.update_breaks(at, ports);
        }
    }

    /// Returns `true` if any comparator is on.
    pub(crate) fn compares(&self) -> bool {
        (0..COUNT).any(|comparator| self.regs[COMP1 + 4 * comparator] & 1 != 0)
    }

    /// Writes OPAMPx_CSR (25.5). A follower has no effect beyond the DAC's code; other modes are
    /// refused.
    pub(crate) fn write_opamp(&mut self, now: Now, address: u32, value: u32) -> Result<(), Fault> {
        if !(address - OPAMP1).is_multiple_of(4) || address >= OPAMP1 + 0x18 {
            return self.refuse(now, address, "the timer-controlled multiplexer");
        }
        let old = self.regs[address];
        if old & LOCK != 0 {
            let bits = value ^ old;
            return if bits == 0 { Ok(()) } else { self.report(now, address, bits, value, Rule::Locked) };
        }
        self.refuse_bits(now, address, value, 1 << 1 | 1 << 11)?;
        let csr = OpampCsr(value);
        if csr.opampen() && (csr.vm_sel().to_bits() != 3 || csr.pga_gain().to_bits() != 0) {
            return self.refuse(now, address, "a mode that is not a follower");
        }
        self.regs[address] = value;
        Ok(())
    }
}
