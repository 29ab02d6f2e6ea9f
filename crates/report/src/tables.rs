//! Timing tables as text: the list of them, one of them.

use super::columns::{Cell, columns, left, right};
use anstyle::Style;
use scanbound_timing::table::builtin::TableSummary;
use scanbound_timing::table::{Evidence, Table};

const BOLD: Style = Style::new().bold();

/// The built-in tables, one a line.
#[must_use]
pub fn list(tables: &[TableSummary]) -> String {
    let mut rows = vec![vec![
        left("table").styled(BOLD),
        right("published").styled(BOLD),
        right("measured").styled(BOLD),
        right("assumed").styled(BOLD),
        left("for").styled(BOLD),
    ]];
    for table in tables {
        let count = |evidence: Evidence| {
            let found = table.rows.iter().find(|(kind, _)| *kind == evidence);
            right(found.map_or(0, |(_, count)| *count).to_string())
        };
        rows.push(vec![
            left(table.name),
            count(Evidence::Published),
            count(Evidence::Measured),
            count(Evidence::Assumed),
            left(&table.title),
        ]);
    }
    columns(0, &rows)
}

/// One table: what it is for, what it leaves out, its rows.
#[must_use]
pub fn one(table: &Table) -> String {
    let mut head: Vec<Vec<Cell>> = vec![vec![left("table").styled(BOLD), left(&table.name)]];
    let mut put = |name: &str, value: String| {
        if !value.is_empty() {
            head.push(vec![left(name).styled(BOLD), left(value)]);
        }
    };
    put("for", table.title.clone());
    put("CPUs", table.cpus.join(" "));
    put("date", table.date.clone().unwrap_or_default());
    put("family", table.family.clone().unwrap_or_default());
    put("amends", table.base.clone().unwrap_or_default());
    if let Some(factor) = &table.factor {
        put(
            "factor",
            format!("{} on the whole scan, {}: {}", factor.text, factor.evidence, factor.source),
        );
    }
    let sides = [("most inputs", &table.most_inputs), ("most outputs", &table.most_outputs)];
    for (side, most) in sides {
        let text = most
            .as_ref()
            .map(|most| format!("{} points, {}: {}", most.points, most.evidence, most.source));
        put(side, text.unwrap_or_default());
    }
    for note in &table.notes {
        put("note", note.clone());
    }
    let titles = ["instruction", "on us", "off us", "per unit us", "unit", "evidence", "source"];
    let mut rows = vec![titles.map(|title| left(title).styled(BOLD)).to_vec()];
    rows.extend(table.rows().iter().map(|row| {
        let per_unit = if row.unit.is_empty() { String::new() } else { row.per_unit.us_text() };
        vec![
            left(&row.name),
            right(row.on.us_text()),
            right(row.off.us_text()),
            right(per_unit),
            left(&row.unit),
            left(row.evidence.word()),
            left(&row.source),
        ]
    }));
    columns(0, &head) + "\n" + &columns(0, &rows)
}

/// What to say of a table that has no faults.
#[must_use]
pub fn checked(table: &Table) -> String {
    let counts: Vec<String> = Evidence::ALL
        .into_iter()
        .filter(|&evidence| table.count(evidence) > 0)
        .map(|evidence| format!("{} {evidence}", table.count(evidence)))
        .collect();
    format!("{}: {} rows, {}\n", table.name, table.rows().len(), counts.join(", "))
}
