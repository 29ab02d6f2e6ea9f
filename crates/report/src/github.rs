//! Results as annotations of GitHub Actions: a line a finding, which the host shows beside the source.

use super::findings::{self, Finding, Level};
use super::format::{Checks, Extent, Format, Project};
use std::io::{self, Write};

/// Annotations for a workflow's log.
pub const FORMAT: Format = Format {
    name: "github",
    about: "Annotations for GitHub Actions",
    suffixes: &[],
    draws: false,
    escapes: false,
    audit: |audit, check, _, out| write(&findings::of_audit(audit, check), out),
    compare: |found, out| write(&findings::of_comparison(found), out),
    diff: |found, _, out| write(&findings::of_difference(found), out),
    checks: || Box::new(All),
    tells_faults: true,
};

struct All;

impl Checks for All {
    fn add(&mut self, project: &Project<'_>, _: Extent, out: &mut dyn Write) -> io::Result<()> {
        write(&findings::of_project(project), out)
    }

    fn end(&mut self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}

fn write(found: &[Finding], out: &mut dyn Write) -> io::Result<()> {
    for one in found {
        let level = match one.level {
            Level::Error => "error",
            Level::Warning => "warning",
            Level::Note => "notice",
        };
        let mut properties = vec![format!("title=scanbound {}", one.rule.name)];
        if let Some((file, line)) = &one.place {
            properties.insert(0, format!("file={}", property(file)));
            properties.extend(line.map(|line| format!("line={line}")));
        }
        writeln!(out, "::{level} {}::{}", properties.join(","), data(&one.message))?;
    }
    Ok(())
}

/// A message on one line.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// A value between commas.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;

    #[test]
    fn each_finding_is_a_line_whatever_it_says() {
        assert_eq!(property("a,b: 5 %\n"), "a%2Cb%3A 5 %25%0A");
        let mut bytes = Vec::new();
        write(&findings::of_audit(&fixture(), None), &mut bytes).expect("memory takes all");
        insta::assert_snapshot!(String::from_utf8(bytes).expect("text"));
    }
}
