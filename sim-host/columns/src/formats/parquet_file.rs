//! Parquet files with columns of numbers.

use parquet::column::reader::ColumnReader;
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::table;
use crate::table::{Column, Table};

/// Largest number of values that are read: 2 GiB in memory.
const MAX_VALUES: u64 = 1 << 28;
/// Number of rows to reserve memory for, as the stated number may be wrong.
const ROWS_PER_READ: usize = 1 << 16;

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
    let names = (0..schema.num_columns()).map(|place| schema.column(place).name().to_owned()).collect();
    let mut columns = Vec::new();
    for place in 0..schema.num_columns() {
        let optional = schema.column(place).max_def_level() > 0;
        let mut values: Vec<f64> = Vec::new();
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group)?;
            let rows = group.metadata().num_rows().max(0) as usize;
            let read = match group.get_column_reader(place)? {
                ColumnReader::DoubleColumnReader(reader) => Some(column(reader, rows, optional, |value| value)?),
                ColumnReader::FloatColumnReader(reader) => Some(column(reader, rows, optional, f64::from)?),
                ColumnReader::Int32ColumnReader(reader) => Some(column(reader, rows, optional, f64::from)?),
                ColumnReader::Int64ColumnReader(reader) => Some(column(reader, rows, optional, |value| value as f64)?),
                _ => None,
            };
            match read {
                Some(read) => values.extend(read),
                None => values.extend(std::iter::repeat_n(f64::NAN, rows)),
            }
        }
        let words = (0..values.len()).filter(|&row| values[row].is_nan()).map(|row| (row, "not a number".to_owned())).collect();
        columns.push(Column { values, words });
    }
    Ok(table(Some(names), columns, "Parquet"))
}

/// Reads the values of a column in one group of rows; an absent value is NaN.
fn column<T: DataType>(
    mut reader: parquet::column::reader::ColumnReaderImpl<T>,
    rows: usize,
    optional: bool,
    number: impl Fn(T::T) -> f64,
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
