//! WAV files: one column per channel, and the times of the samples.

use super::table;
use crate::table::{Column, Table};

/// Reads the channels of a file; full scale is 1.
pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let wrong = |error: hound::Error| format!("a WAV file that cannot be read: {error}");
    let mut reader = hound::WavReader::new(bytes).map_err(wrong)?;
    let spec = reader.spec();
    let samples: Vec<f64> = match spec.sample_format {
        hound::SampleFormat::Float => reader.samples::<f32>().map(|sample| sample.map(f64::from)).collect::<Result<_, _>>(),
        hound::SampleFormat::Int => {
            let scale = 0.5_f64.powi(i32::from(spec.bits_per_sample) - 1);
            reader.samples::<i32>().map(|sample| sample.map(|sample| scale * f64::from(sample))).collect()
        }
    }
    .map_err(wrong)?;
    let channels = usize::from(spec.channels.max(1));
    let column = |values: Vec<f64>| Column { values, words: Vec::new() };
    let times = (0..samples.len() / channels).map(|row| row as f64 / f64::from(spec.sample_rate.max(1))).collect();
    let of = |channel: usize| column(samples.iter().skip(channel).step_by(channels).copied().collect());
    let names = std::iter::once("time_s".to_owned()).chain((1..=channels).map(|channel| format!("channel {channel}")));
    Ok(table(Some(names.collect()), std::iter::once(column(times)).chain((0..channels).map(of)).collect(), "WAV"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_scaled_and_have_times() {
        let spec =
            hound::WavSpec { channels: 2, sample_rate: 1000, bits_per_sample: 16, sample_format: hound::SampleFormat::Int };
        let mut bytes = std::io::Cursor::new(Vec::new());
        let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
        [16384i16, -32768, 0, 8192].into_iter().for_each(|sample| writer.write_sample(sample).unwrap());
        writer.finalize().unwrap();
        let columns = read(bytes.get_ref()).unwrap().columns;
        let values: Vec<&[f64]> = columns.iter().map(|column| column.values.as_slice()).collect();
        assert_eq!(values, [&[0.0, 1e-3][..], &[0.5, 0.0], &[-1.0, 0.25]]);
        assert!(read(&bytes.get_ref()[..20]).is_err());
    }
}
