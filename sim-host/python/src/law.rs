//! A friction law as a function in Python.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use contact::custom::{At, FrictionLaw};
use pyo3::prelude::*;
use scene::Scene;

use crate::errors::SceneError;

/// Friction law that calls a function of slip velocity, m/s, states, sign of the slip velocity and
/// Coulomb force, N. It returns the rates of the states, per second, and the friction, N.
pub struct Law<'a> {
    function: Py<PyAny>,
    /// `true` once the run is to end.
    stop: &'a AtomicBool,
    start: Vec<f64>,
    /// First exception of the function; it is not called again after it.
    raised: Mutex<Option<PyErr>>,
}

impl<'a> Law<'a> {
    /// Creates a law for a scene.
    pub fn new(scene: &Scene, function: Py<PyAny>, start: Vec<f64>, stop: &'a AtomicBool) -> PyResult<Self> {
        let is_single = scene.excited().is_some() && scene.runs == 1 && scene.grid.is_none() && scene.comparison.is_none();
        let is_along = scene.excited().is_some_and(|study| study.excitation.angle_deg == 0.0);
        if !is_single || !is_along {
            let message =
                "a law of your own is for one run of a contact study, without grid, comparison, distributions and angle";
            return Err(SceneError::new_err(message));
        }
        Ok(Law { function, stop, start, raised: Mutex::default() })
    }

    /// Returns the exception of the function, if it has raised one.
    pub fn into_raised(self) -> Option<PyErr> {
        self.raised.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl FrictionLaw for Law<'_> {
    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    fn rates(&self, at: &At, rates: &mut [f64]) -> f64 {
        let mut raised = self.raised.lock().unwrap_or_else(PoisonError::into_inner);
        if raised.is_some() || self.stop.load(Ordering::Relaxed) {
            return f64::NAN;
        }
        let called = Python::attach(|py| {
            let arguments = (at.slip_m_per_s, at.states, at.sign, at.coulomb_n);
            let (found, force): (Vec<f64>, f64) = self.function.call1(py, arguments)?.extract(py)?;
            if found.len() != rates.len() {
                let message = format!("the law returns {} rates, but has {} states", found.len(), rates.len());
                return Err(SceneError::new_err(message));
            }
            rates.copy_from_slice(&found);
            Ok(force)
        });
        called.unwrap_or_else(|error| {
            *raised = Some(error);
            f64::NAN
        })
    }
}
