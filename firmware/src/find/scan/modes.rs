//! Resonances found by a scan, and the chosen one.

use heapless::Vec;

use crate::find::identify::choice::Choice;
use crate::find::identify::pole_fit::{Circuit, Pole};
use crate::seam::compare::{larger, smaller};
use crate::seam::fault::Fault;
use crate::seam::phasor::magnitude;
use crate::seam::transducer::{Deviations, Listed, MOST_MODES, Resonance, Resonances};

/// Minimum distance of two poles of similar Q, in bandwidths of the broader one; closer ones are
/// the same pole found twice.
const MIN_DISTANCE_BANDWIDTHS: f32 = 0.25;
/// Ratio of Q above which two poles are never the same: a narrow one on the flank of a broad one.
const MAX_Q_RATIO: f32 = 2.0;

/// Maximum distance of a neighbour, in bandwidths of the chosen resonance. A fine pass that leaves
/// it out cannot separate both.
const NEIGHBOUR_BANDWIDTHS: f32 = 4.0;

/// Relative strength of another resonance, times the cube of the bandwidth over its distance, above
/// which steps around the lock point measure the clamped branch worse than a scan: their error is
/// 0.3 % of the motional conductance times this.
const CROWDED_STRENGTH_REL: f32 = 0.6;

/// Resonances at rising frequencies.
#[derive(Clone, Debug, Default)]
pub(crate) struct Modes {
    nominal_hz: f32,
    found: Vec<(Pole, Deviations), MOST_MODES>,
    listed: Resonances,
    chosen: usize,
}

impl Modes {
    /// Creates an empty list whose offsets are relative to `nominal_hz`.
    pub(crate) fn new(nominal_hz: f32) -> Self {
        Modes { nominal_hz, ..Modes::default() }
    }

    /// Returns all resonances.
    pub(crate) fn listed(&self) -> &[Resonance] {
        &self.listed
    }

    /// Returns one resonance per block, in rotation.
    pub(crate) fn in_turn(&self, block: usize) -> Option<Listed> {
        if self.listed.is_empty() {
            return None;
        }
        let place = block % MOST_MODES % self.listed.len();
        let resonance = *self.listed.get(place)?;
        Some(Listed { place: place as u8, of: self.listed.len() as u8, resonance })
    }

    /// Returns the index of the chosen resonance.
    pub(crate) fn place(&self) -> usize {
        self.chosen
    }

    /// Returns the chosen resonance.
    pub(crate) fn chosen(&self) -> Option<&(Pole, Deviations)> {
        self.found.get(self.chosen)
    }

    /// Returns the resonances that were not chosen.
    pub(crate) fn others(&self) -> impl Iterator<Item = &Pole> {
        self.found.iter().enumerate().filter(|(n, _)| *n != self.chosen).map(|(_, (pole, _))| pole)
    }

    /// Returns the other resonance that rings most after a step of the drive: its series resonance
    /// frequency, Hz, and its motional capacitance relative to that of the chosen one.
    pub(crate) fn other_mode(&self) -> Option<(f32, f32)> {
        let (chosen, _) = self.chosen()?;
        let disturbs = |pole: &Pole| pole.strength() / (pole.offset_hz - chosen.offset_hz).abs();
        let most = self.others().max_by(|a, b| disturbs(a).total_cmp(&disturbs(b)))?;
        Some((self.nominal_hz + most.offset_hz, most.strength() / chosen.strength()))
    }

    /// Returns `true` if another resonance is within [`NEIGHBOUR_BANDWIDTHS`] of the chosen one.
    pub(crate) fn has_neighbour(&self) -> bool {
        let Some((chosen, _)) = self.chosen() else { return false };
        let reach_hz = NEIGHBOUR_BANDWIDTHS * (self.nominal_hz + chosen.offset_hz) / chosen.q;
        self.others().any(|other| (other.offset_hz - chosen.offset_hz).abs() < reach_hz)
    }

    /// Returns `true` if another resonance makes steps around the chosen one less accurate than a
    /// scan. Its strength grows with the cube of the bandwidth over its distance.
    pub(crate) fn is_crowded(&self) -> bool {
        let Some((chosen, _)) = self.chosen() else { return false };
        let bandwidth_hz = (self.nominal_hz + chosen.offset_hz) / chosen.q;
        self.others().any(|other| {
            let apart = (other.offset_hz - chosen.offset_hz).abs() / bandwidth_hz;
            other.strength() > CROWDED_STRENGTH_REL * apart * apart * apart * chosen.strength()
        })
    }

    /// Returns `true` if the list contains this resonance: an earlier part of the window showed it,
    /// or a fit has split it.
    pub(crate) fn contains(&self, pole: &Pole) -> bool {
        self.found.iter().any(|(other, _)| {
            let (least, most) = (smaller(other.q, pole.q), larger(other.q, pole.q));
            let apart_hz = MIN_DISTANCE_BANDWIDTHS * (self.nominal_hz + pole.offset_hz) / least;
            (other.offset_hz - pole.offset_hz).abs() < apart_hz && most < MAX_Q_RATIO * least
        })
    }

    /// Adds a resonance. If the list is full, the weakest is dropped.
    pub(crate) fn add(&mut self, pole: Pole, deviations: Deviations) {
        let strengths = self.found.iter().map(|(pole, _)| pole.strength()).enumerate();
        match strengths.min_by(|(_, a), (_, b)| a.total_cmp(b)).filter(|_| self.found.is_full()) {
            Some((_, weakest)) if weakest > pole.strength() => return,
            Some((place, _)) => drop(self.found.remove(place)),
            None => {}
        }
        let place = self.found.iter().take_while(|(other, _)| other.offset_hz <= pole.offset_hz).count();
        // There is room: a full list has lost its weakest entry.
        let _ = self.found.insert(place, (pole, deviations));
        self.list();
    }

    /// Chooses the resonance to drive.
    pub(crate) fn choose(&mut self, choice: &Choice) -> Result<(), Fault> {
        let lm_deviations_h: Vec<f32, MOST_MODES> = self.found.iter().map(|(_, deviations)| deviations.lm_h).collect();
        self.chosen = choice.choose(&self.listed, &lm_deviations_h)?;
        Ok(())
    }

    /// Replaces the chosen resonance, the first of a later fit, and all others of that fit. Returns
    /// the index of the chosen one in that fit: another one if the first no longer fits the choice,
    /// as the fit may exchange two of them.
    pub(crate) fn refine(&mut self, fitted: &Circuit, deviations: &[Deviations], choice: &Choice) -> Result<usize, Fault> {
        self.found.retain(|(pole, _)| fitted.known.contains(pole));
        fitted.poles.iter().zip(deviations).for_each(|(pole, deviations)| self.add(*pole, *deviations));
        self.chosen = self.found.iter().position(|(pole, _)| fitted.poles.first() == Some(pole)).unwrap_or(0);
        let first = self.listed.get(self.chosen).zip(deviations.first());
        if !first.is_some_and(|(one, off)| choice.fits(one, off.lm_h)) {
            self.choose(choice)?;
        }
        let chosen = self.chosen().map(|(pole, _)| pole);
        // One that is not in this fit is not measured well enough to be driven.
        fitted.poles.iter().position(|pole| Some(pole) == chosen).ok_or(Fault::WrongMode)
    }

    fn list(&mut self) {
        self.listed = self.found.iter().map(|(pole, _)| resonance(pole, self.nominal_hz)).collect();
    }
}

fn resonance(pole: &Pole, nominal_hz: f32) -> Resonance {
    let hz = nominal_hz + pole.offset_hz;
    let conductance_s = magnitude(pole.conductance);
    Resonance { hz, q: pole.q, lm_h: pole.q / (core::f32::consts::TAU * hz * conductance_s), conductance_s }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seam::phasor::Phasor;

    fn pole(offset_hz: f32, conductance_s: f32) -> Pole {
        Pole { offset_hz, q: 50.0, conductance: Phasor::new(conductance_s, 0.0), ..Pole::default() }
    }

    /// At a strength of 0.2 the limit is 0.69 bandwidths, 553 Hz; a weak near one counts as well.
    #[test]
    fn near_modes_crowd() {
        let crowded = |others: &[(f32, f32)]| {
            let mut modes = Modes::new(40e3);
            for &(offset_hz, strength) in [(0.0, 1.0)].iter().chain(others) {
                modes.add(pole(offset_hz, 0.3 * strength), Deviations::default());
            }
            modes.choose(&Choice { window_hz: (40e3, 5e3), nominal_lm_h: None }).unwrap();
            modes.is_crowded()
        };
        assert!(!crowded(&[]) && !crowded(&[(570.0, 0.2)]) && crowded(&[(540.0, 0.2)]) && crowded(&[(-540.0, 0.2)]));
        assert!(crowded(&[(1200.0, 0.7), (200.0, 0.05)]));
    }

    /// A broad resonance and a narrow one on its flank were taken for the same: the narrow one was
    /// then driven, or refused as the wrong mode.
    #[test]
    fn a_narrow_resonance_on_the_flank_of_a_broad_one_is_another() {
        let [mut broad, narrow] = [pole(3000.0, 5.0), pole(0.0, 0.7)];
        broad.q = 6.0;
        for (first, second) in [(broad, narrow), (narrow, broad)] {
            let mut modes = Modes::new(101e3);
            modes.add(first, Deviations::default());
            assert!(modes.contains(&first) && !modes.contains(&second));
        }
    }

    /// A fit may exchange two resonances: the first is then no longer the chosen one.
    #[test]
    fn a_refined_resonance_fits_the_nominal_inductance() {
        let [strong, weak] = [pole(0.0, 0.3), pole(500.0, 0.01)];
        let lm_h = |pole: &Pole| pole.q / (core::f32::consts::TAU * (40e3 + pole.offset_hz) * pole.conductance.re);
        let refined = |poles: &[Pole], nominal: &Pole| {
            let choice = Choice { window_hz: (40e3, 5e3), nominal_lm_h: Some(lm_h(nominal)) };
            let fitted = Circuit { poles: poles.iter().copied().collect(), ..Circuit::bare(40e3, 1e-9) };
            Modes::new(40e3).refine(&fitted, &[Deviations::default(); 2], &choice)
        };
        assert_eq!([refined(&[strong, weak], &strong), refined(&[weak, strong], &strong)], [Ok(0), Ok(1)]);
        assert_eq!(refined(&[weak], &strong), Err(Fault::WrongMode));
    }

    #[test]
    fn weakest_of_five_is_dropped_and_none_is_listed_twice() {
        let mut modes = Modes::new(40e3);
        for (offset_hz, conductance_s) in [(900.0, 0.2), (-900.0, 0.1), (0.0, 0.3), (500.0, 0.05), (-300.0, 0.4), (-302.0, 0.4)] {
            let pole = pole(offset_hz, conductance_s);
            if !modes.contains(&pole) {
                modes.add(pole, Deviations::default());
            }
        }
        let offsets: std::vec::Vec<f32> = modes.listed().iter().map(|resonance| resonance.hz - 40e3).collect();
        assert_eq!(offsets, [-900.0, -300.0, 0.0, 900.0]);
        assert_eq!((0..5).map(|block| modes.in_turn(block).unwrap().place).collect::<std::vec::Vec<_>>(), [0, 1, 2, 3, 0]);
    }
}
