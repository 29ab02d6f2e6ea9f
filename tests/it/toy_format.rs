//! A toy format of reports: what a new format takes is one file with a `FORMAT` such as this, and its line in
//! `FORMATS`. `audit`, `check`, `compare` and `diff` then write it.

use scanbound::audit::difference::Difference;
use scanbound::audit::{Request, audit};
use scanbound::base::facts::Facts;
use scanbound::base::time::Picos;
use scanbound::front::Input;
use scanbound::measured::{Bounds, Comparison, Selection, capture};
use scanbound::report::FORMATS;
use scanbound::report::format::{Checked, Checks, Extent, Format, Project};
use scanbound::report::formats::{by_suffix, named};
use std::io::{self, Write};

/// One line each.
const TOY: Format = Format {
    name: "toy",
    about: "One line",
    suffixes: &["toy"],
    draws: false,
    escapes: false,
    audit: |audit, check, _, out| match check {
        None => writeln!(out, "at most {}", audit.bound.upper),
        Some(check) => writeln!(out, "at most {}, allowed {}", audit.bound.upper, check.limit),
    },
    compare: |found, out| writeln!(out, "{} scans", found.measured.times.len()),
    diff: |found, _, out| writeln!(out, "{} changes", found.changes.len()),
    checks: || Box::new(Codes),
    tells_faults: false,
};

/// A line a project.
struct Codes;

impl Checks for Codes {
    fn add(&mut self, one: &Project<'_>, _: Extent, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{}: {}", one.file, one.exit_code)
    }

    fn end(&mut self, _: &mut dyn Write) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_format_is_found_and_writes_every_kind_of_result() {
    let formats = [FORMATS, &[TOY]].concat();
    assert!(named(FORMATS, "toy").is_none());
    let toy = named(&formats, "toy").expect("its name");
    assert_eq!(by_suffix(&formats, "out/report.toy").map(|found| found.name), Some("toy"));

    let program = b"LD X0\nMOV K1 D0\nEND\n".to_vec();
    let inputs = [Input { name: "a.il".to_owned(), bytes: program }];
    let facts = Facts::default();
    let audit = audit(&Request { cpu: Some("Q26UDV"), ..Request::new(&inputs, &facts) });
    let audit = audit.expect("an audit");
    let upper = audit.bound.upper;
    assert!(upper > Picos::ZERO);
    let mut written = Vec::new();
    (toy.audit)(&audit, None, Default::default(), &mut written).expect("memory takes it");
    assert_eq!(written, format!("at most {upper}\n").as_bytes());

    let found = Difference::of(&audit, &audit, None);
    written.clear();
    (toy.diff)(&found, Default::default(), &mut written).expect("memory takes it");
    assert_eq!(written, b"0 changes\n");

    let measured = capture::read("m.csv", b"scan_ms\n0.1\n0.2\n", &Selection::default());
    let bounds = Bounds::of(&audit);
    let measured = measured.expect("measurements");
    let found = Comparison::new(audit.files, bounds, measured, false).expect("a comparison");
    written.clear();
    (toy.compare)(&found, &mut written).expect("memory takes it");
    assert_eq!(written, b"2 scans\n");

    written.clear();
    let failed = Checked::Failed("not read".to_owned());
    let mut checks = (toy.checks)();
    let project = Project { file: "scanbound.toml", exit_code: 2, checked: failed };
    checks.add(&project, Default::default(), &mut written).expect("memory takes it");
    checks.end(&mut written).expect("memory takes it");
    assert_eq!(written, b"scanbound.toml: 2\n");
}
