//! Timing of the ADCs. RM0440 21.4.3, 21.4.12, 21.4.16; DS12288, ADC characteristics.

use cortex_m4::Fault;
use stm32_metapac::adc::regs::{Smpr, Smpr2};

use crate::adc::BASES;
use crate::map::at;
use crate::map::at::adc as reg;
use crate::map::base::RCC;
use crate::part::{Now, Stm32g474};
use crate::wires::Wires;

/// Sampling times, ADC cycles (21.4.12).
const SAMPLING: [f64; 8] = [2.5, 6.5, 12.5, 24.5, 47.5, 92.5, 247.5, 640.5];
/// ADC cycles from a trigger to the start of the sampling, by CKMODE (DS12288, ADC characteristics,
/// t_LATR); the maximum for an asynchronous clock.
const LATENCY: [f64; 4] = [2.5, 2.0, 2.25, 2.125];

impl<W: Wires> Stm32g474<W> {
    /// Returns the core cycles of an ADC cycle; `None` without a clock (21.4.3).
    pub(crate) fn adc_period(&self, index: usize) -> Option<f64> {
        let ccr = self.adc_ccr(index);
        match ccr.ckmode().to_bits() {
            0 => {
                let select = self.regs[RCC + at::rcc::CCIPR] >> (if index < 2 { 28 } else { 30 }) & 3;
                let kernel = match select {
                    1 => self.pll_p(),
                    2 => self.system_hz(),
                    _ => return None,
                };
                const PRESCALERS: [u32; 12] = [1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256];
                let prescaler = PRESCALERS.get(usize::from(ccr.presc().to_bits()))?;
                Some(f64::from(*prescaler) * self.time.hz() as f64 / kernel as f64)
            }
            mode => Some(f64::from(1 << (mode - 1))),
        }
    }

    /// Returns the sampling time of a place in the sequence, ADC cycles.
    fn sampling(&self, index: usize, rank: usize) -> f64 {
        let channel = self.channel(index, rank);
        let smpr = Smpr(self.regs[BASES[index] + reg::SMPR]);
        let time = if channel < 10 {
            smpr.smp(usize::from(channel))
        } else {
            Smpr2(self.regs[BASES[index] + reg::SMPR2]).smp(usize::from(channel) - 10)
        };
        match time.to_bits() {
            // SMPPLUS changes 2.5 cycles to 3.5 (21.7.6).
            0 if smpr.smpplus() => 3.5,
            code => SAMPLING[usize::from(code)],
        }
    }

    /// Computes the times of an ADC: when its group is started, after which its registers do not
    /// change, and when the clock changes.
    pub(crate) fn time_adc(&mut self, now: Now, index: usize) -> Result<(), Fault> {
        let Some(period) = self.adc_period(index) else {
            return self.refuse(now, BASES[index] + reg::CR, "an ADC without a clock");
        };
        let latency = LATENCY[usize::from(self.adc_ccr(index).ckmode().to_bits())] * period;
        let sampling = std::array::from_fn(|rank| self.sampling(index, rank) * period);
        let adc = &mut self.adcs[index];
        (adc.period, adc.latency, adc.sampling) = (period, latency, sampling);
        Ok(())
    }

    /// Computes the times of all started ADCs after a change of the clock.
    pub(crate) fn retime_adcs(&mut self, now: Now) -> Result<(), Fault> {
        for index in 0..5 {
            if self.adc_cr(index).adstart() {
                self.time_adc(now, index)?;
            }
        }
        Ok(())
    }
}
