//! The drive lanes: pairs of DAC channels that step together at each update of TIM3, fed by one circular DMA a pair. RM0440 22 (DAC), 25 (OPAMP).
//!
//! | lanes | converter | output | |
//! |---|---|---|---|
//! | 1 or 2 | DAC1 | PA4, PA5, through its own buffers | the buffers reach 1 Msps for small steps only (DS12288, DAC characteristics: the update rate is specified for one code); near full scale at 40 kHz a step is up to 500 codes, so that amplitude and phase are what calibration finds them to be |
//! | 3 or 4 | DAC3, DAC4 | PB11, PB1, PB12, PA8, through OPAMP6, 3, 4, 5 as fast followers | DAC3 and DAC4 are made for 15 Msps, the op-amps for 45 V/us (DS12288) |
//!
//! A word of a ring is two lanes, into DAC_DHR12RD with a single request for both (22.4.8). The trigger moves the held word to the output and
//! then asks for the next one, so that a word plays one trigger after it was fetched: [`AHEAD`].

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
use super::dma::{Channel, Place, Ring, Way};
use super::pins::Pin;

const QUIET: u32 = packing::word(SILENCE, SILENCE);

/// What plays: lanes 0 and 1, and lanes 2 and 3.
static RINGS: [Ring<u32, RING>; 2] = [Ring::new(QUIET), Ring::new(QUIET)];
const CHANNELS: [Channel; 2] = [Channel::of_first(1), Channel::of_first(2)];

/// TIM3_TRGO among the triggers of all DACs (RM0440 22.4.2, interconnection tables).
const TRIGGER: u8 = 8;
/// DAC_MCR.HFSEL for an AHB over 160 MHz (22.7.17).
pub const HFSEL: u8 = 2;
/// Requests of the first channel of each DAC (RM0440 13.3.2, table of requests).
const DAC1_REQUEST: u8 = 6;
const DAC3_REQUEST: u8 = 102;
const DAC4_REQUEST: u8 = 104;

/// The converters that play.
pub struct Lanes {
    converters: &'static [Dac],
}

impl Lanes {
    /// Whether so many lanes play from DAC3 and DAC4; otherwise DAC1 plays, and the other one is free for thresholds.
    pub fn are_four(lanes: u8) -> bool {
        lanes > 2
    }

    /// Starts silence; it plays from the first trigger on.
    pub fn start(lanes: u8) -> Self {
        if !Lanes::are_four(lanes) {
            Pin::new(GPIOA, 4).analog();
            Pin::new(GPIOA, 5).analog();
            pair(DAC1, Mode::NORMAL_EXT_BUFEN, DAC1_REQUEST, 0);
            return Lanes { converters: &[DAC1] };
        }
        for pin in [Pin::new(GPIOB, 11), Pin::new(GPIOB, 1), Pin::new(GPIOB, 12), Pin::new(GPIOA, 8)] {
            pin.analog();
        }
        pair(DAC3, Mode::NORMAL_INT_BUFDIS, DAC3_REQUEST, 0);
        pair(DAC4, Mode::NORMAL_INT_BUFDIS, DAC4_REQUEST, 1);
        // DAC3 channels 1 and 2, DAC4 channels 1 and 2.
        [OPAMP6, OPAMP3, OPAMP4, OPAMP5].into_iter().for_each(follow);
        Lanes { converters: &[DAC3, DAC4] }
    }

    /// Leaves a block in a half of the rings.
    pub fn write(&self, half: Half, block: &DriveBlock) {
        for (pair, ring) in RINGS.iter().enumerate().take(self.converters.len()) {
            // A length that the compiler knows it would write out whole, which would fill the core-coupled RAM.
            let (head, tail) = half.played::<AHEAD, _>(ring.places());
            packing::drive(block, pair, SILENCE, (head, black_box(tail)), Place::write);
        }
    }

    /// Plays mid-code from the next sample on, in both halves.
    #[inline(never)]
    pub fn silence(&self) {
        let playing = RINGS.iter().take(self.converters.len());
        playing.for_each(|ring| black_box(ring.places()).iter().for_each(|place| place.write(QUIET)));
    }

    /// The place in the rings that is fetched next.
    pub fn next(&self) -> usize {
        position::<RING>(CHANNELS[0].remaining().into())
    }

    /// Whether the pairs are fetched together, and none has missed a trigger: DAC_SR.DMAUDR1 (22.7.14), which stops its requests.
    pub fn are_fed(&self) -> bool {
        let missed = self.converters.iter().any(|dac| dac.sr().read().dmaudr(0));
        // Of two counters that are read one after the other.
        let apart = CHANNELS[0].remaining().abs_diff(CHANNELS[1].remaining());
        !missed && (self.converters.len() == 1 || apart <= 2 || usize::from(apart) >= RING - 2)
    }
}

/// Starts a pair of channels.
fn pair(dac: Dac, mode: Mode, request: u8, ring: usize) {
    // DAC_MCR (22.7.17), while both are off: where the output goes, and the wait states of the bus.
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
    CHANNELS[ring].start(request, dac.dhr12rd().as_ptr().cast(), &RINGS[ring], Way::Out, Pl::HIGH);
    // DAC_CR (22.7.1): on, and untriggered for a moment, so that the output is at mid-scale at once.
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    // t_WAKEUP (DS12288, DAC characteristics) is some microseconds.
    delay(10 * CYCLES_PER_US);
    dac.cr().modify(|w| {
        for channel in 0..2 {
            w.set_tsel(channel, TRIGGER);
            w.set_ten(channel, true);
        }
        // One request for both.
        w.set_dmaen(0, true);
    });
}

/// Makes an op-amp a fast follower of its DAC, on its pin: OPAMPx_CSR (25.5), follower mode 25.3.5.
fn follow(opamp: Opamp) {
    opamp.csr().modify(|w| {
        // VP_SEL = 11: DAC3_CH1, DAC3_CH2, DAC4_CH1, DAC4_CH2 of OPAMP6, 3, 4, 5 (25.3.3).
        w.set_vp_sel(VpSel::DAC3_CH1);
        w.set_vm_sel(VmSel::OUTPUT);
        w.set_opahsm(true);
        w.set_opaintoen(false);
        w.set_opampen(true);
    });
}
