//! Results as Markdown: a job's summary in a pipeline.

use super::diff::text as diff;
use super::findings;
use super::format::{Extent, Format, InARow};
use super::text::{next, parts, screen, verdict};
use scanbound_audit::Audit;
use scanbound_audit::breakdown::By;
use scanbound_audit::difference::{Change, Difference};
use scanbound_audit::verdict::Check;
use std::io::{self, Write};

/// A page for a job's summary or a merge request.
pub const FORMAT: Format = Format {
    name: "markdown",
    about: "A job's summary",
    suffixes: &["md"],
    draws: false,
    escapes: false,
    audit: |audit, check, extent, out| out.write_all(render(audit, check, extent).as_bytes()),
    compare: |found, out| compared(&findings::of_comparison(found), out),
    diff: |found, extent, out| out.write_all(difference(found, extent).as_bytes()),
    checks: || {
        Box::new(InARow {
            heading: |file| format!("# {}\n\n", escaped(file)),
            fault: |what| format!("- {}\n", escaped(what)),
            audit: FORMAT.audit,
        })
    },
    tells_faults: false,
};

fn render(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
    let answer = verdict::answer(audit, check);
    let mut text = format!("## Scan time\n\n{}\n\n", answer.markdown());
    for reason in verdict::reasons(check) {
        text += &format!("- {}\n", escaped(&reason));
    }
    text += "\n| | |\n|---|---|\n";
    for fact in screen::facts(audit, check) {
        text += &format!("| {} | {} |\n", fact.label, escaped(&fact.told));
    }
    let by = extent.by.unwrap_or(By::Rung);
    text += &format!("\n### Where the time goes, by {}\n\n", by.name());
    text += "| time | share | what | |\n|--:|--:|---|---|\n";
    for row in parts::shown(audit, by, extent.top, extent.by.is_none()) {
        let code = if row.is_code {
            format!("`{}`{}", row.text.replace('`', "'").replace('|', "\\|"), row.rest)
        } else {
            escaped(&row.text)
        };
        text += &format!("| {} | {} | {} | {code} |\n", row.told, row.share, escaped(&row.what));
    }
    let steps = next::steps(audit);
    if !steps.is_empty() {
        text += "\n### What to do next\n\n";
        for step in steps {
            text += &format!("- {}\n", escaped(&step));
        }
    }
    text
}

fn compared(found: &[findings::Finding], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "## Measured scan times\n")?;
    for one in found {
        writeln!(out, "{}", escaped(&one.message))?;
    }
    Ok(())
}

fn difference(found: &Difference, extent: Extent) -> String {
    let mut text = format!("## Scan time\n\n**{}**\n\n", escaped(&diff::answer(found)));
    text += "| bound | where | what |\n|--:|---|---|\n";
    let differing = found.changes.iter().filter(|one| one.delta() != 0);
    for one in differing.clone().take(extent.top) {
        let (delta, place) = (diff::signed(one.delta()), escaped(&diff::place(one)));
        text += &format!("| {delta} | {place} | {} |\n", escaped(&diff::words(one)));
    }
    let rest: Vec<i128> = differing.skip(extent.top).map(Change::delta).collect();
    if !rest.is_empty() {
        let delta = diff::signed(rest.iter().sum());
        text += &format!("| {delta} | | {} other changes |\n", rest.len());
    }
    text + &format!("| {} | | outside rungs |\n", diff::signed(found.besides))
}

/// The text so that nothing in it is taken for markup.
fn escaped(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    for letter in text.chars() {
        if matches!(letter, '|' | '*' | '_' | '`' | '<' | '>' | '[' | ']' | '\\' | '#') {
            kept.push('\\');
        }
        kept.push(letter);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use scanbound_audit::fixture::fixture;

    #[test]
    fn the_fixture_as_a_summary() {
        insta::assert_snapshot!(render(&fixture(), None, Extent::default()));
    }

    #[test]
    fn nothing_is_taken_for_markup() {
        assert_eq!(escaped("LD< D0 [x] a|b"), "LD\\< D0 \\[x\\] a\\|b");
    }
}
