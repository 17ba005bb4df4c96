//! `sim-host run`.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use firmware::config::Config;

use super::progress::Progress;
use super::{Color, EXPECTATION_MISSED, Format, INTERRUPTED, LOST, RUN_FAILED, RunArgs, SceneArgs, table, with_scene};
use crate::pil::{self, PilError, Qemu};
use crate::processor::{Here, Processor};
use crate::run::RunError;
use crate::scene::load::Loaded;
use crate::study::{self, Level, Study, StudyError};
use crate::{findings, output, settings};

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Runs a scene and says how it went.
pub(super) fn run(args: &RunArgs, color: Color) -> anyhow::Result<ExitCode> {
    // A second Ctrl-C, during the report, ends the program the usual way.
    let first = || {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into())
        }
    };
    ctrlc::set_handler(first).context("cannot listen for Ctrl-C")?;
    let mut sets = args.scene.sets.clone();
    sets.extend(args.seed.map(|seed| format!("seed={seed}")));
    with_scene(&SceneArgs { scene: args.scene.scene.clone(), sets }, color, |loaded| run_loaded(args, loaded, color))
}

fn run_loaded(args: &RunArgs, loaded: &Loaded, color: Color) -> anyhow::Result<ExitCode> {
    let config = settings::config(&loaded.scene);
    let (mut processor, level) = if args.pil {
        match emulated(&config) {
            Ok(processor) => (processor, Level::Pil),
            Err(error) => {
                eprintln!("error: {error}");
                return Ok(ExitCode::from(LOST));
            }
        }
    } else {
        // The scene's rules have built a controller from these settings already.
        (Box::new(Here::new(&config)?) as Box<dyn Processor>, Level::Sil)
    };
    let mut progress = Progress::new(loaded.scene.duration_s, args.quiet);
    let study = study::conduct(loaded, (level, processor.as_mut()), &STOP, Some(&mut |time_s| progress.at(time_s)));
    drop(progress);
    let study = match study {
        Ok(study) => study,
        Err(StudyError::Run(RunError::Lost(error))) => {
            eprintln!("error: {error}");
            return Ok(ExitCode::from(LOST));
        }
        Err(error) => {
            eprintln!("error: {:#}", anyhow::Error::from(error));
            return Ok(ExitCode::from(RUN_FAILED));
        }
    };
    let default_dir = || PathBuf::from("out").join(format!("{}{}", study.name, if args.pil { "-pil" } else { "" }));
    let dir = (!args.no_report).then(|| args.output.clone().unwrap_or_else(default_dir));
    if let Some(dir) = &dir {
        output::write(loaded, &study, dir)?;
    }
    super::print(&match args.format {
        Format::Human => human(&study, args, color),
        Format::Json => format!("{:#}\n", output::summary(&study)),
    })?;
    if let Some(dir) = dir.filter(|_| !args.quiet) {
        eprintln!("report: {}", dir.join("report.html").display());
    }
    Ok(match () {
        () if study.record.interrupted => ExitCode::from(INTERRUPTED),
        () if !study.passes() => ExitCode::from(EXPECTATION_MISSED),
        () => ExitCode::SUCCESS,
    })
}

fn emulated(config: &Config) -> Result<Box<dyn Processor>, PilError> {
    if let Some(missing) = pil::missing() {
        return Err(PilError::Missing(missing));
    }
    Ok(Box::new(Qemu::start(&pil::image()?, config)?))
}

fn human(study: &Study, args: &RunArgs, color: Color) -> String {
    let mut text = format!("{}\n\n", study.scene.title);
    if study.record.interrupted {
        let time_s = study.record.rows.last().map_or(0.0, |row| row.time_s);
        text +=
            &format!("INTERRUPTED after {time_s:.3} s of {} s: what follows is of that part only.\n\n", study.scene.duration_s);
    }
    for remark in findings::remarks(study) {
        text += &format!("{remark}\n\n");
    }
    let headline: Vec<String> = findings::headline(study).iter().map(|(label, value)| format!("{label} {value}")).collect();
    text += &format!("{}\n\n", headline.join(" | "));
    if args.verbose {
        text += &modes(study);
    }
    let mut tables = findings::tables(study);
    if args.verbose || study.judged.is_empty() {
        tables.push(findings::all_metrics(study));
    }
    for block in &tables {
        text += &table::render(block, color.stdout);
    }
    let speed = study.metrics.get("simulated_s_per_wall_s").map(findings::number).unwrap_or_default();
    let _ = writeln!(
        text,
        "{}; {speed} simulated seconds per wall second, {} plant states; drive hash {:016x}",
        study.level, study.record.plant_states, study.record.drive_hash
    );
    text
}

/// The modes that the controller went through, and when.
fn modes(study: &Study) -> String {
    let mut text = String::new();
    let mut last = None;
    for row in &study.record.rows {
        if last != Some((row.mode, row.fault)) {
            last = Some((row.mode, row.fault));
            let fault = if row.fault == 0 { String::new() } else { format!(" {}", row.fault) };
            let _ = writeln!(text, "{:12.6} s  {:?}{fault}", row.time_s, row.mode);
        }
    }
    text + "\n"
}
