//! Commands to a board, with the same grammar on the command line and in a script.

pub mod burst;
pub mod calibrate;
pub mod capture;
pub mod circuit;
pub mod commission;
pub mod drive;
pub mod fault;
pub mod friction;
pub mod hardware;
pub mod identify;
pub mod lock;
pub mod monitor;
pub mod reset;
pub mod scan;
pub mod selftest;
pub mod settings;
pub mod status;
pub mod update;

use clap::Subcommand;
use firmware::board::command::Command;

use crate::answer::Answer;
use crate::link_error::LinkError;
use crate::number_with_unit::number_in;
use crate::session::Session;

/// Command to a board.
#[derive(Clone, Debug, Subcommand)]
pub enum Order {
    /// Identify the board: firmware, protocol version, and quality of the link.
    Identify,
    /// Show the present state of the board.
    Status,
    /// Find the resonances; draw the admittance loop.
    Scan(scan::ScanArgs),
    /// Find the resonance, lock to it, and drive by the configured schedule; report time and
    /// frequency of the lock.
    Lock(lock::LockArgs),
    /// Drive at the resonance: lock if necessary, open the gate, and set the amplitude.
    Drive(drive::DriveArgs),
    /// Open and close the gate of a running drive.
    Burst(burst::BurstArgs),
    /// Tune the controller to an unknown transducer: find its modes in a band, propose settings,
    /// test them, and store them after confirmation.
    Commission(commission::CommissionArgs),
    /// Hold the friction at a ratio (0.4) or at a force (0.05N); `configured` returns to the
    /// configured set point.
    Friction(friction::FrictionArgs),
    /// Measure the gain and phase that each lane's amplifier adds, and trim the lanes accordingly.
    Calibrate,
    /// Watch the board: one line that is updated in a terminal, one line per report elsewhere.
    /// Ctrl-C ends it.
    Monitor(monitor::MonitorArgs),
    /// Show, change and store settings that survive power-off; alone, it lists all of them.
    Settings(settings::SettingsArgs),
    /// Show the present fault; `clear` clears it, `log` lists earlier faults.
    Fault(fault::FaultArgs),
    /// Record voltage, current and drive sample by sample around a trigger, as CSV and figure.
    Capture(capture::CaptureArgs),
    /// Show the running image and the state of an update; with a file: send, verify and install it.
    /// Only while the drive is silent.
    Update(update::UpdateArgs),
    /// Check a board without an amplifier: microcontroller, clock, noise, and a tone from PA4,
    /// which is wired to PA0, PA1 and PA7. The amplifier's enable stays low.
    Selftest(selftest::SelftestArgs),
    /// Stop the drive. Also takes a served board from the client that holds it.
    Stop,
    /// Reset the board. Only while the drive is silent.
    Reset,
}

impl Order {
    /// Returns the name of the command on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Order::Identify => "identify",
            Order::Status => "status",
            Order::Scan(_) => "scan",
            Order::Lock(_) => "lock",
            Order::Drive(_) => "drive",
            Order::Burst(_) => "burst",
            Order::Commission(_) => "commission",
            Order::Friction(_) => "friction",
            Order::Calibrate => "calibrate",
            Order::Monitor(_) => "monitor",
            Order::Settings(_) => "settings",
            Order::Fault(_) => "fault",
            Order::Capture(_) => "capture",
            Order::Update(_) => "update",
            Order::Selftest(_) => "selftest",
            Order::Stop => "stop",
            Order::Reset => "reset",
        }
    }

    /// Returns `true` if the command changes nothing at the board, or stops its drive. A command
    /// that is not listed counts as one that acts.
    pub fn only_reads(&self) -> bool {
        match self {
            Order::Identify | Order::Status | Order::Monitor(_) | Order::Stop => true,
            Order::Settings(args) => matches!(args.order(), settings::SettingsOrder::Get { .. } | settings::SettingsOrder::Trims),
            Order::Fault(args) => !args.clears(),
            Order::Update(args) => args.file.is_none(),
            _ => false,
        }
    }

    /// Runs the command in a session.
    pub fn run(&self, session: &mut Session) -> Result<Answer, LinkError> {
        let answer = match self {
            Order::Identify => identify::run(session),
            Order::Status => status::run(session),
            Order::Scan(args) => scan::run(args, session),
            Order::Lock(args) => lock::run(args, session),
            Order::Drive(args) => drive::run(args, session),
            Order::Burst(args) => burst::run(args, session),
            Order::Commission(args) => commission::run(args, session),
            Order::Friction(args) => friction::run(args, session),
            Order::Calibrate => calibrate::run(session),
            Order::Monitor(args) => monitor::run(args, session),
            Order::Settings(args) => settings::run(args.order(), session),
            Order::Fault(args) => fault::run(args, session),
            Order::Capture(args) => capture::run(args, session),
            Order::Update(args) => update::run(args, session),
            Order::Selftest(args) => selftest::run(args, session),
            Order::Stop => stop(session),
            Order::Reset => reset::run(session),
        }?;
        session.last = answer.clone();
        Ok(answer)
    }
}

/// Stops the drive.
fn stop(session: &mut Session) -> Result<Answer, LinkError> {
    session.client.order(Command::Idle)?;
    session.mark_silent();
    Ok(Answer::to("stop").line("the drive is silent").field("mode", "idle"))
}

/// Reads a number of seconds, from 0 to 1e6.
pub fn seconds(text: &str) -> Result<f64, String> {
    match number_in(text, "s")? {
        seconds if (0.0..=1e6).contains(&seconds) => Ok(seconds),
        _ => Err("expected seconds from 0 to 1000000, such as 0.5".into()),
    }
}

/// Reads a time that may be absent, as zero or more seconds.
pub fn timeout(text: &str) -> Result<f32, String> {
    not_negative(text, "s")
}

/// Reads a voltage of at least zero.
pub fn volts(text: &str) -> Result<f32, String> {
    not_negative(text, "V")
}

/// Reads a current of at least zero.
pub fn amperes(text: &str) -> Result<f32, String> {
    not_negative(text, "A")
}

fn not_negative(text: &str, unit: &str) -> Result<f32, String> {
    match number_in(text, unit)? as f32 {
        amount if amount.is_finite() && amount >= 0.0 => Ok(amount),
        _ => Err(format!("expected a non-negative number of {unit}")),
    }
}
