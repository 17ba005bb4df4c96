//! Files of measured data: delimited text, Touchstone, NPY, Parquet and WAV. Each is read as an
//! admittance, as a friction log and as a signal.
//!
//! Some tables are intact and have drawn units. The values must be converted by a known unit, and
//! an unknown unit must be refused by its name: no unit is replaced by a default.

use std::path::Path;
use std::time::{Duration, Instant};

use hal_mock::chance::Chance;
use import::admittance::measured::Measured;
use import::admittance::options::Options as AdmittanceOptions;
use import::friction::{Log, Options};
use import::signal::{Choice, Columns, Signal};
use import::synthetic::{Example, mutated};

use super::corpus;
use super::target::{Tally, Target};
use super::text::kind;

pub(super) const TARGET: Target = Target {
    name: "tables",
    what: "files of measured data, as admittance, friction log and signal",
    seeds_per_million: 60,
    feed,
    corpus: |tally| corpus::TABLES.iter().try_for_each(|(name, bytes)| read_all(name, bytes, tally)),
};

/// Number of tables with drawn units of each seed.
const UNIT_TABLES: usize = 4;
/// Number of examples from which damaged files are made.
const EXAMPLES: u64 = 400;
/// Maximum time of reading one file.
const MAX_READ: Duration = Duration::from_secs(10);
/// Units of time, displacement, force, frequency and impedance, with their factors to the SI units.
const UNITS: [&[(&str, f64)]; 5] = [
    &[("s", 1.0), ("sec", 1.0), ("ms", 1e-3), ("msec", 1e-3), ("µs", 1e-6), ("usec", 1e-6), ("min", 60.0), ("hours", 3600.0)],
    &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("micron", 1e-6), ("in", 0.0254), ("nm", 1e-9)],
    &[("N", 1.0), ("mN", 1e-3), ("uN", 1e-6), ("kgf", 9.80665), ("lbf", 4.448_221_615)],
    &[("Hz", 1.0), ("kHz", 1e3)],
    &[("ohm", 1.0), ("kΩ", 1e3), ("kOhms", 1e3)],
];
/// Units that are unknown, ambiguous or of other quantities.
const FOREIGN: [&str; 8] = ["qs", "furlong", "dyn", "V", "mT", "msecs2", "degC", "arb"];
/// Ways of writing a heading with a unit.
const HEADINGS: [fn(&str, &str) -> String; 4] = [
    |name, unit| format!("{name} [{unit}]"),
    |name, unit| format!("{name} ({unit})"),
    |name, unit| format!("\"{name} [{unit}]\""),
    |name, unit| format!("{name}/{unit}"),
];
/// Number of rows of a table.
const ROWS: u32 = 80;

fn feed(seed: u64, tally: &mut Tally) -> Result<(), String> {
    let mut chance = Chance::new(seed);
    let (name, bytes) = file(&mut chance);
    let mut damaged = mutated(&bytes, seed);
    for _ in 0..chance.below(4) {
        if let Some(byte) = damaged.get_mut(chance.below(bytes.len() as u64) as usize) {
            *byte ^= 1 << chance.below(8);
        }
    }
    read_all(&name, &damaged, tally)?;
    (0..UNIT_TABLES).try_for_each(|_| units(&mut chance, tally))
}

/// Draws an intact file, with its name.
fn file(chance: &mut Chance) -> (String, Vec<u8>) {
    let numbers = |chance: &mut Chance, count: u64| (0..count).map(|_| chance.byte()).collect::<Vec<u8>>();
    match chance.below(8) {
        0 => {
            let shape = [1_u64, 40, 1 << 20, 1 << 40][chance.below(4) as usize];
            let kind = ["<f8", ">f4", "|u1", "<i2", "|S4", "<c16"][chance.below(6) as usize];
            let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}, 2), }}\n");
            let length = (header.len() as u16).to_le_bytes();
            ("a.npy".into(), [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), &numbers(chance, 1280)].concat())
        }
        1 => {
            let (channels, bits) = (1 + chance.below(3) as u16, [8_u16, 16, 24, 32][chance.below(4) as usize]);
            let format = [&16_u32.to_le_bytes()[..], &1_u16.to_le_bytes(), &channels.to_le_bytes(), &48_000_u32.to_le_bytes()];
            let rates = [&192_000_u32.to_le_bytes()[..], &(channels * bits / 8).to_le_bytes(), &bits.to_le_bytes()];
            let data = numbers(chance, 2400);
            let sizes = [(data.len() as u32 + 36).to_le_bytes(), (data.len() as u32).to_le_bytes()];
            let parts = [b"RIFF", &sizes[0][..], b"WAVEfmt ", &format.concat(), &rates.concat(), b"data", &sizes[1], &data];
            ("a.wav".into(), parts.concat())
        }
        2 => (corpus::TABLES[0].0.into(), corpus::TABLES[0].1.to_vec()),
        3 => ("log.csv".into(), table(chance, &["t [s]", "x [mm]", "F [N]"].map(str::to_owned)).0),
        _ => {
            let example = Example::draw(chance.below(EXAMPLES));
            (example.name, example.bytes)
        }
    }
}

/// Returns a table with these headings, and the numbers of its second row.
fn table(chance: &mut Chance, headings: &[String]) -> (Vec<u8>, Vec<f64>) {
    let (sign, comma) = [(",", false), (";", false), (";", true), ("\t", false), ("\t", true)][chance.below(5) as usize];
    let first = |column: usize| 1.5 + 2.25 * column as f64;
    let number = |row: u32, column: usize| first(column) + 0.125 * f64::from(row) * (1.0 + column as f64);
    let mut text = ["", "# a comment\n", "Device: 1\n\n"][chance.below(3) as usize].to_owned() + &headings.join(sign) + "\n";
    for row in 0..ROWS {
        let cells: Vec<String> = (0..headings.len()).map(|column| format!("{:.4}", number(row, column))).collect();
        let line = cells.join(if comma { "|" } else { sign });
        text += &(if comma { line.replace('.', ",").replace('|', sign) } else { line } + "\n");
    }
    let bytes = match chance.below(4) {
        0 => [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect(),
        1 => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        _ => text.into_bytes(),
    };
    (bytes, (0..headings.len()).map(|column| number(1, column)).collect())
}

/// Reads a file in every way, within the time.
fn read_all(name: &str, bytes: &[u8], tally: &mut Tally) -> Result<(), String> {
    tally.input(bytes.len());
    let path = Path::new(name);
    let began = Instant::now();
    let admittance = Measured::parse(name, bytes, &AdmittanceOptions::default());
    let log = Log::parse(bytes, &Options { normal_n: Some(1.0), ..Options::default() });
    let signal = Columns::parse(path, bytes).and_then(|columns| {
        Signal::from_columns(path, &columns, &Choice { column: Some("1".into()), sample_hz: Some(1.0), ..Choice::default() })
    });
    let took = began.elapsed();
    if took > MAX_READ {
        return Err(format!("{name} took {} s", took.as_secs_f64()));
    }
    let ends = [
        ("admittance", admittance.err().map(|error| error.to_string())),
        ("log", log.err().map(|error| error.to_string())),
        ("signal", signal.err().map(|error| error.to_string())),
    ];
    for (reader, error) in ends {
        match error {
            None => tally.outcome(reader),
            Some(error) if error.trim().is_empty() => return Err(format!("{name}: refused without a reason")),
            Some(error) => tally.outcome(&kind(&error)),
        }
    }
    Ok(())
}

/// Reads an intact table with drawn units.
fn units(chance: &mut Chance, tally: &mut Tally) -> Result<(), String> {
    let is_log = chance.strikes(0.5);
    let (names, kinds) = if is_log { (["t", "x", "F"], [0, 1, 2]) } else { (["f", "R", "X"], [3, 4, 4]) };
    let heading = HEADINGS[chance.below(4) as usize];
    let drawn = kinds.map(|kind| match chance.strikes(0.1) {
        true => (FOREIGN[chance.below(FOREIGN.len() as u64) as usize], None),
        false => {
            let (unit, factor) = UNITS[kind][chance.below(UNITS[kind].len() as u64) as usize];
            (unit, Some(factor))
        }
    });
    let headings: Vec<String> = names.iter().zip(drawn).map(|(name, (unit, _))| heading(name, unit)).collect();
    let (bytes, second) = table(chance, &headings);
    tally.input(bytes.len());
    let read = if is_log {
        let log = Log::parse(&bytes, &Options { normal_n: Some(1.0), ..Options::default() });
        log.map(|log| [log.time_s[1], log.slip_m[1], log.force_n[1]])
    } else {
        let measured = Measured::parse("sweep.csv", &bytes, &AdmittanceOptions::default());
        measured.map(|sweep| (sweep.hz[1], sweep.admittance[1].inv())).map(|(hz, z)| [hz, z.re, z.im])
    };
    let factors = drawn.map(|(_, factor)| factor);
    match (read, factors) {
        (Ok(read), [Some(first), Some(middle), Some(last)]) => {
            // A table has displacements, and a log has steps of a displacement.
            let size = if is_log { 0.125 * 2.0 } else { second[1] };
            let truth = [second[0] * first, size * middle, second[2] * last];
            let is_equal = |(read, truth): (&f64, &f64)| (read - truth).abs() <= 1e-3 * truth.abs();
            match read.iter().zip(&truth).all(is_equal) {
                true => tally.outcome("converted"),
                false => return Err(format!("{headings:?}: {read:?} instead of {truth:?}")),
            }
        }
        (Err(error), factors) if factors.contains(&None) => tally.outcome(&kind(&error.to_string())),
        (Err(error), _) => return Err(format!("{headings:?} is refused: {error}")),
        (Ok(_), _) => return Err(format!("an unknown unit of {headings:?} is replaced by a default")),
    }
    Ok(())
}
