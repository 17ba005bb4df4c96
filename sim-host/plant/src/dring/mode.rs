//! Discrete modes of webbing, D-ring and spool: the motion in each mode, and the events that end
//! it.

use super::Bench;
use super::span::Part;
use super::state::{Ramp, State, Tensions, Way};

/// End of the actuator's friction range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The lowest friction: webbing slides no faster than the actuator can follow.
    Floor,
    /// The highest friction: webbing slides at least as fast as the actuator can follow.
    Full,
}

/// Motion of the webbing at the D-ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slide {
    /// The webbing does not slide.
    Stuck,
    /// The webbing slides with the friction at one end, at any speed on the permitted side of the
    /// law's speed.
    Held(Way, End),
    /// The webbing slides at the speed that the law gives.
    Law(Way),
}

/// Motion of the spool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spool {
    /// The spool does not turn.
    Locked,
    /// The limiter lets it turn.
    Yields,
    /// The spool winds up loose webbing.
    Winds,
}

/// Discrete state of the whole bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// Motion of the webbing at the D-ring.
    pub slide: Slide,
    /// Motion of the spool.
    pub spool: Spool,
    /// Part of the webbing law, such as slack or taut, that applies to the shoulder span.
    pub part: Part,
    /// `true` if the back of the seat still holds the torso against the pretension.
    pub seated: bool,
    /// `true` if the pulse acts.
    pub pulse: bool,
    /// `true` if the actuator's amplitude rises or falls.
    pub ramps: bool,
}

/// Bench, mode and ramp that together determine the motion until the next event.
#[derive(Clone, Copy, Debug)]
pub struct Phase<'a> {
    /// Constants of the bench.
    pub bench: &'a Bench,
    /// Present mode of the bench.
    pub mode: Mode,
    /// Present ramp of the actuator.
    pub ramp: Ramp,
}

impl Phase<'_> {
    /// Returns the tensions in a state, N.
    pub fn tensions(&self, state: &State) -> Tensions {
        Tensions {
            shoulder_n: self.bench.shoulder.tension_n(state.x_m - state.payout_m, self.mode.part),
            retractor_n: self.bench.retractor.tension_n(state.payout_m - state.spool_m, Part::Taut),
        }
    }

    /// Returns the energy stored in torso and webbing, J.
    pub fn stored_j(&self, state: &State) -> f64 {
        let bench = self.bench;
        0.5 * bench.torso_kg * state.v_m_per_s * state.v_m_per_s
            + bench.shoulder.stored_j(state.x_m - state.payout_m, self.mode.part)
            + bench.retractor.stored_j(state.payout_m - state.spool_m, Part::Taut)
    }

    /// Returns the friction ratio at which the tensions make the webbing slide in this direction.
    pub fn ratio(&self, state: &State, way: Way) -> f64 {
        let (high, low) = self.tensions(state).along(way);
        self.bench.capstan.ratio(high, low)
    }

    /// Returns the ratio at one end of the actuator's range.
    fn end(&self, end: End, time_s: f64) -> f64 {
        let effect = self.bench.actuator.effect(&self.bench.capstan, self.ramp.amplitude(time_s));
        if end == End::Floor { effect.floor } else { effect.full }
    }

    /// Returns the speed of sliding by the actuator's law at a ratio, m/s.
    fn speed(&self, state: &State, way: Way, ratio: f64, time_s: f64) -> f64 {
        let (high, low) = self.tensions(state).along(way);
        self.bench.actuator.speed(&self.bench.capstan, self.ramp.amplitude(time_s), ratio, (way, high, low))
    }

    /// Returns the speed of the payout, m/s.
    ///
    /// If friction is held at a ratio, `T_high = C T_low` at all times, with `C = exp(r mu theta)`.
    /// Its derivative with `Ts' = ks (v - p')`, `Tr' = kr (p' - s')`, and `s' = 0` or `Tr' = 0`,
    /// gives `p'`.
    fn payout_speed(&self, state: &State, time_s: f64) -> f64 {
        let (way, end) = match self.mode.slide {
            Slide::Stuck => return 0.0,
            Slide::Law(way) => return way.sign() * self.speed(state, way, self.ratio(state, way), time_s),
            Slide::Held(way, end) => (way, end),
        };
        let capstan = &self.bench.capstan;
        let ratio = self.end(end, time_s);
        let gain = capstan.gain(ratio);
        let ratio_rate = if self.mode.ramps { self.bench.actuator.slope(capstan) * self.ramp.rate_per_s } else { 0.0 };
        let gain_rate = gain * capstan.mu_high * capstan.wrap_rad * ratio_rate;
        let tensions = self.tensions(state);
        let ks = self.bench.shoulder.slope_n_per_m(self.mode.part);
        let kr = if self.mode.spool == Spool::Locked { self.bench.retractor.stiffness_n_per_m } else { 0.0 };
        let v = state.v_m_per_s;
        // If neither span stretches, the speed is undetermined: the webbing follows the torso.
        let solved = |above: f64, below: f64| if below > 0.0 { above / below } else { v };
        match way {
            Way::Out => solved(ks * v - gain_rate * tensions.retractor_n, ks + gain * kr),
            Way::Back => solved(gain * ks * v + gain_rate * tensions.shoulder_n, kr + gain * ks),
        }
    }

    /// Returns the time derivatives of the state.
    pub fn rates(&self, state: &State, time_s: f64) -> State {
        let bench = self.bench;
        let payout = self.payout_speed(state, time_s);
        let spool = if self.mode.spool == Spool::Locked { 0.0 } else { payout };
        let Tensions { shoulder_n, retractor_n } = self.tensions(state);
        let pulse = bench.pulse.at(time_s, self.mode.pulse);
        let rise = if self.mode.seated { 0.0 } else { pulse - shoulder_n / bench.torso_kg };
        State {
            x_m: state.v_m_per_s,
            v_m_per_s: rise,
            payout_m: payout,
            spool_m: spool,
            input_j: bench.torso_kg * pulse * state.v_m_per_s,
            friction_j: (shoulder_n - retractor_n) * payout,
            spool_j: retractor_n * spool,
        }
    }

    /// Returns the rate at which an error in the payout decays while the law applies, 1/s. Steps
    /// must be much shorter than its inverse.
    pub fn stiffness_per_s(&self, state: &State, time_s: f64) -> f64 {
        const RATIO_STEP: f64 = 1e-6;
        let Slide::Law(way) = self.mode.slide else { return 0.0 };
        let capstan = &self.bench.capstan;
        let ratio = self.ratio(state, way).clamp(0.0, 1.0 - RATIO_STEP);
        let speed = |ratio: f64| self.speed(state, way, ratio, time_s);
        let slope = (speed(ratio + 0.5 * RATIO_STEP) - speed((ratio - 0.5 * RATIO_STEP).max(0.0))) / RATIO_STEP;
        let tensions = self.tensions(state);
        let relative = self.bench.shoulder.slope_n_per_m(self.mode.part) / tensions.shoulder_n
            + self.bench.retractor.stiffness_n_per_m / tensions.retractor_n;
        slope * relative / (capstan.mu_high * capstan.wrap_rad)
    }

    /// Returns the events that can end this mode: the distance of each beyond its limit (negative
    /// before it), and the mode that follows.
    pub fn ends(&self, state: &State, time_s: f64) -> [(f64, Mode); 6] {
        let mode = self.mode;
        let never = (f64::NEG_INFINITY, mode);
        let bench = self.bench;
        let elongation = state.x_m - state.payout_m;
        let to_part = |part| Mode { part, ..mode };
        let (slack, loose) = (elongation - bench.shoulder.slack_m, -elongation);
        let parts = match mode.part {
            Part::Loose => [(elongation, to_part(Part::Slack)), never],
            Part::Slack => [(slack, to_part(Part::Taut)), (loose, to_part(Part::Loose))],
            Part::Taut => [(-slack, to_part(Part::Slack)), never],
        };
        let payout = self.payout_speed(state, time_s);
        let retractor_n = self.tensions(state).retractor_n;
        let to_spool = |spool| Mode { spool, ..mode };
        let spool = match mode.spool {
            Spool::Locked if retractor_n > bench.retractor.pretension_n => {
                (retractor_n - bench.limiter_n, to_spool(Spool::Yields))
            }
            Spool::Locked => (bench.retractor.pretension_n - retractor_n, to_spool(Spool::Winds)),
            Spool::Yields => (-payout, to_spool(Spool::Locked)),
            Spool::Winds => (payout, to_spool(Spool::Locked)),
        };
        let slides = self.slide_ends(state, time_s, payout);
        let off_n = bench.torso_kg * bench.pulse.at(time_s, mode.pulse) - self.tensions(state).shoulder_n;
        let seat = if mode.seated { (off_n, Mode { seated: false, ..mode }) } else { never };
        [seat, parts[0], parts[1], spool, slides[0], slides[1]]
    }

    fn slide_ends(&self, state: &State, time_s: f64, payout: f64) -> [(f64, Mode); 2] {
        let mode = self.mode;
        let to = |slide| Mode { slide, ..mode };
        let floor = || self.end(End::Floor, time_s);
        match mode.slide {
            Slide::Stuck => [Way::Out, Way::Back].map(|way| (self.ratio(state, way) - floor(), to(Slide::Held(way, End::Floor)))),
            Slide::Held(way, end) => {
                let speed = way.sign() * payout;
                let law = self.speed(state, way, self.end(end, time_s), time_s);
                // There is no law between the ends if they coincide.
                let leaves = match end {
                    _ if floor() == self.end(End::Full, time_s) => f64::NEG_INFINITY,
                    End::Floor => speed - law,
                    End::Full => law - speed,
                };
                [(-speed, to(Slide::Stuck)), (leaves, to(Slide::Law(way)))]
            }
            Slide::Law(way) => {
                let ratio = self.ratio(state, way);
                [
                    (floor() - ratio, to(Slide::Held(way, End::Floor))),
                    (ratio - self.end(End::Full, time_s), to(Slide::Held(way, End::Full))),
                ]
            }
        }
    }

    /// Returns the mode after the actuator has started, stopped or changed its range. Sliding
    /// continues if possible.
    pub fn reconsidered(&self, state: &State, time_s: f64) -> Mode {
        const RATIO_TOLERANCE: f64 = 1e-9;
        let (floor, full) = (self.end(End::Floor, time_s), self.end(End::Full, time_s));
        let between = |way: Way| {
            let ratio = self.ratio(state, way);
            floor < full && ratio > floor + RATIO_TOLERANCE
        };
        let slide = match self.mode.slide {
            Slide::Stuck if between(Way::Out) => Slide::Law(Way::Out),
            Slide::Stuck if between(Way::Back) => Slide::Law(Way::Back),
            Slide::Law(way) | Slide::Held(way, _) if between(way) => Slide::Law(way),
            // Friction that has increased holds the webbing until the tensions have followed.
            Slide::Law(way) | Slide::Held(way, _) if self.ratio(state, way) < floor - RATIO_TOLERANCE => Slide::Stuck,
            Slide::Law(way) => Slide::Held(way, End::Floor),
            same => same,
        };
        Mode { slide, ..self.mode }
    }
}
