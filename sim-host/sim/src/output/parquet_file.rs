//! Common parts of the Parquet files: row groups of [`GROUP`] rows, compressed by zstd, whose bytes
//! depend on the rows only.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, Encoding, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{DataType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

/// Number of rows of a row group.
pub(super) const GROUP: usize = 65_536;
/// Compression level.
const LEVEL: i32 = 3;

/// Returns the properties of a file, with the program's name instead of the library's version.
pub(super) fn builder() -> Result<WriterPropertiesBuilder, ParquetError> {
    Ok(WriterProperties::builder()
        .set_created_by(format!("sim-host {}", crate::VERSION))
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(LEVEL)?))
        .set_statistics_enabled(EnabledStatistics::Chunk))
}

/// Writes rows of numbers under these names.
pub(super) fn write_table(columns: &[String], rows: &[Vec<f64>], path: &Path) -> io::Result<()> {
    let write = || -> Result<(), ParquetError> {
        let field = |name: &String| {
            Type::primitive_type_builder(name, Physical::DOUBLE).with_repetition(Repetition::REQUIRED).build().map(Arc::new)
        };
        let fields = columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
        let schema = Type::group_type_builder("trace").with_fields(fields).build()?;
        // Samples hardly repeat, but their bytes do when sorted by significance.
        let properties = builder()?.set_dictionary_enabled(false).set_encoding(Encoding::BYTE_STREAM_SPLIT).build();
        let mut file = SerializedFileWriter::new(File::create(path)?, Arc::new(schema), Arc::new(properties))?;
        for rows in rows.chunks(GROUP) {
            let mut group = file.next_row_group()?;
            for place in 0..columns.len() {
                let values: Vec<f64> = rows.iter().map(|row| row[place]).collect();
                whole::<DoubleType>(&mut group, &values)?;
            }
            group.close()?;
        }
        file.close().map(drop)
    };
    write().map_err(io_error)
}

/// Writes the next column, with a value in each row.
pub(super) fn whole<T: DataType>(group: &mut SerializedRowGroupWriter<File>, values: &[T::T]) -> Result<(), ParquetError> {
    column::<T>(group, values, None)
}

/// Writes the next column. If some rows lack a value, `levels` has an entry for each row.
pub(super) fn column<T: DataType>(
    group: &mut SerializedRowGroupWriter<File>,
    values: &[T::T],
    levels: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column = group.next_column()?.ok_or_else(|| ParquetError::General("one column too many".to_owned()))?;
    column.typed::<T>().write_batch(values, levels, None)?;
    column.close()
}

/// Returns the error of the system, if there is one.
pub(super) fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(io) => *io,
            Err(inner) => io::Error::other(inner),
        },
        error => io::Error::other(error),
    }
}
