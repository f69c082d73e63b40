//! Names with dots as places within a value of JSON, both ways.

use serde_json::Value;

use super::Cell;

/// A value as a word, or several.
pub fn word(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(items) => items.iter().map(word).collect::<Vec<_>>().join("  "),
        _ => value.to_string(),
    }
}

/// The cells of a value, named: of an object each field, of a list of objects each of theirs, else the value itself; of a list of
/// lists how many there are.
pub(super) fn fields(name: &str, value: &Value) -> Vec<(String, Cell)> {
    let within = |own: &str| [name, own].join(".").trim_start_matches('.').to_owned();
    let cell = match value {
        Value::Object(inner) => return inner.iter().flat_map(|(own, value)| fields(&within(own), value)).collect(),
        Value::Array(items) if items.iter().any(Value::is_object) => {
            return items.iter().enumerate().flat_map(|(at, item)| fields(&within(&at.to_string()), item)).collect();
        }
        Value::Array(items) => match items.iter().map(Value::as_f64).collect() {
            _ if items.is_empty() => Cell::Empty,
            Some(numbers) => Cell::List(numbers),
            None if items.iter().any(Value::is_array) => items.len().into(),
            None => Cell::Text(items.iter().map(word).collect::<Vec<_>>().join(", ")),
        },
        Value::Null => Cell::Empty,
        Value::Bool(flag) => (*flag).into(),
        Value::Number(number) => number.as_i64().map_or_else(|| number.as_f64().into(), Cell::Whole),
        Value::String(text) => text.as_str().into(),
    };
    vec![(name.to_owned(), cell)]
}

/// What is called so within a value, which is made an object for it, or a list for a number that counts from 0.
pub(super) fn within<'a>(at: &'a mut Value, name: &str) -> &'a mut Value {
    let in_list = |index: &usize| match &*at {
        Value::Null => *index == 0,
        Value::Array(items) => *index <= items.len(),
        _ => false,
    };
    let Some(index) = name.parse::<usize>().ok().filter(in_list) else { return &mut at[name] };
    if at.is_null() {
        *at = Value::Array(Vec::new());
    }
    if let Value::Array(items) = at
        && items.len() == index
    {
        items.push(Value::Null);
    }
    &mut at[index]
}
