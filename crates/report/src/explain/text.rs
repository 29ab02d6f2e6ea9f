//! What is known of an instruction as text.

use crate::columns::{Cell, fitted, left, paint, right};
use crate::format::Extent;
use crate::wrap;
use anstyle::Style;
use scanbound_audit::explain::{ExplainedInstruction, Follow, FormUse};
use scanbound_base::time::Picos;
use scanbound_timing::table::Row;

const BOLD: Style = Style::new().bold();

/// An instruction by one table, all that is known. Has colour codes.
#[must_use]
pub fn one(found: &ExplainedInstruction, extent: Extent) -> String {
    let mut text =
        paint(BOLD, &format!("{}  table {}: {}", found.name, found.table, found.title)) + "\n";
    for form in &found.forms {
        text += &format!("\n{}\n", paint(BOLD, &form.line));
        let mut rows = times(form);
        rows.push(vec![left("follows"), left(follow(form.follow))]);
        rows.extend(form.approximations.iter().map(|told| vec![left("note"), left(told)]));
        text += &fitted(2, &rows, extent.width);
    }
    let mut notes = Vec::new();
    if !found.extras.is_empty() {
        let extras: Vec<String> = found.extras.iter().map(extra).collect();
        notes.push(format!("operands may add: {}", extras.join("; ")));
    }
    if let Some(factor) = &found.factor {
        notes.push(format!(
            "a scan is charged {} times the sum of all ({})",
            factor.text, factor.evidence
        ));
    }
    if !found.variants.is_empty() {
        notes.push(format!("variants: {}", found.variants.join(", ")));
    }
    if !notes.is_empty() {
        text.push('\n');
    }
    for note in notes {
        let lines = wrap::lines(&note, extent.width.saturating_sub(2)).join("\n  ");
        text += &format!("{lines}\n");
    }
    text
}

/// An instruction by several tables, a row each.
#[must_use]
pub fn several(found: &[ExplainedInstruction], extent: Extent) -> String {
    let Some(first) = found.first() else { return String::new() };
    let told = format!(
        "{} by {} timing tables; --cpu or --table tells all of one",
        first.name,
        found.len()
    );
    let mut text = paint(BOLD, wrap::paragraph(0, &told, extent.width).trim_end()) + "\n\n";
    let heads = ["table", "line", "runs", "does not", "evidence", "follows"];
    let mut rows = vec![heads.map(|head| left(head).styled(BOLD)).to_vec()];
    for one in found {
        for (place, form) in one.forms.iter().enumerate() {
            let name = if place == 0 { one.table.as_str() } else { "" };
            let price = form.price.as_ref();
            let time =
                |time: Option<Picos>| right(time.map_or("none".to_owned(), Picos::best_text));
            rows.push(vec![
                left(name),
                left(&form.line),
                time(price.map(|price| price.on)),
                time(price.map(|price| price.off)),
                left(price.map_or("", |price| price.evidence.word())),
                left(form.follow.name()),
            ]);
        }
    }
    text += &fitted(0, &rows, extent.width);
    text
}

/// The times of a form and where they come from.
fn times(form: &FormUse) -> Vec<Vec<Cell>> {
    let Some(price) = &form.price else {
        let name = form.line.split(' ').next().unwrap_or_default();
        return vec![vec![left("time"), left(format!("none in this table: --time {name}=12.5us"))]];
    };
    let mut rows = vec![
        vec![left("runs"), left(price.on.best_text())],
        vec![left("does not run"), left(price.off.best_text())],
    ];
    for row in &form.rows {
        let class = if form.by_class && row.name.starts_with('@') && !row.name.starts_with("@+") {
            " (the row of its class)"
        } else {
            ""
        };
        rows.push(vec![left("row"), left(format!("{}{class}: {}", row.name, parts(row)))]);
        let source =
            if row.source.is_empty() { String::new() } else { format!(": {}", row.source) };
        rows.push(vec![left("evidence"), left(format!("{}{source}", row.evidence))]);
    }
    rows
}

/// The base and per-unit parts of a row.
fn parts(row: &Row) -> String {
    let unit = if row.unit.is_empty() { "unit" } else { row.unit.as_str() };
    match row.per_unit {
        Picos::ZERO => row.on.best_text(),
        each => format!("{} and {} for each {unit}", row.on.best_text(), each.best_text()),
    }
}

fn extra(row: &Row) -> String {
    format!("{} {}", row.name.trim_start_matches("@+"), parts(row))
}

fn follow(follow: Follow) -> &'static str {
    match follow {
        Follow::Nothing => "it writes no device",
        Follow::Exactly => "exactly: the bound knows what it writes, and when",
        Follow::Range => {
            "its result is any value in the bound's model; where it counts or is an index, the range that it can be in is worked out (docs/values.md); a lower bound's scan carries it out"
        }
        Follow::RealRuns => "its result is any value; a lower bound's scan carries it out",
        Follow::Outside => "its result comes from outside: any value",
        Follow::Unknown => {
            "its result is any value, and a scan whose path depends on it is no lower bound"
        }
    }
}
