//! Inputs of the ADCs: channels, sequences. RM0440 21.4.11.

use cortex_m4::Fault;
use stm32_metapac::adc::regs::{Sqr1, Sqr2, Sqr3, Sqr4};

use crate::adc::{BASES, common_of};
use crate::finding::Rule;
use crate::map::SIGNALS;
use crate::map::at::{adc as reg, adccommon as common};
use crate::part::{Now, Stm32g474};
use crate::wires::{Pin, Wires};

/// Input of an ADC channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Input {
    Pin(Pin),
    Sensor,
    Reference,
    Unknown,
}

impl<W: Wires> Stm32g474<W> {
    /// Returns the input of a channel (21.4.11, table of the inputs).
    fn input(&self, index: usize, channel: u8) -> Input {
        let internal = match (index, channel) {
            (0, 16) | (4, 4) => Some(Input::Sensor),
            (0 | 2 | 3 | 4, 18) => Some(Input::Reference),
            _ => None,
        };
        let name = format!("ADC{}", index + 1);
        let signal = format!("IN{channel}");
        let pin = || {
            SIGNALS
                .iter()
                .find(|(peripheral, input, ..)| *peripheral == name && *input == signal)
                .and_then(|(.., pin, _)| Pin::named(pin))
        };
        internal.or_else(|| pin().map(Input::Pin)).unwrap_or(Input::Unknown)
    }

    /// Returns the channel of a place in the sequence (21.7.11 to 21.7.14).
    pub(crate) fn channel(&self, index: usize, rank: usize) -> u8 {
        let base = BASES[index];
        match rank {
            0..4 => Sqr1(self.regs[base + reg::SQR1]).sq(rank),
            4..9 => Sqr2(self.regs[base + reg::SQR2]).sq(rank - 4),
            9..14 => Sqr3(self.regs[base + reg::SQR3]).sq(rank - 9),
            _ => Sqr4(self.regs[base + reg::SQR4]).sq(rank - 14),
        }
    }

    /// Reads the sequence at its start.
    pub(crate) fn prepare_adc(&mut self, now: Now, index: usize) -> Result<(), Fault> {
        let length = usize::from(Sqr1(self.regs[BASES[index] + reg::SQR1]).l());
        for rank in 0..=length {
            let channel = self.channel(index, rank);
            let input = self.input(index, channel);
            let ccr = self.adc_ccr(index);
            match input {
                Input::Unknown => return self.refuse(now, BASES[index] + reg::SQR1, &format!("channel {channel}")),
                Input::Sensor if !ccr.vsenseen() => {
                    self.report(now, common_of(index) + common::CCR, 1 << 23, ccr.0, Rule::AdcInternalOff)?;
                }
                Input::Reference if !ccr.vrefen() => {
                    self.report(now, common_of(index) + common::CCR, 1 << 22, ccr.0, Rule::AdcInternalOff)?;
                }
                _ => {}
            }
            self.adcs[index].inputs[rank] = input;
        }
        self.adcs[index].stop();
        self.time_adc(now, index)
    }
}
