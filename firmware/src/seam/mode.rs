//! The mode of the controller.

use serde::{Deserialize, Serialize};

/// What the controller is doing.
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
    /// Driving, by the burst schedule.
    Run,
    /// Muted by a fault.
    Fault,
    /// Measuring what each lane adds.
    Calibrate,
    /// Measuring the clamped branch, beside the resonance.
    Clamped,
}
