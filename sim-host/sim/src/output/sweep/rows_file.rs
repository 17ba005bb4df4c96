//! Rows as Parquet: one row per point, in row groups of [`GROUP`] rows, compressed by zstd.
//!
//! | column | type |
//! |---|---|
//! | `point` | 64-bit whole number |
//! | each key | number |
//! | each metric | number, or null |
//! | `drive_hash` | text, or null |
//! | `fault_code` | 32-bit whole number, or null |
//! | `failure` | text, or null; only in a part |
//!
//! The bytes depend on the rows only: there are no times, and the program's name replaces the
//! library's version.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{ConvertedType, Encoding, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::get_typed_column_reader;
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{ChunkReader, FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::{FolderError, Part};
use crate::output::folder::{checksum, rename_synced};
use crate::output::parquet_file::{GROUP, builder, column, io_error, whole};
use crate::study::sweep::{Rows, unit};

/// Name of the column with the reason that a point of a part has no result.
const FAILURE: &str = "failure";

/// Columns of a file in addition to those of every file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Names of the keys.
    pub keys: Vec<String>,
    /// Names of the metrics.
    pub metrics: Vec<String>,
}

/// Writer of a file of rows, under a temporary name until the file is complete.
pub(super) struct RowsWriter {
    path: PathBuf,
    unfinished: PathBuf,
    writer: Option<SerializedFileWriter<File>>,
    layout: Layout,
    part: bool,
}

impl RowsWriter {
    /// Begins a file; that of a `part` also contains the reasons of failures.
    pub(super) fn create(path: &Path, layout: &Layout, hash: &str, part: bool) -> Result<Self, FolderError> {
        let unfinished = super::unfinished(path);
        let begin = || -> Result<SerializedFileWriter<File>, ParquetError> {
            let file = File::create(&unfinished)?;
            SerializedFileWriter::new(file, Arc::new(schema(layout, part)?), Arc::new(properties(layout, hash)?))
        };
        let writer = begin().map_err(written(path))?;
        Ok(RowsWriter { path: path.to_owned(), unfinished, writer: Some(writer), layout: layout.clone(), part })
    }

    /// Writes rows as separate row groups, each of at most [`GROUP`] rows.
    pub(super) fn write(&mut self, rows: &Rows) -> Result<(), FolderError> {
        let (layout, part) = (self.layout.clone(), self.part);
        let Some(writer) = &mut self.writer else { return Ok(()) };
        for from in (0..rows.points.len()).step_by(GROUP) {
            let to = rows.points.len().min(from + GROUP);
            let mut group = || -> Result<(), ParquetError> {
                let mut group = writer.next_row_group()?;
                write_group(&mut group, rows, from..to, &layout, part)?;
                group.close().map(drop)
            };
            group().map_err(written(&self.path))?;
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), FolderError> {
        self.writer.take().map_or(Ok(()), |writer| writer.close().map(drop).map_err(written(&self.path)))
    }

    /// Ends the file and renames it.
    pub(super) fn finish(mut self) -> Result<(), FolderError> {
        self.close()?;
        rename_synced(&self.unfinished, &self.path).map_err(super::write(&self.path))
    }

    /// Ends the file of a part and renames it to the part with its checksum.
    pub(super) fn finish_part(mut self, sealed: impl FnOnce(String) -> Part) -> Result<Part, FolderError> {
        self.close()?;
        let part = sealed(File::open(&self.unfinished).and_then(checksum).map_err(super::write(&self.path))?);
        self.path.clone_from(&part.path);
        self.finish().map(|()| part)
    }
}

impl Drop for RowsWriter {
    fn drop(&mut self) {
        // A finished file no longer has the temporary name.
        let _ = fs::remove_file(&self.unfinished);
    }
}

fn schema(layout: &Layout, part: bool) -> Result<Type, ParquetError> {
    let column = |name: &str, physical: Physical, repetition: Repetition| {
        let text = physical == Physical::BYTE_ARRAY;
        let column = Type::primitive_type_builder(name, physical).with_repetition(repetition);
        let column = if text {
            column.with_logical_type(Some(LogicalType::String)).with_converted_type(ConvertedType::UTF8)
        } else {
            column
        };
        column.build().map(Arc::new)
    };
    let mut columns = vec![column("point", Physical::INT64, Repetition::REQUIRED)?];
    for key in &layout.keys {
        columns.push(column(key, Physical::DOUBLE, Repetition::REQUIRED)?);
    }
    for metric in &layout.metrics {
        columns.push(column(metric, Physical::DOUBLE, Repetition::OPTIONAL)?);
    }
    columns.push(column("drive_hash", Physical::BYTE_ARRAY, Repetition::OPTIONAL)?);
    columns.push(column("fault_code", Physical::INT32, Repetition::OPTIONAL)?);
    if part {
        columns.push(column(FAILURE, Physical::BYTE_ARRAY, Repetition::OPTIONAL)?);
    }
    Type::group_type_builder("sweep").with_fields(columns).build()
}

fn properties(layout: &Layout, hash: &str) -> Result<WriterProperties, ParquetError> {
    let units = layout.keys.iter().chain(&layout.metrics).map(|name| (name.clone(), unit(name).into()));
    let units: serde_json::Map<String, serde_json::Value> = units.collect();
    let entry = |name: &str, value: String| KeyValue::new(format!("sonoglide.{name}"), value);
    let entries = vec![entry("plan_hash", hash.to_owned()), entry("units", serde_json::Value::from(units).to_string())];
    let mut properties = builder()?.set_key_value_metadata(Some(entries));
    // Values of a metric hardly repeat, but their bytes do when sorted by significance.
    for metric in &layout.metrics {
        let column = ColumnPath::new(vec![metric.clone()]);
        properties = properties
            .set_column_dictionary_enabled(column.clone(), false)
            .set_column_encoding(column, Encoding::BYTE_STREAM_SPLIT);
    }
    Ok(properties.build())
}

fn write_group(
    group: &mut SerializedRowGroupWriter<File>,
    rows: &Rows,
    range: std::ops::Range<usize>,
    layout: &Layout,
    part: bool,
) -> Result<(), ParquetError> {
    whole::<Int64Type>(group, &rows.points[range.clone()])?;
    for key in &rows.keys[..layout.keys.len()] {
        whole::<DoubleType>(group, &key[range.clone()])?;
    }
    for metric in &rows.metrics[..layout.metrics.len()] {
        some::<DoubleType, f64>(group, &metric[range.clone()], |value| *value)?;
    }
    let text = |text: &String| ByteArray::from(text.as_str());
    some::<ByteArrayType, String>(group, &rows.drive_hashes[range.clone()], text)?;
    some::<Int32Type, i32>(group, &rows.fault_codes[range.clone()], |code| *code)?;
    if part {
        some::<ByteArrayType, String>(group, &rows.failures[range], text)?;
    }
    Ok(())
}

/// Writes the next column, with a value in some rows.
fn some<T: DataType, V>(
    group: &mut SerializedRowGroupWriter<File>,
    values: &[Option<V>],
    as_stored: impl Fn(&V) -> T::T,
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let stored: Vec<T::T> = values.iter().flatten().map(as_stored).collect();
    column::<T>(group, &stored, Some(&levels))
}

/// File of rows.
pub struct RowsFile {
    path: PathBuf,
    reader: Box<dyn FileReader>,
}

impl RowsFile {
    /// Opens a complete file.
    pub fn open(path: &Path) -> Result<Self, FolderError> {
        Self::new(path, File::open(path).map_err(super::read(path))?)
    }

    /// Reads a complete file from its content; the path is for messages.
    pub(super) fn new(path: &Path, content: impl ChunkReader + 'static) -> Result<Self, FolderError> {
        let reader = Box::new(SerializedFileReader::new(content).map_err(read(path))?);
        Ok(RowsFile { path: path.to_owned(), reader })
    }

    /// Returns the number of rows.
    pub fn count(&self) -> u64 {
        self.reader.metadata().file_metadata().num_rows().max(0) as u64
    }

    /// Returns the hash of the plan of its rows.
    pub fn plan_hash(&self) -> Option<String> {
        let entries = self.reader.metadata().file_metadata().key_value_metadata()?;
        entries.iter().find(|entry| entry.key == "sonoglide.plan_hash")?.value.clone()
    }

    /// Returns the number of row groups.
    pub fn groups(&self) -> usize {
        self.reader.metadata().num_row_groups()
    }

    /// Reads the rows of a group. The columns are those of a part.
    pub fn rows(&self, group: usize, layout: &Layout) -> Result<Rows, FolderError> {
        let read = || -> Result<Rows, ParquetError> {
            let group = self.reader.get_row_group(group)?;
            let mut rows = Rows::new(layout.keys.len(), layout.metrics.len());
            let mut place = 0..;
            let mut next = || place.next().unwrap_or_default();
            rows.points = each::<Int64Type>(&*group, next())?;
            for key in &mut rows.keys {
                *key = each::<DoubleType>(&*group, next())?;
            }
            for metric in &mut rows.metrics {
                *metric = options::<DoubleType>(&*group, next())?;
            }
            rows.drive_hashes = texts(&*group, next())?;
            rows.fault_codes = options::<Int32Type>(&*group, next())?;
            rows.failures = texts(&*group, next())?;
            Ok(rows)
        };
        read().map_err(self::read(&self.path))
    }

    /// Returns the number of values in a column that are not null.
    pub fn present(&self, name: &str) -> u64 {
        let Some(place) = self.place(name) else { return 0 };
        let groups = self.reader.metadata().row_groups().iter();
        let count = groups.map(|group| {
            let column = group.column(place);
            let nulls = column.statistics().and_then(|statistics| statistics.null_count_opt()).unwrap_or(0);
            column.num_values().max(0) as u64 - nulls
        });
        count.sum()
    }

    /// Reads a complete column of numbers.
    pub fn column(&self, name: &str) -> Result<Vec<Option<f64>>, FolderError> {
        let Some(place) = self.place(name) else { return Ok(vec![None; self.count() as usize]) };
        let read = || -> Result<Vec<Option<f64>>, ParquetError> {
            let mut values = Vec::with_capacity(self.count() as usize);
            for group in 0..self.groups() {
                values.extend(options::<DoubleType>(&*self.reader.get_row_group(group)?, place)?);
            }
            Ok(values)
        };
        read().map_err(self::read(&self.path))
    }

    fn place(&self, name: &str) -> Option<usize> {
        let columns = self.reader.metadata().file_metadata().schema_descr();
        (0..columns.num_columns()).find(|&place| columns.column(place).name() == name)
    }
}

/// Reads a column with a value in each row.
fn each<T: DataType>(group: &dyn RowGroupReader, place: usize) -> Result<Vec<T::T>, ParquetError> {
    let mut values = Vec::new();
    let rows = group.metadata().num_rows().max(0) as usize;
    let mut reader = get_typed_column_reader::<T>(group.get_column_reader(place)?);
    while values.len() < rows && reader.read_records(rows - values.len(), None, None, &mut values)?.0 > 0 {}
    Ok(values)
}

/// Reads a column with a value in some rows, or in all.
fn options<T: DataType>(group: &dyn RowGroupReader, place: usize) -> Result<Vec<Option<T::T>>, ParquetError> {
    if group.metadata().column(place).column_descr().max_def_level() == 0 {
        return Ok(each::<T>(group, place)?.into_iter().map(Some).collect());
    }
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let rows = group.metadata().num_rows().max(0) as usize;
    let mut reader = get_typed_column_reader::<T>(group.get_column_reader(place)?);
    while levels.len() < rows && reader.read_records(rows - levels.len(), Some(&mut levels), None, &mut values)?.0 > 0 {}
    let mut values = values.into_iter();
    Ok(levels.iter().map(|&level| if level == 0 { None } else { values.next() }).collect())
}

fn texts(group: &dyn RowGroupReader, place: usize) -> Result<Vec<Option<String>>, ParquetError> {
    let bytes = options::<ByteArrayType>(group, place)?;
    Ok(bytes.into_iter().map(|bytes| bytes.map(|bytes| String::from_utf8_lossy(bytes.data()).into_owned())).collect())
}

fn written(path: &Path) -> impl FnOnce(ParquetError) -> FolderError + use<> {
    let path = path.to_owned();
    move |error| FolderError::Write { path, io: io_error(error) }
}

fn read(path: &Path) -> impl FnOnce(ParquetError) -> FolderError + use<> {
    let path = path.to_owned();
    move |error| FolderError::Read { path, why: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize) -> Rows {
        let some = |n: usize| (!n.is_multiple_of(3)).then_some(n);
        Rows {
            points: (0..count as i64).collect(),
            keys: vec![(0..count).map(|n| 0.1 * n as f64).collect()],
            metrics: vec![(0..count).map(|n| some(n).map(|n| (n as f64).sqrt())).collect(), vec![None; count]],
            drive_hashes: (0..count).map(|n| some(n).map(|n| format!("{n:016x}"))).collect(),
            fault_codes: (0..count).map(|n| some(n).map(|n| n as i32)).collect(),
            failures: (0..count).map(|n| some(n + 1).map(|n| format!("not of {n}"))).collect(),
        }
    }

    /// With more than one row group, the rows read equal those written, and the bytes are
    /// reproducible.
    #[test]
    fn rows_round_trip_with_reproducible_bytes() {
        let dir = std::env::temp_dir().join(format!("rows-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("a folder");
        let layout = Layout { keys: vec!["contact.dahl.mu".into()], metrics: vec!["friction_ratio".into(), "reversals".into()] };
        let rows = rows(GROUP + 1000);
        let write = |name: &str| {
            let path = dir.join(name);
            let mut writer = RowsWriter::create(&path, &layout, "abc", true).expect("a file");
            writer.write(&rows).expect("rows");
            assert!(!path.exists(), "a file is renamed only when it is complete");
            writer.finish().expect("an end");
            path
        };
        let (first, second) = (write("a.parquet"), write("b.parquet"));
        assert_eq!(fs::read(&first).expect("bytes"), fs::read(&second).expect("bytes"));
        let file = RowsFile::open(&first).expect("a file");
        assert_eq!((file.groups(), file.count(), file.plan_hash().as_deref()), (2, GROUP as u64 + 1000, Some("abc")));
        let (a, b) = (file.rows(0, &layout).expect("rows"), file.rows(1, &layout).expect("rows"));
        assert_eq!([a.points, b.points].concat(), rows.points);
        assert_eq!([a.failures, b.failures].concat(), rows.failures);
        assert_eq!([a.fault_codes, b.fault_codes].concat(), rows.fault_codes);
        assert_eq!(file.column("friction_ratio").expect("a column"), rows.metrics[0]);
        assert_eq!(file.column("contact.dahl.mu").expect("a column"), rows.keys[0].iter().map(|&x| Some(x)).collect::<Vec<_>>());
        let some = rows.metrics[0].iter().flatten().count() as u64;
        assert_eq!((file.present("friction_ratio"), file.present("reversals")), (some, 0));
        fs::write(&first, b"PAR1 and no end").expect("a file");
        assert!(RowsFile::open(&first).is_err_and(|error| error.to_string().contains("a.parquet")));
        fs::remove_dir_all(&dir).expect("removed");
    }

    #[test]
    fn abandoned_file_is_removed() {
        let dir = std::env::temp_dir().join(format!("given-up-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("a folder");
        let layout = Layout { keys: Vec::new(), metrics: Vec::new() };
        drop(RowsWriter::create(&dir.join("a.parquet"), &layout, "", true).expect("a file"));
        assert_eq!(fs::read_dir(&dir).expect("a folder").count(), 0);
        let error = RowsWriter::create(&dir.join("none/a.parquet"), &layout, "", true).map(drop).expect_err("no folder");
        assert!(error.to_string().contains("none/a.parquet"), "{error}");
        fs::remove_dir_all(&dir).expect("removed");
    }
}
