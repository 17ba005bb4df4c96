//! `sim-host advise`.

use clap::Args;

use super::progress::Progress;
use super::{Color, DEFAULT_SCENE, Exit, Format, mistake, visible};
use scene::circuit::Given;
use scene::load::load;
use sim::advice::case::{Case, CaseError, Numbers, Wishes};
use sim::advice::verification::verify;
use sim::advice::{Advice, AdviceError, advise, advise_amplifier, table as tables};

/// Arguments of the command.
#[derive(Args)]
pub(super) struct AdviseArgs {
    /// Scene with stack, sensors, amplifier and limits (default: lock-cold). If a transducer is
    /// given by its numbers, they replace the stack.
    scene: Option<String>,
    /// Change one value of the scene, as `a.b=v` (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Series resonance frequency, Hz.
    #[arg(long, value_name = "HZ", value_parser = frequency)]
    frequency_hz: Option<f64>,
    /// Quality factor.
    #[arg(long, value_name = "Q", value_parser = quality)]
    q: Option<f64>,
    /// Clamped capacitance, F.
    ///
    /// Needs also --q or --rm-ohm, and two of --frequency-hz, --parallel-resonance-hz, --lm-h, and
    /// --cm-f or --coupling; or both --q and --rm-ohm, and one of these.
    #[arg(long, value_name = "F", value_parser = farad)]
    c0_f: Option<f64>,
    /// Capacitance far below the resonance, F; instead of --c0-f.
    #[arg(long, value_name = "F", value_parser = farad, conflicts_with = "c0_f")]
    ct_f: Option<f64>,
    /// Motional inductance, H.
    #[arg(long, value_name = "H", value_parser = henry)]
    lm_h: Option<f64>,
    /// Parallel resonance frequency, Hz.
    #[arg(long, value_name = "HZ", value_parser = frequency)]
    parallel_resonance_hz: Option<f64>,
    /// Motional resistance, ohm.
    #[arg(long, value_name = "OHM", value_parser = ohm)]
    rm_ohm: Option<f64>,
    /// Motional capacitance, F.
    #[arg(long, value_name = "F", value_parser = motional)]
    cm_f: Option<f64>,
    /// Effective coupling factor k.
    #[arg(long, value_name = "K", value_parser = coupling)]
    coupling: Option<f64>,
    /// Peak drive voltage, V. Default: that of the scene.
    #[arg(long, value_name = "V", value_parser = volts)]
    volts: Option<f64>,
    /// Noise of a conversion, LSB rms. Default: that of the scene.
    #[arg(long, value_name = "LSB", value_parser = lsb)]
    noise_lsb: Option<f64>,
    /// Samples per block. Default: as recommended.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(8..=64))]
    block_samples: Option<u16>,
    /// Print the demand on the amplifier for a tip amplitude, instead of settings for the
    /// controller.
    #[arg(long, conflicts_with = "verify")]
    amplifier: bool,
    /// Peak tip velocity, m/s, with --amplifier. Default: that of the drive voltage.
    #[arg(long, value_name = "M_PER_S", value_parser = tip, requires = "amplifier")]
    tip_m_per_s: Option<f64>,
    /// Peak tip displacement, m, with --amplifier; instead of --tip-m-per-s.
    #[arg(long, value_name = "M", value_parser = tip, requires = "amplifier", conflicts_with = "tip_m_per_s")]
    tip_m: Option<f64>,
    /// Run the whole controller RUNS times and print the results next to the prediction.
    #[arg(long, value_name = "RUNS", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    verify: Option<u32>,
    /// Format of standard output.
    #[arg(long, value_enum, default_value_t = Format::Human)]
    format: Format,
}

/// Key of the force factor, which no electrical measurement finds.
const FORCE_FACTOR: &str = "stack.bvd.force_factor_n_per_v";
/// Description of a complete set of numbers.
const COMPLETE: &str = "in addition to --c0-f or --ct-f give --q or --rm-ohm, and two of --frequency-hz, \
                        --parallel-resonance-hz, --lm-h, and --cm-f or --coupling; or both --q and --rm-ohm, and one of these";

impl AdviseArgs {
    /// Returns the numbers of the transducer.
    fn given(&self) -> Given {
        Given {
            c0_f: self.c0_f,
            ct_f: self.ct_f,
            cm_f: self.cm_f,
            lm_h: self.lm_h,
            rm_ohm: self.rm_ohm,
            series_resonance_hz: self.frequency_hz,
            parallel_resonance_hz: self.parallel_resonance_hz,
            q: self.q,
            coupling: self.coupling,
        }
    }
}

/// Computes and prints the advice.
pub(super) fn run(args: &AdviseArgs, color: Color) -> anyhow::Result<Exit> {
    let given = args.given();
    if args.scene.is_none() && given == Given::default() {
        let which = "no transducer: name a scene (`sim-host list`) or give its numbers: \
                     --frequency-hz 40e3 --q 65 --c0-f 300e-9 --lm-h 0.79e-3";
        return Err(mistake(Exit::Usage, which));
    }
    let loaded = load(args.scene.as_deref().unwrap_or(DEFAULT_SCENE), &args.sets)?;
    let circuit = (given != Given::default()).then(|| given.resolve()).transpose();
    let circuit = circuit.map_err(|error| mistake(Exit::Usage, format!("{error}; {COMPLETE}")))?;
    let numbers = circuit.map(|circuit| Numbers {
        // Given numbers are used directly, without rounding by a conversion to circuit elements.
        frequency_hz: given.series_resonance_hz.unwrap_or_else(|| circuit.series_resonance_hz()),
        q: given.q.unwrap_or_else(|| circuit.q()),
        c0_f: circuit.c0_f,
        lm_h: given.lm_h.unwrap_or(circuit.lm_h),
    });
    let wishes = Wishes { volts: args.volts, noise_lsb: args.noise_lsb, block_samples: args.block_samples };
    let named = |error| match error {
        AdviceError::Case(CaseError::Scene(error)) => anyhow::Error::from(error),
        error => error.into(),
    };
    let case = Case::of(&loaded, numbers, &wishes).map_err(AdviceError::from).map_err(named)?;
    if args.amplifier {
        // The scene's force factor is that of another transducer.
        let is_built_in = scene::builtin::text(&loaded.origin).is_some();
        let of_other = numbers.is_some() && is_built_in && !args.sets.iter().any(|set| set.starts_with(FORCE_FACTOR));
        let assumed = of_other || loaded.assumed.iter().any(|assumed| assumed.key == FORCE_FACTOR);
        let omega = case.parts().map_or(f64::NAN, |parts| parts.circuit.omega());
        let tip_m_per_s = args.tip_m_per_s.or(args.tip_m.map(|tip_m| omega * tip_m));
        let advice = advise_amplifier(&case, tip_m_per_s, assumed)?;
        return match args.format {
            Format::Human => {
                super::print_styled(&advice.tables().iter().map(|block| block.terminal(color.stdout)).collect::<String>())
            }
            Format::Json => super::print_styled(&format!("{:#}\n", serde_json::to_value(&advice)?)),
        };
    }
    let (mut advice, advised) = advise(&case).map_err(named)?;
    if let Some(runs) = args.verify {
        let mut progress = Progress::new(0.0, runs, false);
        advice.verified = Some(verify(&advised, runs, &mut |reached| progress.at(reached))?);
    }
    match args.format {
        Format::Human => super::print_styled(&human(&advice, color)),
        Format::Json => super::print_styled(&format!("{:#}\n", serde_json::to_value(&advice)?)),
    }
}

fn human(advice: &Advice, color: Color) -> String {
    let tables: String = tables::tables(advice).iter().map(|block| block.terminal(color.stdout)).collect();
    let warnings: String = advice.warnings.iter().map(|warning| format!("note: {warning}\n")).collect();
    format!("{tables}{}\nSettings to paste into a scene:\n\n{}", visible(&warnings), visible(&advice.settings.snippet))
}

/// Parses a number within a range. The error states the quantity and the range.
fn within(text: &str, what: &str, range: (f64, f64)) -> Result<f64, String> {
    inside(text.parse().ok(), what, range)
}

fn inside(value: Option<f64>, what: &str, (least, most): (f64, f64)) -> Result<f64, String> {
    let value = value.ok_or_else(|| format!("not a number; give {what} from {least:e} to {most:e}"))?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("give {what} from {least:e} to {most:e}")) }
}

fn frequency(text: &str) -> Result<f64, String> {
    inside(columns::hertz(text), "a resonance in Hz, as 40k,", (100.0, 450e3))
}

fn quality(text: &str) -> Result<f64, String> {
    within(text, "a quality factor", (2.0, 1e5))
}

fn farad(text: &str) -> Result<f64, String> {
    within(text, "a clamped capacitance in farads, as 300e-9,", (1e-12, 1e-3))
}

fn henry(text: &str) -> Result<f64, String> {
    within(text, "a motional inductance in henries, as 0.8e-3,", (1e-9, 1e4))
}

fn ohm(text: &str) -> Result<f64, String> {
    within(text, "a motional resistance in ohm", (1e-6, 1e7))
}

fn motional(text: &str) -> Result<f64, String> {
    within(text, "a motional capacitance in farads, as 600e-12,", (1e-16, 1e-3))
}

fn coupling(text: &str) -> Result<f64, String> {
    within(text, "an effective coupling", (1e-4, 0.99))
}

fn volts(text: &str) -> Result<f64, String> {
    within(text, "a peak voltage in volts", (1e-3, 1e4))
}

fn tip(text: &str) -> Result<f64, String> {
    within(text, "a peak amplitude of the tip", (1e-12, 1e3))
}

fn lsb(text: &str) -> Result<f64, String> {
    within(text, "noise in LSB rms", (0.0, 100.0))
}
