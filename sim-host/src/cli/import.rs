//! `sim-host import`: fits parameters to measured data and writes a report and a scene.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Value, json};

use super::progress::timed;
use super::{Color, Exit, Format, ReportArgs, mistake, print_styled, visible};
use ::import::admittance::coordinate::Topology;
use ::import::admittance::options::{ModeChoice, Options};
use ::import::admittance::{self, MOST_MODES};
use ::import::error::ImportError;
use ::import::friction::conditions::Request;
use ::import::friction::{self, Found};
use ::import::units::Units;
use report::Report;
use scene::load::load_text;
use sim::output::{Folder, Owner};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct ImportArgs {
    #[command(subcommand)]
    kind: ImportKind,
}

#[derive(Subcommand)]
enum ImportKind {
    /// Fit an equivalent circuit to an admittance or impedance sweep.
    ///
    /// Reads Touchstone (.s1p or .s2p) or a table. Prints the circuit with standard deviations.
    Admittance(AdmittanceArgs),
    /// Fit friction at all conditions, or contact models to a log.
    ///
    /// Reads one file or several: logs with time, force and speed, or tables with a row for each
    /// measurement. Conditions are columns or parts of file names, such as `speed=0.1mps_on.csv`.
    /// Friction without (OFF) and with vibration (ON) is fitted together. A log without vibration
    /// becomes a contact.
    Friction(FrictionArgs),
}

/// Arguments that every import has.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for report, figures and scene; unchanged files of an earlier import of the \
same kind are replaced. Default: `out/` and the name of the file, with `-admittance` or `-friction` appended if that folder may \
not be replaced")))]
struct Common {
    /// Column names that replace the table's heading, as `"f [Hz], |Z| [ohm], theta [deg]"`.
    #[arg(long, value_name = "NAMES")]
    columns: Option<String>,
    #[command(flatten)]
    report: ReportArgs,
}

#[derive(Args)]
struct AdmittanceArgs {
    /// Measured file.
    file: PathBuf,
    #[command(flatten)]
    common: Common,
    /// Unit of a column that states none, as `khz`, `ohm`, `ms`, `deg` (repeatable).
    #[arg(long = "unit", value_name = "UNIT")]
    units: Vec<String>,
    /// Reference resistance of scattering parameters in a table, ohm. Touchstone files state their
    /// own. Default: 50.
    #[arg(long, value_name = "OHM", value_parser = ohm)]
    z0: Option<f64>,
    /// Connection of the transducer to the network analyser. Default: one port for .s1p; for .s2p
    /// derived from the data.
    #[arg(long, value_enum)]
    topology: Option<Connection>,
    /// Sweep of the open fixture, in the form of FILE, for compensation.
    #[arg(long, value_name = "FILE")]
    open: Option<PathBuf>,
    /// Sweep of the shorted fixture, in the form of FILE, for compensation.
    #[arg(long, value_name = "FILE")]
    short: Option<PathBuf>,
    /// External resistance in series with the transducer, ohm; it is subtracted.
    #[arg(long, value_name = "OHM", default_value_t = 0.0, value_parser = resistance)]
    series_ohm: f64,
    /// Number of resonances to fit. Default: chosen from the data, at most eight.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=MOST_MODES as i64))]
    modes: Option<u8>,
    /// Working mode, by its number in the table of resonances or by a frequency near it, Hz, as
    /// 40.1k. Default: the one with the largest figure of merit, Q Cm / C0.
    #[arg(long, value_name = "N|HZ")]
    mode: Option<ModeChoice>,
    /// Write the scene even if the circuit does not describe the data.
    #[arg(long)]
    force: bool,
}

#[derive(Args)]
struct FrictionArgs {
    /// Measured files.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    #[command(flatten)]
    common: Common,
    /// Normal force, N, if no column contains it.
    #[arg(long, value_name = "N", value_parser = newtons)]
    normal_n: Option<f64>,
    /// Time with vibration ON, s, if no column states it (repeatable).
    #[arg(long, value_name = "FROM:TO", value_parser = span)]
    on: Vec<(f64, f64)>,
    /// Unit of a column or of a part of a file name that states none, as `m/s`, `N`, `um`
    /// (repeatable).
    #[arg(long = "unit", value_name = "UNIT")]
    units: Vec<String>,
    /// Frequency of the vibration, Hz, such as 40k, if no column contains it. A scene needs it.
    #[arg(long, value_name = "HZ", value_parser = frequency)]
    frequency_hz: Option<f64>,
    /// Peak velocity of the vibration at the contact, m/s, if it was measured and no column
    /// contains it. Default: fitted to the friction ON.
    #[arg(long, value_name = "V", value_parser = positive)]
    tip_m_per_s: Option<f64>,
    /// Write a scene even if the fit does not describe the measurements.
    #[arg(long)]
    force: bool,
    /// Condition to predict, as `speed=0.15,amplitude=5um,normal=10` (repeatable).
    #[arg(long, value_name = "CONDITION")]
    predict: Vec<Request>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Connection {
    /// Reflection S11 at one port.
    OnePort,
    /// Transducer between two ports: S21.
    SeriesThrough,
    /// Transducer from the line between two ports to ground: S21.
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

fn positive(text: &str) -> Result<f64, String> {
    in_range(text.parse().ok())
}

fn frequency(text: &str) -> Result<f64, String> {
    in_range(columns::hertz(text))
}

fn in_range(number: Option<f64>) -> Result<f64, String> {
    number.filter(|number| (1e-9..=1e9).contains(number)).ok_or_else(|| "give a positive number, as 40e3".to_owned())
}

fn span(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').and_then(|(from, to)| Some((from.parse::<f64>().ok()?, to.parse::<f64>().ok()?)));
    ends.filter(|(from, to)| from < to).ok_or_else(|| "give two increasing times in s, as 2:4".to_owned())
}

/// Imports, writes the result folder, and prints the result.
pub(super) fn run(args: &ImportArgs, color: Color) -> anyhow::Result<Exit> {
    match &args.kind {
        ImportKind::Admittance(args) => import_admittance(args, color),
        ImportKind::Friction(args) => import_friction(args, color),
    }
}

fn import_admittance(args: &AdmittanceArgs, color: Color) -> anyhow::Result<Exit> {
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
        mode: args.mode,
    };
    let inputs = [Some(&args.file), options.open.as_ref(), options.short.as_ref()].into_iter().flatten();
    let owner = Owner::new("import admittance", inputs);
    let import = || admittance::import(&args.file, &options);
    finish((common, owner), std::slice::from_ref(&args.file), import, color, |found, source| Imported {
        scene: found.scene(&source).filter(|_| args.force || !found.is_doubtful()),
        samples: found.samples(),
        report: found.report(&source),
        json: found.json(None),
        notes: notes(&found.warnings),
        source,
    })
}

fn import_friction(args: &FrictionArgs, color: Color) -> anyhow::Result<Exit> {
    let common = &args.common;
    let units = Units::parse_friction(args.units.iter().flat_map(|units| units.split(',')));
    let options = friction::Options {
        columns: common.columns.clone(),
        normal_n: args.normal_n,
        on_s: args.on.clone(),
        units: units.map_err(|error| mistake(Exit::Usage, format!("--unit: {error}")))?,
        frequency_hz: args.frequency_hz,
        tip_m_per_s: args.tip_m_per_s,
    };
    let owner = Owner::new("import friction", &args.files);
    let import = || {
        let found = friction::import_files(&args.files, &options)?;
        let predictions = match &found {
            Found::Conditions(conditions, _) => args.predict.iter().map(|request| conditions.predict(request)).collect(),
            Found::Log(_) if args.predict.is_empty() => Ok(Vec::new()),
            Found::Log(_) => {
                let why = "--predict needs measurements with the vibration ON; add them, or mark them with `--on`";
                Err(ImportError::NoFit(why.into()))
            }
        };
        Ok((found, predictions?))
    };
    finish((common, owner), &args.files, import, color, |(found, predictions), source| {
        let (scene, report, json, mut notes) = match &found {
            Found::Log(log) => (log.scene(&source, &options), log.report(&source), log.json(None), notes(&log.warnings)),
            Found::Conditions(conditions, contact) => {
                let (mut report, mut json) = (conditions.report(&predictions), conditions.json(&predictions));
                let mut notes = notes(&conditions.warnings);
                notes.extend(conditions.assumptions.iter().map(|assumed| format!("assumed: {assumed}")));
                if let Some(contact) = contact {
                    report.figures.extend(contact.report(&source).figures);
                    json["off"] = contact.json(None);
                }
                let scene = match conditions.is_doubtful && !args.force {
                    true => Err("`--force`, because the fit does not describe the measurements".to_owned()),
                    false => conditions.scene(&source, &predictions),
                };
                (scene, report, json, notes)
            }
        };
        notes.extend(scene.as_ref().err().map(|missing| format!("note: no scene is written: it needs {missing}")));
        Imported { scene: scene.ok(), samples: None, report, json, notes, source }
    })
}

/// Returns warnings as lines for the terminal.
fn notes(warnings: &[String]) -> Vec<String> {
    warnings.iter().map(|warning| format!("note: {warning}")).collect()
}

/// Result of an import, as its folder and its output need it.
struct Imported {
    /// Name of the measured file.
    source: String,
    /// Scene of the result, if it has one.
    scene: Option<String>,
    /// Random draws of the result for a scene, as CSV.
    samples: Option<String>,
    /// Report of the result.
    report: Report,
    /// Result as JSON, still without the path of its scene.
    json: Value,
    /// Notes about the result, a line each.
    notes: Vec<String>,
}

/// Writes and prints the result of an import.
fn finish<T>(
    (common, owner): (&Common, Owner),
    files: &[PathBuf],
    import: impl FnOnce() -> Result<T, ImportError>,
    color: Color,
    shown: impl Fn(T, String) -> Imported,
) -> anyhow::Result<Exit> {
    let stem = if let [file] = files { stem(file) } else { "conditions".to_owned() };
    let source = match files {
        [file] => file.file_name().map_or_else(|| stem.clone(), |name| name.to_string_lossy().into_owned()),
        _ => format!("{} files", files.len()),
    };
    let quiet = common.report.result.quiet;
    let imported = timed(format!("fitting {source}"), quiet, || import().map(|found| shown(found, source)));
    let found = imported.map_err(|error| match error {
        ImportError::Unreadable { .. } | ImportError::InFile { .. } => anyhow::Error::from(error),
        error if files.len() > 1 => anyhow::Error::from(error),
        error => anyhow::Error::from(error).context(files[0].display().to_string()),
    })?;
    let folder = common.report.open(&stem, owner)?;
    let name = format!("{stem}.toml");
    let scene = found.scene.clone().filter(|text| is_valid(&name, text));
    let mut written = None;
    if let Some(folder) = &folder {
        let scene = scene.as_deref().map(|text| (name.as_str(), text));
        timed("writing the report".into(), quiet, || write(folder, &found, scene))?;
        written = scene.is_some().then(|| folder.dir().join(&name).display().to_string());
    }
    match common.report.result.format {
        Format::Json => print_styled(&format!("{:#}\n", with_scene(&found.json, written.as_deref())))?,
        Format::Human => {
            let tables: String = found.report.tables.iter().map(|table| table.terminal(color.stdout)).collect();
            let notes: String = found.notes.iter().map(|note| format!("{note}\n")).collect();
            print_styled(&format!("{}\n\n{tables}{}", visible(&found.report.title), visible(&notes)))?
        }
    };
    if let Some(folder) = folder.filter(|_| !quiet) {
        say!("report: {}", folder.dir().join("report.html").display());
        if let Some(scene) = &written {
            say!("scene: {scene}; run it with `sim-host run {scene}`");
        }
    }
    Ok(Exit::Done)
}

/// Returns the name of a file without its extension, as a valid name of a scene and folder.
fn stem(file: &Path) -> String {
    let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let clean: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    let clean = clean.trim_matches('-').to_owned();
    if clean.is_empty() { "measured".into() } else { clean }
}

/// Returns `true` if the scene can be run, or else prints the reason.
fn is_valid(name: &str, text: &str) -> bool {
    match load_text(name, text, &[]) {
        Ok(_) => true,
        Err(error) => {
            say!("note: no scene is written, because its values are outside the limits of a scene\n{error}");
            false
        }
    }
}

/// Returns the result as JSON with the path of its scene.
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
        if let Some(samples) = &found.samples {
            put("samples.csv", samples)?;
        }
    }
    put("summary.json", &format!("{:#}\n", with_scene(&found.json, scene.map(|(name, _)| name))))?;
    Ok(folder.finish(json!({ "imported": found.source, "complete": true }))?)
}
