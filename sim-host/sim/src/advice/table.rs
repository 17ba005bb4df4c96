//! Tables of an advice.

use super::Advice;
use super::prediction::LockTime;
use super::transducer::Full;
use super::verification::MeasuredLockTime;
use report::TableBlock;

fn block(title: &str, header: &[&str], rows: Vec<Vec<String>>, caption: &str) -> TableBlock {
    TableBlock {
        title: title.into(),
        header: header.iter().map(|&cell| cell.into()).collect(),
        rows,
        caption: caption.into(),
        ..TableBlock::default()
    }
}

fn ms(value: Option<f64>) -> String {
    value.map_or_else(|| "not in time".into(), |ms| format!("{ms:.3}"))
}

fn row(name: &str, value: String, note: &str) -> Vec<String> {
    vec![name.into(), value, note.into()]
}

/// Returns all tables, in order.
pub fn tables(advice: &Advice) -> Vec<TableBlock> {
    let mut tables = vec![transducer(&advice.transducer), blocks(advice), drive(advice), lock(advice), steady(advice)];
    tables.extend(verified(advice));
    tables
}

/// Returns the table of the circuit.
pub(super) fn transducer(it: &Full) -> TableBlock {
    let zero_phase = match it.zero_phase_bias_hz {
        Some(hz) => row("V-I zero phase", format!("{hz:+.1} Hz"), "M > 2: a plain V-I loop would settle this far off resonance"),
        None => row("V-I zero phase", "none".into(), "M <= 2: a plain V-I loop has no lock point"),
    };
    let rows = vec![
        row("series resonance fs", format!("{:.2} Hz", it.series_resonance_hz), ""),
        row("parallel resonance fp", format!("{:.2} Hz", it.parallel_resonance_hz), ""),
        row("Q", format!("{:.2}", it.q), ""),
        row("Rm", format!("{:.4} ohm", it.rm_ohm), ""),
        row("Lm", format!("{:.5} mH", 1e3 * it.lm_h), ""),
        row("Cm", format!("{:.4} nF", 1e9 * it.cm_f), ""),
        row("C0", format!("{:.4} nF", 1e9 * it.c0_f), ""),
        row("coupling k", format!("{:.4}", it.coupling), "k^2 = Cm / (C0 + Cm)"),
        row("figure of merit M", format!("{:.2}", it.figure_of_merit), "1 / (omega C0 Rm)"),
        row("time constant", format!("{:.3} ms", it.time_constant_ms), "of the ring-up, Q / (pi fs)"),
        zero_phase,
    ];
    block("Transducer", &["", "value", ""], rows, "")
}

fn blocks(advice: &Advice) -> TableBlock {
    let of = |block: &super::settings::BlockTime| {
        let advised = if block.samples == advice.settings.block_samples { "advised" } else { "" };
        let samples = format!("{}", block.samples);
        let times = [block.lock_4hz_median_ms, block.lock_4hz_p95_ms].map(ms);
        let [median, p95] = times;
        vec![samples, format!("{:.2}", block.periods), median, p95, advised.into()]
    };
    let caption = "A shorter block decides sooner but costs more instructions per sample. Fewer than 0.6 periods do not \
                   determine its phasor.";
    let header = ["block [samples]", "periods", "to 4 Hz, median [ms]", "95 % [ms]", ""];
    block("Length of a block", &header, advice.settings.blocks.iter().map(of).collect(), caption)
}

fn drive(advice: &Advice) -> TableBlock {
    let it = &advice.settings.drive;
    let rows = vec![
        row("advised voltage", format!("{:.3} V peak", it.advised_v), &format!("requested: {} V", it.asked_v)),
        row(
            "largest voltage",
            format!("{:.3} V peak", it.largest_v),
            &format!("in calibration, scan and lock, limited by {}", it.bounded_by),
        ),
        row("current at the resonance", format!("{:.3} A peak", it.current_a), ""),
        row("current in the ADC", format!("{:.0} LSB", it.current_lsb), &format!("of {:.0}", it.full_scale_lsb)),
        row("voltage in the ADC", format!("{:.0} LSB", it.voltage_lsb), &format!("of {:.0}", it.full_scale_lsb)),
        row(
            "noise of a block's current",
            format!("{:.3} mA rms", 1e3 * it.block_noise_a),
            &format!("{:.0} ppm of the current", it.block_noise_ppm),
        ),
    ];
    block("Drive and converters", &["", "value", ""], rows, "")
}

fn lock(advice: &Advice) -> TableBlock {
    let of = |time: &LockTime| {
        let times = [time.median_ms, time.bound_median_ms, time.p95_ms, time.bound_p95_ms].map(ms);
        std::iter::once(format!("{:.0}", time.within_hz)).chain(times).collect()
    };
    let caption = format!(
        "Rehearsal of {} cold starts of the firmware's tracker on the linear model, with errors of the nominal values up to 2 % \
         (resonance), a factor of 2 (Q) and 10 % (Lm). The first block is silent. Bound: Cramer-Rao, from the first sample of \
         the drive, with a delay of two blocks from measurement to playback.",
        advice.prediction.draws
    );
    let header = ["to within [Hz]", "median [ms]", "bound [ms]", "95 % [ms]", "bound [ms]"];
    block("Predicted lock time", &header, advice.prediction.lock.iter().map(of).collect(), &caption)
}

fn steady(advice: &Advice) -> TableBlock {
    let it = &advice.prediction;
    let hz = |value: f64| format!("{value:.3} Hz");
    let line = |name: String, value: String, bound: String, note: &str| vec![name, value, bound, note.into()];
    let bandwidth = it.bandwidth_hz.map_or_else(|| "below 10 Hz".into(), |hz| format!("{hz:.0} Hz"));
    let stated = format!("stated by the observer: {:.3} Hz", it.jitter_stated_hz);
    let mut rows = vec![
        line("steady jitter".into(), hz(it.jitter_hz), hz(it.jitter_bound_hz), &stated),
        line("bandwidth".into(), bandwidth, String::new(), "-3 dB, from true resonance to drive"),
    ];
    for ramp in &it.ramps {
        let rate = ramp.hz_per_s / 1e3;
        let constant = ramp.bound_constant_hz.map_or_else(|| "-".into(), hz);
        rows.push(line(
            format!("lag at {rate} kHz/s"),
            hz(ramp.lag_hz),
            hz(ramp.bound_slope_hz),
            "bound: jitter of a fit with a slope",
        ));
        let note = "bound: lag and jitter of a fit without a slope";
        rows.push(line("lag without rate integrator".into(), hz(ramp.lag_without_rate_hz), constant, note));
    }
    rows.push(line(
        "lock point per % of C0".into(),
        format!("{:+.4} Hz", it.bias_hz_per_percent_c0),
        String::new(),
        "C0 above its calibration",
    ));
    rows.push(line(
        "lock point per ns of skew".into(),
        format!("{:+.4} Hz", it.bias_hz_per_ns_skew),
        String::new(),
        "current sampled later",
    ));
    let loss = it.loss_noticed_ms.map_or_else(|| "not within 1 s".into(), |ms| format!("{ms:.2} ms"));
    rows.push(line("loss detected after".into(), loss, String::new(), "from the end of the vibration"));
    block("Predicted steady state", &["", "predicted", "bound", ""], rows, "")
}

fn verified(advice: &Advice) -> Option<TableBlock> {
    let it = advice.verified.as_ref()?;
    let predicted = &advice.prediction;
    let of = |(time, found): (&LockTime, &MeasuredLockTime)| {
        let name = |what: &str| format!("to {:.0} Hz, {what} [ms]", time.within_hz);
        [vec![name("median"), ms(time.median_ms), ms(found.median_ms)], vec![name("95 %"), ms(time.p95_ms), ms(found.p95_ms)]]
    };
    let mut rows: Vec<Vec<String>> = predicted.lock.iter().zip(&it.lock).flat_map(of).collect();
    let found = |value: Option<f64>| value.map_or_else(|| "-".into(), |hz| format!("{hz:.3}"));
    rows.push(vec!["steady jitter [Hz]".into(), format!("{:.3}", predicted.jitter_hz), found(it.jitter_hz)]);
    rows.push(vec!["bias, 95 % [Hz]".into(), String::new(), found(it.bias_p95_hz)]);
    let caption = format!(
        "Of {} runs, {} locked, {} ended in a fault and {} reported a false lock.",
        it.runs, it.locked, it.faulted, it.false_locks
    );
    Some(block("Prediction and whole controller", &["", "predicted", "simulated"], rows, &caption))
}
