//! Results as SARIF 2.1.0, which code hosts show at the lines of the source.

use super::findings::{self, Finding, Level, Rule};
use super::format::{Checks, Extent, Format, Project};
use serde::Serialize;
use std::io::{self, Write};

/// A log of findings for code hosts.
pub const FORMAT: Format = Format {
    name: "sarif",
    about: "SARIF 2.1.0 for code hosts",
    suffixes: &["sarif", "sarif.json"],
    draws: false,
    escapes: false,
    audit: |audit, check, _, out| write(&findings::of_audit(audit, check), out),
    compare: |found, out| write(&findings::of_comparison(found), out),
    diff: |found, _, out| write(&findings::of_difference(found), out),
    checks: || Box::<All>::default(),
    tells_faults: true,
};

/// One run of all projects: code hosts take one run of a tool a log.
#[derive(Default)]
struct All(Vec<Finding>);

impl Checks for All {
    fn add(&mut self, project: &Project<'_>, _: Extent, _: &mut dyn Write) -> io::Result<()> {
        self.0.extend(findings::of_project(project));
        Ok(())
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        write(&self.0, out)
    }
}

/// The published schema.
const SCHEMA: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

#[derive(Serialize)]
struct Log<'a> {
    #[serde(rename = "$schema")]
    schema: &'static str,
    version: &'static str,
    runs: [Run<'a>; 1],
}

#[derive(Serialize)]
struct Run<'a> {
    tool: Tool,
    results: Vec<SarifResult<'a>>,
}

#[derive(Serialize)]
struct Tool {
    driver: Driver,
}

#[derive(Serialize)]
struct Driver {
    name: &'static str,
    version: &'static str,
    rules: Vec<Descriptor>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Descriptor {
    id: &'static str,
    short_description: Text<'static>,
}

#[derive(Serialize)]
struct Text<'a> {
    text: &'a str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct SarifResult<'a> {
    rule_id: &'static str,
    rule_index: usize,
    level: &'static str,
    message: Text<'a>,
    locations: Vec<Location>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    physical_location: Place,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Place {
    artifact_location: Artifact,
    #[serde(skip_serializing_if = "Option::is_none")]
    region: Option<Region>,
}

#[derive(Serialize)]
struct Artifact {
    uri: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: u32,
}

fn write(found: &[Finding], out: &mut dyn Write) -> io::Result<()> {
    let mut rules: Vec<Rule> = found.iter().map(|one| one.rule).collect();
    rules.sort_unstable();
    rules.dedup();
    let descriptor =
        |rule: &Rule| Descriptor { id: rule.name, short_description: Text { text: rule.about } };
    let driver = Driver {
        name: "scanbound",
        version: env!("CARGO_PKG_VERSION"),
        rules: rules.iter().map(descriptor).collect(),
    };
    let results = found.iter().map(|one| result(one, &rules)).collect();
    let run = Run { tool: Tool { driver }, results };
    let log = Log { schema: SCHEMA, version: "2.1.0", runs: [run] };
    serde_json::to_writer_pretty(&mut *out, &log)?;
    out.write_all(b"\n")
}

fn result<'a>(one: &'a Finding, rules: &[Rule]) -> SarifResult<'a> {
    SarifResult {
        rule_id: one.rule.name,
        rule_index: rules.iter().position(|rule| *rule == one.rule).unwrap_or(0),
        level: match one.level {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "note",
        },
        message: Text { text: &one.message },
        locations: one.place.iter().map(location).collect(),
    }
}

fn location((file, line): &(String, Option<u32>)) -> Location {
    Location {
        physical_location: Place {
            artifact_location: Artifact { uri: uri(file) },
            region: line.map(|start_line| Region { start_line }),
        },
    }
}

/// A file's name as a reference: parts apart by `/`, what is no letter, digit or one of `-._~` as its bytes.
fn uri(file: &str) -> String {
    let mut text = String::new();
    let parts = file.replace('\\', "/");
    if parts.starts_with('/') {
        text.push_str("file://");
    } else if parts.as_bytes().get(1) == Some(&b':') {
        text.push_str("file:///");
    }
    for byte in parts.bytes() {
        match byte {
            b'/' | b'-' | b'.' | b'_' | b'~' => text.push(char::from(byte)),
            byte if byte.is_ascii_alphanumeric() => text.push(char::from(byte)),
            byte => text.push_str(&format!("%{byte:02X}")),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;

    #[test]
    fn names_of_files_are_references() {
        assert_eq!(uri("plc/MAIN 1.csv"), "plc/MAIN%201.csv");
        assert_eq!(uri("搬送.csv"), "%E6%90%AC%E9%80%81.csv");
        assert_eq!(uri("/a/b.il"), "file:///a/b.il");
        assert_eq!(uri("C:\\a\\b.il"), "file:///C%3A/a/b.il");
    }

    #[test]
    fn every_result_names_a_rule_and_a_line() {
        let mut bytes = Vec::new();
        write(&findings::of_audit(&fixture(), None), &mut bytes).expect("memory takes all");
        // Read by the types that are made from the published schema.
        let log: serde_sarif::sarif::Sarif = serde_json::from_slice(&bytes).expect("SARIF");
        let run = &log.runs[0];
        let rules = run.tool.driver.rules.as_ref().expect("rules");
        let results = run.results.as_ref().expect("results");
        assert!(results.len() > 5);
        for result in results {
            let index = usize::try_from(result.rule_index.expect("an index")).expect("from 0");
            assert_eq!(Some(&rules[index].id), result.rule_id.as_ref());
        }
        let first = results[0].locations.as_ref().expect("a place")[0].physical_location.as_ref();
        let line = first.and_then(|place| place.region.as_ref()?.start_line);
        assert_eq!(line, Some(4));
    }
}
