//! The arcs of the steady period, in units of `mu kz a` and of the phase p since the deepest
//! indentation.
//!
//! ```text
//! g(p) = max(D + cos p, 0)                                    limit of the friction; D = u0 / a
//! touch  -b, part b: b = acos(-D), or pi for D >= 1           without contact in between
//! stick  p1: where g' = -sin p first equals s, or -b if it jumps above s there
//! slip   p2: where the line g(p1) + s (p - p1) meets g again
//! ```
//!
//! Between p1 and p2 friction is the line, otherwise it is g. With h = (p2 - p1) / 2, c = -cos p1
//! and the jump e = -sin p1 - s (zero if the stick begins smoothly),
//!
//! ```text
//! e h + c sin^2 h - (s + e) (h - sin h cos h) = 0,   one root in the range of g' < s
//! ```
//!
//! The means are sums over arcs, computed without cancellation. With a held load, `mean g = w`
//! gives D: for w >= 1 D = w, otherwise from `sin b - b cos b = pi w`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Largest number of iterations for a root; at least every other one halves the bracket.
const MAX_ITERATIONS: u32 = 200;

/// Mean position of the bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Indentation {
    /// Excess D - 1 while contact is never lost, otherwise 0.
    excess: f64,
    /// Half of the phase in contact, b.
    half: f64,
}

impl Indentation {
    /// Creates the position from the mean indentation in amplitudes, above -1.
    pub(super) fn at(depth: f64) -> Self {
        let (below, above) = ((1.0 - depth).max(0.0), (1.0 + depth).max(0.0));
        Indentation { excess: (depth - 1.0).max(0.0), half: 2.0 * above.sqrt().atan2(below.sqrt()) }
    }

    /// Creates the position from the mean normal force in units of kz a, above 0.
    pub(super) fn under(load: f64) -> Self {
        let below = 1.0 - load;
        if below <= 0.0 {
            return Indentation { excess: -below, half: PI };
        }
        let half = if load > 0.5 {
            // Difference to a load of one: pi (1 - w) = 2 pi sin^2(q / 2) - (sin q - q cos q) with
            // q = pi - b.
            let missing = |q: f64| TAU * (0.5 * q).sin().powi(2) - sine_less_turned(q) - PI * below;
            PI - root((0.0, PI), missing, |q| (PI - q) * q.sin())
        } else {
            root((0.0, PI), |b| sine_less_turned(b) - PI * load, |b| b * b.sin())
        };
        Indentation { excess: 0.0, half }
    }

    /// Returns D, the mean position in amplitudes.
    fn depth(self) -> f64 {
        self.excess - self.half.cos()
    }

    /// Returns `cos p - cos b`.
    fn over_parting(self, phase: f64) -> f64 {
        2.0 * (0.5 * (self.half + phase)).sin() * (0.5 * (self.half - phase)).sin()
    }

    /// Returns g at a phase in contact.
    fn normal(self, phase: f64) -> f64 {
        self.excess + self.over_parting(phase)
    }

    /// Returns the integral of g from `from` to `to`, both in contact.
    fn integral(self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let less = if half == 0.0 { 0.0 } else { less_sine(half) / half };
        2.0 * half * (self.excess + self.over_parting(middle) - middle.cos() * less)
    }

    /// Returns the mean of g over the period.
    fn mean(self) -> f64 {
        if self.half < PI { sine_less_turned(self.half) / PI } else { 1.0 + self.excess }
    }

    /// Returns the largest slope of g: one, or its slope at the beginning of contact if that is in
    /// the last quarter before the deepest indentation.
    fn critical(self) -> f64 {
        if self.half < FRAC_PI_2 { self.half.sin() } else { 1.0 }
    }
}

/// Arcs of a steady period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arcs {
    place: Indentation,
    /// Sliding speed s.
    speed: f64,
    /// Phases between which the contact sticks; `None` if it never does.
    stick: Option<(f64, f64)>,
}

impl Arcs {
    /// Finds the arcs of a sliding speed s >= 0.
    pub(super) fn new(place: Indentation, speed: f64) -> Self {
        Arcs { place, speed, stick: (speed < place.critical()).then(|| stick(place, speed)) }
    }

    /// Returns the mean of the friction.
    pub(super) fn mean_friction(&self) -> f64 {
        let place = self.place;
        let Some((from, to)) = self.stick else { return place.mean() };
        let long = to - from;
        let line = long * (place.normal(from) + 0.5 * self.speed * long);
        (place.integral(-place.half, from) + line + place.integral(to, place.half)) / TAU
    }

    /// Returns the mean of the normal force.
    pub(super) fn mean_normal(&self) -> f64 {
        self.place.mean()
    }

    /// Returns the largest normal force.
    pub(super) fn peak_normal(&self) -> f64 {
        self.place.normal(0.0)
    }

    /// Returns D, the mean position in amplitudes.
    pub(super) fn mean_place(&self) -> f64 {
        self.place.depth()
    }

    /// Returns the fraction of the period in contact.
    pub(super) fn contact_share(&self) -> f64 {
        self.place.half / PI
    }

    /// Returns the fraction of the period in which the contact sticks.
    pub(super) fn stick_share(&self) -> f64 {
        self.stick.map_or(0.0, |(from, to)| (to - from) / TAU)
    }

    /// Returns the speed above which the contact never sticks.
    pub(super) fn critical(&self) -> f64 {
        self.place.critical()
    }

    /// Returns the number of periods within which the relaxed spring reaches the limit, after which
    /// the period is steady.
    pub(super) fn settle_periods(&self) -> f64 {
        let excess = self.place.excess;
        if excess > 0.0 { 1.0 + (excess / (TAU * self.speed)).ceil() } else { 1.0 }
    }

    /// Returns the displacement from the mean position in amplitudes, and friction, at any phase.
    pub(super) fn at(&self, phase: f64) -> (f64, f64) {
        let place = self.place;
        // Within half a period before or after the deepest indentation.
        let turn = (phase + PI).rem_euclid(TAU) - PI;
        let friction = match self.stick {
            _ if turn.abs() > place.half => 0.0,
            Some((from, to)) if turn > from && turn < to => place.normal(from) + self.speed * (turn - from),
            _ => place.normal(turn).max(0.0),
        };
        (turn.cos(), friction)
    }

    /// Returns the phases at which contact or sticking begins or ends.
    pub(super) fn events(&self) -> impl Iterator<Item = f64> {
        let half = Some(self.place.half).filter(|half| *half < PI);
        let contact = half.into_iter().flat_map(|half| [-half, half]);
        contact.chain(self.stick.into_iter().flat_map(|(from, to)| [from, to]))
    }
}

/// Returns the phases between which the contact sticks at a speed below the critical one.
fn stick(place: Indentation, speed: f64) -> (f64, f64) {
    let cosine = ((1.0 - speed) * (1.0 + speed)).sqrt();
    // Phase after the outermost position at which the limit rises as fast as the spring is loaded.
    let smooth = speed.atan2(cosine);
    let jumps = PI - place.half > smooth;
    let (from, slope, cosine) =
        if jumps { (-place.half, place.half.sin(), -place.half.cos()) } else { (smooth - PI, speed, cosine) };
    if speed == 0.0 {
        return (from, place.half);
    }
    let jump = slope - speed;
    // The stick ends after the phase at which the limit's slope falls to the speed again, and
    // before contact is lost or the limit reaches its minimum.
    let bracket = (0.5 * (-smooth - from).max(0.0), 0.5 * (place.half - from));
    let off = |h: f64| 0.5 * slope * less_sine(2.0 * h) - cosine * h.sin().powi(2) - jump * h;
    let rise = |h: f64| 2.0 * h.sin() * (from + h).cos() - jump;
    (from, from + 2.0 * root(bracket, off, rise))
}

/// Finds the root of a function that rises from below zero to above it, by Newton's method within
/// its bracket.
fn root((mut low, mut high): (f64, f64), off: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> f64 {
    let mut at = 0.5 * (low + high);
    let mut before = high - low;
    for _ in 0..MAX_ITERATIONS {
        let value = off(at);
        if value > 0.0 {
            high = at;
        } else {
            low = at;
        }
        let newton = at - value / slope(at);
        // Newton's method is used only while it converges.
        let closes = (newton - at).abs() < 0.5 * before;
        let next = if newton > low && newton < high && closes { newton } else { 0.5 * (low + high) };
        before = (next - at).abs();
        if before <= f64::EPSILON * at {
            return next;
        }
        at = next;
    }
    at
}

/// Returns `x - sin x`, without cancellation.
fn less_sine(x: f64) -> f64 {
    if x > 1.0 {
        return x - x.sin();
    }
    // sum of (-1)^(k+1) x^(2k+1) / (2k+1)!
    let mut term = x;
    let mut sum = 0.0;
    for k in 1..10 {
        let k = f64::from(k);
        term *= -x * x / (2.0 * k * (2.0 * k + 1.0));
        sum -= term;
    }
    sum
}

/// Returns `sin x - x cos x`, without cancellation.
fn sine_less_turned(x: f64) -> f64 {
    // x (1 - cos x) - (x - sin x): for small x the second term is a third of the first.
    2.0 * x * (0.5 * x).sin().powi(2) - less_sine(x)
}
