//! Writes rows to a Parquet file.

use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::Kind;

/// The number of rows written together.
const GROUP: usize = 1 << 16;

/// Writes a table with its header in the first line; returns the number of rows.
pub(super) fn write(rows: &mut impl Read, file: &mut File, kind: impl Fn(&str) -> Kind) -> io::Result<usize> {
    let mut reader = csv::Reader::from_reader(rows);
    let names: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED).build();
    let schema = Arc::new(schema(&names, &kind).map_err(io::Error::other)?);
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).map_err(io::Error::other)?;
    let mut group: Vec<csv::StringRecord> = Vec::new();
    let mut count = 0;
    let mut records = reader.records();
    loop {
        let record = records.next().transpose()?;
        let is_last = record.is_none();
        group.extend(record);
        if group.len() == GROUP || (is_last && !group.is_empty()) {
            let mut rows = writer.next_row_group().map_err(io::Error::other)?;
            for (i, name) in names.iter().enumerate() {
                column(&mut rows, kind(name), group.iter().map(|record| record.get(i).unwrap_or_default()))?;
            }
            rows.close().map_err(io::Error::other)?;
            count += group.len();
            group.clear();
        }
        if is_last {
            break;
        }
    }
    writer.close().map_err(io::Error::other)?;
    Ok(count)
}

fn schema(names: &[String], kind: impl Fn(&str) -> Kind) -> parquet::errors::Result<Type> {
    let field = |name: &String| {
        let (physical, logical) = match kind(name) {
            Kind::Whole => (Physical::INT64, None),
            Kind::Number => (Physical::DOUBLE, None),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()?;
        Ok(Arc::new(field))
    };
    let fields: Vec<_> = names.iter().map(field).collect::<parquet::errors::Result<_>>()?;
    Type::group_type_builder("table").with_fields(fields).build()
}

/// Writes one column of a group; empty fields are null.
fn column<'r>(
    rows: &mut SerializedRowGroupWriter<&mut File>,
    kind: Kind,
    fields: impl Iterator<Item = &'r str> + Clone,
) -> io::Result<()> {
    let levels: Vec<i16> = fields.clone().map(|field| i16::from(!field.is_empty())).collect();
    let present = fields.filter(|field| !field.is_empty());
    let mut column = rows.next_column().map_err(io::Error::other)?.ok_or_else(|| io::Error::other("no column left"))?;
    let written = match kind {
        Kind::Whole => {
            let values: Vec<i64> = present.map(str::parse).collect::<Result<_, _>>().map_err(io::Error::other)?;
            column.typed::<Int64Type>().write_batch(&values, Some(&levels), None)
        }
        Kind::Number => {
            let values: Vec<f64> = present.map(str::parse).collect::<Result<_, _>>().map_err(io::Error::other)?;
            column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)
        }
        Kind::Text => {
            let values: Vec<ByteArray> = present.map(ByteArray::from).collect();
            column.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)
        }
    };
    written.map_err(io::Error::other)?;
    column.close().map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::Field;
    use qrm_scene::files::write_atomic_with;

    use super::*;

    fn kind(name: &str) -> Kind {
        match name {
            "design" | "steps" => Kind::Whole,
            "O2A" => Kind::Number,
            _ => Kind::Text,
        }
    }

    #[test]
    fn a_written_table_can_be_read() {
        let path = std::env::temp_dir().join(format!("qrm-test-{}.parquet", std::process::id()));
        let table = "design,O2A,status,reason,steps\n0,0.15,done,,1756\n1,1e-300,failed,\"no, never\",\n";
        let written = write_atomic_with(&path, |file| write(&mut table.as_bytes(), file, kind));
        assert_eq!(written.expect("written"), 2);
        let reader = SerializedFileReader::new(File::open(&path).expect("there")).expect("Parquet");
        let rows: Vec<Vec<Field>> = reader
            .get_row_iter(None)
            .expect("rows")
            .map(|row| row.expect("a row").get_column_iter().map(|(_, field)| field.clone()).collect())
            .collect();
        std::fs::remove_file(&path).expect("removed");
        let text = |text: &str| Field::Str(text.to_owned());
        assert_eq!(
            rows,
            [
                vec![Field::Long(0), Field::Double(0.15), text("done"), Field::Null, Field::Long(1756)],
                vec![Field::Long(1), Field::Double(1e-300), text("failed"), text("no, never"), Field::Null],
            ]
        );
    }
}
