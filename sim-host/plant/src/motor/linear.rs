//! Amplifiers and stator, advanced by their exact flow like [`stack`](crate::stack).
//!
//! Within a step each lane can change its voltage once, at its own time (see
//! [`lanes`](crate::motor::lanes)). A voltage that begins `s` into a step of `h` has the response
//! of a step of `h - s`; the previous voltage has the rest. The values at the converters follow
//! from the state at the beginning of the step in the same way. The load does not affect the
//! amplifiers, so only eight rows of the flow are full.

use firmware::seam::block::MAX_LANES;
use wide::{f64x2, f64x4};

use crate::motor::lanes::Played;
use crate::motor::model::Model;
use crate::motor::network::{D, DRIVE, E, FORCE, Network, Q, S, STATES, V, WIDTH, network};
use crate::motor::participation::MODES;
use crate::timing::Timing;
use contact::flow::exponential;
use scene::Amplifier;

/// Rows of the network in groups of four that fill vector registers: lane voltages, modes,
/// amplifier outputs, their slopes.
type Fours = [f64x4; 4];

/// Response of the rows to each lane's voltage before and after it changes.
type Response = [[Fours; 2]; MAX_LANES];

/// Coefficients of voltage and current of one lane at a certain time within a step.
#[derive(Clone, Copy, Debug)]
struct Look {
    state: [f64x2; STATES],
    drive: [[f64x2; 2]; MAX_LANES],
    force: [f64x2; MODES],
}

/// The network and its state.
#[derive(Clone, Debug)]
pub struct Linear {
    x: Fours,
    /// The state at the beginning of the last step.
    before: Fours,
    /// Columns of the flow for the rows of voltages and modes.
    flow: [[f64x4; 2]; STATES],
    /// Flow of the amplifiers: `e` from `e` and `d`, `d` from `e` and `d`. All four are identical.
    amplifier: [f64x4; 4],
    /// Response of each step of a sample.
    drive: Vec<Response>,
    /// Response of voltages and modes to the friction on each mode, N.
    force: [[f64x4; 2]; MODES],
    /// Coefficients by step of a sample, by conversion in that step, by lane.
    looks: Vec<Vec<[Look; MAX_LANES]>>,
}

/// Matrix exponentials of one network, each computed once.
struct Flows {
    network: Network,
    made: Vec<(f64, Box<Network>)>,
}

impl Flows {
    fn over(&mut self, seconds: f64) -> &Network {
        let known = self.made.iter().position(|(time, _)| *time == seconds);
        let index = known.unwrap_or_else(|| {
            let exponent = self.network.map(|row| row.map(|x| x * seconds));
            self.made.push((seconds, Box::new(exponential(&exponent))));
            self.made.len() - 1
        });
        &self.made[index].1
    }

    /// Returns the response over `seconds` to a lane's voltage before and after it changes,
    /// `change` seconds into the step.
    fn drive(&mut self, row: usize, lane: usize, seconds: f64, change: f64) -> [f64; 2] {
        let whole = self.over(seconds)[row][DRIVE + lane];
        // A change at or after the end has no effect; one before the beginning has already
        // happened.
        let after = if change >= seconds { 0.0 } else { self.over(seconds - change.max(0.0))[row][DRIVE + lane] };
        [whole - after, after]
    }
}

fn fours(row: impl Fn(usize) -> f64) -> Fours {
    std::array::from_fn(|four| f64x4::new(std::array::from_fn(|n| row(4 * four + n))))
}

impl Linear {
    /// Creates a stator at rest whose lanes change their voltage `change` samples into each sample.
    pub fn new(model: &Model, amplifier: &Amplifier, timing: Timing, change: [f64; MAX_LANES]) -> Self {
        let zero = f64x4::splat(0.0);
        let mut linear = Linear {
            x: [zero; 4],
            before: [zero; 4],
            flow: [[zero; 2]; STATES],
            amplifier: [zero; 4],
            drive: Vec::new(),
            force: [[zero; 2]; MODES],
            looks: Vec::new(),
        };
        linear.remake(model, amplifier, timing, change);
        linear
    }

    /// Changes the stator; voltages, amplitudes and velocities remain.
    pub fn remake(&mut self, model: &Model, amplifier: &Amplifier, timing: Timing, change: [f64; MAX_LANES]) {
        let mut flows = Flows { network: network(model, amplifier), made: Vec::new() };
        let step_s = timing.step_s();
        let step = *flows.over(step_s);
        let column = |c: usize| fours(|r| step[r][c]);
        self.flow = std::array::from_fn(|c| [column(c)[0], column(c)[1]]);
        self.force = std::array::from_fn(|mode| [column(FORCE + mode)[0], column(FORCE + mode)[1]]);
        self.amplifier = [step[E][E], step[E][D], step[D][E], step[D][D]].map(f64x4::splat);

        let into = |step: usize, lane: usize| change[lane] * timing.sample_s - step as f64 * step_s;
        self.drive = (0..timing.steps as usize)
            .map(|step| {
                std::array::from_fn(|lane| {
                    let rows: [[f64; 2]; STATES] = std::array::from_fn(|row| flows.drive(row, lane, step_s, into(step, lane)));
                    [fours(|row| rows[row][0]), fours(|row| rows[row][1])]
                })
            })
            .collect();
        let source = amplifier.source_ohm;
        let mut look = |step: usize, lane: usize, [v, i]: [f64; 2]| {
            let (early, late) = (*flows.over(v), *flows.over(i));
            // Measured at the amplifier's terminals: without electrodes, its full output and no
            // current.
            let terminal = if model.connected[lane] { V + lane } else { E + lane };
            // The total current is (e - v) / Rs.
            let total = |column: usize| (late[E + lane][column] - late[terminal][column]) / source;
            let both = |column: usize| f64x2::new([early[terminal][column], total(column)]);
            Look {
                state: std::array::from_fn(both),
                drive: std::array::from_fn(|by| {
                    let at = into(step, by);
                    let voltage = flows.drive(terminal, by, v, at);
                    let (e, v) = (flows.drive(E + lane, by, i, at), flows.drive(terminal, by, i, at));
                    std::array::from_fn(|n| f64x2::new([voltage[n], (e[n] - v[n]) / source]))
                }),
                force: std::array::from_fn(|mode| both(FORCE + mode)),
            }
        };
        let instants = timing.instants().into_iter().enumerate();
        self.looks = instants
            .map(|(step, instants)| instants.into_iter().map(|at| std::array::from_fn(|lane| look(step, lane, at))).collect())
            .collect();
    }

    /// Advances by step `step` of a sample with the drive as played and no friction.
    #[inline]
    pub fn advance(&mut self, step: usize, played: &Played) {
        let mut sum = [f64x4::splat(0.0); 4];
        for (lane, [before, after]) in self.drive[step].iter().enumerate() {
            let (a, b) = (f64x4::splat(played.before[lane]), f64x4::splat(played.after[lane]));
            for row in 0..4 {
                sum[row] += before[row] * a + after[row] * b;
            }
        }
        let [ee, ed, de, dd] = self.amplifier;
        let [_, _, e, d] = self.x;
        sum[2] += ee * e + ed * d;
        sum[3] += de * e + dd * d;
        for (four, columns) in self.flow.chunks_exact(4).enumerate() {
            for (x, [volts, modes]) in self.x[four].to_array().into_iter().zip(columns) {
                sum[0] += *volts * x;
                sum[1] += *modes * x;
            }
        }
        self.before = std::mem::replace(&mut self.x, sum);
    }

    /// Adds the effect of a friction of `newtons` on each mode during the last step, N.
    #[inline]
    pub fn push(&mut self, newtons: [f64; MODES]) {
        for (newtons, [volts, modes]) in newtons.into_iter().zip(&self.force) {
            self.x[0] += *volts * newtons;
            self.x[1] += *modes * newtons;
        }
    }

    /// Returns the velocity change of a mode by one newton over a step, m/s.
    pub fn velocity_per_newton(&self) -> f64 {
        self.force[0][1].to_array()[0]
    }

    /// Returns the velocities of the sine and the cosine mode, m/s.
    #[inline]
    pub fn velocities(&self) -> [f64; MODES] {
        let [s, c, _, _] = self.x[1].to_array();
        [s, c]
    }

    /// Returns the amplitudes of the sine and the cosine mode, m.
    #[inline]
    pub fn amplitudes(&self) -> [f64; MODES] {
        let [_, _, s, c] = self.x[1].to_array();
        [s, c]
    }

    /// Returns the voltages of the lanes, V.
    #[inline]
    pub fn voltages(&self) -> [f64; MAX_LANES] {
        self.x[0].to_array()
    }

    /// Sets states below 1e-150 to zero: denormal numbers halve the speed of this arithmetic.
    pub fn settle(&mut self) {
        let ended = |x: f64| if x.abs() < 1e-150 { 0.0 } else { x };
        self.x = self.x.map(|four| f64x4::new(four.to_array().map(ended)));
    }

    /// Passes voltage and current of a lane at each conversion within step `step` to `convert`. The
    /// step has just been made, with a friction of `newtons` on each mode.
    #[inline]
    pub fn sample(&self, step: usize, lane: usize, played: &Played, newtons: [f64; MODES], mut convert: impl FnMut(f64x2)) {
        for looks in &self.looks[step] {
            let look = &looks[lane];
            let mut sum = look.force[0] * newtons[0] + look.force[1] * newtons[1];
            for (by, [before, after]) in look.drive.iter().enumerate() {
                sum += *before * played.before[by] + *after * played.after[by];
            }
            for (four, columns) in look.state.chunks_exact(4).enumerate() {
                for (x, column) in self.before[four].to_array().into_iter().zip(columns) {
                    sum += *column * x;
                }
            }
            convert(sum);
        }
    }
}

/// The code above depends on this order of the rows, in groups of four.
const _: () = assert!(V == 0 && S == 4 && Q == 6 && E == 8 && D == 12 && WIDTH == 22);
