//! The rows of a study as a Parquet file: a column for each, of whole numbers, numbers, truths or texts, empty where a row has
//! nothing. Of the file's own remarks `pellucid.columns` says what each column is, as `columns.json` does.

use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use serde_json::{Map, Value as Json};
use std::sync::Arc;

/// What a column holds.
#[derive(Clone, Copy)]
enum Kind {
    Whole,
    Number,
    Truth,
    Text,
}

impl Kind {
    /// The narrowest that has all the values.
    fn of(values: &[Option<&Json>]) -> Kind {
        let all = |is: fn(&Json) -> bool| values.iter().flatten().all(|value| is(value));
        match () {
            () if values.iter().all(Option::is_none) => Kind::Text,
            () if all(Json::is_i64) => Kind::Whole,
            () if all(Json::is_number) => Kind::Number,
            () if all(Json::is_boolean) => Kind::Truth,
            () => Kind::Text,
        }
    }

    fn physical(self) -> Physical {
        match self {
            Kind::Whole => Physical::INT64,
            Kind::Number => Physical::DOUBLE,
            Kind::Truth => Physical::BOOLEAN,
            Kind::Text => Physical::BYTE_ARRAY,
        }
    }

    fn converted(self) -> ConvertedType {
        if matches!(self, Kind::Text) { ConvertedType::UTF8 } else { ConvertedType::NONE }
    }
}

/// The file.
///
/// # Errors
/// What the library refuses.
pub fn file(
    columns: &[String],
    rows: &[Map<String, Json>],
    about: &Json,
) -> Result<Vec<u8>, ParquetError> {
    let values = |column: &String| -> Vec<Option<&Json>> {
        rows.iter().map(|row| row.get(column).filter(|value| !value.is_null())).collect()
    };
    let kinds: Vec<Kind> = columns.iter().map(|column| Kind::of(&values(column))).collect();
    let fields = columns.iter().zip(&kinds).map(|(column, kind)| {
        let field = Type::primitive_type_builder(column, kind.physical());
        let field = field.with_repetition(Repetition::OPTIONAL);
        field.with_converted_type(kind.converted()).build().map(Arc::new)
    });
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("points").with_fields(fields).build()?;
    let about = KeyValue::new("pellucid.columns".to_string(), about.to_string());
    let properties = WriterProperties::builder().set_key_value_metadata(Some(vec![about])).build();
    let mut bytes = vec![];
    let mut writer = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (column, kind) in columns.iter().zip(kinds) {
        let values = values(column);
        match kind {
            Kind::Whole => put::<Int64Type>(&mut group, &values, Json::as_i64)?,
            Kind::Number => put::<DoubleType>(&mut group, &values, Json::as_f64)?,
            Kind::Truth => put::<BoolType>(&mut group, &values, Json::as_bool)?,
            Kind::Text => put::<ByteArrayType>(&mut group, &values, |value| {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
                Some(ByteArray::from(text.into_bytes()))
            })?,
        }
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

/// Writes the next column.
fn put<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, &mut Vec<u8>>,
    values: &[Option<&Json>],
    value: impl Fn(&Json) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let Some(mut column) = group.next_column()? else { return Ok(()) };
    let there: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let values: Vec<T::T> = values.iter().flatten().filter_map(|one| value(one)).collect();
    column.typed::<T>().write_batch(&values, Some(&there), None)?;
    column.close()
}
