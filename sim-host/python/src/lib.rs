//! The native part of the Python package `sonoglide`: scenes, runs and the link to a board, as
//! wrapped by the Python part (`package/sonoglide/`).
//!
//! ```text
//! sonoglide.Scene, Result, Sweep, Link (Python: dictionaries, NumPy, pictures in a notebook)
//!     --> sonoglide._native (here: texts and bytes) --> scene, sim, link, as the command line calls them
//! ```
//!
//! Work runs on a separate thread without the interpreter's lock, and a signal such as Ctrl-C ends
//! it (`interruptible`).

mod errors;
mod imported;
mod interruptible;
mod law;
mod link;
mod result;
mod scene;
mod search;
mod stepped;
mod sweep;
mod tools;
mod vocabulary;

/// The module `sonoglide._native`.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::errors::{LinkError, MeasurementError, RunError, SceneError};
    #[pymodule_export]
    use crate::imported::{import_admittance, import_conditions, import_friction};
    #[pymodule_export]
    use crate::link::Link;
    #[pymodule_export]
    use crate::result::Result;
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::search::{optimise, solve};
    #[pymodule_export]
    use crate::stepped::{Controller, Plant, Telemetry};
    #[pymodule_export]
    use crate::sweep::Sweep;
    #[pymodule_export]
    use crate::tools::{advise, advise_amplifier, compare, spectrum, validate};
    #[pymodule_export]
    use crate::vocabulary::{explain, metrics, scenes};

    /// Version of the package.
    #[pymodule_export]
    const VERSION: &str = sim::VERSION;
}
