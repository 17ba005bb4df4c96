//! Controller and plant of a scene, block by block, for a loop in Python. Codes are passed as bytes
//! of unsigned 16-bit numbers in the order of the machine.

use std::sync::{Mutex, MutexGuard, PoisonError};

use firmware::seam::block::{
    Amplitude, BeltSense, Codes, DriveBlock, Gate, LATENCY_BLOCKS, SenseBlock, SlowSense, Target, dropped_from,
};
use firmware::seam::telemetry::Telemetry as Report;
use hal_mock::analog::Analog;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyComplex};
use sim::stepping::{OrderError, Playing, Stepping};

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

/// The controller of a scene, in the caller's loop.
#[pyclass(frozen, module = "sonoglide._native")]
pub struct Controller {
    stepping: Mutex<(Stepping, SenseBlock, DriveBlock)>,
    silence: DriveBlock,
}

impl Controller {
    fn stepping(&self) -> MutexGuard<'_, (Stepping, SenseBlock, DriveBlock)> {
        self.stepping.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives an order.
    fn order(&self, order: impl FnOnce(&mut Stepping) -> Result<(), OrderError>) -> PyResult<()> {
        order(&mut self.stepping().0).map_err(|error| PyValueError::new_err(error.to_string()))
    }
}

#[pymethods]
impl Controller {
    #[new]
    fn new(scene: &Scene) -> PyResult<Self> {
        let stepping = Stepping::new(&driven(scene)?).map_err(|error| run_error(&error))?;
        let silence = stepping.silence();
        Ok(Controller { stepping: Mutex::new((stepping, SenseBlock::default(), silence.clone())), silence })
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
        let (stepping, sense, drive) = &mut *self.stepping();
        (sense.v, sense.i) = (codes(v, stepping.samples)?, codes(i, stepping.samples)?);
        let (counts, force, temperature) = slow;
        let belt = counts.map(|counts| BeltSense { counts, broken: false });
        sense.slow = SlowSense { belt, force, temperature, ..SlowSense::default() };
        stepping.process(sense, drive).map_err(|lost| RunError::new_err(lost.to_string()))?;
        Ok((lanes(py, drive)?, drive.drops_queue, drive.listen, Telemetry(stepping.report)))
    }

    /// Orders a run with the drive always on, at a voltage or a motional current, or as the scene.
    fn drive(&self, volts: Option<f32>, motional_a: Option<f32>, detune_hz: Option<f32>) -> PyResult<()> {
        let amplitude = match (volts, motional_a) {
            (Some(_), Some(_)) => return Err(PyValueError::new_err("give a voltage or a motional current, not both")),
            (Some(volts), None) => Some(Amplitude::Volts(volts)),
            (None, Some(amperes)) => Some(Amplitude::MotionalCurrent(amperes)),
            (None, None) => None,
        };
        self.order(|stepping| stepping.drive(amplitude, detune_hz))
    }

    /// Orders the gate of the drive: `on`, `off`, `brake`, or the bursts of the scene, `scheduled`.
    fn gate(&self, name: &str) -> PyResult<()> {
        let all = [("scheduled", Gate::Scheduled), ("on", Gate::On), ("off", Gate::Off), ("brake", Gate::Brake)];
        let gate = all.iter().find(|(known, _)| *known == name).map(|(_, gate)| *gate);
        let gate = gate.ok_or_else(|| PyValueError::new_err(format!("there is no gate `{name}`")))?;
        self.stepping().0.gate(gate);
        Ok(())
    }

    /// Orders a friction ratio or a friction force. The friction switch then sets the amplitude.
    fn friction(&self, ratio: Option<f32>, newtons: Option<f32>) -> PyResult<()> {
        let target = match (ratio, newtons) {
            (Some(ratio), None) => Target::Ratio(ratio),
            (None, Some(newtons)) => Target::Force(newtons),
            _ => return Err(PyValueError::new_err("give a friction ratio or a friction force")),
        };
        self.order(|stepping| stepping.friction(target))
    }

    /// Orders silence, and clears a fault if wanted.
    fn stop(&self, clear_fault: bool) {
        self.stepping().0.stop(clear_fault);
    }

    /// Returns a block of silence, lane after lane.
    fn silence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        lanes(py, &self.silence)
    }

    /// Returns lanes, samples in a block, samples per second, blocks of latency, and the sample
    /// from which a dropped queue is silent.
    #[getter]
    fn shape(&self) -> (usize, usize, f64, usize, usize) {
        let stepping = &self.stepping().0;
        let (lanes, samples) = (self.silence.lanes.len(), stepping.samples);
        (lanes, samples, stepping.sample_hz, LATENCY_BLOCKS, dropped_from(samples))
    }

    /// Returns mid-code and largest code of the sense channels, their volts and amperes per code,
    /// mid-code of the drive, and its volts per code.
    #[getter]
    fn scale(&self) -> (u16, u16, f32, f32, u16, f32) {
        let front = &self.stepping().0.front_end;
        let sense = (front.sense_mid_code, front.sense_max_code, front.volt_per_lsb, front.ampere_per_lsb);
        (sense.0, sense.1, sense.2, sense.3, front.drive_mid_code, front.drive_volt_per_lsb)
    }
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
    playing: Mutex<(Playing, DriveBlock, SenseBlock)>,
    lanes: usize,
    samples: usize,
}

impl Plant {
    fn playing(&self) -> MutexGuard<'_, (Playing, DriveBlock, SenseBlock)> {
        self.playing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl Plant {
    #[new]
    fn new(scene: &Scene) -> PyResult<Self> {
        let driven = driven(scene)?;
        let playing = Mutex::new((Playing::new(&driven), DriveBlock::default(), SenseBlock::default()));
        Ok(Plant { playing, lanes: driven.controller.drive.lanes.into(), samples: driven.controller.block_samples.into() })
    }

    /// Plays one block, lane after lane, and returns the codes of voltage and current, and the slow
    /// readings.
    fn step<'py>(&self, py: Python<'py>, drive: &[u8], listen: u8) -> PyResult<(Bound<'py, PyBytes>, Bound<'py, PyBytes>, Slow)> {
        if drive.len() != 2 * self.lanes * self.samples || usize::from(listen) >= self.lanes {
            let said = format!("a block has {} lanes of {} samples, and listens to one of them", self.lanes, self.samples);
            return Err(PyValueError::new_err(said));
        }
        let (playing, block, sense) = &mut *self.playing();
        let lanes = drive.chunks(2 * self.samples).map(|lane| codes(lane, self.samples));
        block.lanes = lanes.collect::<PyResult<Vec<_>>>()?.into_iter().take(block.lanes.capacity()).collect();
        block.listen = listen;
        playing.exchange(block, sense);
        let slow = (sense.slow.belt.map(|belt| belt.counts), sense.slow.force, sense.slow.temperature);
        Ok((bytes(py, &sense.v)?, bytes(py, &sense.i)?, slow))
    }

    /// Hash of all codes that were played.
    #[getter]
    fn drive_hash(&self) -> String {
        format!("{:016x}", self.playing().0.drive_hash())
    }

    /// The truth about the last block, which a controller never receives: name with unit, value.
    #[getter]
    fn truth(&self) -> Vec<(&'static str, f64)> {
        let playing = self.playing();
        let truth = playing.0.plant().truth();
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
