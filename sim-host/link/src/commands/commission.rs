//! `commission`: tunes the controller to an unknown transducer.
//!
//! ```text
//! small tones --> kind of load, C0, voltage --> scans of all windows --> closer scan of each mode --> chosen mode
//!     --> proposed settings --> lock, step of the amplitude, burst --> heating run (--heating) --> rehearsed on the twin
//!     --> stored (--yes), or as before
//! ```
//!
//! Only the band and the maximum voltage are given. However it ends, the drive is silent and the
//! settings of the board are as before, unless new ones were stored at the end.

mod band;
mod board_settings;
mod circle;
mod drawing;
mod findings;
mod fit;
mod heating;
mod limits;
mod load;
mod modes;
mod neighbours;
mod output;
mod probe;
mod proposal;
mod tones;
mod twin;
mod verification;

use std::path::PathBuf;

use clap::Args;
use firmware::board::command::Command;
use firmware::seam::block::Gate;
use firmware::seam::mode::Mode as BoardMode;
use firmware::seam::transducer::Transducer;
use firmware::seam::units::Hertz;

use self::band::Band;
use self::board_settings::BoardSettings;
use self::findings::{in_words, table};
use self::heating::Thermal;
use self::limits::Bounds;
use self::load::Load;
use self::modes::Mode;
use self::neighbours::Resolved;
use self::proposal::Proposal;
use self::verification::Verified;
use super::{amperes, timeout, volts};
use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::session::Session;
use sim::advice::Advice;

/// Ratio of the motional capacitances of two modes above which neither is the stronger one.
const ALIKE_CM_REL: f64 = 0.6;

/// Maximum number of tests per tracking mode, each at less voltage.
const MAX_TESTS: u32 = 4;

/// Arguments of the command.
#[derive(Args, Clone, Debug)]
pub struct CommissionArgs {
    /// Band to search for the resonance, as two frequencies in hertz, such as 20k:45k.
    #[arg(long, value_name = "LOW:HIGH")]
    band: Band,
    /// Maximum peak voltage at the amplifier, V; the board's own limit if that is lower.
    #[arg(long, value_name = "V", value_parser = positive_volts)]
    max_volts: f64,
    /// Maximum peak current, A. Default: the board's limit (`limits.current_a`), which always
    /// applies.
    #[arg(long, value_name = "A", value_parser = positive_amperes)]
    max_amps: Option<f64>,
    /// Mode to drive, by its number in the table. Default: the strongest, with the largest motional
    /// capacitance.
    #[arg(long, value_name = "N")]
    mode: Option<usize>,
    /// Also drive for this time, s, and measure thermal resistance and heat capacity of the stack
    /// without a load; three thermal time constants are enough.
    #[arg(long, value_name = "S", value_parser = positive_seconds)]
    heating: Option<f64>,
    /// Store the settings that have passed the test; without it the settings of the
    /// board remain as before.
    #[arg(long)]
    yes: bool,
    /// Name of the transducer in the files.
    #[arg(long, value_name = "PROFILE", default_value = "transducer")]
    name: String,
    /// Folder for the report, the settings as a script of commands, and the twin as a scene.
    #[arg(short, long = "output", value_name = "DIR")]
    output: Option<PathBuf>,
}

fn positive(value: f32) -> Result<f64, String> {
    if value > 0.0 { Ok(f64::from(value)) } else { Err("expected a positive number".into()) }
}

fn positive_volts(text: &str) -> Result<f64, String> {
    volts(text).and_then(positive)
}

fn positive_amperes(text: &str) -> Result<f64, String> {
    amperes(text).and_then(positive)
}

fn positive_seconds(text: &str) -> Result<f64, String> {
    timeout(text).and_then(positive)
}

/// Result of a commissioning.
struct Commissioned {
    name: String,
    band: Band,
    load: Load,
    modes: Vec<Mode>,
    /// Index of the chosen mode.
    chosen: usize,
    /// Result of its circle.
    resolved: Resolved,
    proposal: Proposal,
    twin: String,
    advice: Advice,
    verified: Verified,
    /// Result of the heating run, if one was requested.
    thermal: Option<Thermal>,
}

impl Commissioned {
    /// Returns all proposed settings, by their names.
    fn settings(&self) -> Vec<(&'static str, f32)> {
        self.proposal.settings().into_iter().chain(self.thermal.iter().flat_map(Thermal::settings)).collect()
    }
}

/// Commissions the transducer at the board. At the end the drive is silent, and the settings are as
/// before, or the result is stored.
pub fn run(args: &CommissionArgs, session: &mut Session) -> Result<Answer, LinkError> {
    let converters = Band::from_converters(&session.identity.converters);
    if !converters.contains(&args.band) {
        return Err(LinkError::Usage(format!(
            "the converters of this board measure {:.0} to {:.0} Hz, but the band is {:.0} to {:.0} Hz",
            converters.low_hz, converters.high_hz, args.band.low_hz, args.band.high_hz
        )));
    }
    // An invalid folder is reported before the first drive.
    let folder = session.folder("commission", args.output.as_deref())?;
    let before = session.status()?;
    session.check(&before)?;
    if before.mode != BoardMode::Idle {
        return Err(LinkError::Failed("the drive is on: send `stop` first".into()));
    }
    let began = session.client.now();
    let mut board = BoardSettings::read(args.heating.is_some(), session)?;
    let done = commission(args, &mut board, session);
    let done = done.and_then(|found| {
        if let Some(folder) = folder {
            output::write(&found, folder, &session.provenance)?;
        }
        if args.yes {
            board.finish(&found.settings(), session)?;
        }
        Ok(found)
    });
    let answer = match done {
        Ok(found) if args.yes => Ok(found),
        done => restore(done, &mut board, session),
    }
    .map(|found| in_words(&found, args))?;
    let board_s = (session.client.now() - began).as_secs_f64();
    Ok(answer.line(format!("{board_s:.2} s of the board's time")).field("board_s", board_s))
}

/// Stops the drive and restores the settings after any result, and reports a failure of that.
fn restore<T>(done: Result<T, LinkError>, board: &mut BoardSettings, session: &mut Session) -> Result<T, LinkError> {
    // Ctrl-C must not interrupt this.
    session.client.ignore_ctrl_c();
    let orders = [
        // Telemetry that continues after an interrupted wait would delay the answers.
        Command::TelemetryEvery(0),
        Command::Idle,
        Command::ClearFault,
        Command::Gate(Gate::Scheduled),
        Command::Amplitude(None),
        Command::Detune(Hertz(0.0)),
    ];
    let restored = orders.into_iter().try_for_each(|command| session.client.order(command));
    let restored = restored.and_then(|()| board.finish(&[], session));
    match (done, restored) {
        (Ok(done), Ok(())) => {
            session.mark_silent();
            Ok(done)
        }
        (Err(error), Ok(())) => {
            session.mark_silent();
            session.client.note("the drive is silent, and the settings are as before");
            Err(error)
        }
        (done, Err(error)) => {
            session.client.note(&format!(
                "the settings could not be restored ({error}). Once the board answers again, restore them with:\n{}",
                board.by_hand()
            ));
            Err(done.err().unwrap_or(error))
        }
    }
}

fn commission(args: &CommissionArgs, board: &mut BoardSettings, session: &mut Session) -> Result<Commissioned, LinkError> {
    let scale = session.scale()?;
    let bounds = Bounds::new(args.max_volts, args.max_amps, board, &scale);
    // An unsuitable board is reported before the first drive.
    args.heating.map(|_| heating::hz_per_k(board)).transpose()?;
    session.live.stage("small tones");
    let load = tones::measure(&args.band, &bounds, board, session)?;
    let search = modes::find(&args.band, &load, &bounds, board, session)?;
    if search.modes.is_empty() {
        return Err(LinkError::Failed(load.without_resonance(&args.band, &search)));
    }
    let modes = search.modes;
    let chosen = choose(&modes, args.mode)?;
    let transducer = modes[chosen].transducer;
    session.live.stage(&format!("admittance circle at {:.0} Hz", modes[chosen].hz()));
    let by_number = args.mode.is_some();
    let others: Vec<Mode> = modes.iter().enumerate().filter(|(place, _)| *place != chosen).map(|(_, mode)| *mode).collect();
    let known: Vec<Transducer> = others.iter().map(|mode| mode.transducer).collect();
    let mut circle = circle::measured(&transducer, &bounds, board, session)?;
    let resolved = match neighbours::resolve(&circle.points, &transducer, &known, by_number) {
        Ok(resolved) => resolved,
        // In one of some hundred circles the noise resembles a neighbour; not in two.
        Err(_) => {
            circle.points.extend(circle::measured(&transducer, &bounds, board, session)?.points);
            neighbours::resolve(&circle.points, &transducer, &known, by_number)?
        }
    };
    let measured = Proposal::new(&resolved.transducer, &bounds)
        .within_limits(circle.volts, circle.amperes, &bounds)
        .above(Band::from_converters(&session.identity.converters).low_hz);
    let (mut proposal, verified) = passing_proposal(&measured, &bounds, board, session)?;
    let thermal = args.heating.map(|time_s| heating::measure(time_s, &proposal, board, session)).transpose()?;
    proposal.limits = (bounds.given_v, bounds.given_a);
    let twin = twin::toml(&args.name, &proposal, &others, &scale, &session.identity.converters);
    session.live.stage("rehearsal on the twin");
    let loaded = twin::load(&args.name, &twin)?;
    let advice = session.meanwhile(|| twin::rehearse(&loaded))??;
    let (name, band) = (args.name.clone(), args.band);
    Ok(Commissioned { name, band, load, modes, chosen, resolved, proposal, twin, advice, verified, thermal })
}

/// Returns the index of the mode to drive.
fn choose(modes: &[Mode], number: Option<usize>) -> Result<usize, LinkError> {
    if let Some(number) = number {
        return if (1..=modes.len()).contains(&number) {
            Ok(number - 1)
        } else {
            Err(LinkError::Failed(format!(
                "there is no mode {number}: {}\n{}",
                count(modes.len()),
                table(modes, None).join("\n")
            )))
        };
    }
    let mut by_strength: Vec<usize> = (0..modes.len()).collect();
    by_strength.sort_by(|&a, &b| modes[b].strength().total_cmp(&modes[a].strength()));
    match by_strength.as_slice() {
        [first, second, ..] if modes[*second].strength() > ALIKE_CM_REL * modes[*first].strength() => {
            Err(LinkError::Failed(format!(
                "two resonances have similar strength, at {:.1} and {:.1} Hz: two transducers in parallel, or one with two such modes. \
                 Disconnect one, or choose by --mode N\n{}",
                modes[*first].hz(),
                modes[*second].hz(),
                table(modes, None).join("\n")
            )))
        }
        [first, ..] => Ok(*first),
        [] => Err(LinkError::Failed("no resonance was found".into())),
    }
}

fn count(modes: usize) -> String {
    if modes == 1 { "one was found".into() } else { format!("{modes} were found") }
}

/// Returns the proposal that passes the test: with the observer, or with the phase loop
/// if the observer fails. The voltage is reduced if it was too high.
fn passing_proposal(
    measured: &Proposal,
    bounds: &Bounds,
    board: &mut BoardSettings,
    session: &mut Session,
) -> Result<(Proposal, Verified), LinkError> {
    let mut reasons = Vec::new();
    for observer in [true, false] {
        let mut proposal = Proposal { observer, ..*measured };
        session.live.stage(if observer { "test with the observer" } else { "test with the phase loop" });
        for _ in 0..MAX_TESTS {
            match verification::verify(&proposal, bounds, board, session)? {
                Ok(verified) => return Ok((proposal, verified)),
                Err(failed) if failed.voltage_too_high && proposal.volts > bounds.min_v => proposal = proposal.reduced(),
                Err(failed) => {
                    reasons.push(format!("{}: {}", if observer { "observer" } else { "phase loop" }, failed.why));
                    break;
                }
            }
        }
    }
    Err(LinkError::Failed(format!(
        "a resonance was identified at {:.2} Hz with Q {:.1}, but no settings for it pass the test, because of \
         another resonance nearby or a changing load. {}",
        measured.transducer.series_resonance_hz,
        measured.transducer.q,
        reasons.join(". ")
    )))
}
