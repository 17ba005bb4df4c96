//! Numbers and verbal statements of the thesis on its second experiment, and the deviations of a
//! law.

use contact::empirical::{EmpiricalLaw, reached};
use report::{TableBlock, significant};

/// Loads of the experiment, N (3.2.3.2).
pub const LOADS_N: [f64; 3] = [270.0, 450.0, 670.0];
/// Amplitudes, relative to the full one (3.2.3.2).
pub const AMPLITUDES: [f64; 2] = [0.5, 0.7];
/// Full amplitude, m (3.2.2).
pub const FULL_M: f64 = 85e-6;
/// Speed of the belt, m/s (3.2.2).
pub const SPEED_M_PER_S: f64 = 0.025;
/// Fitted lag of the pull, s.
pub const LAG_S: f64 = 0.45;

/// A published number.
pub struct Point {
    /// Load on the belt, N.
    pub load_n: f64,
    /// Speed of the belt, m/s.
    pub speed_m_per_s: f64,
    /// Reduction of the friction, %.
    pub percent: f64,
    /// Source, and assumptions about conditions that it does not state.
    pub source: &'static str,
}

/// Published numbers, all taken as of 70 % and 2 s ON. The first two are from the thesis.
pub const POINTS: [Point; 4] = [
    Point {
        load_n: 270.0,
        speed_m_per_s: SPEED_M_PER_S,
        percent: 58.0,
        source: "thesis 3.2.3.1, 5.1: 2 s ON; 270 N and 70 % are inferred from \"up to\"",
    },
    Point { load_n: 670.0, speed_m_per_s: SPEED_M_PER_S, percent: 55.0, source: "thesis 5.2: 670 N; 70 % and 2 s are assumed" },
    Point {
        load_n: 270.0,
        speed_m_per_s: 0.0203,
        percent: 62.0,
        source: "NOT the thesis: JoVE 2015, 52931 (22 kHz, a pin on a disc, 1 to 4 MPa); only its ratio to the next row is used",
    },
    Point { load_n: 270.0, speed_m_per_s: 0.087, percent: 29.0, source: "NOT the thesis: JoVE 2015, 52931, as above" },
];

/// Fraction of the lasting reduction below which, at 1 s, the friction has not bottomed out.
const BOTTOMED_FRACTION: f64 = 0.95;
/// Maximum gain from 2 to 2.5 s, and minimum gain of 70 % over 50 % at 270 N, percentage points.
const SIGNIFICANT_POINTS: f64 = 1.0;
/// Maximum gain of 70 % over 50 % at 450 N, percentage points.
const INSIGNIFICANT_POINTS: f64 = 0.5;

/// A law with a lag.
pub struct Curve {
    /// Name of the law, in tables.
    pub name: String,
    /// Lasting relative reduction of the friction as a function of load, N, speed, m/s, and
    /// amplitude, relative to the full one.
    pub lasting: Box<dyn Fn(f64, f64, f64) -> f64>,
    /// Lag of the friction, s.
    pub lag_s: f64,
}

/// A statement of the thesis, compared with a law.
pub struct Statement {
    /// Statement with its section, and the criterion in numbers.
    pub says: &'static str,
    /// `true` if the law meets the statement.
    pub met: bool,
    /// Numbers computed from the law that the criterion is applied to.
    pub numbers: String,
}

impl Curve {
    /// Creates a curve from the law of a scene.
    pub fn of(name: &str, law: EmpiricalLaw, lag_s: f64) -> Self {
        Curve { name: name.into(), lasting: Box::new(move |load, speed, amplitude| law.lasting(load, speed, amplitude)), lag_s }
    }

    /// Returns the fitted law.
    pub fn fitted() -> Self {
        Self::of("as used", EmpiricalLaw::FITTED, LAG_S)
    }

    /// Returns the reduction at the thesis's speed, %.
    pub fn percent(&self, load_n: f64, amplitude: f64, on_s: f64) -> f64 {
        self.at_speed(load_n, SPEED_M_PER_S, amplitude, on_s)
    }

    /// Returns the reduction at a belt speed, %.
    pub fn at_speed(&self, load_n: f64, speed_m_per_s: f64, amplitude: f64, on_s: f64) -> f64 {
        100.0 * reached((self.lasting)(load_n, speed_m_per_s, amplitude), on_s, self.lag_s)
    }

    /// Returns the gain of 70 % over 50 % amplitude after 2 s, percentage points.
    pub fn gain(&self, load_n: f64) -> f64 {
        self.percent(load_n, AMPLITUDES[1], 2.0) - self.percent(load_n, AMPLITUDES[0], 2.0)
    }

    /// Returns `true` if the reduction falls monotonically from 270 to 670 N, also between the
    /// tested loads.
    pub fn falls_between(&self) -> bool {
        let falls = |amplitude: f64| {
            let at = |step: u32| self.percent(LOADS_N[0] + f64::from(step) * 5.0, amplitude, 2.0);
            (0..80).all(|step| at(step + 1) < at(step))
        };
        AMPLITUDES.into_iter().all(falls)
    }

    /// Returns `true` if ON times of 0.5 and 1 s are too short and 2 s is sufficient.
    pub fn bottoms_out(&self) -> bool {
        let at = |on_s: f64| self.percent(LOADS_N[0], AMPLITUDES[1], on_s);
        let lasting = 100.0 * (self.lasting)(LOADS_N[0], SPEED_M_PER_S, AMPLITUDES[1]);
        at(1.0) < BOTTOMED_FRACTION * lasting && at(2.5) - at(2.0) < SIGNIFICANT_POINTS
    }

    /// Compares the four verbal statements of the thesis with the law.
    pub fn statements(&self) -> [Statement; 4] {
        let at = |on_s: f64| self.percent(LOADS_N[0], AMPLITUDES[1], on_s);
        let over_load = |amplitude: f64| LOADS_N.map(|load| self.percent(load, amplitude, 2.0));
        let falls = |values: [f64; 3]| values.windows(2).all(|pair| pair[1] < pair[0]);
        let list = |values: &[f64]| values.iter().map(|&value| significant(value)).collect::<Vec<_>>().join(", ");
        let [half, more] = AMPLITUDES.map(over_load);
        [
            Statement {
                says: "3.2.3.1: 0.5 and 1 s do not bottom out (1 s: below 95 % of the lasting value); more than 2 s gains \
                       nothing (below one point)",
                met: self.bottoms_out(),
                numbers: format!("0.5, 1, 2, 2.5 s: {} %", list(&[0.5, 1.0, 2.0, 2.5].map(at))),
            },
            Statement {
                says: "3.2.3.2: the reduction falls with the load, at 50 % and at 70 %",
                met: falls(half) && falls(more),
                numbers: format!("270, 450, 670 N: at 50 % {} %, at 70 % {} %", list(&half), list(&more)),
            },
            Statement {
                says: "3.2.3.3: at 270 N, a larger reduction at 70 % than at 50 % (by at least one point)",
                met: self.gain(LOADS_N[0]) >= SIGNIFICANT_POINTS,
                numbers: format!("{} points", significant(self.gain(LOADS_N[0]))),
            },
            Statement {
                says: "3.2.3.3: at 450 N, no significant change from 50 % to 70 % (below half a point)",
                met: self.gain(LOADS_N[1]).abs() < INSIGNIFICANT_POINTS,
                numbers: format!("{} points", significant(self.gain(LOADS_N[1]))),
            },
        ]
    }
}

/// Returns the exponent of the amplitude that changes a reduction, %, by `points` between 50 % and
/// 70 %.
fn exponent_for(points: f64, percent: f64) -> f64 {
    (1.0 - points / percent).ln() / (AMPLITUDES[0] / AMPLITUDES[1]).ln()
}

/// Returns the smallest q that meets the statement about the amplitude at 270 N.
fn least_q() -> f64 {
    exponent_for(SIGNIFICANT_POINTS, POINTS[0].percent)
}

/// Returns the largest q at which the reduction still falls from 270 to 450 N at 50 %.
fn most_q(s: f64) -> f64 {
    let curve = Curve::fitted();
    let ratio = curve.percent(LOADS_N[0], AMPLITUDES[1], 2.0) / curve.percent(LOADS_N[1], AMPLITUDES[1], 2.0);
    ratio.ln() / ((1.0 - (LOADS_N[0] / LOADS_N[1]).powf(s)) * (AMPLITUDES[1] / AMPLITUDES[0]).ln())
}

/// Returns the smallest s that meets the statement about the amplitude at 450 N.
fn least_s(q: f64) -> f64 {
    let percent = Curve::fitted().percent(LOADS_N[1], AMPLITUDES[1], 2.0);
    (q / exponent_for(INSIGNIFICANT_POINTS, percent)).ln() / (LOADS_N[1] / LOADS_N[0]).ln()
}

/// Returns a table of the published numbers and statements and the values of a law.
pub fn residuals(law: EmpiricalLaw, lag_s: f64) -> TableBlock {
    let curve = Curve::of("", law, lag_s);
    let point = |point: &Point| {
        let got = curve.at_speed(point.load_n, point.speed_m_per_s, AMPLITUDES[1], 2.0);
        let says =
            format!("{} % at {} N, {} mm/s, 70 %, 2 s", point.percent, point.load_n, significant(1e3 * point.speed_m_per_s));
        vec![says, format!("{got:.2} %"), format!("{:+.2} points", got - point.percent), point.source.into()]
    };
    let statement = |statement: Statement| {
        let result = if statement.met { "met" } else { "not met" };
        vec![statement.says.into(), statement.numbers, result.into(), "thesis, verbal".into()]
    };
    let rows = POINTS.iter().map(point).chain(curve.statements().into_iter().map(statement)).collect();
    let caption = "Closed form: the law with its lag. The thesis gives only two numbers and these four statements about the law.";
    TableBlock::new(
        "law-residuals",
        "Empirical law and published results",
        caption,
        &["published", "law", "residual", "source"],
        rows,
    )
}

/// Returns a table of the law's formula and constants.
pub fn constants(law: EmpiricalLaw, lag_s: f64) -> TableBlock {
    let row = |name: &str, value: String, from: &str| vec![name.into(), value, from.into()];
    let rows = vec![
        row("R0", format!("{}", law.reduction), "FITTED: 58 % after 2 s with this lag"),
        row("W0", format!("{} N", law.load_n), "reference"),
        row("a0", format!("{} of {} um", law.amplitude_fraction, 1e6 * FULL_M), "reference"),
        row("v0", format!("{} mm/s", significant(1e3 * law.speed_m_per_s)), "reference"),
        row("p", format!("{}", law.load_exponent), "FITTED: 55 % at 670 N"),
        row(
            "q",
            format!("{}", law.amplitude_exponent),
            &format!(
                "CHOSEN: at least {} for the statement at 270 N, at most {} for those over the load",
                significant(least_q()),
                significant(most_q(law.amplitude_load_exponent))
            ),
        ),
        row(
            "s",
            format!("{}", law.amplitude_load_exponent),
            &format!("CHOSEN: with this q, at least {} for the statement at 450 N", significant(least_s(law.amplitude_exponent))),
        ),
        row(
            "vs",
            format!("{} mm/s", significant(1e3 * law.speed_scale_m_per_s)),
            "NOT the thesis: JoVE 2015, 52931; has no effect at v0",
        ),
        row("lowest a", format!("{}", law.lowest_amplitude_fraction), "proportional to a below it: ASSUMED, not tested"),
        row("lag", format!("{lag_s} s"), "FITTED to verbal statements"),
    ];
    let caption =
        "R = R0 g(v) (W/W0)^-p (a/a0)^(q min(1, (W0/W)^s)) (1 - exp(-t/lag)), g = (1 + v0/vs)/(1 + v/vs); pull = mu W (1 - R).";
    TableBlock::new("law-constants", "Empirical law of the belt: FITTED", caption, &["constant", "value", "source"], rows)
}
