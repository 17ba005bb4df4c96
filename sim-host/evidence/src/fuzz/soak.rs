//! Soak test: a whole simulated board with its plant, over very many samples, under random orders,
//! sensor faults that come and go, and flipped bits on its link.
//!
//! ```text
//! orders, damage --> UART --> board (background task, block task, flash, watchdog) <--> faults <--> plant of a scene
//! ```
//!
//! The board may refuse, fault, and reset when ordered to. It must not panic, exceed the built-in
//! voltage limit, be reset by its watchdog, send an invalid frame, or report a drive that is not
//! finite. At the end, with all faults cleared, it must stop on command and run again.

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

use super::frames::valid;
use super::target::{Tally, Target};
use super::text::pick;
use crate::campaign::{cells, columns};
use crate::evidence::{Error, Evidence, Options};
use report::{Report, TableBlock};
use sim::study::StudyError;

pub(super) const TARGET: Target =
    Target { name: "soak", what: "samples of a board and its plant", seeds_per_million: 1, feed, corpus: |_| Ok(()) };

/// Millions of samples, full and quick.
const MILLIONS: [u32; 2] = [1000, 8];
/// Number of samples of each seed.
const SAMPLES: u64 = 1_000_000;
/// Scenes of the boards: one of each kind of drive, one with four lanes, one with an encoder and a
/// force channel.
const SCENES: [&str; 6] = ["lock", "lock-cold", "burst", "usm", "friction-burst", "belt-stop"];
/// Probability of an order in a block.
const ORDER_PROBABILITY: f64 = 0.004;
/// Probability of a fault in a block.
const FAULT_PROBABILITY: f64 = 0.0004;
/// Probability of a flipped bit in a block.
const DAMAGE_PROBABILITY: f64 = 0.0005;
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
/// Faults of a belt's encoder that come and go; an intermittent encoder counts as lost.
const OF_BELT: [FaultKind; 4] = [FaultKind::BeltStopped, FaultKind::EncoderStuck, FaultKind::EncoderLies, FaultKind::EncoderLost];
/// Time within which a reset must be over at the end, s.
const RESET_WITHIN_S: f64 = 0.2;
/// Time within which the board must answer at the end, s.
const ANSWERED_WITHIN_S: f64 = 0.2;
/// Time within which the board must start to drive at the end, s.
const RUNS_WITHIN_S: f64 = 1.0;

/// Runs the soak test, and returns the evidence.
pub(crate) fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let millions = options.count.unwrap_or(MILLIONS[usize::from(options.quick)]);
    (options.progress)(&format!("{millions} million samples"));
    let seeds = options.seed.map_or(0..TARGET.seeds(millions), |seed| seed..seed + 1);
    let (boards, began) = (seeds.end - seeds.start, std::time::Instant::now());
    let (tally, missed) = TARGET.run(seeds, options.stop).ok_or(StudyError::Interrupted)?;
    let seconds = began.elapsed().as_secs_f64();
    let count = |kind: &str| tally.outcomes.get(kind).copied().unwrap_or(0);
    let header = columns("boards | samples | orders | faults injected | resets | failures | time [s] | Msample/s");
    let [orders, faults, resets] = ["order", "fault struck", "reset"].map(count);
    let (time, rate) = (format!("{seconds:.1}"), format!("{:.2}", tally.inputs as f64 / seconds.max(1e-3) / 1e6));
    let row = cells![boards, tally.inputs, orders, faults, resets, missed.len(), time, rate];
    let caption = "Each board runs a million samples, and then until it stops and runs again on command.";
    let table = TableBlock::new("soak", "Soak test", caption, &header, vec![row]);
    let kinds = tally.outcomes.iter().map(|(kind, count)| cells![kind, count]).collect();
    let outcomes = TableBlock::new("outcomes", "Outcomes", "", &["outcome", "count"], kinds);
    Ok(Evidence {
        docs: vec![table.clone()],
        report: Report { title: "Soak: random orders and faults".into(), tables: vec![table, outcomes], ..Report::default() },
        missed,
        ..Evidence::default()
    })
}

/// A board, with the state of its host.
struct Soaked {
    board: SimulatedBoard,
    receiver: Receiver,
    sequence: u16,
    /// Session at the board; none before the board has answered, and after it has refused a frame
    /// of the session because of a reset.
    session: u32,
    limit_codes: u16,
    mid_code: u16,
    latest: Option<Telemetry>,
    /// Answers of the board at the end.
    answers: Vec<String>,
}

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
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
        answers: Vec::new(),
    };
    let with_belt = soaked.board.config().front_end.metre_per_count.is_some();
    let faults = if with_belt { [&FAULTS[..], &OF_BELT].concat() } else { FAULTS.to_vec() };
    for _ in 0..SAMPLES / samples {
        if chance.strikes(ORDER_PROBABILITY) {
            tally.outcome("order");
            let order = match soaked.session {
                NO_SESSION => Command::Identify(chance.below(1 << 32) as u32),
                _ if chance.strikes(0.3) => Command::ClearFault,
                _ => valid(&mut chance),
            };
            soaked.order(order, Some(&mut chance))?;
        }
        if chance.strikes(FAULT_PROBABILITY) {
            let kind = pick(&mut chance, &faults).ok_or("no fault")?;
            tally.outcome("fault struck");
            soaked.board.change_rig(|rig| rig.inner.strike(kind));
        }
        if chance.strikes(4.0 * FAULT_PROBABILITY) {
            soaked.board.change_rig(|rig| faults.iter().for_each(|&kind| rig.inner.repair(kind)));
        }
        soaked.block(tally)?;
    }
    tally.inputs += SAMPLES;
    soaked.check_final_state(tally).map_err(|failure| format!("{name}: {failure}"))
}

impl Soaked {
    /// Sends an order, with a bit flipped at random.
    fn order(&mut self, command: Command, chance: Option<&mut Chance>) -> Result<(), String> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = encode(self.sequence, self.session, command).map_err(|error| format!("{error:?}"))?;
        if let Some(chance) = chance
            && chance.strikes(DAMAGE_PROBABILITY / ORDER_PROBABILITY)
        {
            let at = chance.below(frame.len() as u64) as usize;
            frame[at] ^= 1 << chance.below(8);
        }
        self.board.send(&frame);
        Ok(())
    }

    /// Runs one block, and checks its results.
    fn block(&mut self, tally: &mut Tally) -> Result<(), String> {
        self.board.block();
        let mid_code = self.mid_code;
        let loudest = self.board.with_rig(|rig| {
            let codes = rig.blocks().flat_map(|exchange| exchange.drive.lanes.iter().flatten());
            codes.map(|code| code.abs_diff(mid_code)).max().unwrap_or(0)
        });
        if loudest > self.limit_codes {
            return Err(format!("{loudest} codes, but the limit is {}", self.limit_codes));
        }
        let mut bytes = [0; 64];
        let count = self.board.receive(&mut bytes);
        for &byte in &bytes[..count] {
            match self.receiver.take::<Reply>(byte) {
                Some(Ok(frame)) => self.take(&frame, tally)?,
                Some(Err(error)) => return Err(format!("the board has sent {error:?}")),
                None => {}
            }
        }
        Ok(())
    }

    fn take(&mut self, frame: &Frame<Reply>, tally: &mut Tally) -> Result<(), String> {
        if !matches!(frame.body, Reply::Telemetry(_) | Reply::Status(_)) {
            self.answers.push(format!("{}: {:?}", frame.sequence, frame.body));
        }
        match &frame.body {
            Reply::Telemetry(report) | Reply::Status(Some(report)) => {
                let numbers = [report.drive.0, report.envelope, report.frequency.0];
                if numbers.iter().any(|number| !number.is_finite()) {
                    return Err(format!("a drive that is not finite: {report:?}"));
                }
                tally.outcome(&format!("mode {:?}", report.mode));
                if let Some(fault) = report.fault {
                    tally.outcome(&format!("fault {fault:?}"));
                }
                if self.latest.is_some_and(|latest| latest.block > report.block) {
                    tally.outcome("reset");
                }
                self.latest = Some(*report);
            }
            Reply::Faults(report) if report.last_run == Start::Watchdog => return Err("the watchdog has reset the board".into()),
            Reply::Identity(identity) => self.session = identity.session,
            Reply::Nak(Refusal::Session) if frame.session == self.session => {
                tally.outcome("refused: Session");
                self.session = NO_SESSION;
            }
            Reply::Nak(refusal) => tally.outcome(&format!("refused: {refusal:?}")),
            _ => {}
        }
        Ok(())
    }

    /// Clears all faults, and checks that the board stops and then drives on command.
    fn check_final_state(&mut self, tally: &mut Tally) -> Result<(), String> {
        self.board.change_rig(|rig| FAULTS.iter().chain(&OF_BELT).for_each(|&kind| rig.inner.repair(kind)));
        // The last orders must have been answered. A reset, before which the UART sends its
        // remaining bytes, must be over.
        self.wait(RESET_WITHIN_S, tally)?;
        self.answers.clear();
        self.order(Command::Identify(1), None)?;
        self.wait(0.02, tally)?;
        // The stored settings may not fit this plant. A reset is refused while the board drives.
        for command in [Command::Idle, Command::Patience(0.0), Command::Idle, Command::ClearFault, Command::Faults(0)] {
            self.order(command, None)?;
            self.wait(0.02, tally)?;
        }
        self.until(Command::Status, ANSWERED_WITHIN_S, tally, |report| matches!(report.mode, Mode::Idle))?;
        self.order(Command::Run, None)?;
        self.until(Command::Status, RUNS_WITHIN_S, tally, |report| report.mode != Mode::Idle)
    }

    fn wait(&mut self, seconds: f64, tally: &mut Tally) -> Result<(), String> {
        (0..(seconds / self.board.block_s()) as u64).try_for_each(|_| self.block(tally))
    }

    /// Repeats a request until a report fulfils a condition.
    fn until(&mut self, ask: Command, seconds: f64, tally: &mut Tally, is: impl Fn(&Telemetry) -> bool) -> Result<(), String> {
        let until = self.board.now().as_secs_f64() + seconds;
        self.latest = None;
        while self.board.now().as_secs_f64() < until {
            self.order(ask, None)?;
            self.wait(0.01, tally)?;
            if self.latest.as_ref().is_some_and(&is) {
                return Ok(());
            }
        }
        Err(format!("the final state is not reached, after order {}: {:?}; {:?}", self.sequence, self.latest, self.answers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_soak_of_every_board_finds_nothing() {
        let (tally, failures) = TARGET.run(0..SCENES.len() as u64, None).unwrap();
        println!("{:#?}", tally.outcomes);
        assert!(failures.is_empty(), "{}", failures.join("\n"));
        for reached in ["mode Run", "fault struck", "refused: Driving", "refused: Session"] {
            assert!(tally.outcomes.contains_key(reached), "{reached}: {:?}", tally.outcomes);
        }
    }
}
