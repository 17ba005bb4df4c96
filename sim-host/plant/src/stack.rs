//! Amplifier and stack: a linear network, advanced by its exact flow.
//!
//! [`network`](crate::network) contains the equations. The change of the network over a step is one
//! matrix exponential; the values at the converters within a step are others ([`StepFlow`]). For a
//! network that drifts they are a series in the drifting element ([`Expansion`]). Further modes and
//! delays cost nothing if they are absent.

pub(crate) mod lanes;

use wide::f64x2;

use crate::circuit::Circuit;
use crate::expansion::{Change, Expansion};
use crate::network::{I, STATES, V0, VC};
use crate::parts::Parts;
use crate::quad::{Registers, Wide};
use crate::step_flow::{Layout, Pairs, StepFlow, TOTAL};
use crate::timing::Timing;
use scene::Amplifier;

/// Change of a state in a step by round-off, relative to the largest state.
const STILL_CHANGE_REL: f64 = 1e-14;

/// The drive's part of a step.
#[derive(Clone, Copy, Debug)]
pub struct HeldDrive {
    pairs: Pairs,
    volts: f64,
    /// Drive of the previous sample minus the present one, V, for a drive that is late by a
    /// fraction of a sample.
    before: f64,
    step: usize,
}

/// The network and its state.
#[derive(Clone, Debug)]
pub struct Stack {
    parts: Parts,
    amplifier: Amplifier,
    layout: Layout,
    tip_per_ampere: f64,
    tip_per_volt: f64,
    x: Pairs,
    /// The state at the beginning of the last step.
    before: Pairs,
    /// Present current and capacitor voltage of each further mode.
    further: Vec<[f64; 2]>,
    /// Current and capacitor voltage of each further mode at the beginning of the last step.
    further_before: Vec<[f64; 2]>,
    flow: StepFlow,
    /// Number of times that the flow was recomputed.
    remade: u64,
    expansion: Option<Box<Expansion>>,
    /// Number of changes since a series was computed.
    since: usize,
    /// Changes when the flow was last computed anew.
    moved: Option<Vec<Change>>,
}

impl Stack {
    /// Creates a stack at rest.
    pub fn new(parts: Parts, amplifier: &Amplifier, timing: Timing) -> Self {
        Self::with_late_drive(parts, amplifier, timing, 0.0)
    }

    /// Creates a stack at rest whose drive is late by `late_s`, less than a sample: the previous
    /// value is held for that time.
    pub fn with_late_drive(parts: Parts, amplifier: &Amplifier, timing: Timing, late_s: f64) -> Self {
        let modes = parts.further.len();
        let layout = Layout { timing, late_s, source_ohm: amplifier.source_ohm, further: modes };
        let mut stack = Stack {
            flow: Expansion::new(&parts, &[], amplifier, &layout).1,
            remade: 0,
            parts,
            amplifier: amplifier.clone(),
            layout,
            tip_per_ampere: 0.0,
            tip_per_volt: 0.0,
            x: Pairs::default(),
            before: Pairs::default(),
            further: vec![[0.0; 2]; modes],
            further_before: vec![[0.0; 2]; modes],
            expansion: None,
            since: 0,
            moved: None,
        };
        stack.scale_tip();
        stack
    }

    /// Returns the present circuit of the working mode.
    pub fn circuit(&self) -> &Circuit {
        &self.parts.circuit
    }

    /// Returns all present elements.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Changes the elements. There must be at least as many modes as before; new ones are at rest.
    /// The mechanical motion of every mode continues unchanged.
    pub fn set(&mut self, parts: Parts) {
        if self.parts == parts {
            return;
        }
        let (old, new) = (&self.parts.circuit, &parts.circuit);
        let factor = new.force_factor_n_per_v / old.force_factor_n_per_v;
        self.x[1] *= f64x2::new([1.0, factor]);
        self.x[2] *= f64x2::new([old.cm_f / new.cm_f * factor, 1.0]);
        for ((state, old), new) in self.further.iter_mut().zip(&self.parts.further).zip(&parts.further) {
            // The velocity of the mode is unchanged; the inductance represents its mass.
            let factor = (old.lm_h / new.lm_h).sqrt();
            *state = [state[0] * factor, state[1] * factor * old.cm_f / new.cm_f];
        }
        self.further.resize(parts.further.len(), [0.0; 2]);
        self.further_before.resize(parts.further.len(), [0.0; 2]);
        self.layout.further = parts.further.len();
        let old = std::mem::replace(&mut self.parts, parts);
        self.remake(&old);
        self.scale_tip();
    }

    /// Updates the flow to the present elements: by the series within its range, by a new series if
    /// the same elements change again and the last series, or exact flows since then, have paid for
    /// it, otherwise exactly.
    fn remake(&mut self, old: &Parts) {
        self.remade += 1;
        self.since += 1;
        if self.expansion.as_mut().is_some_and(|expansion| expansion.lead(&self.parts, &mut self.flow)) {
            return;
        }
        let last = std::mem::replace(&mut self.moved, Change::kinds(old, &self.parts));
        let pays = |changes: &&[Change]| self.moved == last && self.since >= Expansion::cost(changes.len());
        let changes = self.moved.as_deref().filter(pays);
        let (expansion, flow) = Expansion::new(&self.parts, changes.unwrap_or_default(), &self.amplifier, &self.layout);
        self.since = if changes.is_some() { 0 } else { self.since };
        self.expansion = changes.map(|_| Box::new(expansion));
        self.flow = flow;
    }

    fn scale_tip(&mut self) {
        let Circuit { cm_f, force_factor_n_per_v, .. } = self.parts.circuit;
        self.tip_per_ampere = 1.0 / force_factor_n_per_v;
        self.tip_per_volt = cm_f / force_factor_n_per_v;
    }

    /// Returns the effect of the drive on every step during which it is held at `volts`.
    #[inline(always)]
    pub fn held(&self, volts: f64) -> HeldDrive {
        HeldDrive { pairs: self.flow.drive.map(|row| row * volts), volts, before: 0.0, step: 0 }
    }

    /// Returns the effect of the drive on step `step` of a sample that begins with the previous
    /// value, `before`.
    #[inline]
    pub fn held_late(&self, step: usize, volts: f64, before: f64) -> HeldDrive {
        let mut held = self.held(volts);
        if let Some(late) = self.flow.late.get(step) {
            held.before = before - volts;
            held.step = step;
            held.pairs.iter_mut().zip(late).for_each(|(row, late)| *row += *late * held.before);
        }
        held
    }

    /// Advances by one step with the drive held and the friction held at `newtons`.
    #[inline(always)]
    pub fn advance(&mut self, drive: &HeldDrive, newtons: f64) {
        let flow = &self.flow;
        let now = self.x.map(f64x2::to_array);
        let [[e, d], [v0, i], [vc, _]] = now;
        let [ce, cd, cv, ci, cc] = &flow.state;
        let held = &drive.pairs;
        let amplifier = held[0] + ce[0] * e + cd[0] * d;
        let row = |r: usize| held[r] + flow.force[r] * newtons + ce[r] * e + cd[r] * d + cv[r] * v0 + ci[r] * i + cc[r] * vc;
        // One by one: a copy of all at once would read data that was just written.
        let x = [amplifier, row(1), row(2)];
        for (n, next) in x.into_iter().enumerate() {
            self.before[n] = f64x2::new(now[n]);
            self.x[n] = next;
        }
        if !self.further.is_empty() {
            self.advance_further(drive, newtons);
        }
    }

    /// Computes the further modes' part of a step.
    fn advance_further(&mut self, drive: &HeldDrive, newtons: f64) {
        std::mem::swap(&mut self.further, &mut self.further_before);
        let [[e, d], [v0, i], [vc, _]] = self.before.map(f64x2::to_array);
        let before = &self.further_before;
        for ((mode, next), &[ik, vk]) in self.flow.further.iter().zip(&mut self.further).zip(before) {
            let [of_current, of_voltage] = &mode.onto;
            for ((x, a), b) in self.x.iter_mut().zip(of_current).zip(of_voltage) {
                *x += *a * ik + *b * vk;
            }
            let [ce, cd, cv, ci, cc] = mode.state;
            let mut sum = mode.drive * drive.volts + mode.force * newtons + ce * e + cd * d + cv * v0 + ci * i + cc * vc;
            if let Some(late) = mode.late.get(drive.step) {
                sum += *late * drive.before;
            }
            for ([a, b], &[ij, vj]) in mode.modes.iter().zip(before) {
                sum += *a * ij + *b * vj;
            }
            *next = sum.to_array();
        }
    }

    /// Adds the effect of additional friction of `newtons` during the last step.
    #[inline(always)]
    pub fn correct_force(&mut self, newtons: f64) {
        self.x[1] += self.flow.force[1] * newtons;
        self.x[2] += self.flow.force[2] * newtons;
        for (mode, state) in self.flow.further.iter().zip(&mut self.further) {
            *state = (f64x2::new(*state) + mode.force * newtons).to_array();
        }
    }

    /// Sets states below 1e-150 V or A to zero, far below any noise. Otherwise they decay into
    /// denormal numbers, which halve the speed of this arithmetic.
    pub fn settle(&mut self) {
        let ended = |x: f64| if x.abs() < 1e-150 { 0.0 } else { x };
        self.x = self.x.map(|pair| f64x2::new(pair.to_array().map(ended)));
        self.further.iter_mut().for_each(|state| *state = state.map(ended));
    }

    /// Returns `true` if the last step changed no state by more than the round-off of the largest
    /// state, or of 0.1 V or A.
    pub fn is_still(&self) -> bool {
        let pairs = self.x.iter().zip(&self.before).map(|(x, before)| (*x, *before));
        let further = self.further.iter().zip(&self.further_before).map(|(x, before)| (f64x2::new(*x), f64x2::new(*before)));
        let (mut moved, mut largest) = (f64x2::splat(0.0), f64x2::splat(0.1));
        for (x, before) in pairs.chain(further) {
            moved = moved.max((x - before).abs());
            largest = largest.max(x.abs());
        }
        let [moved, largest] = [moved, largest].map(|both| both.to_array().into_iter().fold(0.0, f64::max));
        moved <= STILL_CHANGE_REL * largest
    }

    /// Returns the number of states of the network.
    pub fn states(&self) -> usize {
        STATES + 2 * self.further.len()
    }

    fn state(&self, n: usize) -> f64 {
        self.x[n / 2].to_array()[n % 2]
    }

    /// Returns the voltage at the stack, V.
    #[inline]
    pub fn voltage(&self) -> f64 {
        self.state(V0)
    }

    /// Returns the total current into the stack, A.
    #[inline]
    pub fn current(&self) -> f64 {
        self.state(TOTAL)
    }

    /// Returns the motional current of the working mode, A.
    #[inline]
    pub fn motional_current(&self) -> f64 {
        self.state(I)
    }

    /// Returns the voltage of the motional capacitor, V: the displacement times `phi / Cm`.
    #[inline]
    pub fn motional_voltage(&self) -> f64 {
        self.state(VC)
    }

    /// Returns the velocity of the tip, m/s.
    #[inline]
    pub fn tip_velocity(&self) -> f64 {
        self.motional_current() * self.tip_per_ampere
    }

    /// Returns the displacement of the tip, m.
    #[inline]
    pub fn tip_displacement(&self) -> f64 {
        self.motional_voltage() * self.tip_per_volt
    }

    /// Returns the amplitude of the motional current, A, from its present value and that a quarter
    /// period later.
    pub fn motional_amplitude(&self) -> f64 {
        let circuit = &self.parts.circuit;
        self.motional_current().hypot(self.motional_voltage() * circuit.cm_f * circuit.omega())
    }

    /// Returns the amplitude of the motional current, A, for an oscillation at any frequency:
    /// `Im^2 = i^2 - q i'`, with the charge `q` (Kaiser 1990). A driven resonator need not
    /// oscillate at its resonance.
    pub fn oscillation_a(&self) -> f64 {
        let Circuit { cm_f, lm_h, rm_ohm, .. } = self.parts.circuit;
        let (i, vc) = (self.motional_current(), self.motional_voltage());
        let slope = (self.voltage() - rm_ohm * i - vc) / lm_h;
        (i * i - cm_f * vc * slope).max(0.0).sqrt()
    }

    /// Returns the amplitude of the tip velocity, m/s.
    pub fn tip_amplitude(&self) -> f64 {
        self.motional_amplitude() / self.parts.circuit.force_factor_n_per_v
    }

    /// Returns the energy in the motional branches, J.
    pub fn stored_j(&self) -> f64 {
        let circuit = &self.parts.circuit;
        let first = 0.5 * (circuit.lm_h * self.motional_current().powi(2) + circuit.cm_f * self.motional_voltage().powi(2));
        let further = self.parts.further.iter().zip(&self.further);
        further.fold(first, |sum, (branch, [i, vc])| sum + 0.5 * (branch.lm_h * i * i + branch.cm_f * vc * vc))
    }

    /// Returns the sum of the currents of the further modes, A, and the power lost in them, W;
    /// zeros without such modes.
    #[inline]
    pub fn further(&self) -> (f64, f64) {
        let modes = self.parts.further.iter().zip(&self.further);
        modes.fold((0.0, 0.0), |(sum, lost), (branch, [i, _])| (sum + i, lost + branch.rm_ohm * i * i))
    }

    /// Passes voltage and current at the conversions within step `step` of a sample to `convert`,
    /// for two conversions at a time, with their number. The step has just been made with this
    /// drive and a mean friction of `newtons`.
    #[inline(always)]
    pub(crate) fn sample<F: Registers>(
        &self,
        four: F,
        step: usize,
        drive: &HeldDrive,
        newtons: f64,
        mut convert: impl FnMut(Wide<F>, usize),
    ) {
        let [[e, d], [v0, i], [vc, _]] = self.before.map(f64x2::to_array);
        let (volts, newtons) = (Wide::splat(four, drive.volts), Wide::splat(four, newtons));
        let (e, d, v0) = (Wide::splat(four, e), Wide::splat(four, d), Wide::splat(four, v0));
        let (i, vc) = (Wide::splat(four, i), Wide::splat(four, vc));
        for look in &self.flow.looks[step] {
            let [ke, kd, kv, ki, kc] = &look.state;
            let inputs = look.drive.wide(four) * volts + look.force.wide(four) * newtons;
            let amplifier = inputs + ke.wide(four) * e + kd.wide(four) * d;
            let mut both = amplifier + kv.wide(four) * v0 + ki.wide(four) * i + kc.wide(four) * vc;
            if drive.before != 0.0 {
                both = both + look.late.wide(four) * Wide::splat(four, drive.before);
            }
            for ([a, b], &[ik, vk]) in look.further.iter().zip(&self.further_before) {
                both = both + (a.wide(four) * Wide::splat(four, ik) + b.wide(four) * Wide::splat(four, vk));
            }
            convert(both, look.conversions);
        }
    }
}

#[cfg(test)]
mod tests;
