//! A study without its scene, for a caller that stores the scene next to it.

use super::answer::Answer;
use super::contact::Solved;
use super::design::Drawn;
use super::driven::{Level, Run};
use super::monte_carlo::MonteCarlo;
use super::playback::Playback;
use super::{Outcome, Rest, Study};
use crate::record::Record;
use ::design::Solved as Solution;
use scene::Scene;

/// All parts of a study except its scene.
#[derive(Debug)]
pub struct Detached {
    outcome: DetachedOutcome,
    rest: Rest,
}

#[derive(Debug)]
enum DetachedOutcome {
    Driven(Level, Box<Record>),
    Contact(Box<(Option<Answer>, Playback)>),
    Design(Box<Solution>),
    MonteCarlo(Box<MonteCarlo>),
}

impl Study<'_> {
    /// Detaches the study from its scene without copying.
    pub fn detached(self) -> Detached {
        let outcome = match self.outcome {
            Outcome::Driven(run) => DetachedOutcome::Driven(run.level, Box::new(run.record)),
            Outcome::Contact(solved) => DetachedOutcome::Contact(Box::new((solved.answer, solved.playback))),
            Outcome::Design(drawn) => DetachedOutcome::Design(Box::new(drawn.solved)),
            Outcome::MonteCarlo(runs) => DetachedOutcome::MonteCarlo(runs),
        };
        Detached { outcome, rest: self.rest }
    }
}

impl Detached {
    /// Attaches the study to its scene again without copying; `None` if the scene is of another
    /// kind.
    pub fn of(self, scene: &Scene) -> Option<Study<'_>> {
        let outcome = match self.outcome {
            DetachedOutcome::Driven(level, record) => {
                Outcome::Driven(Box::new(Run { scene: scene.driven()?, level, record: *record }))
            }
            DetachedOutcome::Contact(solved) => {
                let (answer, playback) = *solved;
                Outcome::Contact(Box::new(Solved { scene: scene.excited()?, answer, playback }))
            }
            DetachedOutcome::Design(solved) => Outcome::Design(Box::new(Drawn { scene: scene.designed()?, solved: *solved })),
            DetachedOutcome::MonteCarlo(runs) => Outcome::MonteCarlo(runs),
        };
        Some(Study { scene, outcome, rest: self.rest })
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
        for (scene, sets) in
            [("contact-kinematic", &[][..]), ("lock", &[]), ("langevin", &[]), ("lock-cold", &["runs=2".to_owned()])]
        {
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
