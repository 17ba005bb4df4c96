//! What a commissioning has come to, judged against the plant.

use std::cell::RefCell;
use std::f64::consts::PI;
use std::rc::Rc;
use std::sync::atomic::AtomicBool;

use link::client::Client;
use link::link_error::LinkError;
use link::port::Simulated;
use link::script::Script;
use link::session::{Session, SessionOptions};
use link::simulated_board::SimulatedBoard;
use plant::circuit_of;
use scene::load::load;
use sim::study::StudyError;

use super::watched_board::WatchedBoard;
use crate::evidence::Error;
use crate::transducers::draw::{GUESSED_Q, Nominal, Transducer};
use crate::transducers::front_end::{FrontEnd, SCENE, sets};
use crate::transducers::outcome::bound_hz;

/// Upper end of a band over its lower end, and the lowest lower end, which the converters of a board with blocks of 32 samples measure, Hz.
const BAND: (f64, f64) = (1.5, 15_700.0);
/// Time that a commissioning may take, s, and above a Q of so many the ring-down times, `Q / (pi fs)`, that it may take.
const ALLOWED: (f64, f64, f64) = (3.0, 500.0, 50.0);

/// Ctrl-C that is never pressed: a commissioning ends by itself.
static NEVER: AtomicBool = AtomicBool::new(false);

/// What a commissioning has found.
pub(super) struct Found {
    /// Series resonance that is proposed, less the true one, Hz.
    pub error_hz: f64,
    /// Frequency of the tested lock less the true resonance, Hz.
    pub lock_hz: f64,
}

/// A commissioning, judged.
pub(super) struct Judged {
    /// What it has found, or why it has refused.
    pub found: Result<Found, String>,
    /// Bound of an error, Hz.
    pub bound_hz: f64,
    /// Time that it took, and that it may take, of the board, s.
    pub board_s: f64,
    pub allowed_s: f64,
    /// Largest peak voltage and current, as parts of the bounds given.
    pub loudest_v: f64,
    pub loudest_a: f64,
}

impl Judged {
    /// The proposed resonance and the tested lock are within the bound.
    pub(super) fn is_right(&self) -> bool {
        self.found.as_ref().is_ok_and(|found| found.error_hz.abs().max(found.lock_hz.abs()) <= self.bound_hz)
    }

    /// It proposes settings that are wrong.
    pub(super) fn is_silent(&self) -> bool {
        self.found.is_ok() && !self.is_right()
    }

    /// It took no longer than it may.
    pub(super) fn is_in_time(&self) -> bool {
        self.board_s <= self.allowed_s
    }
}

/// The band that is given of a transducer: its ratio is fixed, and the place of the resonance in it follows from the number.
fn band_hz(of: &Transducer) -> (f64, f64) {
    // Evenly over the middle four fifths of the band, on a logarithmic scale.
    let part = 0.1 + 0.8 * (f64::from(of.number) * 0.618_033_988_75).fract();
    let low_hz = (of.hz / BAND.0.powf(part)).max(BAND.1).round();
    (low_hz, (BAND.0 * low_hz).round())
}

/// Commissions a transducer. Gives the command that repeats it, and the judgement.
pub(super) fn judge(transducer: &Transducer) -> Result<(String, Judged), Error> {
    let (low_hz, high_hz) = band_hz(transducer);
    let middle_hz = (low_hz * high_hz).sqrt();
    let nominal = Nominal { hz: middle_hz, span: 0.1, q: GUESSED_Q, lm_h: None, c0_f: None };
    let stranger = Transducer { nominal, ..transducer.clone() };
    let sets = sets(&stranger, "observer");
    let loaded = load(SCENE, &sets)?;
    let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
    let true_hz = circuit_of(&scene).series_resonance_hz();
    let volts = FrontEnd::of(&stranger).drive_v;
    let amperes = scene.controller.limits.current_a;
    let order = format!("commission --band {low_hz}:{high_hz} --max-volts {volts:.3}");
    let board = Rc::new(RefCell::new(WatchedBoard::new(SimulatedBoard::new(&scene, 1)?)));
    let found = commissioned(&order, &board)
        .map(|(found_hz, locked_hz)| Found { error_hz: found_hz - true_hz, lock_hz: locked_hz - true_hz });
    let found = match found {
        Err(error) if error.is_lost() => return Err(Error::Board(error.to_string())),
        found => found.map_err(|error| error.cause().to_string()),
    };
    let board = board.borrow();
    let (loudest_v, loudest_a) = board.loudest();
    let (least_s, q, ring_downs) = ALLOWED;
    let more_s = if transducer.q > q { ring_downs * transducer.q / (PI * transducer.hz) } else { 0.0 };
    let command = sets.iter().fold(format!("sim-host link sim:{SCENE} {order}"), |command, set| format!("{command} --set {set}"));
    Ok((
        command,
        Judged {
            found,
            bound_hz: bound_hz(true_hz, transducer.q),
            board_s: board.seconds(),
            allowed_s: least_s + more_s,
            loudest_v: loudest_v / volts,
            loudest_a: loudest_a / amperes,
        },
    ))
}

/// Series resonance that is proposed, and frequency of the tested lock, Hz.
fn commissioned(order: &str, board: &Rc<RefCell<WatchedBoard>>) -> Result<(f64, f64), LinkError> {
    let port = Box::new(Simulated::new("sim", board.clone(), false));
    let mut session = Session::begin(Client::new(port, &NEVER, |_| ()), SessionOptions::default())?;
    let mut found = None;
    Script::parse("commission", order)?.run(&mut session, |_, done| {
        let field = |name: &str| done.as_ref().ok().and_then(|answer| answer.fields.get(name)?.as_f64());
        found = field("series_resonance_hz").zip(field("locked_hz"));
        Ok(())
    })?;
    found.ok_or_else(|| LinkError::Failed("the answer of `commission` has no resonance".into()))
}
