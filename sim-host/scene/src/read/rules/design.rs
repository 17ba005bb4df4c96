//! The rule for designs: the chain must have a solution.

use super::Rules;
use crate::diagnostic::Problem;
use crate::schema::join;
use design::keys::Design;

const TABLE: &str = "design";

impl Rules<'_> {
    /// Checks a design by solving it.
    pub(super) fn designed(&mut self) {
        let clean = self.findings.problems.is_empty();
        let Some(Ok(keys)) = self.root.at(TABLE).filter(|_| clean).map(|node| node.to_toml().try_into::<Design>()) else {
            return;
        };
        if let Err(error) = design::solve(&keys) {
            let path = join(TABLE, &error.path);
            self.add(&path.clone(), Problem::new(self.place(&path), error.message, error.label));
        }
    }
}
