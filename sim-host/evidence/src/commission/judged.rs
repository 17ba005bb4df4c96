//! The result of a commissioning, compared with the plant.

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

/// Ratio of the ends of a band.
const BAND_RATIO: f64 = 1.5;
/// Lowest lower end of a band that is given, Hz: the converters of a board with blocks of 32
/// samples can measure above the first one, of 50 samples above the second.
const MIN_LOW_HZ: [f64; 2] = [15_700.0, 10_100.0];
/// Detuning at which the tip velocity per volt, 1 / sqrt(1 + (2 Q b / fs)^2), is 0.99 of its
/// maximum, relative to the bandwidth.
const GOOD_REL: f64 = 0.0712;
/// Time allowed for every commissioning, s.
const ALLOWED_S: f64 = 3.0;
/// Q above which more time is allowed.
const SLOW_Q: f64 = 500.0;
/// Number of ring-down times, `Q / (pi fs)`, that are allowed in addition above [`SLOW_Q`].
const SLOW_RING_DOWNS: f64 = 50.0;

/// A stop flag that is never set: a commissioning ends by itself.
static NEVER: AtomicBool = AtomicBool::new(false);

/// Frequencies that a commissioning has found.
pub(super) struct Found {
    /// Proposed series resonance less the true one, Hz.
    pub error_hz: f64,
    /// Frequency of the tested lock less the true resonance, Hz.
    pub lock_hz: f64,
}

/// Result of a commissioning, compared with the plant.
pub(super) struct Judged {
    /// Frequencies found, or the reason of the refusal.
    pub found: Result<Found, String>,
    /// Largest error of a right result, Hz.
    pub bound_hz: f64,
    /// Largest error at which the tip velocity is at most 1 % below its maximum, Hz.
    pub good_hz: f64,
    /// Time that the commissioning took on the board, s.
    pub board_s: f64,
    /// Time that it may take, s.
    pub allowed_s: f64,
    /// Largest peak voltage, relative to its limit.
    pub peak_v_rel: f64,
    /// Largest peak current, relative to its limit.
    pub peak_a_rel: f64,
}

impl Judged {
    /// Returns `true` if the proposed resonance and the tested lock are within the bound.
    pub(super) fn is_right(&self) -> bool {
        self.is_within(self.bound_hz)
    }

    /// Returns `true` if it is not right, but the drive loses at most 1 % of the tip velocity.
    pub(super) fn is_good(&self) -> bool {
        !self.is_right() && self.is_within(self.good_hz.max(self.bound_hz))
    }

    /// Returns `true` if it proposes settings with a larger loss.
    pub(super) fn is_silently_wrong(&self) -> bool {
        self.found.is_ok() && !self.is_right() && !self.is_good()
    }

    fn is_within(&self, hz: f64) -> bool {
        self.found.as_ref().is_ok_and(|found| found.error_hz.abs().max(found.lock_hz.abs()) <= hz)
    }

    /// Returns `true` if it took no longer than allowed.
    pub(super) fn is_in_time(&self) -> bool {
        self.board_s <= self.allowed_s
    }
}

/// Returns the band given for a transducer, Hz. Its ratio is fixed; the transducer's number
/// determines the position of the resonance in it.
fn band_hz(of: &Transducer) -> (f64, f64) {
    // Evenly over the middle four fifths of the band, on a logarithmic scale.
    let part = 0.1 + 0.8 * (f64::from(of.number) * 0.618_033_988_75).fract();
    let min_hz = MIN_LOW_HZ.into_iter().find(|min_hz| *min_hz < 0.98 * of.hz).unwrap_or(0.0);
    let low_hz = (of.hz / BAND_RATIO.powf(part)).max(min_hz).round();
    (low_hz, (BAND_RATIO * low_hz).round())
}

/// Commissions a transducer, and returns the command that repeats it and the result.
pub(super) fn judge(transducer: &Transducer) -> Result<(String, Judged), Error> {
    let (low_hz, high_hz) = band_hz(transducer);
    let middle_hz = (low_hz * high_hz).sqrt();
    let nominal = Nominal { hz: middle_hz, span: 0.1, q: GUESSED_Q, lm_h: None, c0_f: None };
    let unknown = Transducer { nominal, ..transducer.clone() };
    let sets = sets(&unknown, "observer");
    let loaded = load(SCENE, &sets)?;
    let scene = loaded.scene.driven().ok_or(StudyError::Incomplete)?;
    let true_hz = circuit_of(&scene).series_resonance_hz();
    let volts = FrontEnd::of(&unknown).drive_v;
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
    let (peak_v_rel, peak_a_rel) = board.largest();
    let more_s = if transducer.q > SLOW_Q { SLOW_RING_DOWNS * transducer.q / (PI * transducer.hz) } else { 0.0 };
    let command = sets.iter().fold(format!("sim-host link sim:{SCENE} {order}"), |command, set| format!("{command} --set {set}"));
    Ok((
        command,
        Judged {
            found,
            bound_hz: bound_hz(true_hz, transducer.q),
            good_hz: GOOD_REL * true_hz / transducer.q,
            board_s: board.seconds(),
            allowed_s: ALLOWED_S + more_s,
            peak_v_rel: peak_v_rel / volts,
            peak_a_rel: peak_a_rel / amperes,
        },
    ))
}

/// Returns the proposed series resonance and the frequency of the tested lock, Hz.
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
