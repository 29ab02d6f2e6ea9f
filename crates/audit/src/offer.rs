//! Suggests lines for a facts file: what is worth stating about a project.

use super::Audit;
use super::contradiction;
use super::names::Names;
use super::pipeline::{Concluded, STAGES};
use super::request::Request;
use super::solved_bound::SolvedBound;
use super::stated;
use super::unknown::{INDEX, Unknown, UnknownKind};
use scanbound_base::facts::key;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::{ChoiceId, IndexedWrite, Program, Region, Step, WordSource, Write, flow};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A line that the user could add to the facts file, with what it concerns and how much it may lower the bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The name of the table of the facts file in which the line belongs, such as `counts`.
    pub table: &'static str,
    /// The line in that table of the facts file. The user replaces its value by the true one.
    pub line: String,
    /// What the line states, and what the bound assumes without it.
    pub what: String,
    /// The places that the line concerns, with the instructions there. For a count: the longest time first.
    pub places: Vec<(Location, Arc<str>)>,
    /// The largest time by which the line can lower the bound. `None` if unknown.
    pub worth: Option<Picos>,
    /// The bounds if the value that the line states, and those from the words in [`SolvedLimits::with`], are limited.
    /// They come from [`super::what_if`]. `None` if they were not computed.
    pub solved: Option<SolvedLimits>,
}

/// The bounds of the scan for several limits of a number of iterations or units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SolvedLimits {
    /// The other words for which the bounds assume the same limit.
    pub with: Vec<Arc<str>>,
    /// Pairs of a limit, and the bound with that limit.
    pub bounds: Vec<(u32, SolvedBound)>,
}

/// All suggestions, in the order of the tables of a facts file. Among the counts, the longest time comes first.
#[must_use]
pub fn offers(concluded: &Concluded, request: &Request<'_>) -> Vec<Offer> {
    let program = &concluded.followed.program;
    let audit = &concluded.audit;
    let most = contradiction::offered_limits(STAGES, request, &all_unknowns(audit));
    let mut offers = ranges(program);
    offers.extend(unknowns(audit, program, "counts", &most));
    offers.extend(calls(program));
    offers.extend(unknowns(audit, program, "index", &most));
    if concluded.followed.machine.index {
        offers.extend(index(program, request));
    }
    offers.extend(external(audit, program));
    offers.extend(internal(audit));
    offers.extend(interrupts(program));
    offers.extend(audit.points.iter().map(|side| Offer {
        table: "io",
        line: format!("{}s = {}", side.side, side.taken),
        what: format!(
            "the number of {} points that the CPU refreshes; the bound assumes {}",
            side.side, side.why
        ),
        places: Vec::new(),
        worth: None,
        solved: None,
    }));
    offers.extend(audit.bases.first().map(|side| {
        Offer {
            table: "io",
            line: format!("base = {:?}", side.least),
            what: "the kind of base unit on which all modules are mounted: the slowest is assumed"
                .to_owned(),
            places: Vec::new(),
            worth: Some(audit.bases.iter().map(|side| side.saves).sum()),
            solved: None,
        }
    }));
    offers.extend(networks(audit, program));
    // The same name twice is not valid TOML.
    let mut known: BTreeSet<(&str, String)> = BTreeSet::new();
    offers.retain(|one| {
        let name = one.line.split(" = ").next().unwrap_or_default();
        known.insert((one.table, name.to_owned()))
    });
    offers
}

fn place(program: &Program, at: usize) -> (Location, Arc<str>) {
    let instruction = &program.instructions[at];
    (instruction.place, instruction.text.clone())
}

/// Offers of ranges for words that hold an unknown index of a write and that the program itself does not write.
fn ranges(program: &Program) -> Vec<Offer> {
    let mut found: BTreeMap<_, Vec<usize>> = BTreeMap::new();
    for (at, instruction) in program.instructions.iter().enumerate() {
        let indexed = instruction.effects.iter().filter_map(|effect| match effect.write {
            Write::Havoc(region, choice) => unknown_index(program, region, choice),
            _ => None,
        });
        for indexed in indexed.collect::<Vec<_>>() {
            let words = indexed.indices.iter().filter_map(|reading| reading.first());
            for word in words {
                if let WordSource::Cell(cell) = *word {
                    found.entry(cell).or_default().push(at);
                }
            }
        }
    }
    let others = found.into_iter().filter(|(cell, _)| {
        // The name of a word in a program has no blanks.
        let has_name = !program.cell_name(*cell).contains(char::is_whitespace);
        has_name && !flow::is_written(program, *cell)
    });
    let offer = |(cell, mut places): (_, Vec<usize>)| {
        places.dedup();
        let word = program.cell_name(cell);
        let what = format!(
            "{word} is an index: a write with this index may change any device of the area that is written"
        );
        Offer {
            table: "ranges",
            line: format!("{} = [0, {INDEX}]", key(&word)),
            what,
            places: places.into_iter().map(|at| place(program, at)).collect(),
            worth: None,
            solved: None,
        }
    };
    others.map(offer).collect()
}

/// The index with which a region is written. `None` if it has no index, or something is known about the index.
fn unknown_index(program: &Program, region: Region, choice: ChoiceId) -> Option<&IndexedWrite> {
    let indexed = program.indexed.get(&choice)?;
    indexed.is_unknown_in(region).then_some(indexed)
}

/// Offers for the unknown values that can be stated in one table of the facts file. `most` is the limit that is offered
/// for each, by its key; numbers without a limit there are left out.
fn unknowns(
    audit: &Audit,
    program: &Program,
    table: &str,
    most: &BTreeMap<String, u32>,
) -> Vec<Offer> {
    let steps = audit.what_if.as_ref().map_or(&[][..], |what_if| &what_if.steps);
    let all = all_unknowns(audit).into_iter().filter(|one| one.table() == table);
    let all = all.filter(|one| !one.is_number() || most.contains_key(&one.key));
    let offer = |one: Unknown| {
        let one = &one;
        let at = steps.iter().position(|step| step.unknown.key == one.key);
        let solved = audit.what_if.as_ref().zip(at).map(|(what_if, at)| {
            let bounds = what_if.most.iter().zip(&steps[at].solved);
            let bounds = bounds.filter_map(|(&most, bound)| Some((most, (*bound)?))).collect();
            let with = steps[..at].iter().map(|step| step.unknown.word.clone()).collect();
            SolvedLimits { with, bounds }
        });
        Offer {
            table: one.table(),
            line: most.get(&one.key).map_or(one.fact.clone(), |&most| one.stated(most)),
            what: description(program, one),
            places: one.places.clone(),
            worth: one.counts().map(|counts| counts.cost),
            solved,
        }
    };
    all.map(offer).collect()
}

/// The unknown values of an audit, including those that came up only when others were limited (`Audit::what_if`).
fn all_unknowns(audit: &Audit) -> Vec<Unknown> {
    let steps = audit.what_if.as_ref().map_or(&[][..], |what_if| &what_if.steps);
    let is_new = |one: &&Unknown| audit.unknowns.iter().all(|known| known.key != one.key);
    let hidden = steps.iter().map(|step| &step.unknown).filter(is_new);
    audit.unknowns.iter().chain(hidden).cloned().collect()
}

/// What is unknown, and what the bound assumes instead: the text of an offer.
pub(super) fn description(program: &Program, one: &Unknown) -> String {
    match &one.kind {
        UnknownKind::Count(counts) => {
            let named = |comment: &String| comment.starts_with(&format!("{} ", one.word));
            let names = Names::new(program);
            let at = program.instructions.iter().find(|at| {
                let (place, text) = &one.places[0];
                at.place == *place && at.text == *text
            });
            let comments = at.map(|at| names.comments_in(at)).unwrap_or_default();
            let word = comments.into_iter().find(named).unwrap_or_else(|| one.word.to_string());
            format!("{word} is a number of iterations or units: assumed to be at most {}; each adds {} to the scan", counts.most, counts.each)
        }
        UnknownKind::Index(_) => format!(
            "{} is the index of a write{}: the write may change any device of the area that is written",
            one.word,
            one.origin()
        ),
        UnknownKind::IndexBits => "the number of bits of an index to file registers, 16 or 32: a parameter of the CPU; the bound covers both".to_owned(),
        UnknownKind::Indirect => "all devices that the program writes through indirect addresses (@): without this line, the bound assumes that such a write may change any device".to_owned(),
    }
}

/// Offers for called routines whose code is not given and about which nothing is stated.
fn calls(program: &Program) -> Vec<Offer> {
    let calls = program.instructions.iter().enumerate();
    let calls: BTreeMap<usize, usize> = calls
        .filter_map(|(at, one)| match one.step {
            Step::Call { target, .. } => Some((target, at)),
            _ => None,
        })
        .collect();
    let mut routines: BTreeMap<&str, Vec<(Location, Arc<str>)>> = BTreeMap::new();
    for absent in program.missing_routines.iter().filter(|absent| !absent.stated) {
        let at = calls.get(&absent.entry).copied().unwrap_or(absent.entry);
        routines.entry(&absent.name).or_default().push(place(program, at));
    }
    let offer = |(name, places): (&str, _)| Offer {
        table: "calls",
        line: format!("{} = {{ time = \"50us\" }}", key(name)),
        what: format!(
            "{name} is called, but its code is not given. If only its time is stated, the bound assumes that it may write any device; to state the devices that it writes, write {{ time = \"50us\", writes = [\"D100-D199\", \"M5\"] }}"
        ),
        places,
        worth: None,
        solved: None,
    };
    routines.into_iter().map(offer).collect()
}

/// Offers for the size of indices (`bits`) and the targets of indirect addresses (`indirect`), where they matter and
/// are not stated.
fn index(program: &Program, request: &Request<'_>) -> Vec<Offer> {
    let mut offers = Vec::new();
    let of = |matters: &dyn Fn(&Write) -> bool| -> Vec<(Location, Arc<str>)> {
        let is_there =
            |at: &usize| !program.missing_routines.iter().any(|absent| absent.entry == *at);
        let writes = |at: &usize| {
            program.instructions[*at].effects.iter().any(|effect| matters(&effect.write))
        };
        let found = (0..program.instructions.len()).filter(writes).filter(is_there);
        found.map(|at| place(program, at)).collect()
    };
    let either = of(&|write| match *write {
        Write::Havoc(region, choice) => {
            unknown_index(program, region, choice).is_some_and(|indexed| indexed.indices.len() > 1)
        }
        _ => false,
    });
    if request.facts.index_bits.is_none() && !either.is_empty() {
        offers.push(Offer {
            table: "index",
            line: "bits = 16".to_owned(),
            what: "the number of bits of an index to file registers, 16 or 32: a parameter of the CPU; the bound covers both".to_owned(),
            places: either,
            worth: None,
            solved: None,
        });
    }
    let anywhere = of(&|write| matches!(write, Write::Havoc(Region::Everything, _)));
    if request.facts.indirect.is_none() && !anywhere.is_empty() {
        offers.push(Offer {
            table: "index",
            line: "indirect = [\"D0-D99\"]".to_owned(),
            what: "all devices that the program writes through indirect addresses (@): without this line, the bound assumes that such a write may change any device"
                .to_owned(),
            places: anywhere,
            worth: None,
            solved: None,
        });
    }
    offers
}

/// An offer that lists the devices that the bound assumes to be written only by the program. `None` if there are none.
fn external(audit: &Audit, program: &Program) -> Option<Offer> {
    let devices = audit.assumptions.iter().flat_map(|one| &one.devices);
    let devices = devices.filter(|device| stated::holder(program, device).is_some());
    let devices = stated::whole(program, devices);
    let writers = audit.assumptions.iter().flat_map(|one| one.written.iter().cloned());
    (!devices.is_empty()).then(|| Offer {
        table: "external",
        line: listed(devices.iter()),
        what: "devices that operator panels and other stations write: the bound assumes that only the program writes the listed devices; keep in the list only devices that other stations write, too".to_owned(),
        places: writers.collect(),
        worth: None,
        solved: None,
    })
}

/// An offer for devices that only the program writes. `None` if the bound with that statement was not computed.
fn internal(audit: &Audit) -> Option<Offer> {
    let own = audit.what_if.as_ref()?.own.as_ref()?;
    Some(Offer {
        table: "internal",
        line: listed(own.devices.iter()),
        what: format!(
            "if nothing except the program writes the listed devices, the bound is {}",
            own.bound
        ),
        places: Vec::new(),
        worth: audit.bound.upper.checked_sub(own.bound.upper),
        solved: None,
    })
}

/// A list of devices in the format of a facts file.
pub(super) fn listed<'a>(devices: impl Iterator<Item = &'a String>) -> String {
    // A quoted name: the escapes of Rust are valid in TOML, too.
    let devices: Vec<String> = devices.map(|device| format!("{device:?}")).collect();
    format!("devices = [{}]", devices.join(", "))
}

fn interrupts(program: &Program) -> Vec<Offer> {
    let unstated = program.unstated_interrupts();
    let offer = |one: &scanbound_ir::Interrupt| {
        // If a routine is unknown, the only useful statement is that it does not run.
        let is_empty = program.instructions[one.entry].step == Step::Return;
        let times = if is_empty { 0 } else { one.times };
        Offer {
            table: "interrupts",
            line: format!("{} = {times}", key(&one.name)),
            what: format!(
                "the largest number of times that {} interrupts one scan: {} is assumed",
                one.name, one.times
            ),
            places: vec![place(program, one.entry)],
            worth: None,
            solved: None,
        }
    };
    unstated.map(offer).collect()
}

fn networks(audit: &Audit, program: &Program) -> Option<Offer> {
    let what: Vec<&str> = audit.networks.iter().map(|one| one.what.as_str()).collect();
    let first = audit.networks.iter().map(|one| one.first).min()?;
    let text = program.instructions.iter().find(|one| one.place == first);
    Some(Offer {
        table: "network",
        line: "refresh = \"1ms\"".to_owned(),
        what: format!(
            "the time in one scan of network refresh for {}, or \"none\" if no network refreshes them: the bound does not include this time",
            what.join(", ")
        ),
        places: text.map(|one| vec![(first, one.text.clone())]).unwrap_or_default(),
        worth: None,
        solved: None,
    })
}
