//! Drive lanes: pairs of DAC channels that step together at each update of TIM3, each pair fed by
//! one circular DMA. RM0440 22 (DAC), 25 (OPAMP).
//!
//! | lanes | converter | output | speed |
//! |---|---|---|---|
//! | 1 or 2 | DAC1 | PA4, PA5, through its own buffers | the buffers reach 1 Msps only for small steps (DS12288, DAC characteristics: the update rate is specified for one code); near full scale at 40 kHz a step is up to 500 codes, so calibration must measure amplitude and phase |
//! | 3 or 4 | DAC3, DAC4 | PB11, PB1, PB12, PA8, through OPAMP6, 3, 4, 5 as fast followers | DAC3 and DAC4 are specified for 15 Msps, the op-amps for 45 V/us (DS12288) |
//!
//! A word of a ring contains two lanes and goes to DAC_DHR12RD with a single request for both
//! (22.4.8). The trigger moves the held word to the output and then requests the next one. A word
//! therefore plays one trigger after it was fetched: [`AHEAD`].

use core::hint::black_box;

use boards_common::packing;
use boards_common::position::position;
use cortex_m::asm::delay;
use firmware::seam::block::DriveBlock;
use nucleo_g474re::blocks::{AHEAD, Half, RING};
use nucleo_g474re::config::SILENCE;
use stm32_metapac::bdma::vals::Pl;
use stm32_metapac::dac::Dac;
use stm32_metapac::dac::vals::Mode;
use stm32_metapac::opamp::Opamp;
use stm32_metapac::opamp::vals::{VmSel, VpSel};
use stm32_metapac::{DAC1, DAC3, DAC4, GPIOA, GPIOB, OPAMP3, OPAMP4, OPAMP5, OPAMP6};

use super::clocks::CYCLES_PER_US;
use super::dma::{Channel, Direction, Place, Ring};
use super::pins::Pin;

const SILENT_WORD: u32 = packing::word(SILENCE, SILENCE);

/// Rings of lanes 0 and 1, and of lanes 2 and 3.
static RINGS: [Ring<u32, RING>; 2] = [Ring::new(SILENT_WORD), Ring::new(SILENT_WORD)];
const CHANNELS: [Channel; 2] = [Channel::of_dma1(1), Channel::of_dma1(2)];

/// Number of TIM3_TRGO among the triggers of all DACs (RM0440 22.4.2, interconnection tables).
const TRIGGER: u8 = 8;
/// Value of DAC_MCR.HFSEL for an AHB clock above 160 MHz (22.7.17).
pub const HFSEL: u8 = 2;
/// DMA request number of channel 1 of DAC1 (RM0440 13.3.2, table of requests).
const DAC1_REQUEST: u8 = 6;
/// DMA request number of channel 1 of DAC3.
const DAC3_REQUEST: u8 = 102;
/// DMA request number of channel 1 of DAC4.
const DAC4_REQUEST: u8 = 104;

/// Converters that play the drive lanes.
pub struct Lanes {
    converters: &'static [Dac],
}

impl Lanes {
    /// Returns `true` if this number of lanes plays from DAC3 and DAC4. Otherwise DAC1 plays, and
    /// DAC3 is free for the thresholds.
    pub fn are_more_than_two(lanes: u8) -> bool {
        lanes > 2
    }

    /// Starts with silence, which plays from the first trigger.
    pub fn start(lanes: u8) -> Self {
        if !Lanes::are_more_than_two(lanes) {
            Pin::new(GPIOA, 4).analog();
            Pin::new(GPIOA, 5).analog();
            start_pair(DAC1, Mode::NORMAL_EXT_BUFEN, DAC1_REQUEST, 0);
            return Lanes { converters: &[DAC1] };
        }
        for pin in [Pin::new(GPIOB, 11), Pin::new(GPIOB, 1), Pin::new(GPIOB, 12), Pin::new(GPIOA, 8)] {
            pin.analog();
        }
        start_pair(DAC3, Mode::NORMAL_INT_BUFDIS, DAC3_REQUEST, 0);
        start_pair(DAC4, Mode::NORMAL_INT_BUFDIS, DAC4_REQUEST, 1);
        // DAC3 channels 1 and 2, DAC4 channels 1 and 2.
        [OPAMP6, OPAMP3, OPAMP4, OPAMP5].into_iter().for_each(configure_follower);
        Lanes { converters: &[DAC3, DAC4] }
    }

    /// Writes a block to a half of the rings.
    pub fn write(&self, half: Half, block: &DriveBlock) {
        for (pair, ring) in RINGS.iter().enumerate().take(self.converters.len()) {
            // `black_box` hides the length: otherwise the compiler unrolls the loop, which would
            // fill the core-coupled RAM.
            let (head, tail) = half.played::<AHEAD, _>(ring.places());
            packing::drive(block, pair, SILENCE, (head, black_box(tail)), Place::write);
        }
    }

    /// Writes mid-code to both halves; it plays from the next sample.
    #[inline(never)]
    pub fn silence(&self) {
        let playing = RINGS.iter().take(self.converters.len());
        playing.for_each(|ring| black_box(ring.places()).iter().for_each(|place| place.write(SILENT_WORD)));
    }

    /// Returns the place in the rings that DMA fetches next.
    pub fn next(&self) -> usize {
        position::<RING>(CHANNELS[0].remaining().into())
    }

    /// Returns `true` if the pairs are fetched together and none has missed a trigger:
    /// DAC_SR.DMAUDR1 (22.7.14), which stops the DMA requests.
    pub fn are_fed(&self) -> bool {
        let missed = self.converters.iter().any(|dac| dac.sr().read().dmaudr(0));
        // Two counters, read one after the other.
        let apart = CHANNELS[0].remaining().abs_diff(CHANNELS[1].remaining());
        !missed && (self.converters.len() == 1 || apart <= 2 || usize::from(apart) >= RING - 2)
    }
}

/// Starts a pair of channels.
fn start_pair(dac: Dac, mode: Mode, request: u8, ring: usize) {
    // DAC_MCR (22.7.17), while both channels are off: destination of the output, and the wait
    // states of the bus.
    dac.mcr().modify(|w| {
        w.set_mode(0, mode);
        w.set_mode(1, mode);
        w.set_hfsel(HFSEL);
    });
    // DAC_DHR12RD (22.7.9): mid-scale before the first fetch.
    dac.dhr12rd().write(|w| {
        w.set_dhr(0, SILENCE);
        w.set_dhr(1, SILENCE);
    });
    CHANNELS[ring].start(request, dac.dhr12rd().as_ptr().cast(), &RINGS[ring], Direction::Out, Pl::HIGH);
    // DAC_CR (22.7.1): on, and at first without trigger, so that the output is at mid-scale at
    // once.
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    // t_WAKEUP (DS12288, DAC characteristics) is a few microseconds.
    delay(10 * CYCLES_PER_US);
    dac.cr().modify(|w| {
        for channel in 0..2 {
            w.set_tsel(channel, TRIGGER);
            w.set_ten(channel, true);
        }
        // One DMA request for both channels.
        w.set_dmaen(0, true);
    });
}

/// Configures an op-amp as a fast follower of its DAC, with output to its pin: OPAMPx_CSR (25.5),
/// follower mode 25.3.5.
fn configure_follower(opamp: Opamp) {
    opamp.csr().modify(|w| {
        // VP_SEL = 11: DAC3_CH1, DAC3_CH2, DAC4_CH1, DAC4_CH2 for OPAMP6, 3, 4, 5 (25.3.3).
        w.set_vp_sel(VpSel::DAC3_CH1);
        w.set_vm_sel(VmSel::OUTPUT);
        w.set_opahsm(true);
        w.set_opaintoen(false);
        w.set_opampen(true);
    });
}
