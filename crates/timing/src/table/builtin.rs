//! The built-in timing tables, and which of them belongs to the name of a CPU.

use std::collections::BTreeSet;
use std::sync::OnceLock;

use super::{Evidence, Table};
use scanbound_base::suggestion;
use scanbound_base::time::Picos;

/// The name and text of each file under `timing-tables`, sorted by name.
const FILES: [(&str, &str); 19] = [
    ("c200h", include_str!("../../timing-tables/c200h.csv")),
    ("cj2m", include_str!("../../timing-tables/cj2m.csv")),
    ("cp1l", include_str!("../../timing-tables/cp1l.csv")),
    ("flowchart-pc", include_str!("../../timing-tables/flowchart-pc.csv")),
    ("fx2n", include_str!("../../timing-tables/fx2n.csv")),
    ("fx3u", include_str!("../../timing-tables/fx3u.csv")),
    ("fx5u", include_str!("../../timing-tables/fx5u.csv")),
    ("iec", include_str!("../../timing-tables/iec.csv")),
    ("iqr", include_str!("../../timing-tables/iqr.csv")),
    ("l02", include_str!("../../timing-tables/l02.csv")),
    ("l26", include_str!("../../timing-tables/l26.csv")),
    ("minasec-u", include_str!("../../timing-tables/minasec-u.csv")),
    ("q00u", include_str!("../../timing-tables/q00u.csv")),
    ("q02", include_str!("../../timing-tables/q02.csv")),
    ("q02h", include_str!("../../timing-tables/q02h.csv")),
    ("q02u", include_str!("../../timing-tables/q02u.csv")),
    ("q03ud", include_str!("../../timing-tables/q03ud.csv")),
    ("qnudeh", include_str!("../../timing-tables/qnudeh.csv")),
    ("qnudv", include_str!("../../timing-tables/qnudv.csv")),
];

/// The parsed tables. Each is parsed when it is first needed; a test parses them all. None amends another.
static TABLES: [OnceLock<Option<Table>>; FILES.len()] = [const { OnceLock::new() }; FILES.len()];

fn table(index: usize) -> Option<&'static Table> {
    let (name, text) = FILES[index];
    let read = || Table::parse(name, text.as_bytes()).ok().map(|parsed| parsed.table);
    TABLES[index].get_or_init(read).as_ref()
}

/// The second fields of the rows that begin with `row` (a line break, a name and a comma: `"\n@cpu,"`), from a built-in
/// table's text. Much faster than parsing the table.
fn cells<'a>(text: &'a str, row: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(row).skip(1).map(|rest| rest.split([',', '\n']).next().unwrap_or_default().trim())
}

/// The CPUs that a built-in table's text lists.
fn cpus(text: &str) -> impl Iterator<Item = &str> {
    cells(text, "\n@cpu,").flat_map(str::split_whitespace)
}

/// The CPU families for which there are built-in tables.
pub(super) fn families() -> BTreeSet<&'static str> {
    FILES.iter().flat_map(|(_, text)| cells(text, "\n@family,")).collect()
}

fn tables() -> impl Iterator<Item = (&'static str, &'static Table)> {
    FILES.iter().enumerate().filter_map(|(index, (name, _))| Some((*name, table(index)?)))
}

/// The maximum number of CPUs with similar names that are suggested.
const MAX_SIMILAR: usize = 4;

/// One line of the list of built-in tables.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableSummary {
    /// The name that `--table` takes.
    pub name: &'static str,
    /// The title of the table, one line.
    pub title: String,
    /// The names of the CPUs for which the table is.
    pub cpus: Vec<String>,
    /// The number of rows with each kind of evidence, in the order of [`Evidence::ALL`].
    pub rows: [(Evidence, usize); 4],
}

/// The names of the built-in tables, sorted.
#[must_use]
pub fn names() -> Vec<&'static str> {
    FILES.iter().map(|(name, _)| *name).collect()
}

/// The names of the built-in tables, each with the date of its last change as the table states it; empty if it states
/// none.
pub fn dates() -> impl Iterator<Item = (&'static str, &'static str)> {
    let dated = |&(name, text): &(&'static str, &'static str)| {
        (name, cells(text, "\n@date,").next().unwrap_or_default())
    };
    FILES.iter().map(dated)
}

/// The built-in tables of a family, sorted by name.
#[must_use]
pub fn of_family(family: &str) -> Vec<Table> {
    let is_own = |(_, table): &(&str, &Table)| table.family.as_deref() == Some(family);
    tables().filter(is_own).map(|(_, table)| table.clone()).collect()
}

/// The CSV text of the built-in table of this name. Letter case is ignored. `None` if there is none.
#[must_use]
pub fn text(name: &str) -> Option<&'static str> {
    FILES.iter().find(|(own, _)| own.eq_ignore_ascii_case(name.trim())).map(|(_, text)| *text)
}

/// The list of all built-in tables.
#[must_use]
pub fn list() -> Vec<TableSummary> {
    tables()
        .map(|(name, table)| TableSummary {
            name,
            title: table.title.clone(),
            cpus: table.cpus.clone(),
            rows: Evidence::ALL.map(|evidence| (evidence, table.count(evidence))),
        })
        .collect()
}

impl Table {
    /// The built-in table of this name. Letter case is ignored. `None` if there is none.
    #[must_use]
    pub fn builtin(name: &str) -> Option<Table> {
        let index = FILES.iter().position(|(own, _)| own.eq_ignore_ascii_case(name.trim()))?;
        table(index).cloned()
    }

    /// The name of the built-in table for a CPU as a source file names it. If the name means several CPUs (`Q02(H)`),
    /// the table of the slowest, by the on-time of MOV. `None` if no table is for this CPU.
    #[must_use]
    pub fn for_cpu(cpu: &str) -> Option<&'static str> {
        let possible = possible_cpus(cpu);
        let slowness = |table: &Table| table.row("MOV").map_or(Picos::ZERO, |row| row.on);
        let is_meant =
            |text: &str| cpus(text).any(|cpu| possible.iter().any(|possible| possible == cpu));
        FILES
            .iter()
            .enumerate()
            .filter(|(_, (_, text))| is_meant(text))
            .filter_map(|(index, (name, _))| Some((*name, table(index)?)))
            .max_by_key(|(_, table)| slowness(table))
            .map(|(name, _)| name)
    }

    /// What to do if the timing tables do not have this CPU: the help of an error message.
    #[must_use]
    pub fn advice(cpu: &str) -> String {
        let shared = |name: &str| {
            let alike =
                |own: &String| own.chars().zip(name.chars()).take_while(|(a, b)| a == b).count();
            possible_cpus(cpu).iter().map(alike).max().unwrap_or(0)
        };
        let tables = list();
        let all =
            || tables.iter().flat_map(|table| table.cpus.iter().map(move |own| (own, table.name)));
        let most = all().map(|(own, _)| shared(own)).max().unwrap_or(0);
        // Two common letters are weak evidence of similarity, but better than none.
        let near: Vec<String> = all()
            .filter(|(own, _)| most >= 2 && shared(own) == most)
            .take(MAX_SIMILAR)
            .map(|(own, table)| format!("{own} (table {table})"))
            .collect();
        let near = match near.as_slice() {
            [] => String::new(),
            near => {
                format!(
                    "; similar names: {}: compare the CPUs' speeds before you use one",
                    near.join(", ")
                )
            }
        };
        // Different letters may mean another, slower CPU. The same letters in another order are a typing error.
        let slip = all().find(|(own, _)| {
            possible_cpus(cpu).iter().any(|one| suggestion::is_reordered(one, own))
        });
        let slip = slip.map(|(own, _)| own.clone());
        let advice = format!(
            "give a table with --table: a built-in one ({}) or your own file{near}",
            names().join(", ")
        );
        suggestion::with_suggestion(slip, &advice)
    }
}

/// The CPUs that a written name can mean: `FX3U/FX3UC`, `FX3U(C)`, `Q26UDVCPU`. For the order name of a unit
/// (`CJ2M-CPU31`, `CP1L-M40DR-A`, `FX3U-32MR/ES`) this is the series, unless the whole is a name in a table (`L26-BT`).
fn possible_cpus(cpu: &str) -> Vec<String> {
    let mut names = Vec::new();
    for part in cpu.to_ascii_uppercase().replace("CPU", "").split(['/', ',', ' ']) {
        match part.split_once('(') {
            Some((stem, rest)) => {
                let rest: String = rest.chars().filter(|c| *c != ')').collect();
                names.push(stem.to_owned());
                names.push(format!("{stem}{rest}"));
            }
            None => names.push(part.to_owned()),
        }
    }
    names.retain(|name| !name.is_empty());
    if !FILES.iter().any(|(_, text)| cpus(text).any(|cpu| names.iter().any(|name| name == cpu))) {
        let stem = |name: &String| Some(name.split_once(['-', '_'])?.0.to_owned());
        let stems: Vec<String> = names.iter().filter_map(stem).collect();
        names.extend(stems.into_iter().filter(|stem| !stem.is_empty()));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cpus_are_found_without_reading_the_rest() {
        for (index, (name, text)) in FILES.iter().enumerate() {
            let own = &table(index).expect("it reads").cpus;
            assert!(!own.is_empty() && cpus(text).eq(own.iter().map(String::as_str)), "{name}");
        }
    }
}
