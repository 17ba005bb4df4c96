//! Parquet files with columns of numbers.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use parquet::column::reader::ColumnReader;
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use super::table;
use crate::table::{Column, Table};

/// Largest number of values that are read: 2 GiB in memory.
const MAX_VALUES: u64 = 1 << 28;
/// Number of rows to reserve memory for, as the stated number may be wrong.
const ROWS_PER_READ: usize = 1 << 16;

/// Meaning of the whole numbers of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meaning {
    /// Numbers with a sign.
    Signed,
    /// Numbers without a sign.
    Unsigned,
    /// Decimal numbers: this many units are one.
    Decimal(f64),
    /// Times: this many units are a second. They are counted from the first one, because the time
    /// since 1970 has more digits than a floating-point number.
    Time { per_s: f64 },
    /// No quantity, such as a date.
    Unknown,
}

impl Meaning {
    /// Returns the meaning of a column, which older files state by a converted type.
    fn new(column: &ColumnDescriptor) -> Self {
        let per_s = |unit: &TimeUnit| match unit {
            TimeUnit::MILLIS => 1e3,
            TimeUnit::MICROS => 1e6,
            TimeUnit::NANOS => 1e9,
        };
        match (column.logical_type_ref(), column.converted_type()) {
            (Some(LogicalType::Timestamp(time)), _) => Meaning::Time { per_s: per_s(&time.unit) },
            (Some(LogicalType::Time(time)), _) => Meaning::Time { per_s: per_s(&time.unit) },
            (Some(LogicalType::Integer(integer)), _) if !integer.is_signed => Meaning::Unsigned,
            (Some(LogicalType::Integer(_)), _) => Meaning::Signed,
            (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => Meaning::Time { per_s: 1e3 },
            (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => Meaning::Time { per_s: 1e6 },
            (Some(LogicalType::Decimal(_)), _) | (_, ConvertedType::DECIMAL) => Meaning::Decimal(10f64.powi(column.type_scale())),
            (_, ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 | ConvertedType::UINT_64) => {
                Meaning::Unsigned
            }
            (None, _) => Meaning::Signed,
            (Some(_), _) => Meaning::Unknown,
        }
    }

    /// Converts a number of the column; `origin` is the first time.
    fn number(self, value: i64, origin: &mut Option<i64>) -> f64 {
        match self {
            Meaning::Signed | Meaning::Unknown => value as f64,
            Meaning::Unsigned => value as u64 as f64,
            Meaning::Decimal(units) => value as f64 / units,
            Meaning::Time { per_s } => value.wrapping_sub(*origin.get_or_insert(value)) as f64 / per_s,
        }
    }
}

/// Reads all columns of a file into memory.
pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    columns(bytes.to_vec()).map_err(|error| format!("a Parquet file that cannot be read: {error}"))
}

fn columns(bytes: Vec<u8>) -> Result<Table, ParquetError> {
    let file = SerializedFileReader::new(bytes::Bytes::from(bytes))?;
    let schema = file.metadata().file_metadata().schema_descr_ptr();
    let rows = (0..file.num_row_groups()).map(|group| file.metadata().row_group(group).num_rows().max(0).unsigned_abs());
    let values = rows.fold(0, u64::saturating_add).saturating_mul(schema.num_columns() as u64);
    if values > MAX_VALUES {
        return Err(ParquetError::General(format!(
            "it has {values} values, but at most {MAX_VALUES} are read; save fewer rows or columns"
        )));
    }
    let meanings: Vec<Meaning> = (0..schema.num_columns()).map(|place| Meaning::new(&schema.column(place))).collect();
    let named = |(place, meaning): (usize, &Meaning)| match meaning {
        Meaning::Time { .. } => format!("{} [s]", schema.column(place).name()),
        _ => schema.column(place).name().to_owned(),
    };
    let names = meanings.iter().enumerate().map(named).collect();
    let mut columns = Vec::new();
    for (place, meaning) in meanings.iter().enumerate() {
        let optional = schema.column(place).max_def_level() > 0;
        let mut values: Vec<f64> = Vec::new();
        let mut origin = None;
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group)?;
            let rows = group.metadata().num_rows().max(0) as usize;
            let read = match group.get_column_reader(place)? {
                ColumnReader::DoubleColumnReader(reader) => Some(column(reader, rows, optional, |value| value)?),
                ColumnReader::FloatColumnReader(reader) => Some(column(reader, rows, optional, f64::from)?),
                _ if *meaning == Meaning::Unknown => None,
                ColumnReader::Int32ColumnReader(reader) => {
                    // An unsigned number has the bits of a signed one.
                    let wide = |value: i32| if *meaning == Meaning::Unsigned { i64::from(value as u32) } else { value.into() };
                    Some(column(reader, rows, optional, |value| meaning.number(wide(value), &mut origin))?)
                }
                ColumnReader::Int64ColumnReader(reader) => {
                    Some(column(reader, rows, optional, |value| meaning.number(value, &mut origin))?)
                }
                _ => None,
            };
            match read {
                Some(read) => values.extend(read),
                None => values.extend(std::iter::repeat_n(f64::NAN, rows)),
            }
        }
        let text = || match schema.column(place).logical_type_ref() {
            Some(LogicalType::Decimal(_)) => "a decimal number stored as bytes; save it as float64".to_owned(),
            Some(kind) => format!("of the type {}", format!("{kind:?}").split('(').next().unwrap_or_default()),
            None => format!("of the type {}", schema.column(place).physical_type()),
        };
        let is_number = values.iter().any(|value| !value.is_nan());
        let word = |row: usize| (row, if is_number { String::new() } else { text() });
        let words = (0..values.len()).filter(|&row| values[row].is_nan()).map(word).collect();
        columns.push(Column { values, words });
    }
    Ok(table(Some(names), columns, "Parquet"))
}

/// Reads the values of a column in one group of rows; an absent value is NaN.
fn column<T: DataType>(
    mut reader: parquet::column::reader::ColumnReaderImpl<T>,
    rows: usize,
    optional: bool,
    number: impl FnMut(T::T) -> f64,
) -> Result<Vec<f64>, ParquetError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let mut done = 0;
    while done < rows {
        let read = reader.read_records((rows - done).min(ROWS_PER_READ), optional.then_some(&mut levels), None, &mut values)?.0;
        if read == 0 {
            break;
        }
        done += read;
    }
    let mut values = values.into_iter().map(number);
    if !optional {
        return Ok(values.collect());
    }
    Ok(levels.into_iter().map(|level| if level > 0 { values.next().unwrap_or(f64::NAN) } else { f64::NAN }).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::data_type::{Int32Type, Int64Type};
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;

    /// Writes a time, a decimal number, an unsigned number and a date.
    fn file() -> Vec<u8> {
        let schema = "message m { REQUIRED INT64 t (TIMESTAMP(MICROS,true)); REQUIRED INT32 r (DECIMAL(9,2)); REQUIRED INT32 n \
                      (INTEGER(32,false)); REQUIRED INT32 d (DATE); }";
        let mut bytes = Vec::new();
        let mut writer =
            SerializedFileWriter::new(&mut bytes, Arc::new(parse_message_type(schema).unwrap()), Arc::default()).unwrap();
        let mut group = writer.next_row_group().unwrap();
        let mut column = group.next_column().unwrap().unwrap();
        column.typed::<Int64Type>().write_batch(&[1_700_000_000_000_000, 1_700_000_000_000_025], None, None).unwrap();
        column.close().unwrap();
        for values in [[2370, -5], [-1, 7], [19_000, 19_001]] {
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<Int32Type>().write_batch(&values, None, None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
        writer.close().unwrap();
        bytes
    }

    #[test]
    fn whole_numbers_have_the_meaning_of_their_type() {
        let table = read(&file()).unwrap();
        assert_eq!(table.headings(), ["t [s]", "r", "n", "d"]);
        assert_eq!(table.columns[0].values, [0.0, 25e-6]);
        assert_eq!(table.columns[1].values, [23.7, -0.05]);
        assert_eq!(table.columns[2].values, [f64::from(u32::MAX), 7.0]);
        assert!(table.columns[3].numbers().unwrap_err().what.contains("Date"));
    }
}
