//! Pages of tables: a comparison, two versions, several projects. They need no script.

use super::frame::{WIDTH, escaped, framed};
use crate::compare::text as compare;
use crate::diff::text as diff;
use crate::format::{Checked, Checks, Extent, Project};
use crate::text;
use scanbound_audit::difference::{ChangeKind, Difference, Side};
use scanbound_base::time::Picos;
use scanbound_base::time_text::at_most;
use scanbound_measured::Comparison;
use std::io::{self, Write};

/// A cell: what it says, and of which class it is.
struct Cell(String, &'static str);

fn told(what: impl Into<String>) -> Cell {
    Cell(escaped(&what.into()), "")
}

fn number(what: impl Into<String>) -> Cell {
    Cell(escaped(&what.into()), "n")
}

fn code(what: &str) -> Cell {
    let lines: Vec<String> =
        what.split(" / ").map(|one| format!("<code>{}</code>", escaped(one))).collect();
    Cell(lines.join("<br>"), "")
}

/// A part of the page: a heading and a table under heads, those of numbers with `>` in front.
fn section(title: &str, heads: &[&str], rows: Vec<Vec<Cell>>) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let head = |one: &&str| match one.strip_prefix('>') {
        Some(name) => format!("<th class=\"n\">{}</th>", escaped(name)),
        None => format!("<th>{}</th>", escaped(one)),
    };
    let heads: String = heads.iter().map(head).collect();
    let cell = |Cell(what, class): Cell| match class {
        "" => format!("<td>{what}</td>"),
        class => format!("<td class=\"{class}\">{what}</td>"),
    };
    let row = |row: Vec<Cell>| {
        let cells: String = row.into_iter().map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.into_iter().map(row).collect();
    format!(
        "<h2>{}</h2>\n<div class=\"scroll\"><table><tr>{heads}</tr>\n{rows}</table></div>\n",
        escaped(title)
    )
}

fn page(title: &str, answer: &str, class: &str, sections: &[String]) -> String {
    let body = format!(
        "<main>\n<h1>{}</h1>\n<div class=\"answer {class}\">{}</div>\n{}<p class=\"faint\">scanbound {}</p>\n</main>",
        escaped(title),
        escaped(answer.trim_end()),
        sections.concat(),
        env!("CARGO_PKG_VERSION")
    );
    framed(title, &body)
}

fn plain(text: &str) -> String {
    anstream::adapter::strip_str(text).to_string()
}

/// Measured scan times against the bound.
pub(super) fn comparison(found: &Comparison) -> String {
    let heads = ["what", ">time", ">of the bound", ""];
    let figure = |row: compare::Figure| {
        vec![told(row.name), number(row.time), number(row.share), told(row.note)]
    };
    let figures = compare::figure_rows(found).into_iter().map(figure).collect();
    let most = found.histogram.bins.iter().map(|bin| bin.count).max().unwrap_or(1).max(1);
    let bin = |bin: &scanbound_measured::Bin| {
        let share = (bin.count * 100).div_ceil(most);
        let bar = format!(
            "<svg width=\"200\" height=\"10\"><rect width=\"{}\" height=\"10\" fill=\"currentColor\"/></svg>",
            share * 2
        );
        vec![
            number(format!("{} us", bin.from.us_text())),
            number(bin.count.to_string()),
            Cell(bar, ""),
        ]
    };
    let bins = found.histogram.bins.iter().map(bin).collect();
    let notes = compare::notes(found).into_iter().map(|note| vec![told(note)]).collect();
    let class = if found.above.is_some() { "refuted" } else { "proved" };
    let title = format!("{}: measured scan times against the bound", found.files.join(", "));
    let from = vec![vec![
        told(&found.measured.file),
        number(found.figures.count.to_string()),
        told(&found.measured.how),
    ]];
    let histogram = format!("Scans by their time, {} a line", found.histogram.width);
    let whole = format!(
        "<details><summary>The report as text</summary><pre>{}</pre></details>\n",
        escaped(&plain(&compare::render(found)))
    );
    page(
        &title,
        &compare::answer(found),
        class,
        &[
            section("Measured", &["file", ">scans", "how"], from),
            section("Figures", &heads, figures),
            section(&histogram, &[">from", ">scans", ""], bins),
            section("What this can mean", &["note"], notes),
            whole,
        ],
    )
}

/// Two versions, and what each change costs.
pub(super) fn difference(found: &Difference) -> String {
    let time = |side: &Option<Side>| side.as_ref().map_or(String::new(), |one| at(one.time));
    let text = |side: &Option<Side>| code(side.as_ref().map_or("", |one| one.text.as_str()));
    let shown =
        found.changes.iter().filter(|one| one.kind != ChangeKind::Moved || one.delta() != 0);
    let mut rows: Vec<Vec<Cell>> = shown
        .map(|one| {
            let kind = match one.kind {
                ChangeKind::Same => "runs otherwise in the longest scan",
                kind => kind.name(),
            };
            vec![
                number(diff::signed(one.delta())),
                told(diff::place(one)),
                told(kind),
                number(time(&one.old)),
                number(time(&one.new)),
                text(&one.old),
                text(&one.new),
            ]
        })
        .collect();
    if found.besides != 0 {
        let what = "END processing and the like, the factor, what the search left open";
        let empty = || told("");
        let delta = number(diff::signed(found.besides));
        let row =
            vec![delta, told("outside rungs"), empty(), empty(), empty(), empty(), told(what)];
        rows.push(row);
    }
    let heads = [">bound", "where", "what", ">before", ">after", "said before", "says now"];
    let class = match (found.allowed, found.is_above()) {
        (_, true) => "refuted",
        (Some(_), false) => "proved",
        (None, false) => "",
    };
    let versions = vec![
        vec![told("old"), number(at(found.old)), told(found.old_files.join(", "))],
        vec![told("new"), number(at(found.new)), told(found.new_files.join(", "))],
    ];
    let doubt = match found.is_doubtful {
        true => "\nWhat is not stated may make the bounds too low: scanbound audit says what.",
        false => "",
    };
    page(
        "Two versions of a program",
        &(diff::answer(found) + doubt),
        class,
        &[
            section("Versions", &["version", ">bound", "files"], versions),
            section("What changes the bound", &heads, rows),
            format!("<p>{}</p>\n", escaped(&diff::counts(found))),
        ],
    )
}

fn at(time: Picos) -> String {
    at_most(time)
}

/// Several projects: a row each, and what each report says.
#[derive(Default)]
pub(super) struct All {
    rows: Vec<Vec<Cell>>,
    texts: String,
}

impl Checks for All {
    fn add(&mut self, project: &Project<'_>, extent: Extent, _: &mut dyn Write) -> io::Result<()> {
        let extent = Extent { width: WIDTH, height: usize::MAX, ..extent };
        let (verdict, bound, limit, text) = match &project.checked {
            Checked::Audited(audit, check) => (
                check.verdict.name(),
                match audit.unbounded.is_empty() {
                    true => at(audit.upper_with_all_points()),
                    false => String::new(),
                },
                at(check.limit),
                plain(&text::render(audit, Some(check), extent)),
            ),
            Checked::Faulty(faults) => {
                let all: Vec<String> = faults.iter().map(|one| one.brief()).collect();
                ("not checked", String::new(), String::new(), all.join("\n"))
            }
            Checked::Failed(why) => ("not checked", String::new(), String::new(), why.clone()),
        };
        self.rows.push(vec![told(project.file), told(verdict), number(bound), number(limit)]);
        self.texts += &format!(
            "<details><summary>{}: {verdict}</summary><pre>{}</pre></details>\n",
            escaped(project.file),
            escaped(&text)
        );
        Ok(())
    }

    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        let proved = self.rows.iter().filter(|row| row[1].0 == "proved").count();
        let class = if proved == self.rows.len() { "proved" } else { "refuted" };
        let answer = format!("{proved} of {} projects keep to their limits.", self.rows.len());
        let heads = ["project", "verdict", ">bound", ">limit"];
        let sections = [
            section("Projects", &heads, std::mem::take(&mut self.rows)),
            format!("<h2>Reports</h2>\n{}", self.texts),
        ];
        write!(out, "{}", page("Scan times", &answer, class, &sections))
    }
}
