//! Soak: a whole simulated board with its plant, for very many samples, under random orders, faults of its sensors that come and go, and bytes turned on its
//! link.
//!
//! ```text
//! orders, damage --> UART --> board (background task, block task, flash, watchdog) <--> faults <--> plant of a scene
//! ```
//!
//! It may refuse, fault, and reset where it is ordered to. It may not panic, play beyond the voltage limit that is built in, be reset by its watchdog, send
//! what is no frame, report a number of its drive that is none, or stay away: in the end, with everything mended, it falls silent by order, and runs again.

use ::link::simulated_board::SimulatedBoard;
use firmware::board::command::{Command, Reply};
use firmware::board::link::{Frame, NO_SESSION, Receiver, encode};
use firmware::board::start::Start;
use firmware::seam::mode::Mode;
use firmware::seam::refusal::Refusal;
use firmware::seam::telemetry::Telemetry;
use hal_mock::chance::Chance;
use hal_mock::fault_injector::FaultKind;
use scene::load::load;

use super::frames::honest;
use super::target::{Seen, Target};
use super::text::pick;
use crate::evidence::{Error, Evidence, Options};
use report::{Report, TableBlock};
use sim::study::StudyError;

pub(super) const TARGET: Target =
    Target { name: "soak", what: "samples of a board and its plant", seeds_per_million: 1, feed, corpus: |_| Ok(()) };

/// Millions of samples, and those of the quick variant.
const MILLIONS: [u32; 2] = [1000, 8];
/// Samples of each seed.
const SAMPLES: u64 = 1_000_000;
/// The boards: one of each kind of drive, one with four lanes, one with an encoder and a force channel.
const SCENES: [&str; 6] = ["lock", "lock-cold", "burst", "usm", "friction-burst", "belt-stop"];
/// How often something comes in a block: an order, a fault or a repair, a turned byte.
const ORDER: f64 = 0.004;
const FAULT: f64 = 0.0004;
const DAMAGE: f64 = 0.0005;
/// Faults that come and go.
const FAULTS: [FaultKind; 11] = [
    FaultKind::Open,
    FaultKind::Swapped,
    FaultKind::SensorStuck,
    FaultKind::SensorOffset(300),
    FaultKind::Saturation,
    FaultKind::Overtemperature,
    FaultKind::Dropout,
    FaultKind::LateBlock,
    FaultKind::OverCurrentTrip,
    FaultKind::AmplifierFault,
    FaultKind::Supply,
];
/// The same of a belt's encoder, where there is one: one that comes and goes is lost.
const OF_BELT: [FaultKind; 4] = [FaultKind::BeltStopped, FaultKind::EncoderStuck, FaultKind::EncoderLies, FaultKind::EncoderLost];
/// How long a reset, an answer, and a start may take in the end, s.
const RESET_WITHIN_S: f64 = 0.2;
const ANSWERED_WITHIN_S: f64 = 0.2;
const RUNS_WITHIN_S: f64 = 1.0;

/// Soaks so many boards.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let millions = options.count.unwrap_or(MILLIONS[usize::from(options.quick)]);
    (options.progress)(&format!("{millions} million samples"));
    let seeds = options.seed.map_or(0..TARGET.seeds(millions), |seed| seed..seed + 1);
    let (boards, began) = (seeds.end - seeds.start, std::time::Instant::now());
    let (seen, missed) = TARGET.run(seeds, options.stop).ok_or(StudyError::Interrupted)?;
    let seconds = began.elapsed().as_secs_f64();
    let count = |kind: &str| seen.outcomes.get(kind).copied().unwrap_or(0).to_string();
    let header = ["boards", "samples", "orders", "faults struck", "resets", "failures", "time [s]", "Msample/s"];
    let row = vec![
        boards.to_string(),
        seen.inputs.to_string(),
        count("order"),
        count("fault struck"),
        count("reset"),
        missed.len().to_string(),
        format!("{seconds:.1}"),
        format!("{:.2}", seen.inputs as f64 / seconds.max(1e-3) / 1e6),
    ];
    let table = TableBlock::new(
        "soak",
        "Soaked",
        "Each board a million samples, and what it takes to fall silent and run in the end.",
        &header,
        vec![row],
    );
    let kinds = seen.outcomes.iter().map(|(kind, count)| vec![kind.clone(), count.to_string()]).collect();
    let outcomes = TableBlock::new("outcomes", "Outcomes", "", &["outcome", "count"], kinds);
    Ok(Evidence {
        docs: vec![table.clone()],
        report: Report { title: "Soak: random orders and faults".into(), tables: vec![table, outcomes], ..Report::default() },
        missed,
        ..Evidence::default()
    })
}

/// A board, and what a host knows of it.
struct Soaked {
    board: SimulatedBoard,
    receiver: Receiver,
    sequence: u16,
    /// The session at the board; none before it has answered, and once it has refused a frame of it: after a reset.
    session: u32,
    limit_codes: u16,
    mid_code: u16,
    latest: Option<Telemetry>,
    /// What the board has answered in the end.
    said: Vec<String>,
}

fn feed(seed: u64, seen: &mut Seen) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let name = SCENES[(seed % SCENES.len() as u64) as usize];
    let loaded = load(name, &[format!("seed={}", seed % 1000)]).map_err(|error| error.to_string())?;
    let scene = loaded.scene.driven().ok_or("not driven")?;
    let board = SimulatedBoard::new(&scene, 1).map_err(|error| error.to_string())?;
    let (front_end, limits) = (&board.config().front_end, &board.config().limits);
    let limit_codes = (limits.voltage_v / front_end.drive_volt_per_lsb).min(f32::from(u16::MAX) - 1.0) as u16 + 1;
    let mid_code = front_end.drive_mid_code;
    let samples = u64::from(board.config().block_samples);
    let mut soaked = Soaked {
        board,
        receiver: Receiver::default(),
        sequence: 0,
        session: NO_SESSION,
        limit_codes,
        mid_code,
        latest: None,
        said: Vec::new(),
    };
    let with_belt = soaked.board.config().front_end.metre_per_count.is_some();
    let faults = if with_belt { [&FAULTS[..], &OF_BELT].concat() } else { FAULTS.to_vec() };
    for _ in 0..SAMPLES / samples {
        if chance.strikes(ORDER) {
            seen.outcome("order");
            let order = match soaked.session {
                NO_SESSION => Command::Identify(chance.below(1 << 32) as u32),
                _ if chance.strikes(0.3) => Command::ClearFault,
                _ => honest(&mut chance),
            };
            soaked.order(order, Some(&mut chance))?;
        }
        if chance.strikes(FAULT) {
            let kind = pick(&mut chance, &faults).ok_or("no fault")?;
            seen.outcome("fault struck");
            soaked.board.change_rig(|rig| rig.inner.strike(kind));
        }
        if chance.strikes(4.0 * FAULT) {
            soaked.board.change_rig(|rig| faults.iter().for_each(|&kind| rig.inner.repair(kind)));
        }
        soaked.block(seen)?;
    }
    seen.inputs += SAMPLES;
    soaked.in_the_end(seen).map_err(|failure| format!("{name}: {failure}"))
}

impl Soaked {
    /// Sends an order, by chance with a bit turned.
    fn order(&mut self, command: Command, chance: Option<&mut Chance>) -> Result<(), String> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = encode(self.sequence, self.session, command).map_err(|error| format!("{error:?}"))?;
        if let Some(chance) = chance
            && chance.strikes(DAMAGE / ORDER)
        {
            let at = chance.below(frame.len() as u64) as usize;
            frame[at] ^= 1 << chance.below(8);
        }
        self.board.send(&frame);
        Ok(())
    }

    /// One block, and what has come of it.
    fn block(&mut self, seen: &mut Seen) -> Result<(), String> {
        self.board.block();
        let mid_code = self.mid_code;
        let loudest = self.board.with_rig(|rig| {
            let codes = rig.blocks().flat_map(|exchange| exchange.drive.lanes.iter().flatten());
            codes.map(|code| code.abs_diff(mid_code)).max().unwrap_or(0)
        });
        if loudest > self.limit_codes {
            return Err(format!("{loudest} codes, and the limit is {}", self.limit_codes));
        }
        let mut bytes = [0; 64];
        let count = self.board.receive(&mut bytes);
        for &byte in &bytes[..count] {
            match self.receiver.take::<Reply>(byte) {
                Some(Ok(frame)) => self.take(&frame, seen)?,
                Some(Err(error)) => return Err(format!("the board has sent {error:?}")),
                None => {}
            }
        }
        Ok(())
    }

    fn take(&mut self, frame: &Frame<Reply>, seen: &mut Seen) -> Result<(), String> {
        if !matches!(frame.body, Reply::Telemetry(_) | Reply::Status(_)) {
            self.said.push(format!("{}: {:?}", frame.sequence, frame.body));
        }
        match &frame.body {
            Reply::Telemetry(report) | Reply::Status(Some(report)) => {
                let numbers = [report.drive.0, report.envelope, report.frequency.0];
                if numbers.iter().any(|number| !number.is_finite()) {
                    return Err(format!("a drive that is none: {report:?}"));
                }
                seen.outcome(&format!("mode {:?}", report.mode));
                if let Some(fault) = report.fault {
                    seen.outcome(&format!("fault {fault:?}"));
                }
                if self.latest.is_some_and(|latest| latest.block > report.block) {
                    seen.outcome("reset");
                }
                self.latest = Some(*report);
            }
            Reply::Faults(report) if report.last_run == Start::Watchdog => return Err("the watchdog has reset the board".into()),
            Reply::Identity(identity) => self.session = identity.session,
            Reply::Nak(Refusal::Session) if frame.session == self.session => {
                seen.outcome("refused: Session");
                self.session = NO_SESSION;
            }
            Reply::Nak(refusal) => seen.outcome(&format!("refused: {refusal:?}")),
            _ => {}
        }
        Ok(())
    }

    /// Everything is mended: it falls silent by order, and then drives by order, whatever was before.
    fn in_the_end(&mut self, seen: &mut Seen) -> Result<(), String> {
        self.board.change_rig(|rig| FAULTS.iter().chain(&OF_BELT).for_each(|&kind| rig.inner.repair(kind)));
        // What was ordered last has been answered, and a reset is over, before which all that the UART holds leaves.
        self.wait(RESET_WITHIN_S, seen)?;
        self.said.clear();
        self.order(Command::Identify(1), None)?;
        self.wait(0.02, seen)?;
        // What was set stands in the flash, and may not fit this plant; the reset is refused as long as it drives.
        for command in [Command::Idle, Command::Patience(0.0), Command::Idle, Command::ClearFault, Command::Faults(0)] {
            self.order(command, None)?;
            self.wait(0.02, seen)?;
        }
        self.until(Command::Status, ANSWERED_WITHIN_S, seen, |report| matches!(report.mode, Mode::Idle))?;
        self.order(Command::Run, None)?;
        self.until(Command::Status, RUNS_WITHIN_S, seen, |report| report.mode != Mode::Idle)
    }

    fn wait(&mut self, seconds: f64, seen: &mut Seen) -> Result<(), String> {
        (0..(seconds / self.board.block_s()) as u64).try_for_each(|_| self.block(seen))
    }

    /// Asks until a report is as it must be.
    fn until(&mut self, ask: Command, seconds: f64, seen: &mut Seen, is: impl Fn(&Telemetry) -> bool) -> Result<(), String> {
        let until = self.board.now().as_secs_f64() + seconds;
        self.latest = None;
        while self.board.now().as_secs_f64() < until {
            self.order(ask, None)?;
            self.wait(0.01, seen)?;
            if self.latest.as_ref().is_some_and(&is) {
                return Ok(());
            }
        }
        Err(format!("in the end it is not as it must be, after order {}: {:?}; {:?}", self.sequence, self.latest, self.said))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_soak_of_every_board_finds_nothing() {
        let (seen, failures) = TARGET.run(0..SCENES.len() as u64, None).unwrap();
        println!("{:#?}", seen.outcomes);
        assert!(failures.is_empty(), "{}", failures.join("\n"));
        for reached in ["mode Run", "fault struck", "refused: Driving", "refused: Session"] {
            assert!(seen.outcomes.contains_key(reached), "{reached}: {:?}", seen.outcomes);
        }
    }
}
