//! What webbing, D-ring and spool are doing, how everything moves meanwhile, and what ends it.

use super::Bench;
use super::span::Part;
use super::state::{Ramp, State, Tensions, Way};

/// At which end of what the actuator allows the friction is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The lowest friction: webbing slides no faster than the actuator can follow.
    Floor,
    /// The highest friction: webbing slides at least as fast as the actuator can follow.
    Full,
}

/// What webbing does at the D-ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slide {
    /// The webbing does not slide.
    Stuck,
    /// The webbing slides with the friction at one end, at any speed on the right side of that of the law.
    Held(Way, End),
    /// The webbing slides at the speed that the law gives.
    Law(Way),
}

/// What the spool does.
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
    /// The part of its law that the shoulder span is in.
    pub part: Part,
    /// Whether the back of the seat still holds the torso against the pretension.
    pub seated: bool,
    /// Whether the pulse acts.
    pub pulse: bool,
    /// Whether the actuator's amplitude rises or falls.
    pub ramps: bool,
}

/// A bench in a mode, under a ramp.
#[derive(Clone, Copy, Debug)]
pub struct Phase<'a> {
    /// Constants of the bench.
    pub bench: &'a Bench,
    /// What it is doing.
    pub mode: Mode,
    /// What the actuator is doing.
    pub ramp: Ramp,
}

impl Phase<'_> {
    /// Tensions in a state, N.
    pub fn tensions(&self, state: &State) -> Tensions {
        Tensions {
            shoulder_n: self.bench.shoulder.tension_n(state.x_m - state.payout_m, self.mode.part),
            retractor_n: self.bench.retractor.tension_n(state.payout_m - state.spool_m, Part::Taut),
        }
    }

    /// What is stored in torso and webbing, J.
    pub fn stored_j(&self, state: &State) -> f64 {
        let bench = self.bench;
        0.5 * bench.torso_kg * state.v_m_per_s * state.v_m_per_s
            + bench.shoulder.stored_j(state.x_m - state.payout_m, self.mode.part)
            + bench.retractor.stored_j(state.payout_m - state.spool_m, Part::Taut)
    }

    /// The ratio of friction that the tensions need for webbing to slide this way.
    pub fn ratio(&self, state: &State, way: Way) -> f64 {
        let (high, low) = self.tensions(state).along(way);
        self.bench.capstan.ratio(high, low)
    }

    /// The ratio at one end of what the actuator allows.
    fn end(&self, end: End, time_s: f64) -> f64 {
        let effect = self.bench.actuator.effect(&self.bench.capstan, self.ramp.amplitude(time_s));
        if end == End::Floor { effect.floor } else { effect.full }
    }

    /// Speed of sliding by the actuator's law at a ratio, m/s.
    fn speed(&self, state: &State, way: Way, ratio: f64, time_s: f64) -> f64 {
        let (high, low) = self.tensions(state).along(way);
        self.bench.actuator.speed(&self.bench.capstan, self.ramp.amplitude(time_s), ratio, (way, high, low))
    }

    /// Speed of the payout, m/s.
    ///
    /// Where friction is held at a ratio, `T_high = C T_low` at all times, with `C = exp(r mu theta)`. Its derivative with
    /// `Ts' = ks (v - p')`, `Tr' = kr (p' - s')`, and `s' = 0` or `Tr' = 0`, gives `p'`.
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
        // Where neither span gives, nothing says how fast webbing goes: it follows the torso.
        let solved = |above: f64, below: f64| if below > 0.0 { above / below } else { v };
        match way {
            Way::Out => solved(ks * v - gain_rate * tensions.retractor_n, ks + gain * kr),
            Way::Back => solved(gain * ks * v + gain_rate * tensions.shoulder_n, kr + gain * ks),
        }
    }

    /// How everything changes, per second.
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

    /// How fast an error in the payout dies out where the law rules, 1/s: steps must be short beside its inverse.
    pub fn stiffness_per_s(&self, state: &State, time_s: f64) -> f64 {
        const NUDGE: f64 = 1e-6;
        let Slide::Law(way) = self.mode.slide else { return 0.0 };
        let capstan = &self.bench.capstan;
        let ratio = self.ratio(state, way).clamp(0.0, 1.0 - NUDGE);
        let speed = |ratio: f64| self.speed(state, way, ratio, time_s);
        let slope = (speed(ratio + 0.5 * NUDGE) - speed((ratio - 0.5 * NUDGE).max(0.0))) / NUDGE;
        let tensions = self.tensions(state);
        let relative = self.bench.shoulder.slope_n_per_m(self.mode.part) / tensions.shoulder_n
            + self.bench.retractor.stiffness_n_per_m / tensions.retractor_n;
        slope * relative / (capstan.mu_high * capstan.wrap_rad)
    }

    /// What can end this mode: how far beyond its end each is (less than zero before), and the mode that follows.
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
                // Nothing rules where both ends are one.
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

    /// The mode after the actuator has begun, ended or changed its reach: sliding stays sliding where it can.
    pub fn reconsidered(&self, state: &State, time_s: f64) -> Mode {
        const SAME: f64 = 1e-9;
        let (floor, full) = (self.end(End::Floor, time_s), self.end(End::Full, time_s));
        let between = |way: Way| {
            let ratio = self.ratio(state, way);
            floor < full && ratio > floor + SAME
        };
        let slide = match self.mode.slide {
            Slide::Stuck if between(Way::Out) => Slide::Law(Way::Out),
            Slide::Stuck if between(Way::Back) => Slide::Law(Way::Back),
            Slide::Law(way) | Slide::Held(way, _) if between(way) => Slide::Law(way),
            // Friction that is higher than it was holds webbing until the tensions have followed.
            Slide::Law(way) | Slide::Held(way, _) if self.ratio(state, way) < floor - SAME => Slide::Stuck,
            Slide::Law(way) => Slide::Held(way, End::Floor),
            same => same,
        };
        Mode { slide, ..self.mode }
    }
}
