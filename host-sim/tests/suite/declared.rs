//! The columns that `host-sim recording columns` tells of, for every test that looks at a table.

use std::path::Path;

use serde_json::Value;

use crate::program::{host_sim, report};

/// The columns of a kind of table, as `host-sim recording columns` says: name, unit and meaning.
pub(crate) fn declared(kind: &str) -> Vec<[String; 3]> {
    let told = report(host_sim(&["recording", "columns", kind, "--json"]).spawn().expect("host-sim runs"));
    let columns = told[kind]["columns"].as_array().expect("columns");
    let text = |column: &Value, field: &str| column[field].as_str().unwrap_or_default().to_owned();
    columns.iter().map(|column| ["column", "unit", "meaning"].map(|field| text(column, field))).collect()
}

/// This CSV file has just the columns of its kind, in their order.
pub(crate) fn has_columns_of(kind: &str, file: &Path) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|cause| panic!("{}: {cause}", file.display()));
    let names: Vec<String> = declared(kind).into_iter().map(|[name, ..]| name).collect();
    assert_eq!(text.lines().next().unwrap_or_default().split(',').collect::<Vec<_>>(), names, "{kind}");
}
