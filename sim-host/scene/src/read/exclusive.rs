//! Groups of keys and tables that exclude each other.

/// A group of keys that exclude each other.
#[derive(Debug)]
pub struct Exclusive {
    /// Path of the table.
    pub table: &'static str,
    /// Alternatives, of which exactly one must be given.
    pub alternatives: &'static [Alternative],
}

/// One of the alternatives.
#[derive(Debug)]
pub struct Alternative {
    /// Keys of the alternative.
    pub keys: &'static [&'static str],
    /// `true` if all of the keys are needed, `false` if any is sufficient.
    pub complete: bool,
}

const fn all(keys: &'static [&'static str]) -> Alternative {
    Alternative { keys, complete: true }
}

const fn any(keys: &'static [&'static str]) -> Alternative {
    Alternative { keys, complete: false }
}

/// All groups of keys that exclude each other. In an overlay, a key replaces those that it
/// excludes.
pub const EXCLUSIVE: &[Exclusive] = &[
    Exclusive { table: "controller.drive", alternatives: &[all(&["amplitude_v"]), all(&["velocity_m_per_s"])] },
    Exclusive { table: "controller.burst", alternatives: &[all(&["on_s", "off_s"]), all(&["period_s", "duty"])] },
    Exclusive { table: "controller.friction", alternatives: &[all(&["target_ratio"]), all(&["target_force_n"])] },
    Exclusive { table: "excitation", alternatives: &[all(&["velocity_ratio"]), all(&["sliding_m_per_s"])] },
    Exclusive {
        table: "stack.bvd",
        alternatives: &[all(&["cm_f", "lm_h", "rm_ohm"]), all(&["series_resonance_hz", "q", "coupling"])],
    },
    Exclusive {
        table: "contact",
        alternatives: &[
            all(&["coulomb"]),
            all(&["dahl"]),
            all(&["lugre"]),
            all(&["hertz"]),
            all(&["compliant"]),
            all(&["expression"]),
            all(&["empirical"]),
        ],
    },
    Exclusive {
        table: "rig",
        alternatives: &[
            all(&["slider"]),
            all(&["kinematic"]),
            all(&["sdof"]),
            all(&["rotor"]),
            all(&["belt"]),
            all(&["dring"]),
            all(&["carriage"]),
        ],
    },
    Exclusive {
        table: "disturbance",
        alternatives: &[all(&["to"]), all(&["rate_per_s"]), all(&["sine_amplitude", "sine_hz"]), all(&["profile"])],
    },
    Exclusive { table: "rig.kinematic", alternatives: &[all(&["vibration_m_per_s"]), all(&["vibration_amplitude_m"])] },
    Exclusive { table: "rig.dring", alternatives: &[all(&["pulse_g", "pulse_ms"]), all(&["pulse"])] },
    Exclusive {
        table: "vary",
        alternatives: &[all(&["spread"]), all(&["factor"]), all(&["from", "to"]), all(&["sd"]), all(&["samples"])],
    },
    Exclusive { table: "grid.over", alternatives: &[all(&["values"]), all(&["from", "to", "points"])] },
    Exclusive { table: "expect", alternatives: &[any(&["min", "max"]), all(&["value", "tolerance"])] },
];

/// Samples of a profile, or the file with them.
const PROFILE: &[Alternative] = &[any(&["file"]), any(&["time_s", "values"])];

/// Keys that describe the same quantity of a circuit or profile. A key of a scene replaces the
/// alternative of its base, also if the circuit is already complete without it.
pub(crate) const OVERLAY_EXCLUSIVE: &[Exclusive] = &[
    Exclusive { table: "disturbance.profile", alternatives: PROFILE },
    Exclusive { table: "excitation.profile", alternatives: PROFILE },
    Exclusive { table: "rig.dring.pulse", alternatives: PROFILE },
    Exclusive { table: "overlay", alternatives: &[any(&["file"]), any(&["x", "values"])] },
    Exclusive { table: "stack.bvd", alternatives: &[all(&["c0_f"]), all(&["ct_f"])] },
    Exclusive { table: "stack.bvd", alternatives: &[all(&["parallel_resonance_hz"]), all(&["coupling"])] },
    Exclusive { table: "stack.bvd", alternatives: &[all(&["parallel_resonance_hz"]), all(&["cm_f", "lm_h"])] },
];
