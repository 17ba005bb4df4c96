//! Amplifiers and stator, advanced by their exact flow like [`stack`](crate::stack).
//!
//! Within a step each lane can change its voltage once, at its own time (see
//! [`lanes`](crate::motor::lanes)). A voltage that begins `s` into a step of `h` has the response
//! of a step of `h - s`; the previous voltage has the rest. The values at the converters follow
//! from the state at the beginning of the step in the same way. The load does not affect the
//! amplifiers, so only eight rows of the flow are full.

use firmware::seam::block::MAX_LANES;

use crate::converter::Adc;
use crate::motor::lanes::Played;
use crate::motor::model::Model;
use crate::motor::network::{D, DRIVE, E, FORCE, Network, Q, S, STATES, V, WIDTH, network};
use crate::motor::participation::MODES;
use crate::quad::{Quad, Registers, Wide};
use crate::timing::Timing;
use contact::flow::exponential;
use scene::Amplifier;

/// Rows of the network in groups of four that fill vector registers: lane voltages, modes,
/// amplifier outputs, their slopes.
type Fours = [Quad; 4];

/// Response of the rows to each lane's voltage before and after it changes.
type Response = [[Fours; 2]; MAX_LANES];

/// Coefficients of voltage and current of one lane at two times within a step (v, i, v, i).
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    /// Number of conversions, 1 or 2; with one, the second half is zero.
    conversions: usize,
    state: [Quad; STATES],
    drive: [[Quad; 2]; MAX_LANES],
    force: [Quad; MODES],
}

/// The network and its state.
#[derive(Clone, Debug)]
pub struct Linear {
    x: Fours,
    /// The state at the beginning of the last step.
    before: Fours,
    /// Columns of the flow for the rows of voltages and modes.
    flow: [[Quad; 2]; STATES],
    /// Flow of the amplifiers: `e` from `e` and `d`, `d` from `e` and `d`. All four are identical.
    amplifier: [Quad; 4],
    /// Response of each step of a sample.
    drive: Vec<Response>,
    /// Response of voltages and modes to the friction on each mode, N.
    force: [[Quad; 2]; MODES],
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
    std::array::from_fn(|four| Quad(std::array::from_fn(|n| row(4 * four + n))))
}

impl Linear {
    /// Creates a stator at rest whose lanes change their voltage `change` samples into each sample.
    pub fn new(model: &Model, amplifier: &Amplifier, timing: Timing, change: [f64; MAX_LANES]) -> Self {
        let zero = Quad::default();
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
        self.amplifier = [step[E][E], step[E][D], step[D][E], step[D][D]].map(Quad::splat);

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
        let mut look = |step: usize, lane: usize, instants: &[[f64; 2]]| {
            let mut look = Look { conversions: instants.len(), ..Look::default() };
            for (conversion, [v, i]) in instants.iter().enumerate() {
                let (early, late) = (*flows.over(*v), *flows.over(*i));
                // Measured at the amplifier's terminals: without electrodes, its full output and no
                // current.
                let terminal = if model.connected[lane] { V + lane } else { E + lane };
                // The total current is (e - v) / Rs.
                let total = |column: usize| (late[E + lane][column] - late[terminal][column]) / source;
                let put = |quad: &mut Quad, both: [f64; 2]| quad.0[2 * conversion..][..2].copy_from_slice(&both);
                let both = |column: usize| [early[terminal][column], total(column)];
                look.state.iter_mut().enumerate().for_each(|(state, quad)| put(quad, both(state)));
                look.force.iter_mut().enumerate().for_each(|(mode, quad)| put(quad, both(FORCE + mode)));
                for (by, drive) in look.drive.iter_mut().enumerate() {
                    let at = into(step, by);
                    let voltage = flows.drive(terminal, by, *v, at);
                    let (e, u) = (flows.drive(E + lane, by, *i, at), flows.drive(terminal, by, *i, at));
                    drive.iter_mut().enumerate().for_each(|(n, quad)| put(quad, [voltage[n], (e[n] - u[n]) / source]));
                }
            }
            look
        };
        let mut looks = |step: usize, instants: &[[f64; 2]]| std::array::from_fn(|lane| look(step, lane, instants));
        let instants = timing.instants().into_iter().enumerate();
        self.looks = instants.map(|(step, instants)| instants.chunks(2).map(|pair| looks(step, pair)).collect()).collect();
    }

    /// Advances by step `step` of a sample with the drive as played and no friction.
    #[inline(always)]
    pub(crate) fn advance<F: Registers>(&mut self, four: F, step: usize, played: &Played) {
        let mut sum = [Wide::splat(four, 0.0); 4];
        for (lane, [before, after]) in self.drive[step].iter().enumerate() {
            let (a, b) = (Wide::splat(four, played.before[lane]), Wide::splat(four, played.after[lane]));
            for row in 0..4 {
                sum[row] = sum[row] + (before[row].wide(four) * a + after[row].wide(four) * b);
            }
        }
        let [ee, ed, de, dd] = self.amplifier.map(|part| part.wide(four));
        let [_, _, e, d] = self.x.map(|rows| rows.wide(four));
        sum[2] = sum[2] + (ee * e + ed * d);
        sum[3] = sum[3] + (de * e + dd * d);
        for (rows, columns) in self.flow.chunks_exact(4).enumerate() {
            for (x, [volts, modes]) in self.x[rows].0.into_iter().zip(columns) {
                let x = Wide::splat(four, x);
                sum[0] = sum[0] + volts.wide(four) * x;
                sum[1] = sum[1] + modes.wide(four) * x;
            }
        }
        self.before = std::mem::replace(&mut self.x, sum.map(Wide::quad));
    }

    /// Adds the effect of a friction of `newtons` on each mode during the last step, N.
    #[inline(always)]
    pub(crate) fn push<F: Registers>(&mut self, four: F, newtons: [f64; MODES]) {
        for (newtons, force) in newtons.into_iter().zip(&self.force) {
            let newtons = Wide::splat(four, newtons);
            for (x, response) in self.x.iter_mut().zip(force) {
                *x = (x.wide(four) + response.wide(four) * newtons).quad();
            }
        }
    }

    /// Returns the velocity change of a mode by one newton over a step, m/s.
    pub fn velocity_per_newton(&self) -> f64 {
        self.force[0][1][0]
    }

    /// Returns the velocities of the sine and the cosine mode, m/s.
    #[inline]
    pub fn velocities(&self) -> [f64; MODES] {
        let Quad([s, c, _, _]) = self.x[1];
        [s, c]
    }

    /// Returns the amplitudes of the sine and the cosine mode, m.
    #[inline]
    pub fn amplitudes(&self) -> [f64; MODES] {
        let Quad([_, _, s, c]) = self.x[1];
        [s, c]
    }

    /// Returns the voltages of the lanes, V.
    #[inline]
    pub fn voltages(&self) -> [f64; MAX_LANES] {
        self.x[0].0
    }

    /// Sets states below 1e-150 to zero: denormal numbers halve the speed of this arithmetic.
    pub fn settle(&mut self) {
        let ended = |x: f64| if x.abs() < 1e-150 { 0.0 } else { x };
        self.x = self.x.map(|four| Quad(four.0.map(ended)));
    }

    /// Returns the sums of the codes of a lane's voltage and current within step `step`. The step
    /// has just been made, with a friction of `newtons` on each mode.
    #[inline(always)]
    pub(crate) fn sample<F: Registers>(
        &self,
        four: F,
        (step, lane): (usize, usize),
        played: &Played,
        newtons: [f64; MODES],
        adc: &mut Adc,
    ) -> [u16; 2] {
        let times = |part: Quad, number: f64| part.wide(four) * Wide::splat(four, number);
        let mut codes = [0; 2];
        for looks in &self.looks[step] {
            let look = &looks[lane];
            let mut sum = times(look.force[0], newtons[0]) + times(look.force[1], newtons[1]);
            for (by, [earlier, later]) in look.drive.iter().enumerate() {
                sum = sum + (times(*earlier, played.before[by]) + times(*later, played.after[by]));
            }
            for (x, columns) in self.before.iter().zip(look.state.chunks_exact(4)) {
                for (x, column) in x.0.into_iter().zip(columns) {
                    sum = sum + times(*column, x);
                }
            }
            let [v, i] = adc.digitize(adc.scaled(sum), look.conversions);
            codes = [codes[0] + v, codes[1] + i];
        }
        codes
    }
}

/// The code above depends on this order of the rows, in groups of four.
const _: () = assert!(V == 0 && S == 4 && Q == 6 && E == 8 && D == 12 && WIDTH == 22);
