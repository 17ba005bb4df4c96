//! Block stream as a whole: timers, converters, DMA.

use crate::rig::{ADC_RING, DAC_RING, Rig, Setup};
use cortex_m4::Cycle;
use sonoglide_stm32g474::map::{at, base::*, line};
use sonoglide_stm32g474::{Level, Pin, Wires};

/// Board that records its signals. The voltage at PA0 follows the DAC, that at PA1 is a ramp.
#[derive(Default)]
struct Recorder {
    codes: Vec<(Cycle, u16)>,
    asked: Vec<Cycle>,
    code: u16,
}

impl Wires for Recorder {
    fn dac(&mut self, at: Cycle, dac: u8, codes: [u16; 2], _triggered: bool) {
        if dac == 1 {
            self.codes.push((at, codes[0]));
            self.code = codes[0];
        }
    }

    fn volts(&mut self, at: Cycle, pin: Pin) -> f64 {
        if pin == Pin::new('A', 0) {
            self.asked.push(at);
            return f64::from(self.code) / 4096.0 * 3.3;
        }
        1.0
    }

    fn output(&mut self, _at: Cycle, _pin: Pin, _level: Level) {}
}

fn streaming() -> Rig<Recorder> {
    let mut rig = Rig::on(Recorder::default());
    rig.clocks(Setup::default());
    for place in 0..64_u32 {
        let word = (100 + place) | 3000 << 16;
        rig.memory.get_mut(DAC_RING + 4 * place, 4).unwrap().copy_from_slice(&word.to_le_bytes());
    }
    rig.streams(Setup::default());
    rig
}

#[test]
fn the_stream_of_a_correct_program_has_no_finding() {
    let mut rig = streaming();
    rig.us(100);
    assert_eq!(rig.findings(), []);
    assert_eq!(rig.part.hz(), 170_000_000);
}

#[test]
fn the_dac_plays_its_ring_one_sample_a_microsecond() {
    let mut rig = streaming();
    rig.us(130);
    let codes: Vec<_> = rig.part.wires.codes.iter().skip_while(|(_, code)| *code != 100).copied().collect();
    for (pair, expected) in codes.windows(2).zip((0..64).cycle()).take(120) {
        assert_eq!(pair[1].0 - pair[0].0, 170);
        assert_eq!(pair[0].1, 100 + expected);
    }
}

#[test]
fn both_adcs_sum_two_conversions_a_sample() {
    let mut rig = streaming();
    rig.us(70);
    // Twice 1241, the code of 1 V at a reference of 3.3 V.
    let word = u32::from_le_bytes(rig.memory.get(ADC_RING + 4 * 40, 4).unwrap().try_into().unwrap());
    assert_eq!(word >> 16, 2 * 1241);
    // PA0 follows the DAC, which has one code for both conversions of most samples.
    let code = word & 0xffff;
    assert!((200..=340).contains(&code), "{code}");
    let asked: Vec<_> = rig.part.wires.asked.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(asked.iter().all(|gap| *gap == 85), "{asked:?}");
}

#[test]
fn half_and_end_of_the_ring_raise_the_block_interrupt() {
    let mut rig = streaming();
    rig.us(31);
    assert!(!rig.line(line::DMA1_CHANNEL1));
    rig.us(3);
    assert!(rig.line(line::DMA1_CHANNEL1));
    assert_eq!(rig.read(DMA1) & 0xf, 0b0101);
    rig.write(DMA1 + at::dma::IFCR, 0xe);
    assert!(!rig.line(line::DMA1_CHANNEL1));
    rig.us(32);
    assert_eq!(rig.read(DMA1) & 0xf, 0b0011);
    assert_eq!(rig.read(DMA1 + at::dma::CH_0_NDTR), 64 - 1, "the first sample is stored 2 us after the start");
}

#[test]
fn counters_are_read_between_their_events() {
    let mut rig = streaming();
    rig.us(10);
    let first = rig.read(TIM3 + at::timgp16::CNT);
    rig.wait(10);
    let second = rig.read(TIM3 + at::timgp16::CNT);
    assert_eq!((second + 170 - first) % 170, 12);
    // TIM4 has begun three cycles after the first update of TIM3, and counts to 85.
    let (three, four) = (rig.read(TIM3 + at::timgp16::CNT), rig.read(TIM4 + at::timgp16::CNT));
    assert_eq!((three + 2 + 85 - 3) % 85, four);
}
