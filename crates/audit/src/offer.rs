//! What of a project is worth stating: the lines of a facts file that an audit asks for.

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

/// Something worth stating.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The table of the facts file.
    pub table: &'static str,
    /// Its line there, the value to be replaced by what is true.
    pub line: String,
    /// What it is, and what is taken without it.
    pub what: String,
    /// Where it matters, and the instructions there, the dearest first.
    pub places: Vec<(Location, Arc<str>)>,
    /// What the bound loses by it at most.
    pub worth: Option<Picos>,
    /// The bound where it is at most so many, as do those that are named: what [`super::what_if`] solved.
    pub solved: Option<Solved>,
}

/// Bounds for what an offered count may be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Solved {
    /// The counts that are stated to be as many at most besides.
    pub with: Vec<Arc<str>>,
    /// The count, and the bound.
    pub bounds: Vec<(u32, SolvedBound)>,
}

/// All that is worth stating, as a facts file has its tables; within one the dearest first.
#[must_use]
pub fn offers(concluded: &Concluded, request: &Request<'_>) -> Vec<Offer> {
    let program = &concluded.followed.program;
    let audit = &concluded.audit;
    let most = contradiction::offered(STAGES, request, &all_unknowns(audit));
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
        what: format!("{} points that the CPU refreshes: {}", side.side, side.why),
        places: Vec::new(),
        worth: None,
        solved: None,
    }));
    offers.extend(audit.bases.first().map(|side| Offer {
        table: "io",
        line: format!("base = {:?}", side.least),
        what: "the kind of base unit that all modules sit on: the dearest is taken".to_owned(),
        places: Vec::new(),
        worth: Some(audit.bases.iter().map(|side| side.saves).sum()),
        solved: None,
    }));
    offers.extend(networks(audit, program));
    // Two lines of one name are no TOML.
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

/// Words of which each holds an index that is not known and that nobody but others write.
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
        // Such a name is not one that a program has.
        let has_name = !program.cell_name(*cell).contains(char::is_whitespace);
        has_name && !flow::is_written(program, *cell)
    });
    let offer = |(cell, mut places): (_, Vec<usize>)| {
        places.dedup();
        let word = program.cell_name(cell);
        let what = format!("{word}, an index: what is written by it may be any device of its kind");
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

/// The index by which a region is written, where nothing is known of it.
fn unknown_index(program: &Program, region: Region, choice: ChoiceId) -> Option<&IndexedWrite> {
    let indexed = program.indexed.get(&choice)?;
    indexed.is_unknown_in(region).then_some(indexed)
}

/// What is not known of words, for one of the facts file's tables; `most` is what each number is offered as.
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
            Solved { with, bounds }
        });
        Offer {
            table: one.table(),
            line: most.get(&one.key).map_or(one.fact.clone(), |&most| one.stated(most)),
            what: what(program, one),
            places: one.places.clone(),
            worth: one.counts().map(|counts| counts.cost),
            solved,
        }
    };
    all.map(offer).collect()
}

/// What is not known, and what is named only where others are stated.
fn all_unknowns(audit: &Audit) -> Vec<Unknown> {
    let steps = audit.what_if.as_ref().map_or(&[][..], |what_if| &what_if.steps);
    let is_new = |one: &&Unknown| audit.unknowns.iter().all(|known| known.key != one.key);
    let hidden = steps.iter().map(|step| &step.unknown).filter(is_new);
    audit.unknowns.iter().chain(hidden).cloned().collect()
}

/// What is not known, and what is taken.
pub(super) fn what(program: &Program, one: &Unknown) -> String {
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
            format!("{word}, a count: taken as up to {}, {} each", counts.most, counts.each)
        }
        UnknownKind::Index(_) => format!(
            "{}, the index of what is written there{}: it may be any device of its kind",
            one.word,
            one.origin()
        ),
        UnknownKind::IndexBits => "how many bits an index to file registers has, 16 or 32: a parameter of the CPU; both are reckoned with".to_owned(),
        UnknownKind::Indirect => "all that is written through indirect addresses (@): without it, anything".to_owned(),
    }
}

/// Routines that are not there.
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
            "{name} is called and not there. It may write anything, unless it is stated what: {{ time = \"50us\", writes = [\"D100-D199\", \"M5\"] }}"
        ),
        places,
        worth: None,
        solved: None,
    };
    routines.into_iter().map(offer).collect()
}

/// How indices and indirect addresses work.
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
            what: "how many bits an index to file registers has, 16 or 32: a parameter of the CPU; both are reckoned with".to_owned(),
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
            what: "all that is written through indirect addresses (@): without it, anything"
                .to_owned(),
            places: anywhere,
            worth: None,
            solved: None,
        });
    }
    offers
}

/// More devices of one table are counted, not named.
const MOST_DEVICES: usize = 40;

/// What others may write after all.
fn external(audit: &Audit, program: &Program) -> Option<Offer> {
    let devices = audit.assumptions.iter().flat_map(|one| &one.devices);
    let devices = devices.filter(|device| stated::holder(program, device).is_some());
    let devices = stated::whole(program, devices);
    let writers = audit.assumptions.iter().flat_map(|one| one.written.iter().cloned());
    (!devices.is_empty()).then(|| Offer {
        table: "external",
        line: listed(devices.iter().take(MOST_DEVICES)),
        what: "what HMIs and others write: these are trusted since the program writes them; leave only those that somebody else writes, too".to_owned(),
        places: writers.collect(),
        worth: None,
        solved: None,
    })
}

/// What nobody else may write, as far as that was solved.
fn internal(audit: &Audit) -> Option<Offer> {
    let own = audit.what_if.as_ref()?.own.as_ref()?;
    Some(Offer {
        table: "internal",
        line: listed(own.devices.iter()),
        what: format!("if nobody but the program writes all of these, the bound is {}", own.bound),
        places: Vec::new(),
        worth: audit.bound.upper.checked_sub(own.bound.upper),
        solved: None,
    })
}

/// A list of devices as a facts file has it.
pub(super) fn listed<'a>(devices: impl Iterator<Item = &'a String>) -> String {
    // A name in quotes: what TOML takes for an escape is one of Rust's, too.
    let devices: Vec<String> = devices.map(|device| format!("{device:?}")).collect();
    format!("devices = [{}]", devices.join(", "))
}

fn interrupts(program: &Program) -> Vec<Offer> {
    let unstated = program.unstated_interrupts();
    let offer = |one: &scanbound_ir::Interrupt| {
        // Of a routine of which nothing is known it can only be stated that it does not run.
        let is_empty = program.instructions[one.entry].step == Step::Return;
        let times = if is_empty { 0 } else { one.times };
        Offer {
            table: "interrupts",
            line: format!("{} = {times}", key(&one.name)),
            what: format!(
                "how often {} interrupts a scan at most: {} is taken",
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
            "what networks take to refresh {} in one scan, or \"none\" where nothing refreshes them: not in the bound",
            what.join(", ")
        ),
        places: text.map(|one| vec![(first, one.text.clone())]).unwrap_or_default(),
        worth: None,
        solved: None,
    })
}
