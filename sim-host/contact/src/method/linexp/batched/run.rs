//! Eight batched runs from beginning to end, one stretch at a time.

use fearless_simd::{Simd, SimdBase, SimdFloat, SimdMask};

use super::super::METHOD;
use super::super::exact_step::Exact;
use super::super::quadrature::Nodes;
use super::super::simd_nodes::Places;
use super::fast_step::fast_step;
use super::forcing::Forcings;
use super::state::Batch;
use super::table::Tables;
use super::vector::{Mask, Vector, WIDTH, all, each, numbers, put};
use crate::SolveError;
use crate::problem::Problem;
use crate::state::State;
use crate::tally::Tally;
use crate::timeline::{Stretch, Timeline};

/// Number of steps of the batch between two pauses, counted over all contacts.
const STEPS_PER_PAUSE: u32 = 1 << 16;

/// Result of a run.
pub(super) type Outcome = Result<Tally, SolveError>;

/// Largest absolute values at the ends of steps.
struct Peaks<S: Simd> {
    velocity: Vector<S>,
    displacement: Vector<S>,
    force: Vector<S>,
    steps: u64,
}

/// Runs eight contacts and returns the first `count` results; `None` if their stretches are not
/// equal.
#[inline(always)]
pub(super) fn run<S: Simd, const K: usize, const N: usize>(
    simd: S,
    problems: &[&Problem; WIDTH],
    count: usize,
    alone: [Exact<K, N>; WIDTH],
    steps_per_period: u32,
    pause: &dyn Fn(),
) -> Option<Vec<Outcome>>
where
    Nodes<K>: Places,
{
    let zero = all(simd, 0.0);
    let mut runs = Batch::new(simd, alone);
    let mut peaks = Peaks { velocity: zero, displacement: zero, force: zero, steps: 0 };
    let mut timelines = problems.map(Timeline::new);
    let mut tables: Vec<Option<Tables<S, K, N>>> = Vec::new();
    let mut outcomes: [Option<Outcome>; WIDTH] = std::array::from_fn(|_| None);
    let mut on = Mask::from_bitmask(simd, (1 << count) - 1);
    let mut now_s = [0.0; WIDTH];
    let mut since_pause = 0;
    while let Some(stretches) = alike(&mut timelines, steps_per_period)? {
        let forcings = Forcings::combine(simd, &stretches.each_ref().map(|stretch| stretch.forcing))?;
        begin(&mut runs, &stretches, &forcings, now_s, on);
        let steps = stretches[0].steps(steps_per_period);
        let h = each(simd, |number| stretches[number].length_s / f64::from(steps));
        let mut tabled = on;
        for number in numbers(on) {
            if runs.alone[number].is_stiff(h[number]) {
                tabled.set(number, false);
            }
        }
        let template = stretches[0].template.filter(|_| tabled.any_true());
        if let Some(template) = template {
            if tables.len() <= template {
                tables.resize_with(template + 1, || None);
            }
            if tables[template].is_none() {
                tables[template] = Some(Tables::new(&runs, &forcings, steps, h));
            }
        }
        let table = template.and_then(|template| tables.get(template)).and_then(Option::as_ref);
        let behind_n_s = std::mem::replace(&mut runs.friction_n_s, zero);
        for step in 0..steps {
            go(&mut runs, table, (&forcings, step, h), (on, tabled));
            peaks.see(&runs, on);
        }
        since_pause += steps * WIDTH as u32;
        if since_pause >= STEPS_PER_PAUSE {
            since_pause = 0;
            pause();
        }
        runs.friction_n_s += behind_n_s;
        now_s = std::array::from_fn(|number| stretches[number].start_s + f64::from(steps) * h[number]);
        let finite = runs.x.is_finite() & (runs.coulomb_n * runs.f).is_finite();
        for number in numbers(on & !finite) {
            outcomes[number] = Some(Err(SolveError::Diverged { method: METHOD, time_s: now_s[number] }));
        }
        on &= finite;
        if !on.any_true() {
            break;
        }
    }
    for number in numbers(on) {
        outcomes[number] = Some(Ok(peaks.finish(&mut runs, number, now_s[number])));
    }
    outcomes.into_iter().take(count).collect()
}

/// Returns the next stretch of each timeline: `Some(None)` if all have ended, `None` if the
/// stretches are not equal.
#[inline(always)]
fn alike(timelines: &mut [Timeline; WIDTH], steps_per_period: u32) -> Option<Option<[Stretch; WIDTH]>> {
    let next = timelines.each_mut().map(Iterator::next);
    let Some(first) = next[0] else { return next.iter().all(Option::is_none).then_some(None) };
    let like = |stretch: &Stretch| {
        stretch.template == first.template
            && (stretch.opens, stretch.closes) == (first.opens, first.closes)
            && stretch.load.is_none()
            && stretch.steps(steps_per_period) == first.steps(steps_per_period)
    };
    next.iter().all(|stretch| stretch.as_ref().is_some_and(like)).then(|| Some(next.map(|stretch| stretch.unwrap_or(first))))
}

/// Begins a stretch, as [`Exact::face`] and the meter do.
#[inline(always)]
fn begin<S: Simd, const K: usize, const N: usize>(
    runs: &mut Batch<S, K, N>,
    stretches: &[Stretch; WIDTH],
    forcings: &Forcings<S>,
    now_s: [f64; WIDTH],
    on: Mask<S>,
) where
    Nodes<K>: Places,
{
    if matches!(forcings, Forcings::Cosine { .. }) && !(on & runs.sense.simd_eq(0.0)).any_true() {
        // A cosine continues the previous one.
        runs.face(on, runs.end(runs.f, runs.slip_velocity, runs.a));
    } else {
        for number in numbers(on) {
            let Stretch { forcing, length_s, .. } = stretches[number];
            runs.let_one(number, |run| run.face(&forcing, length_s));
        }
    }
    for number in numbers(on) {
        let state = state(runs, number, now_s[number]);
        let run = &mut runs.alone[number];
        run.meter.totals.friction_n_s = runs.friction_n_s[number];
        run.meter.totals.friction_work_j = runs.friction_work_j[number];
        run.meter.at(&stretches[number], &state, run.coulomb_n);
    }
}

#[inline(always)]
fn state<S: Simd, const K: usize, const N: usize>(runs: &Batch<S, K, N>, number: usize, time_s: f64) -> State
where
    Nodes<K>: Places,
{
    let force_n = runs.coulomb_n[number] * runs.f[number];
    State { time_s, x_m: runs.x[number], v_m_per_s: runs.v[number], force_n }
}

/// Computes one step of the contacts in `on`: by the table, by the table with one reversal, or in
/// parts.
#[inline(always)]
fn go<S: Simd, const K: usize, const N: usize>(
    runs: &mut Batch<S, K, N>,
    table: Option<&Tables<S, K, N>>,
    (forcings, step, h): (&Forcings<S>, u32, Vector<S>),
    (on, tabled): (Mask<S>, Mask<S>),
) where
    Nodes<K>: Places,
{
    let mut todo = on;
    let mut done = all(runs.simd, 0.0);
    if let Some(table) = table {
        todo &= !fast_step(runs, table, step as usize, tabled);
        let short = todo & tabled & h.simd_le(runs.longest());
        if short.any_true()
            && let Some(mut part) = table.part(runs, step as usize)
        {
            let end = runs.go(&mut part, short);
            put(&mut done, short, end);
        }
    }
    todo &= done.simd_lt(1.0);
    if todo.any_true() {
        runs.step(forcings, h * f64::from(step), h, done * h, todo);
    }
}

impl<S: Simd> Peaks<S> {
    /// Records the end of a step.
    #[inline(always)]
    fn see<const K: usize, const N: usize>(&mut self, runs: &Batch<S, K, N>, on: Mask<S>)
    where
        Nodes<K>: Places,
    {
        larger(&mut self.velocity, runs.v.abs(), on);
        larger(&mut self.displacement, runs.x.abs(), on);
        larger(&mut self.force, runs.f.abs(), on);
        self.steps += 1;
    }

    /// Returns the sums of one run.
    #[inline(always)]
    fn finish<const K: usize, const N: usize>(&self, runs: &mut Batch<S, K, N>, number: usize, time_s: f64) -> Tally
    where
        Nodes<K>: Places,
    {
        let state = state(runs, number, time_s);
        let run = &mut runs.alone[number];
        run.meter.totals.friction_n_s = runs.friction_n_s[number];
        run.meter.totals.friction_work_j = runs.friction_work_j[number];
        let tally = &mut run.meter.tally;
        tally.peak_velocity_m_per_s = self.velocity[number];
        tally.peak_displacement_m = self.displacement[number];
        tally.peak_force_ratio = self.force[number];
        tally.steps = self.steps;
        tally.reversals = runs.reversals[number] as u64;
        run.meter.finish(&state, run.coulomb_n)
    }
}

#[inline(always)]
fn larger<S: Simd>(peak: &mut Vector<S>, size: Vector<S>, on: Mask<S>) {
    put(peak, on & size.simd_gt(*peak), size);
}
