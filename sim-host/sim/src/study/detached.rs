//! A study without its scene, for a caller that stores the scene next to it.

use super::answer::Answer;
use super::comparison::ComparisonResult;
use super::contact::Solved;
use super::driven::{Level, Run};
use super::grid::GridResult;
use super::monte_carlo::MonteCarlo;
use super::playback::Playback;
use super::{Judged, Outcome, Study};
use crate::metrics::Metrics;
use crate::overlay::Overlaid;
use crate::record::Record;
use scene::Scene;
use scene::load::{Assumed, Inherited};

/// All parts of a study except its scene.
#[derive(Debug)]
pub struct Detached {
    name: String,
    origin: String,
    changes: Vec<String>,
    run_number: Option<u32>,
    outcome: DetachedOutcome,
    metrics: Metrics,
    judged: Vec<Judged>,
    inherited: Option<Inherited>,
    assumed: Vec<Assumed>,
    grid: Option<GridResult>,
    comparison: Option<ComparisonResult>,
    overlaid: Option<Overlaid>,
    interrupted: bool,
}

#[derive(Debug)]
enum DetachedOutcome {
    Driven(Level, Box<Record>),
    Contact(Box<(Option<Answer>, Playback)>),
    MonteCarlo(Box<MonteCarlo>),
}

impl Study<'_> {
    /// Detaches the study from its scene without copying.
    pub fn detached(self) -> Detached {
        let Study {
            name,
            origin,
            changes,
            run_number,
            metrics,
            judged,
            inherited,
            assumed,
            grid,
            comparison,
            overlaid,
            interrupted,
            ..
        } = self;
        let outcome = match self.outcome {
            Outcome::Driven(run) => DetachedOutcome::Driven(run.level, Box::new(run.record)),
            Outcome::Contact(solved) => DetachedOutcome::Contact(Box::new((solved.answer, solved.playback))),
            Outcome::MonteCarlo(runs) => DetachedOutcome::MonteCarlo(runs),
        };
        Detached {
            name,
            origin,
            changes,
            run_number,
            outcome,
            metrics,
            judged,
            inherited,
            assumed,
            grid,
            comparison,
            overlaid,
            interrupted,
        }
    }
}

impl Detached {
    /// Attaches the study to its scene again without copying; `None` if the scene is of another
    /// kind.
    pub fn of(self, scene: &Scene) -> Option<Study<'_>> {
        let Detached {
            name,
            origin,
            changes,
            run_number,
            metrics,
            judged,
            inherited,
            assumed,
            grid,
            comparison,
            overlaid,
            interrupted,
            ..
        } = self;
        let outcome = match self.outcome {
            DetachedOutcome::Driven(level, record) => {
                Outcome::Driven(Box::new(Run { scene: scene.driven()?, level, record: *record }))
            }
            DetachedOutcome::Contact(solved) => {
                let (answer, playback) = *solved;
                Outcome::Contact(Box::new(Solved { scene: scene.excited()?, answer, playback }))
            }
            DetachedOutcome::MonteCarlo(runs) => Outcome::MonteCarlo(runs),
        };
        Some(Study {
            name,
            origin,
            changes,
            run_number,
            scene,
            outcome,
            metrics,
            judged,
            inherited,
            assumed,
            grid,
            comparison,
            overlaid,
            interrupted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Options, Study, run};
    use crate::provenance::Provenance;
    use crate::{output, tables};
    use scene::load::load;

    /// A reattached study of each kind equals the original.
    #[test]
    fn reattached_study_equals_the_original() {
        for (scene, sets) in [("contact-kinematic", &[][..]), ("lock", &[]), ("lock-cold", &["runs=2".to_owned()])] {
            let loaded = load(scene, sets).unwrap_or_else(|error| panic!("{error}"));
            let study = run(&loaded, Options::default()).expect("a study");
            // Compared as text, because NaN differs from itself.
            let text = |study: &Study| format!("{} {:?}", output::summary(study), tables::report(study, &Provenance::default()));
            let before = text(&study);
            let again = study.detached().of(&loaded.scene).expect("of the same kind");
            assert!(before == text(&again), "{scene}");
        }
        let (contact, lock) = (load("contact-kinematic", &[]).expect("a scene"), load("lock", &[]).expect("a scene"));
        assert!(run(&contact, Options::default()).expect("a study").detached().of(&lock.scene).is_none());
    }
}
