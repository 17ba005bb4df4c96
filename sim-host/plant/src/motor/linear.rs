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

/// Response of the rows in one step to the lanes' voltages: before and after they change.
#[derive(Clone, Copy, Debug)]
struct Response {
    /// `true` if a lane still has its earlier voltage in this step.
    is_early: bool,
    /// Response to each lane, before and after its change, of voltages and modes.
    shared: [[[Quad; 2]; 2]; MAX_LANES],
    /// Response of the amplifiers' outputs and slopes, each to its own lane before and after its
    /// change.
    own: [[Quad; 2]; 2],
}

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

/// Returns the total of the sums of four groups of columns and of the drive.
#[inline(always)]
fn total<F: Registers>([v, modes, e, d, drive]: [Wide<F>; 5]) -> Wide<F> {
    ((v + modes) + (e + d)) + drive
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
                let mut response = |row: usize, lane: usize, when: usize| flows.drive(row, lane, step_s, into(step, lane))[when];
                let mut quad =
                    |first: usize, lane: usize, when: usize| Quad([0, 1, 2, 3].map(|n| response(first + n, lane, when)));
                let shared = std::array::from_fn(|lane| [0, 1].map(|when| [V, S].map(|first| quad(first, lane, when))));
                let own = [E, D].map(|first| [0, 1].map(|when| Quad([0, 1, 2, 3].map(|n| response(first + n, n, when)))));
                Response { is_early: (0..MAX_LANES).any(|lane| into(step, lane) > 0.0), shared, own }
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
        let response = &self.drive[step];
        let [ee, ed, de, dd] = self.amplifier.map(|part| part.wide(four));
        let [_, _, e, d] = self.x.map(|rows| rows.wide(four));
        let [own_e, own_d] = response.own;
        let after = Quad(played.after).wide(four);
        let mut e_rows = (ee * e + ed * d) + own_e[1].wide(four) * after;
        let mut d_rows = (de * e + dd * d) + own_d[1].wide(four) * after;
        // Separate sums of groups of four columns: in a single one each addition would wait for the
        // one before.
        let zero = Wide::splat(four, 0.0);
        let (mut volts, mut modes) = ([zero; 5], [zero; 5]);
        for (lane, [before, after]) in response.shared.iter().enumerate() {
            let x = Wide::splat(four, played.after[lane]);
            volts[4] = volts[4] + after[0].wide(four) * x;
            modes[4] = modes[4] + after[1].wide(four) * x;
            if response.is_early {
                let x = Wide::splat(four, played.before[lane]);
                volts[4] = volts[4] + before[0].wide(four) * x;
                modes[4] = modes[4] + before[1].wide(four) * x;
            }
        }
        if response.is_early {
            let before = Quad(played.before).wide(four);
            e_rows = e_rows + own_e[0].wide(four) * before;
            d_rows = d_rows + own_d[0].wide(four) * before;
        }
        for (group, columns) in self.flow.chunks_exact(4).enumerate() {
            for (x, column) in self.x[group].0.into_iter().zip(columns) {
                let x = Wide::splat(four, x);
                volts[group] = volts[group] + column[0].wide(four) * x;
                modes[group] = modes[group] + column[1].wide(four) * x;
            }
        }
        let sum = [total(volts), total(modes), e_rows, d_rows];
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
            let mut parts = [Wide::splat(four, 0.0); 5];
            parts[4] = times(look.force[0], newtons[0]) + times(look.force[1], newtons[1]);
            for (by, [earlier, later]) in look.drive.iter().enumerate() {
                parts[4] = parts[4] + times(*later, played.after[by]);
                parts[4] = parts[4] + times(*earlier, played.before[by]);
            }
            for (group, columns) in look.state.chunks_exact(4).enumerate() {
                for (x, column) in self.before[group].0.into_iter().zip(columns) {
                    parts[group] = parts[group] + times(*column, x);
                }
            }
            let sum = total(parts);
            let [v, i] = adc.digitize(adc.scaled(sum), look.conversions);
            codes = [codes[0] + v, codes[1] + i];
        }
        codes
    }
}

/// The code above depends on this order of the rows, in groups of four.
const _: () = assert!(V == 0 && S == 4 && Q == 6 && E == 8 && D == 12 && WIDTH == 22);
