//! Rules for values that are replaced before they have an effect: values of an axis of the grid or
//! of `[[vary]]`, and values that are set on top of a `[[vary]]`.

use super::{Rules, join};
use crate::Scene;
use crate::diagnostic::{Place, Problem};
use crate::replaced::Replaced;

impl Rules<'_> {
    pub(super) fn replaced(&mut self) {
        if !self.findings.problems.is_empty() || !(self.given("vary") || self.given("grid")) {
            return;
        }
        let Ok(scene) = Scene::from_tree(self.root) else { return };
        let (drawn, axes) = (self.named("vary"), self.named("grid.over"));
        let set = |(set, place): (String, Place)| Some((set.split_once('=')?.0.trim().to_owned(), place));
        let sets: Vec<_> = self.sets("grid.set").into_iter().filter_map(set).collect();
        let over = || axes.iter().chain(&sets);
        let others: Vec<&str> = over().map(|(key, _)| key.as_str()).collect();
        // Points with their own `vary` or `runs` are checked when they are built.
        let own_draws = others.iter().any(|key| *key == "runs" || key.starts_with("vary"));
        let of_a_point = over().filter(|_| !own_draws).map(|(key, place)| (key, place.clone(), scene.replaced(key, &others)));
        let of_a_run = drawn.iter().map(|(key, place)| (key, place.clone(), scene.replaced_in_time(key, &others)));
        // A value in the same text is the initial value for the entry of `[[vary]]`.
        let laid_over = drawn.iter().filter_map(|(key, _)| {
            let (by, place) = (scene.drawn(key)?, self.root.at(key)?.place.clone());
            (place.source < self.place(&by.by).source).then_some((key, place, Some(by)))
        });
        let problem = |(key, place, by): (&String, Place, Option<Replaced>)| {
            let Replaced { why, help, .. } = by?;
            Some((key.clone(), Problem::new(place, format!("`{key}` {why}"), "other values have no effect").help(help)))
        };
        let problems: Vec<_> = of_a_point.chain(of_a_run).chain(laid_over).filter_map(problem).collect();
        problems.into_iter().for_each(|(key, problem)| self.add(&key, problem));
    }

    /// Returns the keys that the tables of a list name, with their places.
    fn named(&self, list: &str) -> Vec<(String, Place)> {
        let key = |table: &String| Some((self.text(&join(table, "key"))?.to_owned(), self.place(&join(table, "key"))));
        self.tables(list).iter().filter_map(key).collect()
    }
}
