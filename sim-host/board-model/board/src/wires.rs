//! Circuit at the pins of the Nucleo-G474RE: amplifier, plant, sense channels, emergency stop and
//! the host's serial line.
//!
//! ```text
//! DAC1, or DAC3 and DAC4 -> amplifiers, while PA10 is high -> plant -> V (PA0), I (PA1 and PA7), of the lane of PC8 and PC9
//! encoder (PB2, PC12, PC10, PC11), force (PB0) <- plant
//! PC3 <- closed contact of the emergency stop          LPUART1 <-> host
//! PA6 <- fault output of the amplifier                 PA9 -> status LED
//! ```
//!
//! Offset, noise and rounding of the converters are part of the scene's plant. A plant returns the
//! sum of the conversions of a sample. The pin gives half of that sum to each of the two
//! conversions of the microcontroller.

use std::collections::VecDeque;

use cortex_m4::Cycle;
use firmware::seam::block::MAX_LANES;
use nucleo_g474re::config::{CONVERSIONS, SILENCE};
use plant::Plant;
use plant::stream::Stream;
use scene::Driven;
use stm32g474::{Drive, Level, Pin, Received, Wires};

use crate::reset::Reset;
use crate::sensors::Sensors;

/// Address pins of the multiplexer of the sense channels.
const LISTEN: [Pin; 2] = [Pin::new('C', 8), Pin::new('C', 9)];
/// Input of the force channel.
const FORCE: Pin = Pin::new('B', 0);
/// Amplifier enable.
const ENABLE: Pin = Pin::new('A', 10);
/// Input of the voltage channel.
const VOLTAGE: Pin = Pin::new('A', 0);
/// Inputs of the current channel, and of the comparator of its negative trip.
const CURRENT: [Pin; 2] = [Pin::new('A', 1), Pin::new('A', 7)];
/// Emergency stop: high while it is not pressed.
const STOP: Pin = Pin::new('C', 3);
/// Fault output of the amplifier, open drain: low during a fault.
const AMPLIFIER_FAULT: Pin = Pin::new('A', 6);
/// Status LED.
const LED: Pin = Pin::new('A', 9);
/// Cycles of a sample: 170 MHz / 1 MHz.
const SAMPLE_CYCLES: Cycle = 170;
/// Voltage per code of the ADC, V.
const VOLT_PER_CODE: f64 = 3.3 / 4096.0;
/// Code of zero at the sense channels, for one conversion.
const ZERO: u16 = 2048;

/// Change of the amplifier's enable, or of the status LED.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Cycle of the change.
    pub at: Cycle,
    /// New level.
    pub high: bool,
}

/// Plant, and state of the scene's time.
#[derive(Clone, Debug)]
enum Scene {
    /// At rest: until the image has its command, each block begins with the initial plant of the
    /// scene.
    Waiting { fresh: Box<Stream>, now: Box<Stream> },
    /// Scene in progress.
    Running(Box<Stream>),
}

/// Circuit at the pins of a board.
#[derive(Clone, Debug)]
pub struct Bench {
    scene: Scene,
    /// Codes of the two conversions of the current sample, of voltage and of current.
    conversions: [[u16; CONVERSIONS as usize]; 2],
    /// First cycle of the current sample.
    began: Cycle,
    /// Number of samples played since the first trigger of the DAC.
    samples: usize,
    /// Codes at the DACs in these samples, of each lane, if they are recorded.
    pub codes: Option<Vec<[u16; MAX_LANES]>>,
    /// Number of lanes: up to two by DAC1, more by DAC3 and DAC4.
    lanes: u8,
    sensors: Sensors,
    /// Lane whose voltage and current are measured.
    listen: u8,
    block_samples: usize,
    /// `true` if PA4 is wired to the inputs of both sense channels: the plant stays at rest, and
    /// its noise and offset remain.
    pub jumper: bool,
    /// `true` if the scene begins with the next block.
    ordered: bool,
    first_block: Option<usize>,
    enabled: bool,
    /// Changes of the enable so far.
    pub edges: Vec<Edge>,
    /// First cycle of the last sample in which the amplifier was on with a code other than silence.
    pub last_driven: Cycle,
    /// First sample with a code other than silence while the amplifier was off, which gives zero
    /// volts.
    pub first_lost: Option<usize>,
    /// Resets of the microcontroller so far.
    pub resets: Vec<Reset>,
    /// Cycle from which the emergency stop is pressed, or its wire broken.
    stop_pressed: Option<Cycle>,
    /// Cycle from which the amplifier reports a fault.
    amplifier_failed: Option<Cycle>,
    /// Changes of the status LED so far.
    pub led: Vec<Edge>,
    /// Analog pins that are tied to a voltage, V, from a cycle on.
    tied: Vec<(Cycle, Pin, f64)>,
    /// Cycles of planned changes that the microcontroller has not read yet, in order.
    changes: VecDeque<Cycle>,
    /// Number of next bytes to the board that arrive with a low stop bit.
    pub bad_stop_bits: u32,
    /// Codes in the DACs, of each lane.
    held: [u16; MAX_LANES],
    /// Bytes in transit to the board.
    pub to_board: VecDeque<u8>,
    /// Bytes that the board has sent.
    pub to_host: VecDeque<u8>,
}

impl Bench {
    /// Creates a circuit whose plant waits for the run command, with `block_samples` samples per
    /// block and `lanes` lanes. `record` records the codes at the DACs.
    pub fn new(scene: &Driven, lanes: u8, block_samples: usize, record: bool) -> Self {
        let plant = Stream::new(Plant::new(scene), lanes.into(), block_samples);
        let sensors = Sensors::new(scene);
        let scene = Scene::Waiting { fresh: Box::new(plant.clone()), now: Box::new(plant) };
        Bench {
            scene,
            conversions: [[ZERO; CONVERSIONS as usize]; 2],
            began: 0,
            samples: 0,
            codes: record.then(Vec::new),
            lanes,
            sensors,
            listen: 0,
            block_samples,
            jumper: false,
            ordered: false,
            first_block: None,
            enabled: false,
            edges: Vec::new(),
            last_driven: 0,
            first_lost: None,
            resets: Vec::new(),
            stop_pressed: None,
            amplifier_failed: None,
            led: Vec::new(),
            tied: Vec::new(),
            changes: VecDeque::new(),
            bad_stop_bits: 0,
            held: [SILENCE; MAX_LANES],
            to_board: VecDeque::new(),
            to_host: VecDeque::new(),
        }
    }

    /// Starts the scene's time at the next block.
    pub fn begin(&mut self) {
        self.ordered = true;
    }

    /// Returns the first block of the scene, counted from the first played block; `None` before the
    /// scene has begun.
    pub fn first_block(&self) -> Option<usize> {
        self.first_block
    }

    /// Presses the emergency stop at a future cycle; its contact stays open.
    pub fn press_stop(&mut self, at: Cycle) {
        self.stop_pressed = Some(at);
        self.plan(at);
    }

    /// Sets the cycle from which the amplifier reports a fault; `None` clears it.
    pub fn fail_amplifier(&mut self, at: Option<Cycle>) {
        self.amplifier_failed = at;
    }

    /// Ties an analog pin to a voltage, V, from a future cycle on: a broken wire, or a short.
    pub fn tie(&mut self, at: Cycle, pin: Pin, volts: f64) {
        self.tied.push((at, pin, volts));
        self.plan(at);
    }

    /// Plans a change, so that the microcontroller reads the pins at a cycle.
    fn plan(&mut self, at: Cycle) {
        self.changes.push_back(at);
        self.changes.make_contiguous().sort_unstable();
    }

    /// Removes the changes that the microcontroller has read.
    fn mark_read(&mut self, at: Cycle) {
        while self.changes.front().is_some_and(|change| *change <= at) {
            self.changes.pop_front();
        }
    }

    /// Returns the code of the first lane's DAC, even if the amplifier is off.
    pub fn code(&self) -> u16 {
        self.held[0]
    }

    /// Returns the number of samples played since the first trigger of the DAC.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Returns `true` if the amplifier is on.
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Advances the plant with the held code if triggers are missing.
    fn catch_up(&mut self, at: Cycle) {
        while self.samples > 0 && at >= self.began + 2 * SAMPLE_CYCLES {
            self.began += SAMPLE_CYCLES;
            self.play();
        }
    }

    /// Returns the plant.
    pub fn plant(&self) -> &Stream {
        match &self.scene {
            Scene::Waiting { now, .. } => now,
            Scene::Running(plant) => plant,
        }
    }

    fn begin_block(&mut self) {
        if let Scene::Waiting { fresh, now } = &mut self.scene {
            if self.ordered {
                self.first_block = Some(self.samples / self.block_samples);
                self.scene = Scene::Running(fresh.clone());
            } else {
                now.clone_from(fresh);
            }
        }
    }

    fn play(&mut self) {
        if self.samples.is_multiple_of(self.block_samples) {
            self.begin_block();
        }
        self.samples += 1;
        if let Some(codes) = &mut self.codes {
            codes.push(self.held);
        }
        let (plant, under_way) = match &mut self.scene {
            Scene::Waiting { now, .. } => (now, false),
            Scene::Running(plant) => (plant, true),
        };
        let driven = if self.enabled && !self.jumper { self.held } else { [SILENCE; MAX_LANES] };
        if driven != self.held && !self.jumper && self.first_lost.is_none() {
            self.first_lost = Some(self.samples - 1);
        }
        if driven != [SILENCE; MAX_LANES] {
            self.last_driven = self.began;
        }
        let (v, i) = plant.play(driven, self.listen);
        if self.samples.is_multiple_of(self.block_samples) {
            self.sensors.update(*plant.slow(), under_way);
        }
        let moved = if self.jumper { i32::from(CONVERSIONS) * (i32::from(self.held[0]) - i32::from(SILENCE)) } else { 0 };
        let [v, i] = [v, i].map(|sum| (i32::from(sum) + moved).clamp(0, i32::from(CONVERSIONS) * 4095) as u16);
        self.conversions = [v, i].map(|sum| [sum / CONVERSIONS, sum - sum / CONVERSIONS]);
    }
}

impl Wires for Bench {
    fn dac(&mut self, at: Cycle, dac: u8, codes: [u16; 2], triggered: bool) {
        // The other DACs give the thresholds of the comparators.
        let place = match (dac, self.lanes > 2) {
            (1, false) | (3, true) => 0,
            (4, true) => 2,
            _ => return,
        };
        // Of two DACs with the same trigger the last one completes the sample.
        let last = place + 2 >= usize::from(self.lanes);
        if !triggered || place == 0 {
            self.catch_up(at);
        }
        self.held[place..place + 2].copy_from_slice(&codes);
        if triggered && last {
            self.began = at;
            self.play();
        }
    }

    fn volts(&mut self, at: Cycle, pin: Pin) -> f64 {
        self.mark_read(at);
        if let Some((.., volts)) = self.tied.iter().rev().find(|(from, tied, _)| *tied == pin && *from <= at) {
            return *volts;
        }
        self.catch_up(at);
        if pin == FORCE
            && let Some(code) = self.sensors.force_code()
        {
            return f64::from(code) * VOLT_PER_CODE;
        }
        let channel = match pin {
            VOLTAGE => 0,
            pin if CURRENT.contains(&pin) => 1,
            // An unconnected pin has half of the supply.
            _ => return f64::from(ZERO) * VOLT_PER_CODE,
        };
        let conversion = usize::from(at - self.began >= SAMPLE_CYCLES / 2);
        f64::from(self.conversions[channel][conversion]) * VOLT_PER_CODE
    }

    fn output(&mut self, at: Cycle, pin: Pin, level: Level) {
        let high = level == Level::High;
        if let Some(bit) = LISTEN.iter().position(|listen| *listen == pin) {
            self.listen = self.listen & !(1 << bit) | u8::from(high) << bit;
        }
        if pin == LED && high != self.led.last().is_some_and(|edge| edge.high) {
            self.led.push(Edge { at, high });
        }
        if pin == ENABLE && high != self.enabled {
            self.enabled = high;
            self.edges.push(Edge { at, high });
        }
    }

    fn inputs(&mut self, at: Cycle, port: u8) -> Drive {
        self.mark_read(at);
        let closed = port == STOP.port && self.stop_pressed.is_none_or(|pressed| at < pressed);
        let high = if closed { 1 << STOP.number } else { 0 };
        let failed = port == AMPLIFIER_FAULT.port && self.amplifier_failed.is_some_and(|failed| at >= failed);
        let low = if failed { 1 << AMPLIFIER_FAULT.number } else { 0 };
        self.sensors.levels(port, Drive { driven: high | low, high })
    }

    fn encoder(&mut self, at: Cycle) -> i32 {
        self.catch_up(at);
        self.sensors.counts()
    }

    fn celsius(&mut self, _at: Cycle) -> f64 {
        self.sensors.celsius()
    }

    fn due(&self) -> Cycle {
        self.changes.front().copied().unwrap_or(Cycle::MAX)
    }

    fn byte_due(&self) -> Cycle {
        if self.to_board.is_empty() { Cycle::MAX } else { 0 }
    }

    fn receive(&mut self, _at: Cycle) -> Option<Received> {
        let byte = self.to_board.pop_front()?;
        let framing = self.bad_stop_bits > 0;
        self.bad_stop_bits -= u32::from(framing);
        Some(Received { byte, framing, ..Received::default() })
    }

    fn reset(&mut self, at: Cycle, flags: u32) {
        // A reset DAC has no output (22.4.2), and the amplifier is off.
        self.catch_up(at);
        self.held = [SILENCE; MAX_LANES];
        self.resets.push(Reset { at, flags });
    }

    fn sent(&mut self, _at: Cycle, byte: u8) {
        self.to_host.push_back(byte);
    }
}
