//! Figures as text: numbers, fields and the lines of tables.

use comfy_table::{CellAlignment, Table};
use serde_json::Value as Json;

/// A text as a field of a CSV file, whatever is in it.
pub fn csv_text(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// A table's lines with the names of groups at the margin, a blank line before each but the first.
pub fn at_margin(lines: &str) -> String {
    let mut text = String::new();
    for line in lines.lines().map(|line| line.strip_prefix(' ').unwrap_or(line).trim_end()) {
        if !text.is_empty() && !line.starts_with(' ') {
            text.push('\n');
        }
        text += &format!("{line}\n");
    }
    text
}

/// The figures of these columns stand at the right.
pub fn align_right(table: &mut Table, columns: &[usize]) {
    for column in columns {
        if let Some(column) = table.column_mut(*column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

/// `1234567` as `1,234,567`; anything else as it is.
pub fn grouped(value: &Json) -> String {
    let Some(number) = value.as_u64() else { return value.to_string() };
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k) % 3 == 0 {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_are_grouped() {
        let text = |n: u64| grouped(&json!(n));
        assert_eq!([0, 999, 1000, 1234567].map(text), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!(grouped(&json!(0.5)), "0.5");
    }

    #[test]
    fn a_field_holds_commas_and_quotes() {
        assert_eq!(csv_text(r#"a,"b""#), r#""a,""b""""#);
    }
}
