//! Rules of overlays: the figure must have the curve, and an axis with a convertible unit.

use super::{Rules, listed, nearest, short};
use crate::diagnostic::Problem;
use crate::figures::{FIGURES, FigureData, axis_units};
use crate::schema::join;
use columns::heading::factor;

impl Rules<'_> {
    pub(super) fn overlays(&mut self) {
        for path in self.tables("overlay") {
            self.curve(&path);
            self.points(&path);
        }
    }

    fn curve(&mut self, path: &str) {
        let (quantity, figure) = (join(path, "quantity"), join(path, "figure"));
        let Some(curve) = self.text(&quantity).map(str::to_owned) else { return };
        let named = self.text(&figure).map(str::to_owned);
        if let Some(id) = &named
            && FigureData::of(id).is_none()
        {
            let ids = FIGURES.iter().map(|figure| figure.id);
            let label =
                nearest(id, ids).first().map_or("not a figure of a run".to_owned(), |near| format!("did you mean `{near}`?"));
            let problem = Problem::new(self.place(&figure), format!("there is no figure `{}`", short(id)), label);
            return self.add(
                &figure,
                problem.help("`sim-host explain FIGURE.csv` describes a figure; docs/metrics-and-files.md lists all"),
            );
        }
        let may_be = |figure: &&FigureData| named.as_ref().is_none_or(|id| figure.has_id(id)) && figure.has_curves();
        let candidates: Vec<&FigureData> = FIGURES.iter().filter(may_be).collect();
        let having: Vec<&FigureData> = candidates.iter().copied().filter(|figure| figure.has(&curve)).collect();
        if having.is_empty() {
            let curves: Vec<&str> = candidates.iter().flat_map(|figure| figure.columns.iter().copied()).collect();
            let label = nearest(&curve, curves.iter().copied())
                .first()
                .map_or("not a curve".to_owned(), |near| format!("did you mean `{near}`?"));
            let message = match &named {
                Some(id) => format!("the figure `{}` has no curve `{}`", short(id), short(&curve)),
                None => format!("no figure has a curve `{}`", short(&curve)),
            };
            let problem = Problem::new(self.place(&quantity), message, label);
            let help = match &named {
                Some(_) => format!("it has {}", listed(curves, "and")),
                None => "the curves of each figure are the columns of its CSV; docs/metrics-and-files.md lists them".to_owned(),
            };
            return self.add(&quantity, problem.help(help));
        }
        let unit = self.text(&join(path, "x_unit")).map(str::to_owned);
        let axes: Vec<&str> = having.iter().map(|figure| figure.x).collect();
        if self.clean(path)
            && self.has_points(path)
            && !axes.iter().flat_map(|axis| axis_units(axis)).any(|axis| factor(unit.as_deref(), axis).is_some())
        {
            let given = unit.unwrap_or_else(|| "no unit".to_owned());
            let message = format!("the points are over {given}, but the figure is over {}", listed(axes, "or"));
            let problem = Problem::new(self.place(&join(path, "x")), message, "another axis");
            self.add(path, problem.help("`x_column` and `x_unit` select the horizontal axis"));
        }
    }

    fn has_points(&self, path: &str) -> bool {
        self.root.at(&join(path, "x")).is_some_and(|node| node.samples().is_some())
    }

    fn points(&mut self, path: &str) {
        let samples = |key: &str| self.root.at(&join(path, key)).and_then(|node| node.samples()).map(|samples| samples.len());
        let (Some(x), Some(values)) = (samples("x"), samples("values")) else { return };
        if self.clean(path) && (x != values || x == 0) {
            let problem = Problem::new(
                self.place(&join(path, "values")),
                format!("the overlay has {x} positions and {values} values"),
                "needs equal numbers of both, at least one",
            );
            self.add(path, problem);
        }
    }
}
