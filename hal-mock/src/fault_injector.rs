//! Middleware on the converters: injects faults between the load and the controller, on schedule or
//! at random.
//!
//! Drive codes pass unchanged; sampled codes are damaged. A scheduled fault begins at its block and
//! lasts until [`FaultInjector::repair`]; an event ([`FaultKind::lasts`]) affects only that block.
//! A random fault affects single blocks. Without scheduled or random faults the middleware changes
//! nothing.

mod encoder;

use firmware::seam::block::{BeltSense, DriveBlock, SenseBlock, Trips};
use firmware::seam::config::FrontEnd;

use crate::analog::Analog;
use crate::chance::Chance;
use crate::fault_injector::encoder::Encoder;

/// Kind of an injected fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// A broken lead: the current channel reads zero current.
    Open,
    /// Voltage and current channel are exchanged.
    Swapped,
    /// The voltage channel stays at its last code.
    SensorStuck,
    /// The current channel is one sample late.
    CurrentLate,
    /// The voltage channel is offset by this number of codes.
    SensorOffset(i16),
    /// Both channels read the end of their range.
    Saturation,
    /// The belt's encoder stays at its last count. Without an encoder, a stationary one is added.
    BeltStopped,
    /// The belt's encoder stays at its last count while the belt moves.
    EncoderStuck,
    /// The belt's encoder continues to count at its last speed.
    EncoderLies,
    /// A line of the belt's encoder is broken.
    EncoderLost,
    /// The force channel stays at its last reading.
    ForceStuck,
    /// The board's temperature sensor reads [`OVERTEMPERATURE_C`].
    Overtemperature,
    /// A block arrives without codes. An event.
    Dropout,
    /// A block is reported missed. An event.
    LateBlock,
    /// The comparator on the current fires. An event.
    OverCurrentTrip,
    /// The amplifier reports a fault. An event.
    AmplifierFault,
    /// The amplifier's supply is outside its permitted range. An event.
    Supply,
}

/// Temperature reading of an overheated board, degrees Celsius.
pub const OVERTEMPERATURE_C: f32 = 200.0;

impl FaultKind {
    /// Returns `true` if the fault lasts until it is repaired. An event affects one block.
    pub fn lasts(self) -> bool {
        !matches!(
            self,
            FaultKind::Dropout
                | FaultKind::LateBlock
                | FaultKind::OverCurrentTrip
                | FaultKind::AmplifierFault
                | FaultKind::Supply
        )
    }
}

/// Fault that begins at a given block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scheduled {
    /// Block at which the fault begins, counted from zero.
    pub at_block: u64,
    /// Kind of the fault.
    pub kind: FaultKind,
}

/// Analog side whose sampled codes are damaged by faults.
#[derive(Clone, Debug)]
pub struct FaultInjector<A> {
    /// Analog side without faults.
    pub inner: A,
    mid_code: u16,
    max_code: u16,
    chance: Chance,
    scheduled: Vec<Scheduled>,
    broken: Vec<FaultKind>,
    by_chance: Vec<(FaultKind, f64)>,
    flip: f64,
    last_voltage_code: u16,
    /// Last current code of the previous block, before any damage.
    last_current_code: u16,
    last_force: Option<f32>,
    encoder: Encoder,
    block: u64,
}

impl<A> FaultInjector<A> {
    /// Creates an injector without faults. The front end defines the codes of zero and of the end
    /// of the range.
    pub fn new(inner: A, front_end: &FrontEnd, seed: u64) -> Self {
        FaultInjector {
            inner,
            mid_code: front_end.sense_mid_code,
            max_code: front_end.sense_max_code,
            chance: Chance::new(seed),
            scheduled: Vec::new(),
            broken: Vec::new(),
            by_chance: Vec::new(),
            flip: 0.0,
            last_voltage_code: front_end.sense_mid_code,
            last_current_code: front_end.sense_mid_code,
            last_force: None,
            encoder: Encoder::default(),
            block: 0,
        }
    }

    /// Adds a fault to the schedule. If its block is past, it begins at the next one.
    pub fn schedule(&mut self, fault: Scheduled) {
        self.scheduled.push(fault);
    }

    /// Makes a fault begin at the next block.
    pub fn strike(&mut self, kind: FaultKind) {
        self.schedule(Scheduled { at_block: self.block, kind });
    }

    /// Ends a lasting fault.
    pub fn repair(&mut self, kind: FaultKind) {
        self.broken.retain(|&broken| broken != kind);
    }

    /// Makes a fault affect each block with this probability.
    pub fn set_chance(&mut self, kind: FaultKind, probability: f64) {
        self.by_chance.retain(|&(other, _)| other != kind);
        self.by_chance.push((kind, probability));
    }

    /// Flips one bit of each sense code with this probability.
    pub fn set_bit_flips(&mut self, probability: f64) {
        self.flip = probability;
    }

    /// Returns the number of blocks so far.
    pub fn blocks(&self) -> u64 {
        self.block
    }

    /// Returns the events of this block, and starts the lasting faults that are due.
    fn next_events(&mut self) -> Vec<FaultKind> {
        if self.scheduled.is_empty() && self.by_chance.is_empty() {
            return Vec::new();
        }
        let block = self.block;
        let due = self.scheduled.extract_if(.., |fault| fault.at_block <= block).map(|fault| fault.kind);
        let (lasting, mut events): (Vec<_>, Vec<_>) = due.partition(|kind| kind.lasts());
        self.broken.extend(lasting);
        events.extend(self.by_chance.iter().filter(|(_, p)| self.chance.strikes(*p)).map(|&(kind, _)| kind));
        events
    }

    fn apply(&mut self, kind: FaultKind, sense: &mut SenseBlock) {
        match kind {
            FaultKind::Open => sense.i.fill(self.mid_code),
            FaultKind::Swapped => std::mem::swap(&mut sense.v, &mut sense.i),
            FaultKind::SensorStuck => sense.v.fill(self.last_voltage_code),
            FaultKind::CurrentLate => {
                let mut late = self.last_current_code;
                sense.i.iter_mut().for_each(|code| std::mem::swap(code, &mut late));
            }
            FaultKind::SensorOffset(codes) => {
                sense.v.iter_mut().for_each(|code| *code = code.saturating_add_signed(codes).min(self.max_code));
            }
            FaultKind::Saturation => {
                sense.v.fill(self.max_code);
                sense.i.fill(self.max_code);
            }
            FaultKind::BeltStopped | FaultKind::EncoderStuck => sense.slow.belt = Some(self.encoder.last()),
            FaultKind::EncoderLies => sense.slow.belt = Some(self.encoder.extrapolate()),
            FaultKind::EncoderLost => sense.slow.belt = Some(BeltSense { broken: true, ..self.encoder.last() }),
            FaultKind::ForceStuck => sense.slow.force = self.last_force,
            FaultKind::Overtemperature => sense.slow.temperature = Some(OVERTEMPERATURE_C),
            FaultKind::Dropout => {
                sense.v.clear();
                sense.i.clear();
            }
            FaultKind::LateBlock => sense.slow.missed_blocks = Some(sense.slow.missed_blocks.unwrap_or(0) + 1),
            FaultKind::AmplifierFault => sense.slow.trips = Some(Trips { amplifier_fault: true, ..Trips::default() }),
            FaultKind::Supply => sense.slow.trips = Some(Trips { supply: true, ..Trips::default() }),
            FaultKind::OverCurrentTrip => sense.slow.trips = Some(Trips { over_current: true, ..Trips::default() }),
        }
    }

    fn flip_bits(&mut self, sense: &mut SenseBlock) {
        if self.flip == 0.0 {
            return;
        }
        let bits = u64::from(u16::BITS - self.max_code.leading_zeros());
        for code in sense.v.iter_mut().chain(&mut sense.i) {
            if self.chance.strikes(self.flip) {
                *code = (*code ^ (1 << self.chance.below(bits))).min(self.max_code);
            }
        }
    }
}

impl<A: Analog> Analog for FaultInjector<A> {
    fn exchange(&mut self, drive: &DriveBlock, sense: &mut SenseBlock) {
        self.inner.exchange(drive, sense);
        self.damage(sense);
    }
}

impl<A> FaultInjector<A> {
    /// Damages the block that was just sampled. For a caller that samples by other means than
    /// [`Analog::exchange`].
    pub fn damage(&mut self, sense: &mut SenseBlock) {
        let events = self.next_events();
        let current_code = sense.i.last().copied();
        let measures =
            |kind: &FaultKind| !matches!(kind, FaultKind::BeltStopped | FaultKind::EncoderStuck | FaultKind::EncoderLies);
        if let Some(belt) = sense.slow.belt.filter(|_| self.broken.iter().all(measures)) {
            self.encoder.update(belt);
        }
        let broken = self.broken.clone();
        broken.iter().chain(&events).for_each(|&kind| self.apply(kind, sense));
        self.flip_bits(sense);
        self.last_force = sense.slow.force;
        self.last_current_code = current_code.unwrap_or(self.last_current_code);
        self.last_voltage_code = sense.v.last().copied().unwrap_or(self.last_voltage_code);
        self.block += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loop_back::{self, LoopBack};

    type Shows = fn(&SenseBlock) -> bool;

    fn injector(seed: u64) -> FaultInjector<LoopBack> {
        let config = loop_back::config();
        FaultInjector::new(LoopBack::of(&config), &config.front_end, seed)
    }

    fn wave() -> DriveBlock {
        DriveBlock { lanes: [(0..32).map(|n| 2000 + 7 * n).collect()].into_iter().collect(), listen: 0, drops_queue: false }
    }

    fn sense(analog: &mut impl Analog) -> SenseBlock {
        let mut sense = SenseBlock::default();
        analog.exchange(&wave(), &mut sense);
        sense
    }

    fn sampled(injector: &mut FaultInjector<LoopBack>, blocks: usize) -> Vec<SenseBlock> {
        (0..blocks).map(|_| sense(injector)).collect()
    }

    #[test]
    fn inactive_it_changes_nothing() {
        let mut bare = LoopBack::of(&loop_back::config());
        assert_eq!(sampled(&mut injector(1), 5), (0..5).map(|_| sense(&mut bare)).collect::<Vec<_>>());
    }

    #[test]
    fn lasting_faults_last_from_their_block_until_repaired() {
        let healthy = sampled(&mut injector(1), 8);
        let cases: [(FaultKind, Shows); 7] = [
            (FaultKind::Open, |sense| sense.i.iter().all(|&code| code == 2048) && sense.v[3] == 2021),
            (FaultKind::Swapped, |sense| sense.i[31] == 2000 + 7 * 31 && sense.v[31] != sense.i[31]),
            (FaultKind::SensorStuck, |sense| sense.v.iter().all(|&code| code == 2000 + 7 * 31) && sense.i[3] != 2048),
            (FaultKind::SensorOffset(-300), |sense| sense.v[0] == 1700 && sense.v[31] == 1917),
            (FaultKind::Saturation, |sense| sense.v.iter().chain(&sense.i).all(|&code| code == 4095)),
            (FaultKind::BeltStopped, |sense| sense.slow.belt == Some(BeltSense::default())),
            (FaultKind::Overtemperature, |sense| sense.slow.temperature == Some(OVERTEMPERATURE_C)),
        ];
        for (kind, shows) in cases {
            let mut injector = injector(1);
            injector.schedule(Scheduled { at_block: 3, kind });
            let got = sampled(&mut injector, 6);
            assert_eq!(got[..3], healthy[..3], "{kind:?}");
            assert!(kind.lasts() && got[3..].iter().all(shows), "{kind:?}: {:?}", got[3]);
            injector.repair(kind);
            assert_eq!(sampled(&mut injector, 2), healthy[6..], "{kind:?}");
        }
    }

    /// The belt moves by three counts a block.
    #[test]
    fn an_encoder_sticks_lies_and_breaks() {
        let counts_after = |kind: FaultKind| {
            let mut injector = injector(1);
            injector.inner.set_belt(Some(3));
            injector.schedule(Scheduled { at_block: 10, kind });
            sampled(&mut injector, 10);
            // The belt stops; a correct encoder would report no motion.
            injector.inner.set_belt(Some(0));
            let sampled = sampled(&mut injector, 5);
            sampled.iter().map(|sense| sense.slow.belt.unwrap()).map(|belt| (belt.counts, belt.broken)).collect::<Vec<_>>()
        };
        assert_eq!(counts_after(FaultKind::EncoderStuck), [(30, false); 5]);
        assert_eq!(counts_after(FaultKind::EncoderLost), [(30, true); 5]);
        assert_eq!(counts_after(FaultKind::EncoderLies), [33, 36, 39, 42, 45].map(|counts| (counts, false)));
    }

    #[test]
    fn events_strike_one_block() {
        let healthy = sampled(&mut injector(1), 4);
        let cases: [(FaultKind, Shows); 3] = [
            (FaultKind::Dropout, |sense| sense.v.is_empty() && sense.i.is_empty()),
            (FaultKind::LateBlock, |sense| sense.slow.missed_blocks == Some(1)),
            (FaultKind::OverCurrentTrip, |sense| sense.slow.trips == Some(Trips { over_current: true, ..Trips::default() })),
        ];
        for (kind, shows) in cases {
            let mut injector = injector(1);
            injector.schedule(Scheduled { at_block: 2, kind });
            let got = sampled(&mut injector, 4);
            assert!(!kind.lasts() && shows(&got[2]), "{kind:?}");
            assert_eq!((&got[..2], &got[3..]), (&healthy[..2], &healthy[3..]), "{kind:?}");
        }
    }

    #[test]
    fn random_faults_have_their_rate_and_are_reproducible() {
        let missed = |seed| {
            let mut injector = injector(seed);
            injector.set_chance(FaultKind::LateBlock, 0.1);
            sampled(&mut injector, 5000).iter().map(|sense| sense.slow.missed_blocks.is_some()).collect::<Vec<_>>()
        };
        let one = missed(1);
        assert!((400..600).contains(&one.iter().filter(|&&struck| struck).count()));
        assert_eq!(one, missed(1));
        assert_ne!(one, missed(2));
    }

    #[test]
    fn flips_single_bits_inside_the_range() {
        let (healthy, mut injector) = (sampled(&mut injector(1), 100), injector(1));
        injector.set_bit_flips(0.05);
        let got = sampled(&mut injector, 100);
        let pairs = healthy.iter().zip(&got).flat_map(|(a, b)| a.v.iter().chain(&a.i).zip(b.v.iter().chain(&b.i)));
        let distances: Vec<u32> = pairs.map(|(a, b)| (a ^ b).count_ones()).collect();
        assert!(distances.iter().all(|&bits| bits <= 1));
        assert!((240..400).contains(&distances.iter().sum::<u32>()), "{}", distances.iter().sum::<u32>());
    }
}
