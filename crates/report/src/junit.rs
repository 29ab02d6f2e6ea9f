//! Results as JUnit XML: a case for the limit, so that a pipeline shows it among its tests.

use super::format::{Checked, Checks, Detail, Extent, Format, Project};
use super::text::{self, verdict};
use super::{compare, diff};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use scanbound_audit::Audit;
use scanbound_audit::difference::Difference;
use scanbound_audit::verdict::{Check, Verdict};
use scanbound_base::diagnostic::Diagnostic;
use scanbound_measured::Comparison;
use std::io::{self, Write};

/// XML for servers that show tests.
pub const FORMAT: Format = Format {
    name: "junit",
    about: "JUnit XML for pipelines",
    suffixes: &["xml"],
    draws: false,
    escapes: false,
    audit: |audit, check, extent, out| {
        write(vec![suite(case(audit, check, extent), audit.files.join(", "))], out)
    },
    compare: |found, out| write(vec![suite(compared(found), found.files.join(", "))], out),
    diff: |found, extent, out| {
        write(vec![suite(differed(found, extent), found.new_files.join(", "))], out)
    },
    checks: || Box::<All>::default(),
    tells_faults: true,
};

/// The name of a check's case, whatever the limit is: servers follow cases by their names.
const CHECK: &str = "no scan takes longer than the limit";

/// A suite a project.
#[derive(Default)]
struct All(Vec<TestSuite>);

impl Checks for All {
    fn add(&mut self, project: &Project<'_>, extent: Extent, _: &mut dyn Write) -> io::Result<()> {
        let case = match &project.checked {
            Checked::Audited(audit, check) => case(audit, Some(check), extent),
            Checked::Faulty(faults) => {
                let all: Vec<String> = faults.iter().map(Diagnostic::brief).collect();
                TestCase::new(CHECK, broken(all.join("\n")))
            }
            Checked::Failed(why) => TestCase::new(CHECK, broken(why.clone())),
        };
        self.0.push(suite(case, project.file.to_owned()));
        Ok(())
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        write(std::mem::take(&mut self.0), out)
    }
}

fn case(audit: &Audit, check: Option<&Check>, extent: Extent) -> TestCase {
    let answer = verdict::answer(audit, check).plain();
    let status = match check.map(|check| &check.verdict) {
        _ if audit.is_endless() => failed("refuted", answer),
        None if !audit.unbounded.is_empty() => failed("undecided", answer),
        None | Some(Verdict::Proved) => TestCaseStatus::success(),
        Some(Verdict::Refuted) => failed("refuted", answer),
        Some(Verdict::Undecided(_)) => {
            let mut status = failed("undecided", answer);
            status.set_description(verdict::reasons(check).join("\n"));
            status
        }
    };
    let name = if check.is_some() { CHECK } else { "the scan time is bounded" };
    let mut case = TestCase::new(name, status);
    let short = Extent { detail: Detail::Short, height: usize::MAX, ..extent };
    let shown = anstream::adapter::strip_str(&text::render(audit, check, short)).to_string();
    case.set_system_out(shown);
    case.set_time(audit.elapsed);
    case
}

fn compared(found: &Comparison) -> TestCase {
    let status = match found.above {
        Some(_) => failed("above", compare::text::answer(found)),
        None => TestCaseStatus::success(),
    };
    let mut case = TestCase::new("no measured scan takes longer than the bound", status);
    case.set_system_out(anstream::adapter::strip_str(&compare::text::render(found)).to_string());
    case
}

fn differed(found: &Difference, extent: Extent) -> TestCase {
    let status = match found.is_above() {
        true => failed("above", diff::text::answer(found)),
        false => TestCaseStatus::success(),
    };
    let mut case = TestCase::new("the bound grows by no more than is allowed", status);
    let shown = diff::text::render(found, extent);
    case.set_system_out(anstream::adapter::strip_str(&shown).to_string());
    case
}

fn failed(kind: &str, message: String) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
    status.set_type(kind).set_message(message);
    status
}

/// The project cannot be read.
fn broken(why: String) -> TestCaseStatus {
    let mut status = TestCaseStatus::non_success(NonSuccessKind::Error);
    status.set_type("input").set_message(why);
    status
}

fn suite(mut case: TestCase, name: String) -> TestSuite {
    case.set_classname("scanbound");
    let mut suite = TestSuite::new(name);
    suite.add_test_case(case);
    suite
}

fn write(suites: Vec<TestSuite>, out: &mut dyn Write) -> io::Result<()> {
    let mut report = Report::new("scanbound");
    report.add_test_suites(suites);
    let text = report.to_string().map_err(io::Error::other)?;
    // Jenkins' schema knows no such attribute. It stands in the suites' tags; what is told has its quotes escaped.
    let text = text.replace(" disabled=\"0\" errors=", " errors=");
    out.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;
    use scanbound_audit::verdict::Margin;
    use scanbound_base::time::Picos;

    /// The report as it is read by others: failures, and what the first case says.
    fn read(limit: u64) -> (usize, Option<String>) {
        let mut audit = fixture();
        audit.doubts.clear();
        let check = Check::new(&audit, Picos(limit), Margin::default());
        let mut bytes = Vec::new();
        let case = case(&audit, Some(&check), Extent::default());
        write(vec![suite(case, "a".to_owned())], &mut bytes).expect("memory takes all");
        let text = String::from_utf8(bytes).expect("text");
        let report = Report::deserialize_from_str(&text).expect("JUnit");
        let case = &report.test_suites[0].test_cases[0];
        let told = match &case.status {
            TestCaseStatus::NonSuccess { ty, .. } => ty.as_ref().map(|ty| ty.as_str().to_owned()),
            _ => None,
        };
        (report.failures, told)
    }

    #[test]
    fn a_limit_that_is_not_proved_is_a_failure() {
        assert_eq!(read(600_000_000), (0, None));
        assert_eq!(read(450_000_000), (1, Some("undecided".to_owned())));
        assert_eq!(read(300_000_000), (1, Some("refuted".to_owned())));
    }
}
