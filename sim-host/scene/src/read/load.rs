//! Loading of a scene from a name, a file or standard input; failures give a report of all
//! mistakes.

mod assumed;
mod designed;
mod inherited;
mod manifest;
mod pair;

use std::io;
use std::path::{Path, PathBuf};

use columns::file;

use crate::diagnostic::{Problem, Report, Source};
use crate::nearest::{nearest, short};
use crate::overlay::{joined, overlay, parse_set, syntax};
use crate::profile::resolve::{PathProblem, files, resolve};
use crate::schema::BASE;
use crate::tree::{Node, Origin, Value};
use crate::walk::walk;
use crate::{Scene, builtin, distribution, rules};

pub use assumed::Assumed;
pub use inherited::{Change, Inherited, inputs};
pub use manifest::is_unchanged;

/// Largest manifest, bytes. It contains every sample of measured profiles.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;
/// Maximum length of a chain of bases.
const MAX_BASES: usize = 64;

/// A scene and its origin.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Name of the scene: that of a built-in scene, or of the file without folder and extension.
    pub name: String,
    /// Name of the text in messages: the built-in name, the file's path, or `<stdin>`.
    pub origin: String,
    /// The scene as read, with its changes.
    pub scene: Scene,
    /// The text as read.
    pub input: String,
    /// The requested changes, as `key=value`.
    pub sets: Vec<String>,
    /// Number of changes, at the beginning of `sets`, that are defaults of the program, not of the
    /// user.
    pub defaults: usize,
    /// Number of the run, if the scene has several.
    pub run: Option<u32>,
    /// Parts that the repeated run inherited from another scene.
    pub repeats: Option<Inherited>,
    /// Values that the user did not set for this transducer or contact.
    pub assumed: Vec<Assumed>,
    /// `true` if nobody set the number of runs of a scene with distributions.
    pub default_runs: bool,
}

/// A scene without grid and comparison, parsed once, for copies with some values changed.
#[derive(Debug)]
pub struct Template<'a> {
    loaded: &'a Loaded,
    root: Node,
    /// Names of the scene's texts. Files are searched relative to them.
    names: Vec<String>,
}

/// Place of a change: the first of a scene's sources.
const SET: Origin = Origin { source: 0, offset: 0 };

impl Template<'_> {
    /// Returns the scene with these changes, the same as [`Loaded::cell`].
    pub fn scene(&self, sets: &[String]) -> Result<Scene, LoadError> {
        let (mut sources, mut root) = self.sources_and_root();
        let mut problems = Vec::new();
        for over in sets.iter().filter_map(|set| parse_set(set, SET).ok()) {
            overlay(&mut root, over, "", &mut problems);
        }
        // The template already has the values that follow from these keys.
        let derives = |key: &str| root.at(key).map(|node| &node.place) != self.root.at(key).map(|node| &node.place);
        if ["contact.pair", "stack.design"].into_iter().any(derives) {
            return self.loaded.cell(sets).map(|cell| cell.scene);
        }
        let found = resolve(&mut root, &mut sources);
        match checked_scene(root, found) {
            Ok(scene) if problems.is_empty() => Ok(scene),
            // Reading the text again gives the places for the report.
            _ => self.loaded.cell(sets).map(|cell| cell.scene),
        }
    }

    fn assumed_with(&self, keys: &[&str]) -> Vec<Assumed> {
        let (sources, mut root) = self.sources_and_root();
        for over in keys.iter().filter_map(|key| parse_set(&format!("{key}=1"), SET).ok()) {
            overlay(&mut root, over, "", &mut Vec::new());
        }
        assumed::find(&root, &sources)
    }

    fn sources_and_root(&self) -> (Vec<Source>, Node) {
        let sources = self.names.iter().map(|name| Source { name: name.clone(), text: String::new() });
        (sources.collect(), self.root.clone())
    }
}

impl Loaded {
    /// Returns the scene as a template, for many changed copies.
    pub fn template(&self) -> Result<Template<'_>, LoadError> {
        let (sources, read) = read(&self.origin, &self.input, &self.sets);
        let names = sources.iter().map(|source| source.name.clone()).collect();
        let ReadScene { mut root, found, .. } =
            read.map_err(|problems| LoadError::Invalid(Report::new(sources.clone(), problems)))?;
        if !found.is_empty() {
            let problems = found.into_iter().map(|(_, problem)| problem).collect();
            return Err(LoadError::Invalid(Report::new(sources, problems)));
        }
        rules::remove_non_cell_keys(&mut root);
        Ok(Template { loaded: self, root, names })
    }

    /// Returns the values that the user does not set if these keys are set as well, as in a sweep.
    pub fn assumed_with(&self, keys: &[&str]) -> Vec<Assumed> {
        let found = self.template().map_or_else(|_| Vec::new(), |template| template.assumed_with(keys));
        let own = self.assumed.iter().filter(|own| !keys.contains(&own.key.as_str()));
        let more: Vec<_> = own.filter(|own| found.iter().all(|other| other.key != own.key)).cloned().collect();
        [found, more].concat()
    }

    /// Returns the paths that the scene was read from: its own, those of its bases, and those of
    /// its measured profiles. Built-in names are included.
    pub fn files(&self) -> Vec<PathBuf> {
        let (sources, read) = read(&self.origin, &self.input, &self.sets);
        let measured = read.map(|whole| whole.files).unwrap_or_default();
        sources.iter().skip(1).map(|source| PathBuf::from(&source.name)).chain(measured).collect()
    }

    /// Returns the scene with default values, as `key=value`, for keys that neither it nor a change
    /// gives. Keys of lists are not supported.
    pub fn with_defaults(self, defaults: &[String]) -> Result<Self, LoadError> {
        let (_, root) = read(&self.origin, &self.input, &self.sets);
        let gives = |set: &&String| {
            let mut keys = set.split('=').next().unwrap_or_default().split('.');
            root.as_ref().is_ok_and(|read| keys.try_fold(&read.root, |node, key| Some(&node.table()?.get(key)?.node)).is_some())
        };
        let missing: Vec<String> = defaults.iter().filter(|set| !gives(set)).cloned().collect();
        if missing.is_empty() {
            return Ok(self);
        }
        let defaults = missing.len();
        let sets = [missing, self.sets].concat();
        Ok(Self { name: self.name, defaults, ..loaded(&self.origin, &self.input, &sets, |_| ())? })
    }

    /// Returns the scene with further changes.
    pub fn changed(&self, sets: &[String]) -> Result<Self, LoadError> {
        let sets = [self.sets.as_slice(), sets].concat();
        Ok(Self { name: self.name.clone(), defaults: self.defaults, ..loaded(&self.origin, &self.input, &sets, |_| ())? })
    }

    /// Returns the scene with further changes, without grid and comparison: a cell of its grid, or
    /// a case of its comparison.
    pub fn cell(&self, sets: &[String]) -> Result<Self, LoadError> {
        let sets = [self.sets.as_slice(), sets].concat();
        Ok(Self {
            name: self.name.clone(),
            defaults: self.defaults,
            ..loaded(&self.origin, &self.input, &sets, rules::remove_non_cell_keys)?
        })
    }
}

/// Reason why a scene could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Neither a built-in scene nor a file.
    #[error("there is no scene `{name}`: {}", suggest(nearest))]
    NotFound {
        /// The requested name.
        name: String,
        /// Built-in scenes with a similar name.
        nearest: Vec<&'static str>,
    },
    /// The file cannot be read.
    #[error("cannot read the scene `{path}`: {io}")]
    Read {
        /// Path of the file.
        path: String,
        /// Cause of the error.
        #[source]
        io: io::Error,
    },
    /// The scene has mistakes.
    #[error("{0}")]
    Invalid(Report),
}

fn suggest(nearest: &[&str]) -> String {
    match nearest {
        [] => "it is neither a file nor built in; `sim-host list` lists the built-in scenes".to_owned(),
        names => format!("it is neither a file nor built in; try {}", super::nearest::listed(names.iter().copied(), "or")),
    }
}

/// Loads a scene, with changes as `key=value`. The source is the name of a built-in scene, the path
/// of a TOML file or of the manifest of a run, or standard input (`-`).
pub fn load(source: &str, sets: &[String]) -> Result<Loaded, LoadError> {
    if source == "-" {
        const STDIN: &str = "<stdin>";
        let text = scene_text(file::read_from(io::stdin().lock(), MAX_MANIFEST_BYTES))
            .map_err(|io| LoadError::Read { path: STDIN.to_owned(), io })?;
        return Ok(Loaded { name: "stdin".to_owned(), ..load_text(STDIN, &text, sets)? });
    }
    let text = read_source(source, source)?;
    if let Some(repeated) = manifest::scene(&text) {
        let (name, text, repeats, assumed) = repeated.map_err(|why| {
            let io = io::Error::new(io::ErrorKind::InvalidData, why);
            LoadError::Read { path: source.to_owned(), io }
        })?;
        let sets_key = |key: &str| sets.iter().any(|set| set.split('=').next().map(str::trim) == Some(key));
        let is_set = |it: &Assumed| sets_key(&it.key) || it.pair.is_some() && sets_key("contact.pair");
        let repeated = load_text(source, &text, sets)?;
        let assumed = assumed.into_iter().filter(|it| !is_set(it)).chain(repeated.assumed).collect();
        return Ok(Loaded { name, repeats, assumed, ..repeated });
    }
    let name = match builtin::text(source) {
        Some(_) => source.to_owned(),
        None => Path::new(source).file_stem().map_or_else(|| source.to_owned(), |stem| stem.to_string_lossy().into_owned()),
    };
    Ok(Loaded { name, ..load_text(source, &text, sets)? })
}

/// Loads a scene from its text. A relative `base` is relative to the folder of `name`.
pub fn load_text(name: &str, text: &str, sets: &[String]) -> Result<Loaded, LoadError> {
    loaded(name, text, sets, |_| ())
}

/// A tree with the samples of its profiles.
struct ReadScene {
    root: Node,
    /// Problems of the profiles.
    found: Vec<PathProblem>,
    /// Files that the profiles are read from.
    files: Vec<PathBuf>,
    /// Number of sources, at the beginning of the list, that are changes and texts of scenes. The
    /// rest are files of profiles.
    texts: usize,
    /// `true` if the number of runs is the default of a scene with distributions.
    default_runs: bool,
}

/// Reads the texts of a scene, and builds the tree with its changes and the samples of its
/// profiles.
fn read(name: &str, text: &str, sets: &[String]) -> (Vec<Source>, Result<ReadScene, Vec<Problem>>) {
    let (changes, starts) = joined(sets);
    // Newer texts come first in this list.
    let mut sources = vec![Source { name: "--set".to_owned(), text: changes }];
    sources.push(Source { name: name.to_owned(), text: text.to_owned() });
    let root = merge_bases(&mut sources).and_then(|root| change(root, sets, &starts)).and_then(|mut root| {
        let texts = sources.len();
        let mut files = files(&root, &sources);
        files.extend(designed::replace(&mut root, &sources).map_err(|problem| vec![problem])?);
        pair::complete(&mut root).map_err(|problem| vec![problem])?;
        let (more, default_runs) = distribution::replace(&mut root, &sources)?;
        files.extend(more);
        let found = resolve(&mut root, &mut sources);
        Ok(ReadScene { root, found, files, texts, default_runs })
    });
    (sources, root)
}

fn loaded(name: &str, text: &str, sets: &[String], prepare: fn(&mut Node)) -> Result<Loaded, LoadError> {
    let (sources, read) = read(name, text, sets);
    let ReadScene { mut root, found, default_runs, .. } = match read {
        Ok(read) => read,
        Err(problems) => return Err(LoadError::Invalid(Report::new(sources, problems))),
    };
    prepare(&mut root);
    let assumed = assumed::find(&root, &sources);
    match checked_scene(root, found) {
        Ok(scene) => Ok(Loaded {
            name: name.to_owned(),
            origin: name.to_owned(),
            scene,
            input: text.to_owned(),
            sets: sets.to_vec(),
            defaults: 0,
            run: None,
            repeats: None,
            assumed,
            default_runs,
        }),
        Err(problems) => Err(LoadError::Invalid(Report::new(sources, problems))),
    }
}

fn checked_scene(mut root: Node, found: Vec<PathProblem>) -> Result<Scene, Vec<Problem>> {
    if let Some(problem) = rules::two_kinds(&root) {
        return Err(vec![problem]);
    }
    rules::circuit::clamped(&mut root);
    let mut walked = walk(&mut root);
    found.into_iter().for_each(|(path, problem)| walked.add(path, problem));
    rules::circuit::complete(&mut root);
    let problems = rules::check(&root, walked).problems;
    if !problems.is_empty() {
        return Err(problems);
    }
    Scene::from_tree(&root).map_err(|error| vec![Problem::new(root.place.clone(), error.message(), "")])
}

/// Merges the scene with its base, the base with its own base, and so on. Adds the bases to the
/// sources.
fn merge_bases(sources: &mut Vec<Source>) -> Result<Node, Vec<Problem>> {
    let mut stack = Vec::new();
    loop {
        let number = sources.len() - 1;
        let source = &sources[number];
        let origin = Origin { source: number, offset: 0 };
        let mut root = Node::parse(&source.text, origin).map_err(|error| vec![syntax(&error, &source.text, origin)])?;
        let base = take_base(&mut root);
        let empty = root.table().is_some_and(|table| table.is_empty());
        if empty && base.is_none() {
            let problem = Problem::new(root.place.clone(), "the scene is empty", "nothing to run");
            return Err(vec![problem.help("start from a copy: `sim-host show experiment-1 > my-scene.toml`")]);
        }
        stack.push(root);
        let Some(base) = base else { break };
        if stack.len() > MAX_BASES {
            let problem =
                Problem::new(base.place, format!("more than {MAX_BASES} scenes start from one another"), "one too many");
            return Err(vec![problem.help("combine some of the bases into one file")]);
        }
        let found = find_base(&base, sources, number).map_err(|problem| vec![problem])?;
        sources.push(found);
    }
    let mut problems = Vec::new();
    let mut layers = stack.into_iter().rev();
    let Some(mut root) = layers.next() else { return Err(Vec::new()) };
    for over in layers {
        let end = over.place.clone();
        overlay(&mut root, over, "", &mut problems);
        root.place = end;
    }
    if problems.is_empty() { Ok(root) } else { Err(problems) }
}

fn take_base(root: &mut Node) -> Option<Node> {
    match &mut root.value {
        Value::Table(table) => table.remove(BASE).map(|entry| entry.node),
        _ => None,
    }
}

fn find_base(base: &Node, sources: &[Source], number: usize) -> Result<Source, Problem> {
    let problem = |message: String, label: String| Problem::new(base.place.clone(), message, label);
    let Some(name) = base.text() else {
        return Err(problem(
            format!("`base` cannot be {}", base.kind()),
            "expected a built-in name or a file, as a string".to_owned(),
        ));
    };
    let beside = sources.get(number).and_then(|source| Path::new(&source.name).parent()).unwrap_or(Path::new(""));
    let path = match builtin::text(name) {
        Some(_) => name.to_owned(),
        None => beside.join(name).to_string_lossy().into_owned(),
    };
    let same = |source: &&Source| canonical(&source.name) == canonical(&path);
    if let Some(earlier) = sources.iter().skip(1).find(same) {
        let message = format!("`base` is circular: it leads back to {}", short(&earlier.name));
        return Err(problem(message, "already part of this scene".to_owned()));
    }
    let text = read_source(&path, name).map_err(|error| match error {
        LoadError::NotFound { nearest, .. } => {
            problem(format!("there is no scene `{}` to start from", short(name)), suggest(&nearest))
        }
        other => problem(other.to_string(), "the scene to start from".to_owned()),
    })?;
    Ok(Source { name: path, text })
}

fn canonical(name: &str) -> PathBuf {
    Path::new(name).canonicalize().unwrap_or_else(|_| PathBuf::from(name))
}

/// Applies the `--set` arguments; `starts` are their offsets in the first source.
fn change(mut root: Node, sets: &[String], starts: &[usize]) -> Result<Node, Vec<Problem>> {
    let mut problems = Vec::new();
    for (set, &offset) in sets.iter().zip(starts) {
        match parse_set(set, Origin { source: 0, offset }) {
            Ok(mut over) => match take_base(&mut over) {
                Some(base) => {
                    let problem = Problem::new(base.place, "`base` cannot be set", "name the scene to run instead");
                    problems.push(problem);
                }
                None => overlay(&mut root, over, "", &mut problems),
            },
            Err(problem) => problems.push(problem),
        }
    }
    if problems.is_empty() { Ok(root) } else { Err(problems) }
}

/// Reads the text of a built-in scene or of a file; `asked` is the name that the user gave.
pub(crate) fn read_source(source: &str, asked: &str) -> Result<String, LoadError> {
    if let Some(text) = builtin::text(source) {
        return Ok(text.to_owned());
    }
    let path = Path::new(source);
    let looks_like_name = Path::new(asked).extension().is_none() && Path::new(asked).components().count() == 1;
    match scene_text(file::read(path, MAX_MANIFEST_BYTES)) {
        Ok(text) => Ok(text),
        Err(error) if error.kind() == io::ErrorKind::NotFound && looks_like_name => {
            let nearest = nearest(asked, builtin::all().iter().map(|(name, _)| *name));
            Err(LoadError::NotFound { name: asked.to_owned(), nearest })
        }
        Err(_) if path.join("manifest.json").is_file() => {
            let what = format!("it is the folder of a run; `sim-host run {source}/manifest.json` repeats the run");
            Err(LoadError::Read { path: source.to_owned(), io: io::Error::other(what) })
        }
        Err(io) => Err(LoadError::Read { path: source.to_owned(), io }),
    }
}

/// Returns the text of a scene, or of a larger manifest.
fn scene_text(read: io::Result<Vec<u8>>) -> io::Result<String> {
    let bytes = read?;
    if bytes.iter().find(|byte| !byte.is_ascii_whitespace()) != Some(&b'{') {
        file::check_size(bytes.len() as u64, file::MAX_TEXT_BYTES)?;
    }
    file::text(bytes)
}
