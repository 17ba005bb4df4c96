//! `sim-host spectrum`.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::json;

use super::progress::timed;
use super::{Color, DrawingArgs, Exit, Format, ReportArgs, print_styled};
use import::signal::spectrogram::{Asked, Method, Spectrogram};
use import::signal::{Choice, Signal};
use report::Report;
use sim::output::{Owner, npy};

/// Arguments of the command.
#[derive(Args)]
#[command(mut_arg("output", |arg| arg.help("Folder for report, figure, CSV and NPY. Default: `out/FILE-METHOD`")))]
pub(super) struct SpectrumArgs {
    /// Trace, link capture, or any table: CSV or other delimited text, NPY, NPZ, Parquet, WAV.
    file: PathBuf,
    /// Column to analyse, by its name or its number from 1. Default: the only one besides the
    /// times.
    #[arg(short, long, value_name = "NAME")]
    column: Option<String>,
    /// Method of the time-frequency analysis.
    #[arg(short, long, value_enum, default_value_t = Methods::Stft)]
    method: Methods,
    /// Column of times. Default: the first with such a name, as `time_s` or `t [ms]`. The name
    /// states the unit; without one, give it as `t [ms]`.
    #[arg(long, value_name = "NAME", conflicts_with = "sample_hz")]
    time: Option<String>,
    /// Sample rate of a file without times, Hz.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = sample_hz)]
    sample_hz: Option<f64>,
    /// Start of the analysed part, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    from_s: Option<f64>,
    /// End of the analysed part, s.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    to_s: Option<f64>,
    /// Frequencies to show, Hz.
    #[arg(long, value_name = "LOW:HIGH", value_parser = band)]
    band: Option<(f64, f64)>,
    /// Window length of the short-time transform, s. Default: chosen from the number of samples.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    window_s: Option<f64>,
    /// Cycles of a wavelet. Default: 0.95 (Morlet's wavelet with the angular centre frequency 6).
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    cycles: Option<f64>,
    /// Length of the time window of the Wigner-Ville distribution, s; 0 keeps the cross terms
    /// between components. Default: chosen from the number of samples.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    smooth_s: Option<f64>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    drawing: DrawingArgs,
}

fn sample_hz(text: &str) -> Result<f64, String> {
    columns::hertz(text).ok_or_else(|| "give a frequency in Hz, as 100k".to_owned())
}

#[derive(Clone, Copy, ValueEnum)]
enum Methods {
    /// Short-time Fourier transform: windows of equal length.
    Stft,
    /// Morlet wavelets: the same number of cycles at each frequency.
    Wavelet,
    /// Smoothed pseudo Wigner-Ville distribution: highest resolution, with cross terms between
    /// components.
    WignerVille,
}

impl Methods {
    fn method(self) -> Method {
        match self {
            Methods::Stft => Method::Stft,
            Methods::Wavelet => Method::Wavelet,
            Methods::WignerVille => Method::WignerVille,
        }
    }
}

/// Parses two frequencies, each in Hz or with the suffix `k` or `M`.
fn band(text: &str) -> Result<(f64, f64), String> {
    let ends = text.split_once(':').and_then(|(low, high)| columns::hertz(low).zip(columns::hertz(high)));
    ends.ok_or_else(|| "must be two frequencies in Hz, as 20e3:60e3 or 20k:60k".to_owned())
}

/// Reads a signal, computes its spectrum, and prints and writes the result.
pub(super) fn run(args: &SpectrumArgs, color: Color) -> anyhow::Result<Exit> {
    let choice = Choice {
        column: args.column.clone(),
        time: args.time.clone(),
        sample_hz: args.sample_hz,
        from_s: args.from_s,
        to_s: args.to_s,
    };
    let asked = Asked {
        method: args.method.method(),
        window_s: args.window_s,
        cycles: args.cycles,
        smooth_s: args.smooth_s,
        band_hz: args.band,
    };
    let (source, quiet) = (args.file.display().to_string(), args.report.result.quiet);
    let found = timed(format!("analysing {source}"), quiet, || -> anyhow::Result<_> {
        Ok(Spectrogram::new(Signal::read(&args.file, &choice)?, &asked)?)
    })?;
    let stem = args.file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let folder = args.report.open(&format!("{stem}-{}", found.method), Owner::new("spectrum", [&args.file]))?;
    if let Some(folder) = &folder {
        timed("writing the report".into(), quiet, || write(&found, &source, folder.unfinished(), args))?;
        folder.finish(json!({ "spectrum": found.json(&source), "complete": true }))?;
    }
    match args.report.result.format {
        Format::Human => print_styled(&found.table(&source).terminal(color.stdout))?,
        Format::Json => print_styled(&format!("{:#}\n", found.json(&source)))?,
    };
    if let Some(folder) = folder.filter(|_| !quiet) {
        say!("report: {}", folder.dir().join("report.html").display());
    }
    Ok(Exit::Done)
}

fn write(found: &Spectrogram, source: &str, dir: &Path, args: &SpectrumArgs) -> anyhow::Result<()> {
    let footer = super::provenance().footer();
    report::write_drawn(&Report { footer, ..found.report(source) }, dir, &args.drawing.drawing())?;
    let path = dir.join("summary.json");
    fs::write(&path, format!("{:#}\n", found.json(source))).with_context(|| format!("cannot write {}", path.display()))?;
    let power: Vec<f64> = found.power.iter().flatten().copied().collect();
    let shape = [found.times_s.len(), found.hz.len()];
    for (name, shape, values) in [
        ("power.npy", &shape[..], &power),
        ("time_s.npy", &shape[..1], &found.times_s),
        ("frequency_hz.npy", &shape[1..], &found.hz),
    ] {
        let path = dir.join(name);
        let written = File::create(&path).map(BufWriter::new).and_then(|mut file| {
            npy::write_array(shape, values, &mut file)?;
            file.flush()
        });
        written.with_context(|| format!("cannot write {}", path.display()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::band;

    #[test]
    fn a_band_is_two_frequencies() {
        assert_eq!(band("20k:0.06M"), Ok((20e3, 60e3)));
        assert_eq!(band("20e3:60e3"), Ok((20e3, 60e3)));
        for text in ["20k", ":", "a:b", "1:inf", "1:2:3"] {
            assert!(band(text).is_err(), "{text}");
        }
    }
}
