//! The study of an S-net as JSON.

use super::Study;
use schemars::JsonSchema;
use serde::Serialize;
use std::io::{self, Write};

/// The document.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Report<'a> {
    schema: &'static str,
    file: &'a str,
    name: &'a str,
    sound: bool,
    net: Net,
    code: Code,
    place_invariants: Vec<Invariant>,
    transition_invariants: Vec<Vec<Weight>>,
    siphons: Vec<Siphon>,
    traps: Vec<Vec<String>>,
    siphons_complete: bool,
    findings: Vec<Finding>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Net {
    markings: usize,
    complete: bool,
    dead: usize,
    never_fire: Vec<String>,
    not_seen_to_fire: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Code {
    states: usize,
    complete: bool,
    follows: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Weight {
    name: String,
    weight: i64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Invariant {
    places: Vec<Weight>,
    sum: i64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Siphon {
    places: Vec<String>,
    kept: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Finding {
    kind: &'static str,
    error: bool,
    line: u32,
    message: String,
    help: &'static str,
    start: Option<&'static str>,
    run: Option<Vec<String>>,
}

/// Writes the document.
///
/// # Errors
/// What writing to `out` fails with.
pub fn write(study: &Study<'_>, out: &mut dyn Write) -> io::Result<()> {
    let check = study.check;
    let weights = |all: &[(usize, i64)], name: &dyn Fn(usize) -> String| -> Vec<Weight> {
        all.iter().map(|&(at, weight)| Weight { name: name(at), weight }).collect()
    };
    let place = |at: usize| study.place(at);
    let transition = |at: usize| study.transition(at);
    let names = |all: &[usize]| -> Vec<String> { all.iter().map(|&at| study.place(at)).collect() };
    let fires =
        |all: &[usize]| -> Vec<String> { all.iter().map(|&at| study.transition(at)).collect() };
    let arcs = &check.structure;
    let findings = study.found().into_iter().map(|one| {
        let (start, run) = one.run.map_or((None, None), |(start, run)| (Some(start), Some(run)));
        Finding {
            kind: one.kind,
            error: one.is_error,
            line: one.line,
            message: one.message,
            help: one.help,
            start,
            run,
        }
    });
    let report = Report {
        schema: "scanbound.snet/1",
        file: &study.diagram.file,
        name: &study.diagram.name,
        sound: check.is_sound(),
        net: Net {
            markings: check.markings.count,
            complete: check.markings.complete,
            dead: check.markings.dead_count,
            never_fire: fires(&check.markings.never),
            not_seen_to_fire: fires(&check.markings.unseen),
        },
        code: Code {
            states: check.code.count,
            complete: check.code.complete,
            follows: if !check.code.divergences.is_empty() {
                "no"
            } else if check.code.complete || check.code.undecided.is_empty() {
                "yes"
            } else {
                "unknown"
            },
        },
        place_invariants: (arcs.place_invariants.iter())
            .map(|one| Invariant { places: weights(&one.weights, &place), sum: one.sum })
            .collect(),
        transition_invariants: (arcs.transition_invariants.iter())
            .map(|one| weights(one, &transition))
            .collect(),
        siphons: (arcs.siphons.iter())
            .map(|one| Siphon { places: names(&one.places), kept: one.is_kept })
            .collect(),
        traps: arcs.traps.iter().map(|one| names(one)).collect(),
        siphons_complete: arcs.complete,
        findings: findings.collect(),
    };
    serde_json::to_writer_pretty(&mut *out, &report)?;
    writeln!(out)
}
