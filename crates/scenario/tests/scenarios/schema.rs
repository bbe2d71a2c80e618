//! The schema knows every field of every scenario that comes with Hopper.

use scenario::{BUILT_IN, Scenario};

use crate::says;

/// Walks a scenario along the schema, following references, and fails where a field is not in it.
#[test]
fn every_field_of_every_shipped_scenario_is_in_the_schema() {
    let schema = Scenario::schema();
    for (name, text) in BUILT_IN {
        let value: toml::Table = text.parse().unwrap();
        follow(&schema, &schema, &serde_json::to_value(value).unwrap(), name);
    }
    let text = schema.to_string();
    says(
        &text,
        &["additionalProperties\":false", "paper-2023", "seen_differences", "elevation_file", "survey"],
    );
}

fn follow(root: &serde_json::Value, schema: &serde_json::Value, value: &serde_json::Value, at: &str) {
    let schema = match schema.get("$ref").and_then(serde_json::Value::as_str) {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
        None => schema,
    };
    let serde_json::Value::Object(fields) = value else { return };
    if let Some(variants) = schema.get("oneOf").or(schema.get("anyOf")).and_then(serde_json::Value::as_array)
    {
        let variant = variants.iter().find(|variant| {
            let properties = follow_reference(root, variant).get("properties");
            properties.is_some_and(|properties| fields.keys().all(|key| properties.get(key).is_some()))
        });
        return follow(root, variant.unwrap_or_else(|| panic!("{at} is no variant of {schema}")), value, at);
    }
    for (key, value) in fields {
        let property = schema.pointer(&format!("/properties/{key}"));
        follow(
            root,
            property.unwrap_or_else(|| panic!("{at}.{key} is not in the schema")),
            value,
            &format!("{at}.{key}"),
        );
    }
}

fn follow_reference<'a>(root: &'a serde_json::Value, schema: &'a serde_json::Value) -> &'a serde_json::Value {
    match schema.get("$ref").and_then(serde_json::Value::as_str) {
        Some(reference) => root.pointer(reference.trim_start_matches('#')).unwrap(),
        None => schema,
    }
}
