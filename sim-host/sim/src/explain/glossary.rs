//! Terms of the book; `docs/glossary.md` is generated from them.

use std::fmt::Write as _;

/// Creates the table, with a term in each line.
macro_rules! terms {
    ($($names:literal: $meaning:literal, $page:literal;)+) => { &[$(($names, $meaning, $page)),+] };
}

/// Names of a term, separated by commas, with its meaning and the page that explains it.
pub(crate) const TERMS: &[(&str, &str, &str)] = terms! {
    "admittance loop": "Circle of the admittance near a resonance in the complex plane. Its diameter is 1 / Rm.", "stack-and-tracking";
    "antiresonance, parallel resonance": "Frequency above the series resonance at which the impedance is largest.", "stack-and-tracking";
    "bandwidth": "Series resonance divided by Q, Hz: width of the resonance at half its power.", "stack-and-tracking";
    "block": "Samples that the controller processes in one step: 32 by default, 100 on the board.", "board";
    "boost, boosted edge": "Short drive above the set point at the beginning of a burst, with which the vibration reaches its level early.", "bursts-and-waveforms";
    "brake": "Short drive in opposite phase at the end of a burst, which stops the vibration.", "bursts-and-waveforms";
    "burst": "Interval in which the drive is ON, with an edge at each end.", "bursts-and-waveforms";
    "BVD, Butterworth-Van Dyke circuit": "Equivalent circuit of a piezo stack: the series branch Lm, Cm, Rm in parallel with C0.", "stack-and-tracking";
    "C0, clamped capacitance": "Capacitance of the stack without motion, F. Its current moves nothing.", "stack-and-tracking";
    "commissioning": "Search, measurement, settings and test for an unknown transducer by one command.", "your-transducer";
    "contact study": "Scene with a friction contact and a given vibration, without a controller.", "your-contact";
    "coupling, k": "Effective electromechanical coupling: k² = Cm / (C0 + Cm).", "stack-and-tracking";
    "D-ring": "Ring over which a seat belt slides at the shoulder.", "applications";
    "Dahl length": "Displacement over which friction builds up after a reversal: friction force over contact stiffness, m.", "contact";
    "Dahl model": "Friction model of an elastic contact that yields gradually.", "contact";
    "detuning": "Distance of the drive frequency from the series resonance, Hz.", "stack-and-tracking";
    "drive hash": "Checksum of every DAC code of a run. Two runs with the same hash played the same signal.", "metrics-and-files";
    "expectation": "Metric with its limits in a scene. A run that misses one ends with exit code 4.", "ci";
    "fault": "Number of the reason for which the drive is muted until the fault is cleared.", "faults";
    "force factor": "Tip force per volt, which is motional current per tip velocity, N/V or A s/m.", "stack-and-tracking";
    "friction ratio": "Mean friction with vibration over friction without.", "contact";
    "friction switch": "Part of the controller that holds a set friction ratio by amplitude or by bursts.", "applications";
    "gate": "Switch of the drive after the lock: ON or OFF.", "bursts-and-waveforms";
    "guard": "Checks of every block that mute the drive when a sensor, the load, the belt or the host fails.", "safety";
    "host timeout": "Time without a message from the host after which the board mutes its drive.", "link";
    "images": "Parts of a DAC's output at the sample rate plus and minus the drive frequency.", "bursts-and-waveforms";
    "kappa": "Vibration amplitude in Dahl lengths. With the velocity ratio it determines the friction ratio.", "contact";
    "lane": "One drive output: a DAC and an amplifier. A motor has four.", "board";
    "limit": "Number of the reason for which the drive is at present below its set point.", "faults";
    "Lm, Cm, Rm": "Inductance, capacitance and resistance of the motional branch.", "stack-and-tracking";
    "lock": "State in which the drive frequency follows the resonance.", "stack-and-tracking";
    "lock point": "Frequency at which a tracker comes to rest. Its distance from the series resonance is the bias.", "stack-and-tracking";
    "lock-in, demodulation": "Measurement of amplitude and phase of voltage and current at the drive frequency.", "stack-and-tracking";
    "motional branch": "Part of the equivalent circuit that represents the motion: Lm, Cm and Rm.", "stack-and-tracking";
    "motional current": "Current of the motional branch: tip velocity times force factor, A.", "stack-and-tracking";
    "nominal value": "Value of the data sheet, which a setting gives to the controller.", "your-transducer";
    "observer": "Tracker that estimates resonance and damping from the growth of the motional current in every block.", "stack-and-tracking";
    "PIL": "Processor in the loop: the controller as machine code in an emulator, against the simulated plant.", "claims";
    "phase loop, phase lock": "Tracker that controls the phase of the motional current to zero.", "stack-and-tracking";
    "plant": "Simulated amplifier, stack, contact and sensors.", "stack-and-tracking";
    "power ratio": "Power into friction with vibration over the power without.", "contact";
    "Q, quality factor": "Series resonance over bandwidth. The time constant is Q / π periods.", "stack-and-tracking";
    "scan": "Sweep of the frequency window that finds the resonances.", "your-transducer";
    "scene": "TOML file with everything that a run needs.", "scenes";
    "self-test": "Tone before the scan that checks sense channels and load.", "safety";
    "series resonance": "Frequency at which the motional current is in phase with the voltage and largest.", "stack-and-tracking";
    "SIL": "Software in the loop: the controller on the host, against the simulated plant.", "claims";
    "skew": "Delay between the samples of voltage and current, s.", "board";
    "survey": "Measurement of the contact by the friction switch: friction at some amplitudes.", "applications";
    "time constant, ring-down time": "Time in which the vibration falls to 37 % without drive: Q / (π f), s.", "stack-and-tracking";
    "tip velocity": "Velocity of the surface of the stack that touches the contact, amplitude, m/s.", "contact";
    "twin": "Scene that a commissioning writes: the measured transducer for the simulator.", "your-transducer";
    "V-I loop": "Usual tracker on the phase of the total current. C0 moves its lock point.", "stack-and-tracking";
    "velocity ratio": "Sliding speed over amplitude of the tip velocity. Friction falls if it is below 1.", "contact";
    "Y0": "Admittance of the parts that do not move: C0 and the delay of the converters.", "stack-and-tracking";
    "window": "Frequencies in which the controller searches and tracks: the nominal frequency and `tracking.span` on both sides.", "your-transducer";
};

const HEAD: &str = "\
# Glossary

The terms of this book in one sentence each.
`sim-host explain SIL` prints the entry of one term; `sim-host explain` also knows metrics, keys, faults, limits and files.

| term | meaning | more |
|---|---|---|
";

const REFERENCES: &str = "
## References

* *Active Friction Control via Piezoelectrically Generated Ultrasonic Vibrations*, M.S. thesis, The Ohio State University, 2009: \"the thesis\".
  Its chapter 3 is the experiment, its chapter 4 the friction models; Tables 3.1 and 4.1 have the parameters.
  The parameters of the stack of `experiment-1` are our consistent reading of the thesis.
* TransientBVD (Measurement and Sensor Technology Group, TU Darmstadt), `transducers.json`: the six measured equivalent circuits.
* P. R. Dahl, *A solid friction model*, The Aerospace Corporation, 1968.
* K. S. Van Dyke, *The piezo-electric resonator and its equivalent network*, Proc. IRE, 1928.
* E. C. Levy, *Complex-curve fitting*, 1959; C. K. Sanathanan and J. Koerner,
  *Transfer function synthesis as a ratio of two complex polynomials*, 1963: the circle fit.
";

/// Returns the page, in Markdown.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    for (names, meaning, more) in TERMS {
        let _ = writeln!(page, "| {names} | {meaning} | [{}]({more}.md) |", more.replace('-', " "));
    }
    page + REFERENCES
}

/// Returns `true` if a word is one of the names of a term.
pub(crate) fn is_named(names: &str, word: &str) -> bool {
    names.split(", ").any(|name| name.eq_ignore_ascii_case(&word.replace('_', " ")))
}

#[cfg(test)]
mod tests {
    /// `UPDATE_DOCS=1 cargo test docs -- --include-ignored` regenerates the page.
    #[test]
    fn docs_of_the_glossary_are_generated_from_its_terms() {
        report::docs::page("glossary.md", &super::page());
    }
}
