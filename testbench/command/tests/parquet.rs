//! `points.parquet`, read back: it has the rows of `points.jsonl`.

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::{Value, json};
use std::fs::{self, File};
use std::process::Command;

const STUDY: &str = r#"
[[scene]]
scene = "glass"
width = 40
height = 30
[[machine]]
arch = "tbuffer"
sections = [16, 2048]
[[machine]]
arch = "dfb"
index = ["up", "down"]
"#;

#[test]
fn rows_are_those_of_the_json_lines() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .args(["explore", "study.toml", "--out", "out"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("points.parquet"));
    let out = folder.path().join("out");
    let lines = fs::read_to_string(out.join("points.jsonl")).unwrap();
    let file = File::open(out.join("points.parquet")).unwrap();
    let reader = SerializedFileReader::new(file).unwrap();
    let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    for (row, line) in rows.iter().zip(lines.lines()) {
        let expected: Value = serde_json::from_str(line).unwrap();
        let mut there = 0;
        for (name, field) in row.get_column_iter() {
            let value = match field {
                Field::Null => Value::Null,
                Field::Bool(truth) => json!(truth),
                Field::Long(number) => json!(number),
                Field::Double(number) => json!(number),
                Field::Str(text) => json!(text),
                other => panic!("{name}: {other:?}"),
            };
            let expected = expected.get(name).unwrap_or(&Value::Null);
            assert_eq!((value.as_f64(), value.as_str()), (expected.as_f64(), expected.as_str()));
            assert_eq!(
                (value.as_bool(), value.is_null()),
                (expected.as_bool(), expected.is_null())
            );
            there += usize::from(!value.is_null());
        }
        let object = expected.as_object().unwrap();
        assert_eq!(there, object.values().filter(|value| !value.is_null()).count());
    }
    // What a column is stands in the file.
    let remarks = reader.metadata().file_metadata().key_value_metadata().unwrap();
    let columns = remarks.iter().find(|remark| remark.key == "pellucid.columns").unwrap();
    let columns: Value = serde_json::from_str(columns.value.as_ref().unwrap()).unwrap();
    let beside: Value =
        serde_json::from_slice(&fs::read(out.join("columns.json")).unwrap()).unwrap();
    assert_eq!(columns, beside);
}
