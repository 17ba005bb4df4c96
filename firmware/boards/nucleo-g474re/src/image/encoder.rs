//! Encoder of the belt: TIM5 counts every edge of both channels in 32 bits that wrap, as
//! [`BeltSense`] requires. RM0440 29.4.16 (encoder interface).
//!
//! `A` is on PB2, `B` on PC12, their complements on PC10 and PC11; [`Wires`] checks that they are
//! opposite. All pins are pulled down, so that a broken wire is low.

use boards_common::wires::Wires;
use firmware::seam::block::BeltSense;
use stm32_metapac::gpio::vals::Pupdr;
use stm32_metapac::timer::vals::{CcmrInputCcs, FilterValue, Sms};
use stm32_metapac::{GPIOB, GPIOC, TIM5};

use super::pins::Pin;

/// Pin of channel `A`, TIM5_CH1 (DS12288, alternate functions).
const A: Pin = Pin::new(GPIOB, 2);
/// Alternate function of TIM5_CH1 at its pin.
const A_FUNCTION: u8 = 2;
/// Pin of channel `B`, TIM5_CH2 (DS12288, alternate functions).
const B: Pin = Pin::new(GPIOC, 12);
/// Alternate function of TIM5_CH2 at its pin.
const B_FUNCTION: u8 = 1;
const NOT_A: Pin = Pin::new(GPIOC, 10);
const NOT_B: Pin = Pin::new(GPIOC, 11);

/// Encoder of the belt.
pub struct Encoder {
    wires: Wires,
}

impl Encoder {
    /// Starts counting.
    pub fn start() -> Self {
        A.alternate(A_FUNCTION, Pupdr::PULL_DOWN);
        B.alternate(B_FUNCTION, Pupdr::PULL_DOWN);
        NOT_A.input(Pupdr::PULL_DOWN);
        NOT_B.input(Pupdr::PULL_DOWN);
        // CCMR1 (29.5.7): IC1 on TI1, IC2 on TI2, both by value 01. Levels shorter than 8 * 8
        // cycles, 0.4 us, are ignored as glitches.
        TIM5.ccmr_input(0).modify(|w| {
            for channel in 0..2 {
                w.set_ccs(channel, CcmrInputCcs::from_bits(1));
                w.set_icf(channel, FilterValue::FDTS_DIV8_N8);
            }
        });
        // SMCR.SMS = encoder mode 3, every edge of both channels (29.5.3); ARR = all 32 bits
        // (29.5.14); CR1.CEN (29.5.1).
        TIM5.smcr().modify(|w| w.set_sms(Sms::ENCODER_MODE_3));
        TIM5.arr().write_value(u32::MAX);
        TIM5.cr1().modify(|w| w.set_cen(true));
        Encoder { wires: Wires::default() }
    }

    /// Returns the counts so far, TIM5_CNT (29.5.12). They rise while the belt pays out, with `A`
    /// before `B`.
    pub fn read(&mut self) -> BeltSense {
        let broken = self.wires.look([(A.is_high(), NOT_A.is_high()), (B.is_high(), NOT_B.is_high())]);
        BeltSense { counts: TIM5.cnt().read() as i32, broken }
    }
}
