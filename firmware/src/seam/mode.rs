//! The mode of the controller.

use serde::{Deserialize, Serialize};

/// Activity of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(all(feature = "defmt", target_os = "none"), derive(defmt::Format))]
pub enum Mode {
    /// Silent, waiting for an order.
    #[default]
    Idle,
    /// Checking the sense channels and that there is a transducer.
    SelfTest,
    /// Looking for the resonance.
    Scan,
    /// Acquiring the lock.
    Lock,
    /// Driving, with the burst schedule.
    Run,
    /// Muted by a fault.
    Fault,
    /// Measuring the lanes for their trims.
    Calibrate,
    /// Measuring the clamped branch, off resonance.
    Clamped,
}
