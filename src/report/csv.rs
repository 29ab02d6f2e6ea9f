//! An audit as CSV: a row a charge, for spreadsheets.

use super::compare;
use super::format::Format;
use crate::audit::{Audit, ChargeUse};
use crate::base::time::Picos;
use csv::Writer;
use std::io;

/// A table for spreadsheets.
pub const FORMAT: Format = Format {
    name: "csv",
    about: "A row a charge, for spreadsheets",
    suffixes: &["csv"],
    audit: |audit, _, _, out| write(audit, out),
    compare: |found, out| out.write_all(compare::csv::render(found).as_bytes()),
};

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

fn write(audit: &Audit, out: &mut dyn io::Write) -> io::Result<()> {
    let mut writer = Writer::from_writer(out);
    // As it was met: where the reader has gone away, that must still be seen.
    let fault = |error: csv::Error| match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    };
    let mut put = |row: &[String]| writer.write_record(row).map_err(fault);
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
    writer.flush()
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
    use crate::audit::fixture::fixture;

    #[test]
    fn the_fixture_as_csv() {
        insta::assert_snapshot!(super::render(&fixture()));
    }
}
