//! State of a worker: the last run, whose files the page can request.

use std::error::Error;

use contact::Clock;
use scene::load::Loaded;
use scene::resolved::resolved_toml;
use serde_json::Value;
use sim::study::{self, Detached, Options, Study};
use sim::{figures, summary, trace_table};

use crate::measurement::OpenedFile;
use crate::request::Request;
use crate::series::Shown;
use crate::{opened, outcome};

/// Observer of a run: called with the simulated time, s, or for several runs with the number of
/// completed ones.
pub type Progress<'a> = &'a mut (dyn FnMut(f64) + Send);

/// Opens scenes, runs them, and returns the files of the last run.
#[derive(Default)]
pub struct Session {
    last: Option<(Loaded, Detached)>,
    clock: Option<Clock>,
}

impl Session {
    /// Creates a session that times its runs.
    pub fn timed(clock: Clock) -> Self {
        Session { clock: Some(clock), ..Session::default() }
    }

    /// Returns the data of a scene that the page shows before a run.
    ///
    /// # Errors
    /// All errors in the scene, with the messages of the command line.
    pub fn open(&self, request: &Request) -> Result<Value, String> {
        opened::opened(request)
    }

    /// Runs a scene.
    ///
    /// # Errors
    /// All errors in the scene, or the reason for which it has no result, with the messages of the
    /// command line.
    pub fn run(&mut self, request: &Request, progress: Option<Progress>) -> Result<Value, String> {
        let loaded = request.load()?;
        let options = Options { progress, clock: self.clock, ..Options::default() };
        let study = study::run(&loaded, options).map_err(|error| causes(&error))?;
        let shown = outcome::to_json(&study);
        let study = study.detached();
        self.last = Some((loaded, study));
        Ok(shown)
    }

    /// Returns a file of the last run, byte for byte as the command line writes it: `summary.json`,
    /// `trace.csv`, `scene.toml`, or `ID.csv` of a figure.
    ///
    /// # Errors
    /// If there is no run, or the run has no such file.
    pub fn file(&mut self, name: &str) -> Result<String, String> {
        self.of_last(|study, _| text(study, name))?
    }

    /// Reads a file as a scene. A measurement becomes the scene of its fit, or is compared with the
    /// last run.
    ///
    /// # Errors
    /// If the content is neither a scene nor a measurement, in the words of the command line.
    pub fn read(&mut self, file: &OpenedFile, content: Vec<u8>) -> Result<Value, String> {
        let shown = self.of_last(|study, loaded| Shown { loaded: loaded.clone(), figures: figures::of(study) });
        file.read(content, shown.ok().as_ref())
    }

    fn of_last<T>(&mut self, find: impl FnOnce(&Study, &Loaded) -> T) -> Result<T, String> {
        let (loaded, study) = self.last.take().ok_or("there is no run yet")?;
        let Some(study) = study.of(&loaded.scene) else {
            return Err("the last run is of a different kind from its scene".to_owned());
        };
        let found = find(&study, &loaded);
        let study = study.detached();
        self.last = Some((loaded, study));
        Ok(found)
    }
}

fn text(study: &Study, name: &str) -> Result<String, String> {
    match name {
        "summary.json" => Ok(format!("{:#}\n", summary::summary(study))),
        "scene.toml" => Ok(resolved_toml(study.scene)),
        "trace.csv" => trace_table::text(study)
            .map_err(|error| causes(&error))
            .and_then(|bytes| String::from_utf8(bytes).map_err(|error| causes(&error))),
        name => {
            let figures = figures::of(study);
            let figure = figures.iter().find(|figure| Some(figure.id.as_str()) == name.strip_suffix(".csv"));
            let figure = figure.ok_or_else(|| format!("the run has no file `{name}`"))?;
            report::csv(figure).map_err(|error| causes(&error))
        }
    }
}

/// Formats an error with its causes as on the command line.
fn causes(error: &dyn Error) -> String {
    let mut said = format!("error: {error}");
    let mut next = error.source();
    while let Some(cause) = next {
        said += &format!(": {cause}");
        next = cause.source();
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(name: &str) -> (Session, Value) {
        let mut session = Session::default();
        let result = session.run(&Request { name: name.into(), ..Request::default() }, None);
        (session, result.unwrap_or_else(|error| panic!("{error}")))
    }

    #[test]
    fn a_driven_run_has_a_scope_figures_and_files() {
        let (mut session, result) = run("belt-stop");
        let lanes: Vec<_> =
            result["scope"]["lanes"].as_array().unwrap().iter().map(|lane| lane["id"].as_str().unwrap()).collect();
        assert_eq!(lanes, ["drive", "current", "velocity", "friction", "frequency"]);
        let events = result["scope"]["events"].to_string();
        assert!(events.contains("fault 40") && events.contains("mode Run"), "{events}");
        for figure in result["figures"].as_array().unwrap() {
            let csv = session.file(&format!("{}.csv", figure["id"].as_str().unwrap())).unwrap();
            assert!(csv.lines().count() > 1, "{figure}");
        }
        assert!(session.file("trace.csv").unwrap().starts_with("time_s,mode,"));
        assert!(session.file("summary.json").unwrap().contains("\"drive_hash\": \"67fece284568bb71\""));
        assert!(session.file("scene.toml").unwrap().contains("[rig.slider]"));
        assert_eq!(session.file("nothing.csv").unwrap_err(), "the run has no file `nothing.csv`");
    }

    #[test]
    fn a_motor_and_a_crash_have_their_views() {
        let (_, motor) = run("usm");
        let view = &motor["motor"];
        assert_eq!((&view["waves"], &view["tabs"], &view["lanes"]), (&3.0.into(), &12.into(), &4.into()));
        let turned = view["rotor_rad"].as_array().unwrap().last().unwrap().as_f64().unwrap();
        let speed = motor["metrics"]["rotor_speed_rad_per_s"].as_f64().unwrap();
        assert!(turned > 0.12 * speed && motor["crash"].is_null(), "{turned} rad at {speed} rad/s");
        let (_, crash) = run("dring-crash");
        assert!(crash["crash"]["instants"].as_array().unwrap().len() > 100 && crash["motor"].is_null());
    }

    #[test]
    fn a_contact_and_several_runs_have_no_codes() {
        let (_, contact) = run("contact");
        assert!(contact["drive_hash"].is_null() && contact["scope"]["lanes"].as_array().unwrap().len() == 3);
        let request = Request { name: "lock-cold".into(), sets: vec!["runs=3".into()], ..Request::default() };
        let runs = Session::default().run(&request, None).unwrap();
        assert!(runs["scope"].is_null() && runs["drive_hash"].is_string());
    }
}
