//! Finding a column of numbers in a Parquet schema.

use std::fmt::Debug;
use std::path::Path;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::schema::types::{SchemaDescriptor, Type};

use crate::formats::error::{FaultKind, FormatError, Place, quoted};
use crate::formats::table::nearest;

/// A column of numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// As asked for.
    pub(super) name: &'static str,
    /// Its place among the leaves of the schema.
    pub(super) leaf: usize,
    /// Whether its integers are without sign.
    pub(super) unsigned: bool,
}

/// The column of this name, trimmed, letters of either case.
pub(super) fn find(
    file: &Path,
    schema: &SchemaDescriptor,
    name: &'static str,
) -> Result<Column, FormatError> {
    let fields = schema.root_schema().get_fields();
    let same = |field: &Type| field.name().trim().eq_ignore_ascii_case(name);
    let mut hits = fields.iter().enumerate().filter(|(_, field)| same(field));
    let fault = |kind, found: String, expected: String| {
        FormatError::new(kind, file, Place::Header, found, expected)
    };
    let (root, field) = match (hits.next(), hits.next()) {
        (Some(hit), None) => hit,
        (Some(_), Some(_)) => {
            let found = format!("two columns {name}");
            return Err(fault(FaultKind::BadValue, found, "one".to_owned()));
        }
        (None, _) => {
            let columns: Vec<String> = fields.iter().map(|f| f.name().to_owned()).collect();
            let mut found = quoted(columns.join(",").as_bytes());
            if let Some(nearest) = nearest(&columns, &[name]) {
                found.push_str(&format!(
                    " (nearest column: {})",
                    quoted(nearest.as_bytes()).trim_matches('"')
                ));
            }
            return Err(fault(
                FaultKind::MissingColumn,
                found,
                format!("a column {name}"),
            ));
        }
    };
    let leaf = (0..schema.num_columns()).find(|leaf| schema.get_column_root_idx(*leaf) == root);
    match (leaf, numeric(field)) {
        (Some(leaf), Some(unsigned)) => Ok(Column {
            name,
            leaf,
            unsigned,
        }),
        _ => {
            let found = format!("column {name} of type {}", words(field));
            let expected = "FLOAT, DOUBLE, INT32 or INT64, plain numbers".to_owned();
            Err(fault(FaultKind::BadValue, found, expected))
        }
    }
}

/// Whether a field holds plain numbers, and whether these are integers without sign. Decimals, dates and times are not plain: their
/// stored integers count something else than units.
fn numeric(field: &Type) -> Option<bool> {
    if field.is_group() {
        return None;
    }
    let info = field.get_basic_info();
    let stored = matches!(
        field.get_physical_type(),
        Physical::FLOAT | Physical::DOUBLE | Physical::INT32 | Physical::INT64
    );
    let one = !info.has_repetition() || info.repetition() != Repetition::REPEATED;
    let plain = match (info.logical_type_ref(), info.converted_type()) {
        (Some(LogicalType::Integer(integer)), _) => Some(!integer.is_signed),
        (Some(_), _) => None,
        (None, ConvertedType::NONE) => Some(false),
        (
            None,
            ConvertedType::INT_8
            | ConvertedType::INT_16
            | ConvertedType::INT_32
            | ConvertedType::INT_64,
        ) => Some(false),
        (
            None,
            ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64,
        ) => Some(true),
        _ => None,
    };
    plain.filter(|_| stored && one)
}

/// A field's type for a message.
fn words(field: &Type) -> String {
    if field.is_group() {
        return "list or group".to_owned();
    }
    let info = field.get_basic_info();
    let meant = match (info.logical_type_ref(), info.converted_type()) {
        (Some(logical), _) => format!(" ({})", word(logical)),
        (None, ConvertedType::NONE) => String::new(),
        (None, converted) => format!(" ({converted})"),
    };
    let repeated = info.has_repetition() && info.repetition() == Repetition::REPEATED;
    let repeated = if repeated { ", repeated" } else { "" };
    format!("{}{meant}{repeated}", field.get_physical_type())
}

/// The first word of what something is called in the code.
pub(super) fn word(value: &impl Debug) -> String {
    let text = format!("{value:?}");
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_'));
    text[..end.unwrap_or(text.len())].to_owned()
}
