//! The study of an S-net for the terminal.

use super::Study;
use std::fmt::Write;

/// How many lines of one kind are shown.
const SHOWN: usize = 12;

/// All that was found.
#[must_use]
pub fn render(study: &Study<'_>) -> String {
    let (diagram, check) = (study.diagram, study.check);
    let mut out = String::new();
    let name = if diagram.name.is_empty() { &diagram.pages[0].name } else { &diagram.name };
    let _ = writeln!(out, "net {name}  {}", diagram.file);
    let _ = writeln!(out, "  {}", study.contents());
    let known = |complete: bool| {
        if complete { "all there are" } else { "the search ended before it had all" }
    };
    let markings = &check.markings;
    let _ = writeln!(
        out,
        "  the net's rule: {} seen, {}; {} dead",
        counted(markings.count, "marking"),
        known(markings.complete),
        markings.dead_count
    );
    let code = &check.code;
    let _ = writeln!(
        out,
        "  the code's rule: {} seen, {}; {}",
        counted(code.count, "state"),
        known(code.complete),
        if !code.divergences.is_empty() {
            "code and net part"
        } else if code.complete {
            "the code follows the net in every scan"
        } else if code.undecided.is_empty() {
            "the code follows the net in every scan, by gates and place invariants"
        } else {
            "no scan was found in which code and net part"
        }
    );
    structure(study, &mut out);
    let found = study.found();
    if !found.is_empty() {
        out += "  to look at\n";
    }
    for one in found {
        let mark = if one.is_error { "error" } else { "note" };
        let _ = writeln!(out, "    {mark}, line {}: {}", one.line, one.message);
        if let Some((start, run)) = &one.run {
            let _ = writeln!(out, "      run: {start}");
            for step in shortened(run) {
                let _ = writeln!(out, "           {step}");
            }
        }
        let _ = writeln!(out, "      {}", one.help);
    }
    if !markings.unseen.is_empty() {
        let names: Vec<String> = markings.unseen.iter().map(|&at| study.transition(at)).collect();
        let _ = writeln!(out, "  not seen to fire, as far as was looked: {}", names.join(", "));
    }
    out
}

/// A long run without its middle.
fn shortened(run: &[String]) -> Vec<String> {
    if run.len() <= SHOWN {
        return run.to_vec();
    }
    let (front, back) = (&run[..SHOWN / 2], &run[run.len() - SHOWN / 3..]);
    let left = run.len() - front.len() - back.len();
    let middle = format!("... {left} steps more (--format json has all)");
    [front, &[middle], back].concat()
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn list(out: &mut String, heading: &str, lines: Vec<String>) {
    if lines.is_empty() {
        return;
    }
    let _ = writeln!(out, "  {heading}");
    for line in lines.iter().take(SHOWN) {
        let _ = writeln!(out, "    {line}");
    }
    if lines.len() > SHOWN {
        let _ = writeln!(out, "    and {} more (--format json has all)", lines.len() - SHOWN);
    }
}

fn structure(study: &Study<'_>, out: &mut String) {
    let arcs = &study.check.structure;
    let has_stops = study.diagram.transitions.iter().any(|one| one.is_stop);
    let equals = if has_stops { "at most" } else { "always" };
    let places = arcs.place_invariants.iter();
    let places = places.map(|one| {
        format!("{}: {equals} {}", study.sum(&one.weights, |at| study.place(at)), one.sum)
    });
    list(out, "place invariants", places.collect());
    let cycles = arcs.transition_invariants.iter();
    let cycles = cycles.map(|one| study.sum(one, |at| study.transition(at)));
    list(out, "transition invariants (firings after which all is as before)", cycles.collect());
    let names = |places: &[usize]| -> String {
        places.iter().map(|&at| study.place(at)).collect::<Vec<_>>().join(", ")
    };
    let siphons = arcs.siphons.iter().map(|one| {
        let end =
            if one.is_kept { "a marked trap keeps it from getting empty" } else { "can get empty" };
        format!("{}: {end}", names(&one.places))
    });
    list(out, "siphons (once empty, empty for good)", siphons.collect());
    list(
        out,
        "traps (once marked, marked for good)",
        arcs.traps.iter().map(|one| names(one)).collect(),
    );
    if !arcs.complete {
        *out += "  there are more siphons or traps than were searched out\n";
    }
}
