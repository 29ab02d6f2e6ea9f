//! An audit as CSV: a row a charge, for spreadsheets.

use super::format::{Checked, Checks, Extent, Format, Project};
use super::sheet::Sheet;
use super::{compare, diff};
use scanbound_audit::breakdown::{By, Piece};
use scanbound_audit::{Audit, ChargeUse};
use scanbound_base::time::Picos;
use std::io;

/// A table for spreadsheets.
pub const FORMAT: Format = Format {
    name: "csv",
    about: "A row a charge, for spreadsheets",
    suffixes: &["csv"],
    draws: false,
    escapes: false,
    audit: |audit, _, extent, out| match extent.by {
        Some(by) => write_parts(audit, by, out),
        None => write(audit, out),
    },
    compare: |found, out| out.write_all(compare::csv::render(found).as_bytes()),
    diff: |found, _, out| diff::csv::write(found, out),
    checks: || Box::<All>::default(),
    tells_faults: false,
};

const PROJECT_HEADS: [&str; 7] =
    ["project", "verdict", "exit_code", "limit_us", "upper_us", "lower_us", "told"];

/// A row a project.
#[derive(Default)]
struct All(Vec<[String; 7]>);

impl Checks for All {
    fn add(&mut self, project: &Project<'_>, _: Extent, _: &mut dyn io::Write) -> io::Result<()> {
        let [mut verdict, mut limit, mut upper, mut lower, mut told] = [const { String::new() }; 5];
        match &project.checked {
            Checked::Audited(audit, check) => {
                verdict = check.verdict.name().to_owned();
                limit = check.limit.us_text();
                if audit.unbounded.is_empty() {
                    upper = audit.upper_with_all_points().us_text();
                }
                lower = audit.lower_without_points().us_text();
            }
            Checked::Faulty(faults) => {
                let all: Vec<String> = faults.iter().map(|one| one.brief()).collect();
                told = all.join("; ");
            }
            Checked::Failed(why) => told.clone_from(why),
        }
        let code = project.exit_code.to_string();
        self.0.push([project.file.to_owned(), verdict, code, limit, upper, lower, told]);
        Ok(())
    }

    fn end(&mut self, out: &mut dyn io::Write) -> io::Result<()> {
        let mut sheet = Sheet::new(out)?;
        sheet.put(&PROJECT_HEADS)?;
        for row in &self.0 {
            sheet.put(row)?;
        }
        sheet.finish()
    }
}

const HEADS: [&str; 16] = [
    "group",
    "file",
    "line",
    "step",
    "block",
    "instruction",
    "via",
    "on_us",
    "off_us",
    "reached",
    "runs",
    "cost_us",
    "evidence",
    "row",
    "part",
    "factor_us",
];

/// All charges of the audit: those of the groups, then those that no assignment changes, then the overhead, then the
/// factor on all of these, which their times hold: it has no cost of its own, each row says how much of its cost it is.
#[must_use]
pub fn render(audit: &Audit) -> String {
    let mut bytes = Vec::new();
    write(audit, &mut bytes).expect("memory takes every record");
    String::from_utf8(bytes).expect("written from strings")
}

const PART_HEADS: [&str; 12] = [
    "kind",
    "file",
    "line",
    "step",
    "rung",
    "name",
    "time_us",
    "share_percent",
    "most_us",
    "always_us",
    "instructions",
    "order",
];

/// A row a part of the bound: the column `time_us` adds up to it.
fn write_parts(audit: &Audit, by: By, out: &mut dyn io::Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    sheet.put(&PART_HEADS)?;
    for (number, part) in audit.breakdown(by).iter().enumerate() {
        let file = |index: u32| audit.files.get(index as usize).cloned().unwrap_or_default();
        let (file, at, block, name) = match &part.piece {
            Piece::Program(index) => (file(*index), None, None, String::new()),
            Piece::Routine(index, name) => {
                (file(*index), None, None, name.as_deref().unwrap_or_default().to_owned())
            }
            Piece::Rung { block, at, instruction } => {
                (file(at.file), Some(*at), Some(*block), instruction.to_string())
            }
            Piece::Instruction(name) => (String::new(), None, None, name.to_string()),
            Piece::EveryScan(name) => (String::new(), None, None, name.clone()),
            Piece::Open => (String::new(), None, None, "left open by the search".to_owned()),
            Piece::Factor(text) => (String::new(), None, None, format!("factor {text}")),
        };
        let number_of = |value: Option<u32>| value.map_or(String::new(), |value| value.to_string());
        let share = part.share(audit).0;
        sheet.put(&[
            part.piece.kind().to_owned(),
            file,
            number_of(at.map(|at| at.line)),
            number_of(at.and_then(|at| at.step)),
            number_of(block),
            name,
            part.time.us_text(),
            format!("{}.{}", share / 10, share % 10),
            part.most.us_text(),
            part.always.us_text(),
            part.instructions.to_string(),
            (number + 1).to_string(),
        ])?;
    }
    sheet.finish()
}

fn write(audit: &Audit, out: &mut dyn io::Write) -> io::Result<()> {
    let mut sheet = Sheet::new(out)?;
    let mut put = |row: &[String]| sheet.put(row);
    put(&HEADS.map(str::to_owned))?;
    for group in &audit.groups {
        for charge in &group.charges {
            put(&row(audit, charge, &group.id.to_string(), "group"))?;
        }
    }
    for charge in &audit.always {
        put(&row(audit, charge, "", "always"))?;
    }
    for term in &audit.overhead {
        let time = term.time.us_text();
        let mut fields = HEADS.map(|_| String::new());
        for (head, value) in [
            ("instruction", term.name.as_str()),
            ("on_us", &time),
            ("off_us", &time),
            ("cost_us", &time),
            ("evidence", term.evidence.word()),
            ("row", &term.name),
            ("part", "overhead"),
            ("factor_us", &factor(audit, term.time)),
        ] {
            if let Some(at) = HEADS.iter().position(|&other| other == head) {
                fields[at] = value.to_owned();
            }
        }
        put(&fields)?;
    }
    if let Some(one) = &audit.table.factor {
        let row = HEADS.map(|head| match head {
            "instruction" => format!("factor {}", one.text),
            "evidence" => one.evidence.word().to_owned(),
            "row" => "@factor".to_owned(),
            "part" => "factor".to_owned(),
            _ => String::new(),
        });
        put(&row)?;
    }
    sheet.finish()
}

fn row(audit: &Audit, charge: &ChargeUse, group: &str, part: &str) -> [String; HEADS.len()] {
    [
        group.to_owned(),
        charge.at.of(&audit.files).clone(),
        charge.at.line.to_string(),
        charge.at.step.map_or(String::new(), |step| step.to_string()),
        charge.block.to_string(),
        charge.instruction.to_string(),
        charge.via.join(" > "),
        charge.on.us_text(),
        charge.off.us_text(),
        charge.reached.to_string(),
        charge.runs.to_string(),
        charge.cost.us_text(),
        charge.evidence.word().to_owned(),
        charge.row.to_string(),
        part.to_owned(),
        factor(audit, charge.cost),
    ]
}

/// How much of a time the table's factor is.
fn factor(audit: &Audit, time: Picos) -> String {
    time.checked_sub(audit.bare(time)).unwrap_or_default().us_text()
}

#[cfg(test)]
mod tests {
    use scanbound_audit::breakdown::By;
    use scanbound_audit::fixture::fixture;
    use scanbound_base::time::Picos;

    #[test]
    fn the_parts_of_the_fixture_add_up_to_its_bound() {
        let audit = fixture();
        for by in By::ALL {
            let mut bytes = Vec::new();
            super::write_parts(&audit, by, &mut bytes).expect("memory takes all");
            let text = String::from_utf8(bytes).expect("text");
            let table = text.strip_prefix('\u{FEFF}').expect("a mark");
            let mut reader = csv::Reader::from_reader(table.as_bytes());
            let times = reader.records().map(|row| row.expect("a row")[6].to_owned());
            let sum: Picos = times.map(|us| Picos::from_us_text(&us).expect("a time")).sum();
            assert_eq!(sum, audit.bound.upper, "{}", by.name());
        }
    }

    #[test]
    fn the_fixture_as_csv() {
        insta::assert_snapshot!(super::render(&fixture()));
    }
}
