//! An audit as text for people: the bound, its parts, the groups, the scan that attains it, what it rests on.

use super::columns::{Cell, columns, left, paint, right};
use super::format::{Extent, Format};
use super::{compare, method, response};
use crate::audit::verdict::{Check, Verdict};
use crate::audit::{
    ApproximationUse, Assumption, Audit, Fact, Fate, FreeValue, GroupUse, Minor, Reason, RungUse,
    Share, Status, UnstatedPoints, Value,
};
use crate::base::budget::Cut;
use crate::base::location::Location;
use crate::base::time::Picos;
use crate::timing::table::Evidence;
use anstyle::{AnsiColor, Style};
use std::collections::BTreeMap;
use unicode_width::UnicodeWidthStr;

const BOLD: Style = Style::new().bold();
const GOOD: Style = AnsiColor::Green.on_default().bold();
const CARE: Style = AnsiColor::Yellow.on_default().bold();
const BAD: Style = AnsiColor::Red.on_default().bold();
const FAINT: Style = Style::new().dimmed();

/// Lists are wrapped to so many columns.
const WIDTH: usize = 100;
/// So many of the instructions that write a word are named.
const MOST_WRITERS: usize = 4;

/// Text to be read.
pub const FORMAT: Format = Format {
    name: "text",
    about: "To be read",
    suffixes: &["txt"],
    audit: |audit, check, extent, out| out.write_all(render(audit, check, extent).as_bytes()),
    compare: |found, out| out.write_all(compare::text::render(found).as_bytes()),
};

/// The audit, headed by the check's answer if there is one. Has colour codes.
#[must_use]
pub fn render(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
    let mut text = String::new();
    if let Some(check) = check {
        text += &answer(audit, check);
    }
    text += &head(audit);
    text += &unknowns(audit, extent);
    text += &response::section(audit);
    text += &super::path::loops(audit);
    text += &parts(audit, extent);
    for group in audit.main_groups(extent.top).0 {
        text += &self::group(audit, group, extent);
    }
    text += &witness(audit, extent);
    text += &run(audit, extent);
    text += &super::path::path(audit);
    text += &assumed(audit, extent);
    text += &list("What the table's times do not hold", &audit.table.notes);
    text += &list("What was stated and is believed", &facts(audit));
    text += &trusted(audit);
    text += &list(
        "Why the bound may be too low all the same (state it with --facts or --interrupts)",
        &shown(&audit.all_doubts()),
    );
    text += &approximations(audit, extent);
    text += &list("Warnings", &warnings(audit));
    text
}

fn answer(audit: &Audit, check: &Check) -> String {
    let (most, limit) = (audit.upper_with_all_points(), check.limit);
    let with_margin = |time: Picos| match check.margin.is_none() {
        true => String::new(),
        false => format!(" ({time} with the margin of {})", check.margin),
    };
    match &check.verdict {
        Verdict::Proved => format!(
            "{}: no scan takes longer than {most}{}{}{}, the limit is {limit}\n\n",
            paint(GOOD, "PROVED"),
            with_margin(check.upper),
            all_points(audit),
            rests(check)
        ),
        Verdict::Refuted if !audit.unbounded.is_empty() => {
            format!("{}: a scan can go round a loop without end\n\n", paint(BAD, "REFUTED"))
        }
        Verdict::Refuted => format!(
            "{}: a scan takes {}{}{}, the limit is {limit}{}; it is shown below\n\n",
            paint(BAD, "REFUTED"),
            audit.possible(),
            with_margin(check.lower),
            rests(check),
            if audit.is_reached() { "" } else { ", unless its start state is impossible" }
        ),
        Verdict::Undecided(reasons) if check.upper <= limit => {
            let doubts = reasons.iter().any(|reason| !matches!(reason, Reason::Assumed { .. }));
            let reasons: String = reasons.iter().map(|reason| format!("  {reason}\n")).collect();
            let low = if doubts { "; but the bound may be too low" } else { "; but" };
            format!(
                "{}: no scan takes longer than {most}{}{}, the limit is {limit}{low}:\n{reasons}\n",
                paint(CARE, "UNDECIDED"),
                with_margin(check.upper),
                all_points(audit)
            )
        }
        Verdict::Undecided(reasons) => {
            let reasons: String = reasons.iter().map(|reason| format!("  {reason}\n")).collect();
            format!(
                "{}: a scan takes {}{}, none is known to take more than {most}{}, the limit is {limit}\n{reasons}\n",
                paint(CARE, "UNDECIDED"),
                audit.lower_without_points(),
                with_margin(check.lower),
                with_margin(check.upper)
            )
        }
    }
}

/// On what the time that decides a check rests.
fn rests(check: &Check) -> String {
    let assumed = &check.assumed;
    match (assumed.time, assumed.at_most) {
        (Picos::ZERO, _) => String::new(),
        (_, false) => format!(" ({} of it on assumed times)", assumed.share()),
        (_, true) => format!(" (at most {} of it on assumed times)", assumed.share()),
    }
}

/// What was counted beyond the parts of the bound where points are not stated.
fn all_points(audit: &Audit) -> String {
    let counted =
        |points: &&UnstatedPoints| points.most.as_ref().is_some_and(|most| most.more > Picos::ZERO);
    let counted: Vec<_> = audit.points.iter().filter(counted).collect();
    let most = counted.iter().filter_map(|points| Some((points.side, points.most.as_ref()?)));
    let all: Vec<String> =
        most.clone().map(|(side, most)| format!("{} {side}", most.points)).collect();
    if all.is_empty() {
        return String::new();
    }
    let assumed = most.into_iter().any(|(_, most)| most.evidence == Evidence::Assumed);
    let assumed = if assumed { " (assumed)" } else { "" };
    format!(", even with all {} points that the CPU can have{assumed}", all.join(" and "))
}

fn head(audit: &Audit) -> String {
    let bound = &audit.bound;
    let time = |time: Picos| right(time.text_like(bound.naive));
    let reached = if audit.is_reached() { "; a run from power-up leads to it" } else { "" };
    let mut rows = Vec::new();
    if !audit.unbounded.is_empty() {
        rows.push(vec![
            left("longest scan").styled(BOLD),
            right("unbounded").styled(BAD),
            left("a scan can go round a loop without end"),
        ]);
        rows.push(vec![
            left("cut off"),
            right(bound.upper.best_text()),
            left("at most, every scan ended where it has gone round such a loop"),
        ]);
    } else if audit.possible() == bound.upper {
        rows.push(vec![
            left("longest scan").styled(BOLD),
            time(bound.upper).styled(BOLD),
            left(format!("exact: a scan that takes this long was found and replayed{reached}")),
        ]);
    } else {
        rows.push(vec![
            left("longest scan").styled(BOLD),
            time(bound.upper).styled(BOLD),
            left(if audit.ended_early {
                "at most: no scan takes longer; the search ended here, since the limit is decided"
            } else {
                "at most: no scan takes longer"
            }),
        ]);
        rows.push(vec![
            left(""),
            time(audit.possible()).styled(BOLD),
            left(format!("at least: a scan that takes this long was found and replayed{reached}")),
        ]);
    }
    if let Some(why) = &audit.stands_between {
        rows.push(vec![
            left("the model's"),
            time(bound.model),
            left(format!("what the model allows; between it and the scan that was found: {why}")),
        ]);
    }
    rows.push(vec![
        left("structural bound"),
        time(bound.naive),
        left(format!(
            "everything at its dearer time; exclusion takes off {}{} ({})",
            if audit.ended_early { "at least " } else { "" },
            bound.saved(),
            Share::of(bound.saved(), bound.naive)
        )),
    ]);
    rows.extend(networks(audit));
    rows.extend(response::nominal(audit));
    let mut text = columns(0, &rows);
    text.push('\n');
    let cpu = audit.cpu.as_ref().map_or(String::new(), |cpu| format!(", {cpu}"));
    let files = capped(&audit.files, 3).join(", ");
    let told = |name: &str, what: Option<String>| what.map(|what| vec![left(name), left(what)]);
    let mut rows = vec![
        vec![
            left("program"),
            left(format!(
                "{files} ({}{cpu}): {} instructions in {} rungs",
                audit.dialect, audit.instructions, audit.blocks
            )),
        ],
        vec![left("table"), left(trust(audit))],
    ];
    rows.extend(told("search", method::searched(audit)));
    rows.extend(told("confirmed", method::confirmed(audit)));
    let cut = |cut: &Cut| format!("by {} while {}: {}", cut.by, cut.stage, cut.open);
    rows.extend(audit.cuts.iter().map(|one| vec![left("ended").styled(CARE), left(cut(one))]));
    text + &columns(0, &rows)
}

/// That the refresh of networks comes on top of the bound, where nobody says how long it takes.
fn networks(audit: &Audit) -> Option<Vec<Cell>> {
    let first = audit.networks.iter().map(|one| one.first).min()?;
    let what: Vec<&str> = audit.networks.iter().map(|one| one.what.as_str()).collect();
    Some(vec![
        left("plus network refresh").styled(CARE),
        right("not stated"),
        left(format!(
            "of {}, used from {} on: [network] refresh = \"1.5ms\" or \"none\"",
            what.join(", "),
            place(audit, first)
        )),
    ])
}

fn trust(audit: &Audit) -> String {
    let table = &audit.table;
    if table.assumed.is_empty() {
        return format!("{}: every time used is published, measured or stated", table.name);
    }
    let shown: Vec<&str> = table.assumed.iter().take(6).map(|one| one.name.as_str()).collect();
    let more = if table.assumed.len() > shown.len() { ", ..." } else { "" };
    format!(
        "{}: {} of the bound rests on assumed times: {}{more}",
        table.name,
        table.assumed_share,
        shown.join(", ")
    )
}

fn parts(audit: &Audit, extent: Extent) -> String {
    let bound = &audit.bound;
    // The factor is a row of its own here, so the others are without it.
    let row = |name: String, time: Picos, what: String| {
        let share = Share::of(time, bound.upper).to_string();
        vec![left(name), right(us(time)), right(share), left(what).styled(FAINT)]
    };
    let always = "what no state of the plant changes".to_owned();
    let mut rows = vec![row("always".to_owned(), audit.bare(bound.always), always)];
    for term in &audit.overhead {
        let why = term.why.split(';').next().unwrap_or_default();
        let assumed = if term.evidence == Evidence::Assumed { " (assumed)" } else { "" };
        rows.push(row(term.name.clone(), audit.bare(term.time), format!("{why}{assumed}")));
    }
    let (shown, rest) = audit.main_groups(extent.top);
    for group in shown {
        let exact = if group.exact() { "exact" } else { "at most" };
        let what = format!("{exact}; structural {}", us(audit.bare(group.naive)));
        rows.push(row(format!("group {}", group.id), audit.bare(group.upper), what));
    }
    let small: Picos = rest.iter().map(|group| audit.bare(group.upper)).sum();
    match rest.len() {
        0 => {}
        1 => rows.push(row("1 small group".to_owned(), small, String::new())),
        n => rows.push(row(format!("{n} small groups"), small, String::new())),
    }
    if let Some(factor) = &audit.table.factor {
        let assumed = if factor.evidence == Evidence::Assumed { " (assumed)" } else { "" };
        let what = format!("on the rows above; all other times shown hold it{assumed}");
        rows.push(row(format!("factor {}", factor.text), factor.part, what));
    }
    heading("Parts of the bound") + &columns(2, &rows)
}

fn group(audit: &Audit, group: &GroupUse, extent: Extent) -> String {
    let exact =
        if group.exact() { String::from("exact") } else { format!("at least {}", us(group.lower)) };
    let mut text = heading(&format!(
        "Group {}: at most {}, {exact}; {}",
        group.id,
        us(group.upper),
        count(group.blocks.len(), "rung", "rungs")
    ));
    let ties: Vec<String> = group.ties.iter().map(|tie| named(&tie.device, &tie.comment)).collect();
    text += &wrapped("  tied by ", &capped(&ties, 10));
    let rows: Vec<Vec<Cell>> =
        group.rungs.iter().take(extent.top).map(|rung| self::rung(audit, rung)).collect();
    text += &columns(2, &rows);
    text += &more(group.rungs.len(), extent.top, "  ", "cheaper rung", "cheaper rungs");
    text
}

fn rung(audit: &Audit, rung: &RungUse) -> Vec<Cell> {
    let (fate, style) = match rung.fate {
        Fate::Runs => ("runs", GOOD),
        Fate::Partly => ("partly", CARE),
        Fate::Excluded => ("excluded", FAINT),
    };
    let time = match rung.fate {
        Fate::Runs => us(rung.cost),
        Fate::Partly => format!("{} of {}", us(rung.cost), us(rung.naive)),
        Fate::Excluded => format!("0 of {}", us(rung.naive)),
    };
    let mut what = rung.instruction.to_string();
    if rung.others > 0 {
        what += &format!(" (+{})", rung.others);
    }
    let comments = rung.comments.join(", ");
    let reason = rung.exclusion.as_ref().map(|reason| {
        let through = match reason.devices.len() {
            1..=4 => format!(" through {}", reason.devices.join(", ")),
            // So many tell nothing.
            _ => String::new(),
        };
        match reason.blocks.as_slice() {
            [] => format!("never costs more{through}"),
            [one] => format!("excluded by rung {one}{through}"),
            several => {
                let numbers: Vec<String> = several.iter().map(u32::to_string).collect();
                format!("excluded by rungs {}{through}", numbers.join(", "))
            }
        }
    });
    let notes: Vec<String> =
        [Some(comments).filter(|text| !text.is_empty()), reason].into_iter().flatten().collect();
    vec![
        left(fate).styled(style),
        right(time),
        left(format!("rung {}", rung.block)),
        left(place(audit, rung.at)),
        left(what).styled(BOLD),
        left(notes.join("; ")).styled(FAINT),
    ]
}

/// The run from power-up to the scan, if one was found.
fn run(audit: &Audit, extent: Extent) -> String {
    let scans = &audit.witness_run;
    if scans.is_empty() {
        return String::new();
    }
    let mut text = heading("How a PLC with cleared memory comes to it, from power-up");
    for (index, scan) in scans.iter().enumerate() {
        let inputs = scan.inputs.iter().map(|(name, value)| match value {
            Value::Word(number) => format!("{name} = {number}"),
            Value::Bit(_) => name.clone(),
        });
        let inputs: Vec<String> = inputs.collect();
        let inputs = match inputs.is_empty() {
            true => vec!["none on".to_owned()],
            false => capped(&inputs, extent.values),
        };
        let title = format!("  scan {:<2} {}  inputs  ", index + 1, scan.took);
        text += &wrapped(&title, &inputs);
    }
    text
}

fn witness(audit: &Audit, extent: Extent) -> String {
    let matter: Vec<&FreeValue> = audit.witness.iter().filter(|free| free.matters).collect();
    if matter.is_empty() {
        return String::new();
    }
    let title = format!(
        "The scan that takes {}: {} of {} free values matter",
        audit.bound.lower,
        matter.len(),
        audit.witness.len()
    );
    let mut text = heading(&title);
    for (label, at_start) in [("when it starts", true), ("while it runs", false)] {
        let mut lines: Vec<(String, Vec<String>)> = Vec::new();
        for free in matter.iter().filter(|free| free.at_start == at_start) {
            let name = named(&free.name, &free.comment);
            let (state, name) = match free.value {
                Value::Word(number) => ("", format!("{name} = {number}")),
                Value::Bit(true) => ("on", name),
                Value::Bit(false) => ("off", name),
            };
            match lines.iter_mut().find(|(known, _)| known == state) {
                Some((_, names)) => names.push(name),
                None => lines.push((state.to_owned(), vec![name])),
            }
        }
        lines.sort_by_key(|(state, _)| ["on", "off", ""].iter().position(|known| known == state));
        if !lines.is_empty() {
            text += &format!("  {label}\n");
        }
        for (state, names) in lines {
            let state = if state.is_empty() { "words" } else { &state };
            text += &wrapped(&format!("    {state:<5}  "), &capped(&names, extent.values));
        }
    }
    text
}

fn assumed(audit: &Audit, extent: Extent) -> String {
    let table = &audit.table;
    if table.assumed.is_empty() {
        return String::new();
    }
    let title =
        format!("Assumed times: {} of the bound, {}", table.assumed_share, us(table.assumed_time));
    let rows: Vec<Vec<Cell>> = table
        .assumed
        .iter()
        .take(extent.values)
        .map(|one| {
            let used = match one.count {
                0 if one.row == "@factor" => {
                    "on the whole scan: what it adds to other times".to_owned()
                }
                0 => "a term of the scan".to_owned(),
                1 => "once in the program".to_owned(),
                n => format!("{n} times in the program"),
            };
            let class = if one.by_class {
                format!(", priced by its class {}", one.row)
            } else {
                String::new()
            };
            vec![left(&one.name), right(us(one.time)), left(used + &class).styled(FAINT)]
        })
        .collect();
    heading(&title)
        + &columns(2, &rows)
        + &more(table.assumed.len(), extent.values, "  ", "assumed time", "assumed times")
}

/// The words that are trusted, what for, and which scans that leaves out.
fn trusted(audit: &Audit) -> String {
    let mut lines: Vec<String> =
        audit.assumptions.iter().map(|one| assumption(audit, one)).collect();
    if let Some(Minor { count: n, without }) = audit.what_if.as_ref().and_then(|one| one.minor) {
        let others = if lines.is_empty() { "" } else { "further " };
        let words = count(n, "word or set of relays", "words or sets of relays");
        lines.push(format!(
            "{others}{words}, none of which lowers the bound by 0.1 % alone: without all of them {without}"
        ));
    }
    if !lines.is_empty() && audit.what_if.is_none() {
        lines.push("--what-if solves what each is worth: the bound without it".to_owned());
    }
    if !lines.is_empty() {
        lines.push(
            "not covered: the first scans after a download or a change in RUN, when memory may hold anything"
                .to_owned(),
        );
    }
    let title = "What is trusted: nobody but the program writes these (--trust none does without)"
        .to_owned();
    let order = if audit.what_if.is_some() { ", the dearest first" } else { "" };
    list(&(title + order), &lines)
}

/// What is trusted of a word or of relays, and the lines that write them.
fn assumption(audit: &Audit, one: &Assumption) -> String {
    let mut by = one
        .written
        .iter()
        .take(MOST_WRITERS)
        .map(|(at, instruction)| format!("`{instruction}` ({})", place(audit, *at)))
        .collect::<Vec<_>>()
        .join(", ");
    if one.written.len() > MOST_WRITERS {
        by += &format!(" and {} more", one.written.len() - MOST_WRITERS);
    }
    let without = one.without.map(|bound| format!("; without that the bound is {bound}"));
    let without = without.unwrap_or_default();
    match one.range {
        Some((low, high)) => {
            let name = one.name();
            format!("{name} is {low} to {high} whenever a scan starts: written by {by}{without}")
        }
        None => {
            let names = one.name();
            format!("of {names} no two are on when a scan starts: written by {by}{without}")
        }
    }
}

/// What was stated, and whether the program keeps it.
fn facts(audit: &Audit) -> Vec<String> {
    let told = |fact: &Fact| match fact.status() {
        Status::Kept => format!("{fact}: the program writes nothing else into it"),
        Status::Unproved => format!("{fact}: nothing here proves it"),
        Status::Stated => fact.to_string(),
    };
    audit.facts.iter().map(told).collect()
}

/// Counts of which nothing is known, and what to state of them.
fn unknowns(audit: &Audit, extent: Extent) -> String {
    let Some(first) = audit.unknowns.first() else { return String::new() };
    let rows: Vec<Vec<Cell>> = audit
        .unknowns
        .iter()
        .take(extent.values)
        .map(|one| {
            vec![
                right(one.cost.to_string()),
                left(place(audit, one.places[0].0)),
                left(match one.places.len() {
                    1 => one.places[0].1.to_string(),
                    n => format!("{} (+{})", one.places[0].1, n - 1),
                }),
                left(format!("{} taken as up to {}, {} each", one.word, one.most, one.each))
                    .styled(FAINT),
            ]
        })
        .collect();
    let solve = match audit.what_if {
        Some(_) => "",
        None => "  --what-if solves the bound for counts of at most 20 and 100\n",
    };
    heading("The bound rests on counts that are not known, the dearest first")
        + &columns(2, &rows)
        + &more(audit.unknowns.len(), extent.values, "  ", "count", "counts")
        + &format!(
            "  say in a facts file (--facts) what they are, such as at most 20:\n      [counts]\n      {}\n",
            first.fact
        )
        + solve
        + &solved(audit)
}

/// The bounds where these counts are stated, and those that are named then.
fn solved(audit: &Audit) -> String {
    let Some(what_if) = audit.what_if.as_ref().filter(|one| !one.steps.is_empty()) else {
        return String::new();
    };
    let mut head = vec![left("")];
    head.extend(what_if.most.iter().map(|most| right(format!("at most {most}"))));
    let rows = what_if.steps.iter().enumerate().map(|(index, step)| {
        let and = if index == 0 { "" } else { "and " };
        let unknown = &step.unknown;
        let mut row = vec![left(format!("{and}{}", unknown.word))];
        row.extend(step.solved.iter().map(|bound| match bound {
            Some(bound) => right(bound.to_string()),
            None => right("cannot be"),
        }));
        row.push(left(place(audit, unknown.places[0].0)).styled(FAINT));
        row
    });
    let rows: Vec<Vec<Cell>> = [head].into_iter().chain(rows).collect();
    heading("The bound where these are stated, solved for each, together with those above it")
        + &columns(2, &rows)
}

fn approximations(audit: &Audit, extent: Extent) -> String {
    if audit.approximations.is_empty() {
        return String::new();
    }
    // The same said of several instructions is said once: of `it`.
    let mut kinds: Vec<(String, Vec<&ApproximationUse>)> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for one in &audit.approximations {
        let mnemonic = mnemonic(one);
        let what = one.what.to_string();
        let mut kind = String::with_capacity(what.len());
        for (index, word) in what.split(' ').enumerate() {
            kind.push_str(if index > 0 { " " } else { "" });
            kind.push_str(if word == mnemonic { "it" } else { word });
        }
        let at = *known.entry(kind.clone()).or_insert_with(|| {
            kinds.push((kind, Vec::new()));
            kinds.len() - 1
        });
        kinds[at].1.push(one);
    }
    kinds.sort_by_key(|(_, uses)| std::cmp::Reverse(uses.len()));
    let title = format!(
        "Over-approximated ({}): the bound can only be too high by these",
        count(audit.approximations.len(), "place", "places")
    );
    let mut text = heading(&title);
    for (kind, uses) in kinds.iter().take(extent.values) {
        let alone = uses.iter().all(|one| mnemonic(one) == mnemonic(uses[0]));
        let what = if alone { &uses[0].what.to_string() } else { kind };
        let entries: Vec<String> = uses
            .iter()
            .map(|one| match alone {
                true => place(audit, one.at),
                false => format!("{} {}", mnemonic(one), place(audit, one.at)),
            })
            .collect();
        text += &format!("  {what}\n");
        text += &wrapped("      ", &capped(&entries, 6));
    }
    text + &more(kinds.len(), extent.values, "  ", "kind", "kinds")
}

fn mnemonic(one: &ApproximationUse) -> &str {
    one.instruction.split(' ').next().unwrap_or_default()
}

fn warnings(audit: &Audit) -> Vec<String> {
    audit
        .warnings
        .iter()
        .map(|one| {
            let line = one.line.map_or(String::new(), |line| format!(":{line}"));
            let place = match one.file.as_str() {
                "" => String::new(),
                file => format!("{file}{line}: "),
            };
            format!("{place}{}", one.message)
        })
        .collect()
}

fn shown<T: ToString>(entries: &[T]) -> Vec<String> {
    entries.iter().map(ToString::to_string).collect()
}

fn list(title: &str, entries: &[String]) -> String {
    if entries.is_empty() {
        return String::new();
    }
    heading(title) + &entries.iter().map(|entry| format!("  {entry}\n")).collect::<String>()
}

fn heading(text: &str) -> String {
    format!("\n{}\n", paint(BOLD, text))
}

fn more(all: usize, shown: usize, indent: &str, one: &str, several: &str) -> String {
    match all.saturating_sub(shown) {
        0 => String::new(),
        rest => format!("{indent}and {}\n", count(rest, one, several)),
    }
}

/// The first so many entries, and how many more there are.
fn capped(entries: &[String], most: usize) -> Vec<String> {
    let mut shown: Vec<String> = entries.iter().take(most).cloned().collect();
    if entries.len() > most {
        shown.push(format!("and {} more", entries.len() - most));
    }
    shown
}

/// The entries apart by commas, behind a label and under each other where a line is full.
fn wrapped(label: &str, entries: &[String]) -> String {
    let indent = label.width().min(WIDTH / 3);
    let (mut text, mut used) = (label.to_owned(), label.width());
    for (index, entry) in entries.iter().enumerate() {
        let comma = if index + 1 < entries.len() { "," } else { "" };
        if index > 0 && used + 1 + entry.width() + comma.len() > WIDTH {
            text += &format!("\n{}", " ".repeat(indent));
            used = indent;
        } else if index > 0 {
            text.push(' ');
            used += 1;
        }
        text += entry;
        text += comma;
        used += entry.width() + comma.len();
    }
    text + "\n"
}

fn count(number: usize, one: &str, several: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { several })
}

fn named(device: &str, comment: &str) -> String {
    if comment.is_empty() { device.to_owned() } else { format!("{device} {comment}") }
}

pub(super) fn place(audit: &Audit, at: Location) -> String {
    let step = at.step.map_or(String::new(), |step| format!(" step {step}"));
    format!("{}:{}{step}", short(audit, at), at.line)
}

/// The file's name without its directories, where that tells the files apart.
fn short(audit: &Audit, at: Location) -> &str {
    let base = |name: &'_ str| name.rsplit(['/', '\\']).next().map_or(0, str::len);
    let name = at.of(&audit.files);
    let last = &name[name.len() - base(name)..];
    let same = audit.files.iter().filter(|other| &other[other.len() - base(other)..] == last);
    if same.count() == 1 { last } else { name }
}

/// Microseconds to three places, rounded up.
fn us(time: Picos) -> String {
    let nanos = time.0.div_ceil(1_000);
    format!("{}.{:03} us", nanos / 1_000, nanos % 1_000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audit::fixture::fixture;
    use crate::audit::verdict::Margin;

    fn plain(audit: &Audit, check: Option<&Check>, extent: Extent) -> String {
        anstream::adapter::strip_str(&render(audit, check, extent)).to_string()
    }

    #[test]
    fn the_fixture_as_text() {
        insta::assert_snapshot!(plain(&fixture(), None, Extent::default()));
    }

    #[test]
    fn an_exact_and_short_report() {
        let mut audit = fixture();
        audit.bound.lower = audit.bound.upper;
        audit.table.assumed.clear();
        let extent = Extent { top: 1, values: 1 };
        insta::assert_snapshot!(plain(&audit, None, extent));
    }

    #[test]
    fn the_answers_of_a_check() {
        let mut audit = fixture();
        let margin: Margin = "10%".parse().expect("a margin");
        let mut answers = String::new();
        for (limit, doubts) in [(600, true), (300, true), (460, true), (600, false)] {
            if !doubts {
                audit.doubts.clear();
            }
            let check = Check::new(&audit, Picos(limit * 1_000_000), margin);
            answers += &anstream::adapter::strip_str(&answer(&audit, &check)).to_string();
        }
        insta::assert_snapshot!(answers);
    }

    #[test]
    fn a_bound_that_rests_on_assumed_times_alone_is_not_said_to_be_too_low() {
        let mut audit = fixture();
        let told = |audit: &Audit| {
            let check = Check::new(audit, Picos(600_000_000), Margin::default());
            let check = check.if_assumed_at_most(audit, "0%".parse().expect("a share"));
            anstream::adapter::strip_str(&answer(audit, &check)).to_string()
        };
        assert!(told(&audit).contains("; but the bound may be too low:\n"));
        audit.doubts.clear();
        assert!(told(&audit).contains("; but:\n"));
    }
}
