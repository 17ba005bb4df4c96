//! Controller and plant of a scene, block by block, for a loop in Python. Codes are passed as bytes
//! of unsigned 16-bit numbers in the order of the machine.

use std::sync::{Mutex, MutexGuard, PoisonError};

use firmware::seam::block::{
    Amplitude, BeltSense, Codes, DriveBlock, Gate, LATENCY_BLOCKS, Orders, Request, SenseBlock, SlowSense, Target, dropped_from,
};
use firmware::seam::config::FrontEnd;
use firmware::seam::telemetry::Telemetry as Report;
use firmware::seam::units::Hertz;
use hal_mock::analog::Analog;
use hal_mock::fault_injector::FaultInjector;
use hal_mock::tracer::DriveHash;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyComplex};
use sim::processor::{Here, Processor};
use sim::run::{Script, breakable_plant};

use crate::errors::{RunError, SceneError, run_error};
use crate::scene::Scene;

/// Slow readings: counts of the encoder, force, N, temperature at the driver, degrees Celsius.
type Slow = (Option<i32>, Option<f32>, Option<f32>);

/// Converts bytes to codes.
fn codes(bytes: &[u8], samples: usize) -> PyResult<Codes> {
    if bytes.len() != 2 * samples {
        return Err(PyValueError::new_err(format!("{} codes are given, but a block has {samples} samples", bytes.len() / 2)));
    }
    Ok(bytes.as_chunks().0.iter().map(|&pair| u16::from_ne_bytes(pair)).collect())
}

/// Converts codes to bytes.
fn bytes<'py>(py: Python<'py>, codes: &[u16]) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, 2 * codes.len(), |into| {
        into.as_chunks_mut().0.iter_mut().zip(codes).for_each(|(pair, code)| *pair = code.to_ne_bytes());
        Ok(())
    })
}

/// Converts the lanes of a block to bytes, lane after lane.
fn lanes<'py>(py: Python<'py>, drive: &DriveBlock) -> PyResult<Bound<'py, PyBytes>> {
    bytes(py, &drive.lanes.iter().flatten().copied().collect::<Vec<u16>>())
}

/// State of a controller.
struct Stepping {
    here: Here,
    script: Script,
    /// While `true`, the friction steps of the scene are ordered; the first order of the caller
    /// ends this.
    scripted: bool,
    sense: SenseBlock,
    drive: DriveBlock,
    report: Report,
    block: u64,
}

/// The controller of a scene, in the caller's loop.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Controller {
    stepping: Mutex<Stepping>,
    front_end: FrontEnd,
    sample_hz: f64,
    samples: usize,
    silence: DriveBlock,
    detune: Hertz,
    switches_friction: bool,
}

impl Controller {
    fn stepping(&self) -> MutexGuard<'_, Stepping> {
        self.stepping.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives an order of the caller, from the next block on. The friction steps of the scene end.
    fn change(&self, order: impl FnOnce(&mut Orders)) {
        let mut stepping = self.stepping();
        let orders = &mut stepping.script.orders;
        orders.sequence += 1;
        orders.clear_fault = false;
        order(orders);
        stepping.scripted = false;
    }
}

#[pymethods]
impl Controller {
    #[new]
    fn new(scene: &Scene) -> PyResult<Self> {
        let driven = driven(scene)?;
        let config = scene::settings::config(&driven);
        let here = Here::new(&config).map_err(|error| run_error(&sim::run::RunError::from(error)))?;
        let silence = here.silence();
        Ok(Controller {
            stepping: Mutex::new(Stepping {
                here,
                script: Script::new(&driven),
                scripted: true,
                sense: SenseBlock::default(),
                drive: silence.clone(),
                report: Report::default(),
                block: 0,
            }),
            front_end: config.front_end,
            sample_hz: f64::from(config.sample_hz),
            samples: config.block_samples.into(),
            silence,
            detune: Hertz(driven.controller.drive.detune_hz as f32),
            switches_friction: driven.controller.friction.is_some(),
        })
    }

    /// Processes the codes of one block. Returns the codes to play, lane after lane, `true` if the
    /// queued codes must not play any longer, the lane to listen to, and the report.
    fn process<'py>(
        &self,
        py: Python<'py>,
        v: &[u8],
        i: &[u8],
        slow: Slow,
    ) -> PyResult<(Bound<'py, PyBytes>, bool, u8, Telemetry)> {
        let mut stepping = self.stepping();
        let Stepping { here, script, scripted, sense, drive, report, block } = &mut *stepping;
        (sense.v, sense.i) = (codes(v, self.samples)?, codes(i, self.samples)?);
        let (counts, force, temperature) = slow;
        let belt = counts.map(|counts| BeltSense { counts, broken: false });
        sense.slow = SlowSense { belt, force, temperature, ..SlowSense::default() };
        if *scripted {
            script.order_friction(*block as f64 * self.samples as f64 / self.sample_hz);
        }
        here.process_into(&script.orders, sense, drive, report).map_err(|lost| RunError::new_err(lost.to_string()))?;
        if *scripted {
            script.follow(report.mode);
        }
        *block += 1;
        Ok((lanes(py, drive)?, drive.drops_queue, drive.listen, Telemetry(*report)))
    }

    /// Orders a run with the drive always on, at a voltage or a motional current, or as the scene.
    fn drive(&self, volts: Option<f32>, motional_a: Option<f32>, detune_hz: Option<f32>) -> PyResult<()> {
        let amplitude = match (volts, motional_a) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("give a voltage or a motional current, not both")),
            (Some(volts), None) => Some(Amplitude::Volts(positive(volts)?)),
            (None, Some(amperes)) => Some(Amplitude::MotionalCurrent(positive(amperes)?)),
            (None, None) => None,
        };
        if detune_hz.is_some_and(|hz| !hz.is_finite()) {
            return Err(PyValueError::new_err("the detuning is not a finite number"));
        }
        let scene_hz = self.detune;
        self.change(|orders| {
            (orders.request, orders.gate, orders.amplitude) = (Request::Run, Gate::On, amplitude);
            orders.detune = detune_hz.map_or(scene_hz, Hertz);
            orders.attempt += 1;
        });
        Ok(())
    }

    /// Orders the gate of the drive: `on`, `off`, `brake`, or the bursts of the scene, `scheduled`.
    fn gate(&self, name: &str) -> PyResult<()> {
        let all = [("scheduled", Gate::Scheduled), ("on", Gate::On), ("off", Gate::Off), ("brake", Gate::Brake)];
        let gate = all.iter().find(|(known, _)| *known == name).map(|(_, gate)| *gate);
        let gate = gate.ok_or_else(|| PyValueError::new_err(format!("there is no gate `{name}`")))?;
        self.change(|orders| orders.gate = gate);
        Ok(())
    }

    /// Orders a friction ratio or a friction force. The friction switch then sets the amplitude.
    fn friction(&self, ratio: Option<f32>, newtons: Option<f32>) -> PyResult<()> {
        let target = match (ratio, newtons) {
            (Some(ratio), None) => Target::Ratio(ratio),
            (None, Some(newtons)) => Target::Force(newtons),
            _ => return Err(PyValueError::new_err("give a friction ratio or a friction force")),
        };
        if !self.switches_friction {
            return Err(PyValueError::new_err("the scene has no [controller.friction]"));
        }
        if !target.is_plausible() {
            return Err(PyValueError::new_err("a friction ratio is from 0 to 1, and a friction force is not negative"));
        }
        self.change(|orders| (orders.friction, orders.amplitude) = (Some(target), None));
        Ok(())
    }

    /// Orders silence, and clears a fault if wanted.
    fn stop(&self, clear_fault: bool) {
        self.change(|orders| (orders.request, orders.clear_fault) = (Request::Idle, clear_fault));
    }

    /// Returns a block of silence, lane after lane.
    fn silence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        lanes(py, &self.silence)
    }

    /// Returns lanes, samples in a block, samples per second, blocks of latency, and the sample
    /// from which a dropped queue is silent.
    #[getter]
    fn shape(&self) -> (usize, usize, f64, usize, usize) {
        (self.silence.lanes.len(), self.samples, self.sample_hz, LATENCY_BLOCKS, dropped_from(self.samples))
    }

    /// Returns mid-code and largest code of the sense channels, their volts and amperes per code,
    /// mid-code of the drive, and its volts per code.
    #[getter]
    fn scale(&self) -> (u16, u16, f32, f32, u16, f32) {
        let front = &self.front_end;
        let sense = (front.sense_mid_code, front.sense_max_code, front.volt_per_lsb, front.ampere_per_lsb);
        (sense.0, sense.1, sense.2, sense.3, front.drive_mid_code, front.drive_volt_per_lsb)
    }
}

/// Returns an amplitude that is a finite number, zero or more.
fn positive(value: f32) -> PyResult<f32> {
    let is_valid = value.is_finite() && value >= 0.0;
    is_valid.then_some(value).ok_or_else(|| PyValueError::new_err("an amplitude is a finite number, zero or more"))
}

/// Returns the scene as one that a controller drives.
fn driven(scene: &Scene) -> PyResult<scene::Driven<'_>> {
    scene.loaded().scene.driven().ok_or_else(|| SceneError::new_err("the scene has no [controller]"))
}

/// Report of one block.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Telemetry(Report);

#[pymethods]
impl Telemetry {
    /// Number of the block, from zero.
    #[getter]
    fn block(&self) -> u32 {
        self.0.block
    }

    /// Mode of the controller.
    #[getter]
    fn mode(&self) -> String {
        format!("{:?}", self.0.mode)
    }

    /// Number of the fault for which the drive is muted, or zero.
    #[getter]
    fn fault(&self) -> u8 {
        self.0.fault.map_or(0, |fault| fault.code())
    }

    /// Number of the limit that acts, or zero.
    #[getter]
    fn limit(&self) -> u8 {
        self.0.limit.map_or(0, |limit| limit.code())
    }

    /// `True` if the tracker is locked.
    #[getter]
    fn locked(&self) -> bool {
        self.0.locked
    }

    /// Frequency of the codes returned, Hz.
    #[getter]
    fn frequency_hz(&self) -> f32 {
        self.0.frequency.0
    }

    /// Smoothed estimate of the resonance, Hz.
    #[getter]
    fn resonance_hz(&self) -> f32 {
        self.0.resonance.0
    }

    /// Peak voltage of the codes returned, before the envelope, V.
    #[getter]
    fn drive_v(&self) -> f32 {
        self.0.drive.0
    }

    /// Mean envelope of the codes returned, 0 to 1.
    #[getter]
    fn envelope(&self) -> f32 {
        self.0.envelope
    }

    /// Voltage of the measured block relative to the drive, V peak.
    #[getter]
    fn voltage_v<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        PyComplex::from_doubles(py, self.0.v.re.into(), self.0.v.im.into())
    }

    /// Current of the measured block, A peak.
    #[getter]
    fn current_a<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        PyComplex::from_doubles(py, self.0.i.re.into(), self.0.i.im.into())
    }

    /// Motional current of the measured block, A peak.
    #[getter]
    fn motional_current_a<'py>(&self, py: Python<'py>) -> Bound<'py, PyComplex> {
        PyComplex::from_doubles(py, self.0.motional_current.re.into(), self.0.motional_current.im.into())
    }

    /// Estimate of the friction ratio, if friction is switched.
    #[getter]
    fn friction_ratio(&self) -> Option<f32> {
        self.0.friction.map(|friction| friction.ratio)
    }
}

/// The plant of a scene, in the caller's loop.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Plant {
    playing: Mutex<Playing>,
    lanes: usize,
    samples: usize,
}

impl Plant {
    fn playing(&self) -> MutexGuard<'_, Playing> {
        self.playing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// State of a plant.
struct Playing {
    plant: FaultInjector<plant::Plant>,
    drive: DriveBlock,
    sense: SenseBlock,
    hash: DriveHash,
}

#[pymethods]
impl Plant {
    #[new]
    fn new(scene: &Scene) -> PyResult<Self> {
        let driven = driven(scene)?;
        let plant = breakable_plant(&driven);
        let (drive, sense, hash) = (DriveBlock::default(), SenseBlock::default(), DriveHash::default());
        let (lanes, samples) = (driven.controller.drive.lanes.into(), driven.controller.block_samples.into());
        Ok(Plant { playing: Mutex::new(Playing { plant, drive, sense, hash }), lanes, samples })
    }

    /// Plays one block, lane after lane, and returns the codes of voltage and current, and the slow
    /// readings.
    fn step<'py>(&self, py: Python<'py>, drive: &[u8], listen: u8) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyBytes>, Slow)> {
        if drive.len() != 2 * self.lanes * self.samples || usize::from(listen) >= self.lanes {
            let said = format!("a block has {} lanes of {} samples, and listens to one of them", self.lanes, self.samples);
            return Err(PyValueError::new_err(said));
        }
        let mut playing = self.playing();
        let Playing { plant, drive: block, sense, hash } = &mut *playing;
        let lanes = drive.chunks(2 * self.samples).map(|lane| codes(lane, self.samples));
        block.lanes = lanes.collect::<PyResult<Vec<_>>>()?.into_iter().take(block.lanes.capacity()).collect();
        block.listen = listen;
        plant.exchange(block, sense);
        hash.add(block);
        let slow = (sense.slow.belt.map(|belt| belt.counts), sense.slow.force, sense.slow.temperature);
        Ok((bytes(py, &sense.v)?, bytes(py, &sense.i)?, slow))
    }

    /// Hash of all codes that were played.
    #[getter]
    fn drive_hash(&self) -> String {
        format!("{:016x}", self.playing().hash.value())
    }

    /// The truth about the last block, which a controller never receives: name with unit, value.
    #[getter]
    fn truth(&self) -> Vec<(&'static str, f64)> {
        let playing = self.playing();
        let truth = playing.plant.inner.truth();
        vec![
            ("friction_n", truth.friction_mean_n),
            ("tip_velocity_m_per_s", truth.tip_velocity_m_per_s),
            ("series_resonance_hz", truth.series_resonance_hz),
            ("power_w", truth.power_w),
            ("load_cell_n", truth.load_cell_n),
            ("belt_speed_m_per_s", truth.belt_speed_m_per_s),
        ]
    }
}
