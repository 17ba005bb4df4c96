//! Twin of a commissioned transducer: a scene with the identified transducer, the board's
//! converters and the proposed settings.

use firmware::board::command::Converters;

use super::modes::Mode;
use super::proposal::Proposal;
use crate::link_error::LinkError;
use crate::scale::Scale;
use report::rounded;
use scene::load::{Loaded, load_text};
use sim::advice::case::{Case, Wishes};
use sim::advice::{Advice, advise};

/// Minimum duration of the scene, s.
const MIN_DURATION_S: f64 = 0.2;
/// Minimum duration of the scene, ring-up time constants of the transducer.
const MIN_DURATION_TIME_CONSTANTS: f64 = 60.0;

/// Returns the scene as TOML.
pub fn toml(name: &str, proposal: &Proposal, others: &[Mode], scale: &Scale, converters: &Converters) -> String {
    let it = &proposal.transducer;
    let (drive_half, sense_half) = (u32::from(converters.drive_mid_code), u32::from(converters.sense_mid_code));
    // Conversions are summed to codes: the number of them that leaves a power of two.
    let oversample =
        (1..=8).find(|&n| sense_half % n == 0 && (sense_half / n).is_power_of_two() && sense_half / n <= 2048).unwrap_or(1);
    let bits = |half: u32| half.max(2).ilog2() + 1;
    let duration_s = MIN_DURATION_S.max(MIN_DURATION_TIME_CONSTANTS * f64::from(it.time_constant_s()));
    let modes: String = others
        .iter()
        .map(|mode| {
            let it = &mode.transducer;
            format!(
                "\n[[stack.mode]]\nseries_resonance_hz = {:?}\nq = {:?}\nlm_h = {:?}\n",
                rounded(it.series_resonance_hz.into(), 7),
                rounded(it.q.into(), 5),
                rounded(it.lm_h.into(), 5)
            )
        })
        .collect();
    format!(
        "title = {title:?}\nsource = \"identified by sim-host link commission\"\n\
         notes = [\"Converters and settings are those of the board. Noise, bandwidth and source resistance of the amplifier \
         are defaults of scenes, because a commissioning does not measure them.\"]\n\
         duration_s = {duration_s:.3}\n\n\
         [controller]\nblock_samples = {block}\n\n\
         [controller.drive]\nfrequency_hz = {hz:?}\namplitude_v = {volts:?}\n\n\
         [controller.tracking]\nmode = \"{mode}\"\nspan = {span:.4}\nnominal_q = {q:?}\nnominal_lm_h = {lm:?}\nnominal_c0_f = {c0:?}\n\n\
         [controller.limits]\nvoltage_v = {limit_v:?}\ncurrent_a = {limit_a:?}\n\n\
         [amplifier]\nfull_scale_v = {full_v:?}\n\n\
         [sensors]\nsample_hz = {sample_hz:?}\nadc_bits = {adc_bits}\ndac_bits = {dac_bits}\noversample = {oversample}\n\
         v_full_scale_v = {sense_v:?}\ni_full_scale_a = {sense_a:?}\n\n\
         [stack.bvd]\nseries_resonance_hz = {hz:?}\nq = {q:?}\nc0_f = {c0:?}\ncoupling = {coupling:?}\n{modes}",
        title = format!("Twin of {name}"),
        block = converters.block_samples,
        hz = rounded(it.series_resonance_hz.into(), 7),
        volts = proposal.volts,
        mode = if proposal.observer { "observer" } else { "phase_lock" },
        span = proposal.span,
        q = rounded(it.q.into(), 5),
        lm = rounded(it.lm_h.into(), 5),
        c0 = rounded(it.c0_f.into(), 5),
        coupling = rounded(it.coupling.into(), 5),
        limit_v = proposal.limits.0,
        limit_a = proposal.limits.1,
        full_v = scale.drive_volt_per_lsb * f64::from(drive_half),
        sample_hz = scale.sample_hz,
        adc_bits = bits(sense_half / oversample),
        dac_bits = bits(drive_half),
        sense_v = scale.volt_per_lsb * f64::from(sense_half),
        sense_a = scale.ampere_per_lsb * f64::from(sense_half),
    )
}

/// Loads the scene as `sim-host run` does.
pub fn load(name: &str, text: &str) -> Result<Loaded, LinkError> {
    load_text(name, text, &[]).map_err(|error| LinkError::Failed(format!("the twin is not a valid scene: {error}")))
}

/// Predicts the effect of the settings by runs of the twin.
pub fn rehearse(twin: &Loaded) -> Result<Advice, LinkError> {
    let block_samples = twin.scene.controller.as_ref().map(|controller| controller.block_samples);
    let failed = |error: &dyn std::fmt::Display| LinkError::Failed(format!("the twin cannot be rehearsed: {error}"));
    let case = Case::of(twin, None, &Wishes { block_samples, ..Wishes::default() }).map_err(|error| failed(&error))?;
    advise(&case).map(|(advice, _)| advice).map_err(|error| failed(&error))
}
