//! Conclusions of a scan: the resonances of a window, the chosen one, and the result.

use heapless::Vec;

use crate::find::damage::{Damage, damage};
use crate::find::identify::choice::Choice;
use crate::find::identify::mode_search::MAX_DISTANCE_HALF_SPANS;
use crate::find::identify::pole_fit::{Circuit, Pole};
use crate::find::scan::pass::{MeasuredResonance, Pass};
use crate::find::scan::ring_down::RingDown;
use crate::find::scan::{MARGIN_REL, Scan, Stage};
use crate::generate::step::Step;
use crate::seam::fault::Fault;
use crate::seam::transducer::Transducer;

impl Scan {
    /// Lists the resonances in a part of the window by rising frequency; the weakest are dropped.
    pub(super) fn take_part(&mut self, part: u32) {
        let width_hz = 2.0 * self.window_hz * (1.0 + MARGIN_REL) / self.parts as f32;
        let middle_hz = (part as f32 + 0.5) * width_hz - self.window_hz * (1.0 + MARGIN_REL);
        // A resonance in the overlap of two parts appears in both and is listed once.
        let reach_hz = 0.5 * width_hz * (1.0 + MARGIN_REL);
        let own = |hz: f32| self.parts == 1 || (hz - middle_hz).abs() < reach_hz;
        let (circuit, deviations) = self.search.found();
        for (pole, deviations) in circuit.poles.iter().zip(deviations).filter(|(pole, _)| own(pole.offset_hz)) {
            if self.parts == 1 || !self.modes.contains(pole) {
                self.modes.add(*pole, *deviations);
            }
        }
    }

    /// Chooses the resonance, and starts the fine pass unless its deviation is already small
    /// enough. If no inductance fits, the strongest resonance is taken, and the fine pass decides:
    /// the window may merge others into it.
    pub(super) fn choose(&mut self) -> Step {
        let fits = self.modes.choose(&self.choice);
        let strongest = Choice { nominal_lm_h: None, ..self.choice };
        if let Err(fault) = fits.or_else(|fault| self.modes.choose(&strongest).map_err(|_| fault)) {
            return Step::Failed(fault);
        }
        let Some(&(pole, deviations)) = self.modes.chosen() else { return Step::Failed(Fault::NoResonance) };
        let reach_hz = self.window_hz * (1.0 + MARGIN_REL);
        let hz = self.nominal_hz + pole.offset_hz;
        let seen = MeasuredResonance {
            hz,
            offset_hz: pole.offset_hz,
            q: pole.q,
            deviation_hz: deviations.series_resonance_hz,
            has_neighbour: self.modes.has_neighbour(),
        };
        let fine = self.pass.fine(&seen, reach_hz, self.block_s);
        if fine.repeats > 0 || self.parts > 1 || fits.is_err() {
            self.begin_pass(Pass { repeats: fine.repeats.max(1), ..fine }, Stage::Fine);
            return self.tune();
        }
        let chosen = |other: &Pole| other.offset_hz == pole.offset_hz;
        self.take(self.search.found().0.poles.iter().position(chosen).unwrap_or(0))
    }

    /// Fits the chosen resonance, together with all others that the fine pass shows unless it is
    /// fitted alone.
    pub(super) fn begin_fit(&mut self) {
        let mut circuit = Circuit { poles: Vec::new(), known: Vec::new(), ..self.search.found().0.clone() };
        let (centre_hz, half_hz) = (self.pass.centre_hz, 0.5 * self.pass.width_hz);
        // There is room: both lists hold as many as can be found.
        circuit.poles.extend(self.modes.chosen().map(|(pole, _)| *pole));
        for pole in self.modes.others() {
            let inside = !self.alone && (pole.offset_hz - centre_hz).abs() < MAX_DISTANCE_HALF_SPANS * half_hz;
            let _ = if inside { circuit.poles.push(*pole) } else { circuit.known.push(*pole) };
        }
        let (blocks, samples) = self.measured();
        self.alone |= circuit.poles.len() < 2;
        self.search.refit(&circuit, blocks, samples);
    }

    /// Accepts the fit of the fine pass.
    pub(super) fn take_fit(&mut self) -> Step {
        let (circuit, deviations) = self.search.found();
        if circuit.poles.is_empty() {
            // The others may be too weak for a fit together.
            if core::mem::replace(&mut self.alone, true) {
                return Step::Failed(Fault::NoResonance);
            }
            self.begin(Stage::Fit);
            return self.tune();
        }
        match self.modes.refine(circuit, deviations, &self.choice) {
            Ok(place) => self.take(place),
            Err(fault) => Step::Failed(fault),
        }
    }

    /// Accepts one resonance of the latest fit as the result.
    fn take(&mut self, place: usize) -> Step {
        let (circuit, deviations) = self.search.found();
        if let Some(nominal_q) = self.judged_q
            && let Some((chosen, _)) = self.modes.chosen()
            && damage(chosen.q / nominal_q) == Damage::Certain
        {
            return Step::Failed(Fault::ResonanceDamaged);
        }
        let transducer = Transducer {
            deviations: deviations.get(place).copied().unwrap_or_default(),
            quality: self.search.quality(place),
            modes: self.modes.listed().len() as u8,
            chosen: self.modes.place() as u8,
            ..circuit.transducer(place)
        };
        // During the search the drive was at the centre of the window, not at the resonance; during
        // the fit it was at the first one.
        let still_blocks = if self.stage == Stage::Fit && place == 0 { self.still_blocks } else { 0 };
        self.begin(Stage::RingDown(RingDown::new(
            transducer,
            (circuit.motional(place), circuit.others_slope(place)),
            still_blocks,
            self.block_s,
        )));
        self.tune()
    }
}
