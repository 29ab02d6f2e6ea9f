//! The schemas of what is written as JSON, worked out from the types that are written; what each key means is said in
//! docs/json.md and taken from there.

use super::json::projects;
use super::{advice, compare, cpus, diff, doctor, explain, json, netcheck, sfc, snet};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema, json_schema};
use serde_json::Value;
use std::collections::BTreeMap;

/// What keys mean: the tables of this page.
const PAGE: &str = include_str!("../docs/json.md");

/// The schema of a kind of JSON.
#[derive(Debug, Clone, Copy)]
pub struct Published {
    /// Its name, as `scanbound schema` takes it and as its file under docs/schema is called.
    pub name: &'static str,
    /// What documents of it have as their `schema`.
    pub id: &'static str,
    /// What writes it.
    pub about: &'static str,
    /// The heading of its table in docs/json.md.
    heading: &'static str,
    of: fn() -> Schema,
}

/// All of them.
pub const SCHEMAS: &[Published] = &[
    Published {
        name: "audit",
        id: "scanbound.audit/1",
        about: "audit and check",
        heading: "## audit and check",
        of: of::<json::Report<'static>>,
    },
    Published {
        name: "checks",
        id: projects::SCHEMA,
        about: "check --all",
        heading: "## check --all",
        of: checks,
    },
    Published {
        name: "compare",
        id: "scanbound.compare/1",
        about: "compare",
        heading: "## compare",
        of: of::<compare::json::Report<'static>>,
    },
    Published {
        name: "diff",
        id: "scanbound.diff/1",
        about: "diff",
        heading: "## diff",
        of: of::<diff::json::Report<'static>>,
    },
    Published {
        name: "advise",
        id: "scanbound.advice/1",
        about: "advise",
        heading: "## advise",
        of: of::<advice::json::Report<'static>>,
    },
    Published {
        name: "cpus",
        id: "scanbound.cpus/1",
        about: "cpus",
        heading: "## cpus",
        of: of::<cpus::json::Report<'static>>,
    },
    Published {
        name: "doctor",
        id: "scanbound.doctor/1",
        about: "doctor",
        heading: "## doctor",
        of: of::<doctor::json::Report<'static>>,
    },
    Published {
        name: "explain",
        id: "scanbound.explain/1",
        about: "explain",
        heading: "## explain",
        of: of::<explain::json::Report<'static>>,
    },
    Published {
        name: "sfc",
        id: "scanbound.sfc/1",
        about: "sfc",
        heading: "## sfc",
        of: of::<sfc::json::Report<'static>>,
    },
    Published {
        name: "snet",
        id: "scanbound.snet/1",
        about: "snet check",
        heading: "## snet",
        of: of::<netcheck::json::Report<'static>>,
    },
    Published {
        name: "snet-monitor",
        id: snet::readings::SCHEMA,
        about: "snet monitor, a line each poll",
        heading: "## snet monitor",
        of: of::<snet::readings::Row<'static>>,
    },
];

impl Published {
    /// The schema on indented lines.
    #[must_use]
    pub fn text(&self) -> String {
        let mut schema = (self.of)().to_value();
        let object = schema.as_object_mut().expect("the schema of an object");
        object.insert("title".to_owned(), self.id.into());
        object.remove("description");
        describe(&mut schema, "", &meanings(self.heading));
        schema["properties"]["schema"] = serde_json::json!({ "const": self.id });
        let text = serde_json::to_string_pretty(&schema);
        text.expect("plain data has a JSON form") + "\n"
    }
}

/// What a type is written as.
fn of<T: JsonSchema>() -> Schema {
    let settings = SchemaSettings::draft2020_12().for_serialize();
    settings.with(|s| s.inline_subschemas = true).into_generator().into_root_schema_for::<T>()
}

/// The document of several projects, which is no type since it is written piece by piece.
fn checks() -> Schema {
    let project = of::<projects::Project<'static>>();
    let mut schema = json_schema!({
        "type": "object",
        "properties": { "schema": {}, "projects": { "type": "array", "items": project } },
        "required": ["schema", "projects"],
    });
    let dialect = schema.get_mut("properties").and_then(|all| {
        all["projects"]["items"].as_object_mut().and_then(|project| project.remove("$schema"))
    });
    schema.insert("$schema".to_owned(), dialect.unwrap_or_default());
    schema
}

/// What the table below a heading says of each key, by its path: `groups.charges.line`. A name that begins with a point
/// stands beside the one before it; what a row says, it says of all its keys.
fn meanings(heading: &str) -> BTreeMap<String, String> {
    let below = PAGE.lines().skip_while(|line| *line != heading).skip(1);
    let mut found = BTreeMap::new();
    for row in below.take_while(|line| !line.starts_with("## ")) {
        let cells = row.strip_prefix("| ").and_then(|row| row.strip_suffix(" |"));
        let cells = cells.filter(|row| row.starts_with('`'));
        let Some((names, meaning)) = cells.and_then(|row| row.split_once(" | ")) else { continue };
        let mut last = String::new();
        for name in names.split("`, `").map(|name| name.trim_matches('`').replace("[]", "")) {
            let beside = last.rsplit_once('.').map_or("", |(owner, _)| owner);
            last = match name.strip_prefix('.') {
                Some(own) => format!("{beside}.{own}"),
                None => name,
            };
            let text = match names.contains("`, `") {
                true => format!("{names}: {meaning}"),
                false => meaning.to_owned(),
            };
            found.insert(last.clone(), text);
        }
    }
    found
}

/// Says of each key what it means.
fn describe(schema: &mut Value, path: &str, meanings: &BTreeMap<String, String>) {
    let Some(object) = schema.as_object_mut() else { return };
    if let Some(items) = object.get_mut("items") {
        describe(items, path, meanings);
    }
    for forms in ["anyOf", "oneOf"] {
        if let Some(Value::Array(forms)) = object.get_mut(forms) {
            forms.iter_mut().for_each(|form| describe(form, path, meanings));
        }
    }
    let Some(Value::Object(properties)) = object.get_mut("properties") else { return };
    for (key, property) in properties {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        describe(property, &path, meanings);
        if let (Some(meaning), Some(object)) = (meanings.get(&path), property.as_object_mut()) {
            object.insert("description".to_owned(), meaning.clone().into());
        }
    }
}
