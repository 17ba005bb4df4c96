//! `sim-host import`: measured data as parameters, with a report and a ready scene.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Value, json};

use super::{Color, Exit, Format, ReportArgs, mistake, print};
use ::import::admittance::coordinate::Topology;
use ::import::admittance::options::Options;
use ::import::admittance::{self, MOST_MODES};
use ::import::error::ImportError;
use ::import::friction;
use ::import::units::Units;
use report::Report;
use scene::load::load_text;
use sim::output::{Folder, Owner};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct ImportArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// A measured admittance or impedance over frequency (Touchstone .s1p or .s2p, or a table): the equivalent circuit with standard deviations.
    Admittance(AdmittanceArgs),
    /// A friction log (time or displacement, force, velocity; OFF and ON parts): contact models with standard deviations, and the friction ratio.
    Friction(FrictionArgs),
}

/// What every import has.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for report, figures and scene. The files of an earlier import of the same kind are replaced if none has changed. Default: `out/` and the name of the file; if that folder may not be replaced, the same name with `-admittance` or `-friction` behind")))]
struct Common {
    /// The measured file.
    file: PathBuf,
    /// Names of a table's columns, in place of its heading, as `"f [Hz], |Z| [ohm], theta [deg]"`.
    #[arg(long, value_name = "NAMES")]
    columns: Option<String>,
    #[command(flatten)]
    report: ReportArgs,
}

#[derive(Args)]
struct AdmittanceArgs {
    #[command(flatten)]
    common: Common,
    /// Unit of a column that names none, as `khz`, `ohm`, `ms`, `deg`. Repeatable.
    #[arg(long = "unit", value_name = "UNIT")]
    units: Vec<String>,
    /// Reference resistance of scattering parameters in a table, ohm; a Touchstone file says its own.
    #[arg(long, value_name = "OHM", default_value_t = 50.0, value_parser = ohm)]
    z0: f64,
    /// How the transducer was connected to a network analyser. Default: of an .s1p one port, of an .s2p what its data show.
    #[arg(long, value_enum)]
    topology: Option<Connection>,
    /// A sweep of the open fixture, in the form of FILE, to be taken away.
    #[arg(long, value_name = "FILE")]
    open: Option<PathBuf>,
    /// A sweep of the shorted fixture, in the form of FILE, to be taken away.
    #[arg(long, value_name = "FILE")]
    short: Option<PathBuf>,
    /// A resistance in series with the transducer that is no part of it, ohm.
    #[arg(long, value_name = "OHM", default_value_t = 0.0, value_parser = resistance)]
    series_ohm: f64,
    /// How many resonances to fit. Default: as many as the data ask for, three at most.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=MOST_MODES as i64))]
    modes: Option<u8>,
}

#[derive(Args)]
struct FrictionArgs {
    #[command(flatten)]
    common: Common,
    /// Normal force, N, where no column has it.
    #[arg(long, value_name = "N", value_parser = newtons)]
    normal_n: Option<f64>,
    /// When the vibration is ON, s, where no column says it. Repeatable.
    #[arg(long, value_name = "FROM:TO", value_parser = span)]
    on: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Connection {
    /// Reflection S11 of one port.
    OnePort,
    /// Between two ports: S21.
    SeriesThrough,
    /// From the line between two ports to ground: S21.
    ShuntThrough,
}

fn ohm(text: &str) -> Result<f64, String> {
    let ohm = text.parse::<f64>().ok().filter(|ohm| (1e-3..=1e6).contains(ohm));
    ohm.ok_or_else(|| "give a resistance from 0.001 to 1e6 ohm".to_owned())
}

fn resistance(text: &str) -> Result<f64, String> {
    let ohm = text.parse::<f64>().ok().filter(|ohm| (0.0..=1e6).contains(ohm));
    ohm.ok_or_else(|| "give a resistance from 0 to 1e6 ohm".to_owned())
}

fn newtons(text: &str) -> Result<f64, String> {
    let newtons = text.parse::<f64>().ok().filter(|newtons| (1e-9..=1e6).contains(newtons));
    newtons.ok_or_else(|| "give a force from 1e-9 to 1e6 N".to_owned())
}

fn span(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').and_then(|(from, to)| Some((from.parse::<f64>().ok()?, to.parse::<f64>().ok()?)));
    ends.filter(|(from, to)| from < to).ok_or_else(|| "give two rising times in s with a colon between, as 2:4".to_owned())
}

/// Imports, writes the folder of the result, and prints.
pub(super) fn run(args: &ImportArgs, color: Color) -> anyhow::Result<Exit> {
    match &args.what {
        What::Admittance(args) => of_admittance(args, color),
        What::Friction(args) => of_friction(args, color),
    }
}

fn of_admittance(args: &AdmittanceArgs, color: Color) -> anyhow::Result<Exit> {
    let common = &args.common;
    let units = Units::parse(args.units.iter().flat_map(|units| units.split(',')));
    let units = units.map_err(|error| mistake(Exit::Usage, format!("--unit: {error}")))?;
    let topology = args.topology.map(|connection| match connection {
        Connection::OnePort => Topology::OnePort,
        Connection::SeriesThrough => Topology::SeriesThrough,
        Connection::ShuntThrough => Topology::ShuntThrough,
    });
    let options = Options {
        z0_ohm: args.z0,
        topology,
        units,
        columns: common.columns.clone(),
        open: args.open.clone(),
        short: args.short.clone(),
        series_ohm: args.series_ohm,
        modes: args.modes.map(usize::from),
    };
    let inputs = [Some(&common.file), options.open.as_ref(), options.short.as_ref()].into_iter().flatten();
    let owner = Owner::new("import admittance", inputs);
    finish((common, owner), admittance::import(&common.file, &options), color, |found, source| Imported {
        scene: found.scene(&source),
        report: found.report(&source),
        json: found.json(None),
        warnings: found.warnings,
        source,
    })
}

fn of_friction(args: &FrictionArgs, color: Color) -> anyhow::Result<Exit> {
    let common = &args.common;
    let options = friction::Options { columns: common.columns.clone(), normal_n: args.normal_n, on_s: args.on.clone() };
    let owner = Owner::new("import friction", [&common.file]);
    finish((common, owner), friction::import(&common.file, &options), color, |found, source| Imported {
        scene: found.scene(&source),
        report: found.report(&source),
        json: found.json(None),
        warnings: found.warnings,
        source,
    })
}

/// What an import has found, as far as its folder and its output need it.
struct Imported {
    /// Name of the measured file.
    source: String,
    /// The scene of the result, if it has one.
    scene: Option<String>,
    /// The report of the result.
    report: Report,
    /// The result for programs, which does not say yet where its scene is.
    json: Value,
    /// What the reader should be careful about.
    warnings: Vec<String>,
}

/// Writes and prints what an import has found.
fn finish<T>(
    (common, owner): (&Common, Owner),
    imported: Result<T, ImportError>,
    color: Color,
    shown: impl Fn(T, String) -> Imported,
) -> anyhow::Result<Exit> {
    let stem = stem(&common.file);
    let source = common.file.file_name().map_or_else(|| stem.clone(), |name| name.to_string_lossy().into_owned());
    let found = imported.map(|found| shown(found, source)).map_err(|error| match error {
        ImportError::Unreadable { .. } => anyhow::Error::from(error),
        error => anyhow::Error::from(error).context(common.file.display().to_string()),
    })?;
    let folder = common.report.open(&stem, owner)?;
    let name = format!("{stem}.toml");
    let scene = found.scene.clone().filter(|text| is_valid(&name, text));
    let mut written = None;
    if let Some(folder) = &folder {
        write(folder, &found, scene.as_deref().map(|text| (name.as_str(), text)))?;
        written = scene.is_some().then(|| folder.dir().join(&name).display().to_string());
    }
    match common.report.result.format {
        Format::Json => print(&format!("{:#}\n", with_scene(&found.json, written.as_deref())))?,
        Format::Human => {
            let tables: String = found.report.tables.iter().map(|table| table.terminal(color.stdout)).collect();
            let notes: String = found.warnings.iter().map(|warning| format!("note: {warning}\n")).collect();
            print(&format!("{}\n\n{tables}{notes}", found.report.title))?
        }
    };
    if let Some(folder) = folder.filter(|_| !common.report.result.quiet) {
        say!("report: {}", folder.dir().join("report.html").display());
        if let Some(scene) = &written {
            say!("scene: {scene}, to be run by `sim-host run {scene}`");
        }
    }
    Ok(Exit::Done)
}

/// The name of a file without its ending, as that of a scene and of a folder.
fn stem(file: &Path) -> String {
    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let clean: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    let clean = clean.trim_matches('-').to_owned();
    if clean.is_empty() { "measured".into() } else { clean }
}

/// Whether a scene is one that can be run; says why where it is not.
fn is_valid(name: &str, text: &str) -> bool {
    match load_text(name, text, &[]) {
        Ok(_) => true,
        Err(error) => {
            say!("note: no scene is written: its values are outside of what a scene can have\n{error}");
            false
        }
    }
}

/// The result for programs, with where its scene is.
fn with_scene(json: &Value, scene: Option<&str>) -> Value {
    let mut json = json.clone();
    json["scene"] = json!(scene);
    json
}

fn write(folder: &Folder, found: &Imported, scene: Option<(&str, &str)>) -> anyhow::Result<()> {
    let dir = folder.unfinished();
    let file = vec![("measured file".to_owned(), found.source.clone())];
    let footer = [file, super::provenance().footer()].concat();
    report::write(&Report { footer, ..found.report.clone() }, dir)?;
    let put = |name: &str, text: &str| {
        let path = dir.join(name);
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    if let Some((name, text)) = scene {
        put(name, text)?;
    }
    put("summary.json", &format!("{:#}\n", with_scene(&found.json, scene.map(|(name, _)| name))))?;
    Ok(folder.finish(json!({ "imported": found.source, "complete": true }))?)
}
