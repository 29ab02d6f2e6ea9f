//! Which additional statement of the user lowers the bound most. Candidates come from the unknown values of the audit
//! and from the longest scan. For each, the audit is repeated with the statement.

use super::names::Names;
use super::pipeline::Concluded;
use super::request::{Progress, Request};
use super::solved_bound::SolvedBound;
use super::unknown::{Unknown, UnknownKind};
use super::weight::{turned, weights_of_bits};
use super::what_if::{matters, runs, trusting_all};
use super::{Failure, offer, stated};
use scanbound_base::facts::Facts;
use scanbound_base::location::Location;
use scanbound_base::time::Picos;
use scanbound_ir::{BitSource, Program, Role, Source};
use scanbound_model::{Assignment, Atom, Lit, Node, Origin, ScanModel};
use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The name of this stage in the progress display.
const STAGE: &str = "measuring by how much each statement lowers the bound";
/// The largest number of bits from which pairs are formed. The bits are taken first that shorten the longest scan most
/// if each is off alone.
const MAX_BITS: usize = 24;
/// The largest number of pairs of bits that are tried: those whose two bits each control a long part of the longest
/// scan that the other does not control.
const MAX_PAIRS: usize = 12;

/// The settings of the search for advice.
#[derive(Debug, Clone, Copy)]
pub struct AdviceSettings<'a> {
    /// The upper limits that are tried for each unknown number of iterations or units, and for each unknown index.
    pub most: &'a [u32],
    /// The total time that all audits together may take. `None`: there is no such limit.
    pub budget: Option<Duration>,
}

/// Statements that the user could make, with the bound that each gives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Advice {
    /// The program's files.
    pub files: Vec<String>,
    /// The bound without further statements. `None` if a scan may never end; then no statement is tried.
    pub upper: Option<Picos>,
    /// The statements that lower the bound by at least a thousandth of the new bound, the lowest bound first. Each was
    /// tried alone.
    pub found: Vec<Measured>,
    /// The number of statements that were tried but are not in `found`, because they lower the bound by less than a
    /// thousandth, contradict the program, or their audit ended without a result.
    pub useless: usize,
    /// The number of statements that were not tried, or not to the end, because the time was over.
    pub untried: usize,
}

/// A statement that was tried, and the bound of an audit with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// The statement that was tried.
    pub statement: SuggestedFact,
    /// The bound of the scan with this statement.
    pub bound: SolvedBound,
}

/// A statement that the user could add to the facts file, if it is true.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SuggestedFact {
    /// What the statement is about.
    pub kind: AdviceKind,
    /// The table of the facts file to which the line belongs.
    pub table: &'static str,
    /// The line to write into that table.
    pub line: String,
    /// Why the statement may matter: a sentence without a full stop.
    pub what: String,
    /// The places that the statement concerns, with the instructions there. Empty if it concerns the whole program.
    pub places: Vec<(Location, Arc<str>)>,
}

/// What a suggested statement is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AdviceKind {
    /// An upper limit for a number of iterations or units.
    Count,
    /// An upper limit for an index that selects where an instruction writes, or the number of bits of such an index.
    Index,
    /// Two bits that are never on together.
    Exclusive,
    /// That only the program writes certain devices.
    Internal,
    /// The kind of base unit on which all modules are mounted.
    Base,
}

impl AdviceKind {
    /// The name of the kind in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            AdviceKind::Count => "count",
            AdviceKind::Index => "index",
            AdviceKind::Exclusive => "exclusive",
            AdviceKind::Internal => "internal",
            AdviceKind::Base => "base",
        }
    }
}

/// A statement that is to be tried, with the facts of the request and this statement together.
struct UntriedFact {
    statement: SuggestedFact,
    facts: Facts,
    /// An estimate of the time by which the statement can lower the bound; the whole bound if nothing is known of that.
    /// Statements with the largest estimate are tried first.
    largest_gain: Picos,
}

/// Measures by how much each possible statement lowers the bound, by one further audit for each.
///
/// # Errors
/// If the analysis and the interpreter disagree in one of these audits.
pub fn advise(
    concluded: &Concluded,
    request: &Request<'_>,
    settings: AdviceSettings<'_>,
) -> Result<Advice, Failure> {
    let start = Instant::now();
    let audit = &concluded.audit;
    let upper = audit.bound.upper;
    let mut advice = Advice {
        files: audit.files.clone(),
        upper: audit.unbounded.is_empty().then_some(upper),
        found: Vec::new(),
        useless: 0,
        untried: 0,
    };
    if advice.upper.is_none() {
        return Ok(advice);
    }
    let left = || settings.budget.map(|budget| budget.saturating_sub(start.elapsed()));
    let is_over = || (request.cancelled)() || left().is_some_and(|left| left.is_zero());
    // Each audit may use what is left of the time budget.
    let within =
        || Request { time_limit: left().into_iter().chain(request.time_limit).min(), ..*request };
    let mut candidates = unknowns(concluded, request, settings.most);
    candidates.extend(bases(concluded, request));
    candidates.extend(pairs(concluded, request));
    candidates.sort_by_key(|one| Reverse(one.largest_gain));
    if !is_over() {
        (request.progress)(Progress::Stage(STAGE));
        // A candidate that was found by an audit is tried first.
        if let Some(own) = internal(concluded, &within())? {
            candidates.insert(0, own);
        }
    }
    let mut open = candidates.into_iter().peekable();
    while open.peek().is_some() && !is_over() {
        let few: Vec<UntriedFact> = open.by_ref().take(rayon::current_num_threads()).collect();
        let facts: Vec<Facts> = few.iter().map(|one| one.facts.clone()).collect();
        for (one, run) in few.into_iter().zip(runs(&within(), &facts)?) {
            let ran_out = is_over() && run.as_ref().is_some_and(|run| run.bound.cut);
            match run.filter(|run| matters(run.bound.upper, upper)) {
                Some(run) => {
                    advice.found.push(Measured { statement: one.statement, bound: run.bound });
                }
                None if ran_out => advice.untried += 1,
                None => advice.useless += 1,
            }
        }
    }
    advice.untried += open.count();
    advice.found.sort_by_key(|one| one.bound.upper);
    Ok(advice)
}

/// A statement for each unknown count or index and each of the upper limits `most`, and one for each unknown number of
/// bits of an index. Targets of indirect addresses cannot be guessed.
fn unknowns(concluded: &Concluded, request: &Request<'_>, most: &[u32]) -> Vec<UntriedFact> {
    let (audit, program) = (&concluded.audit, &concluded.followed.program);
    let of = |one: &Unknown, most: u32| {
        let mut facts = request.facts.clone();
        one.state(&mut facts, most);
        let (kind, largest_gain) = match &one.kind {
            UnknownKind::Count(counts) => (AdviceKind::Count, counts.cost),
            // How much depends on the place of a write is known only after an audit.
            _ => (AdviceKind::Index, audit.bound.upper),
        };
        UntriedFact {
            statement: SuggestedFact {
                kind,
                table: one.table(),
                line: one.stated(most),
                what: offer::description(program, one),
                places: one.places.clone(),
            },
            facts,
            largest_gain,
        }
    };
    // The targets of indirect addresses cannot be guessed.
    let can_be_stated = |one: &&Unknown| !matches!(one.kind, UnknownKind::Indirect);
    let all = audit.unknowns.iter().filter(can_be_stated).flat_map(|one| {
        // The number of bits of an index does not depend on an upper limit, so it is tried once.
        let values = if one.is_number() { most } else { &most[..most.len().min(1)] };
        values.iter().map(move |&most| of(one, most))
    });
    all.collect()
}

/// The statement that all modules are on the fastest kind of base unit. `None` if the kind is stated or does not
/// matter.
fn bases(concluded: &Concluded, request: &Request<'_>) -> Option<UntriedFact> {
    let bases = &concluded.audit.bases;
    let least = bases.first()?.least.clone();
    Some(UntriedFact {
        statement: SuggestedFact {
            kind: AdviceKind::Base,
            table: "io",
            line: format!("base = {least:?}"),
            what: "the kind of base unit on which all modules are mounted: the slowest is assumed"
                .to_owned(),
            places: Vec::new(),
        },
        facts: Facts { base: Some(least), ..request.facts.clone() },
        largest_gain: bases.iter().map(|side| side.saves).sum(),
    })
}

/// The statement that only the program writes certain devices: those that further assumptions concern in an audit that
/// trusts all devices. `None` if the bound of that audit is not lower by at least a thousandth, if it concerns no
/// devices that can be stated, or if the user chose a trust other than the default.
fn internal(concluded: &Concluded, request: &Request<'_>) -> Result<Option<UntriedFact>, Failure> {
    let (audit, program) = (&concluded.audit, &concluded.followed.program);
    let Some((_, new)) = trusting_all(audit, request)? else { return Ok(None) };
    let devices: BTreeSet<String> = new.into_iter().flat_map(|one| one.devices).collect();
    let known = devices.into_iter().filter(|device| stated::cell(program, device).is_some());
    let devices: Vec<String> = known.collect();
    if devices.is_empty() {
        return Ok(None);
    }
    let mut facts = request.facts.clone();
    facts.internal.extend(devices);
    Ok(Some(UntriedFact {
        statement: SuggestedFact {
            kind: AdviceKind::Internal,
            table: "internal",
            line: offer::listed(facts.internal.iter()),
            what: "state this if only the program writes these devices, and no operator panel or second PLC does: then they keep the values that the program wrote, and relays that the program keeps mutually exclusive are never both on".to_owned(),
            places: Vec::new(),
        },
        facts,
        largest_gain: audit.bound.upper,
    }))
}

/// A bit that is on when the longest scan starts.
struct ActiveBit {
    atom: Atom,
    name: String,
    comment: String,
    /// How much shorter the scan would be if only this bit were off.
    worth: Picos,
}

impl ActiveBit {
    fn description(&self) -> String {
        if self.comment.is_empty() {
            self.name.clone()
        } else {
            format!("{} {}", self.name, self.comment)
        }
    }
}

/// A statement for each pair of bits that are both on when the longest scan starts, and of which each controls a part
/// of the scan that the other does not. At most [`MAX_PAIRS`].
fn pairs(concluded: &Concluded, request: &Request<'_>) -> Vec<UntriedFact> {
    let followed = &concluded.followed;
    if followed.is_structural_only() {
        return Vec::new();
    }
    let (model, program) = (&followed.model, &followed.program);
    let mut longest = Assignment(vec![0; model.variables.len()]);
    concluded.maxima.iter().for_each(|found| found.best.copy_to(&mut longest));
    let charges: Vec<usize> =
        followed.groups.iter().flat_map(|group| group.charges.iter().copied()).collect();
    let whole = model.cost(&charges, &longest);
    let bits = bits_on(program, model, &longest, &charges);
    let mut found = Vec::new();
    for (at, one) in bits.iter().enumerate() {
        for other in &bits[at + 1..] {
            let lost = whole.checked_sub(model.cost(&charges, &without(&longest, &[one, other])));
            let lost = lost.unwrap_or_default();
            // The time that only one of the two controls. If there is none, both control the same: no interlock.
            let own = [other, one].map(|on| lost.checked_sub(on.worth).unwrap_or_default());
            let least = own[0].min(own[1]);
            if least > Picos::ZERO {
                found.push((least, one, other));
            }
        }
    }
    found.sort_by_key(|(least, ..)| Reverse(*least));
    found.truncate(MAX_PAIRS);
    let driven = |on: &ActiveBit, other: &ActiveBit| {
        driven(
            program,
            model,
            &charges,
            [&longest, &without(&longest, &[on]), &without(&longest, &[other])],
        )
    };
    let candidate = |(least, one, other): (Picos, &ActiveBit, &ActiveBit)| {
        let mut facts = request.facts.clone();
        facts.exclusive.push(vec![one.name.clone(), other.name.clone()]);
        let places = [driven(one, other), driven(other, one)].into_iter().flatten().collect();
        UntriedFact {
            statement: SuggestedFact {
                kind: AdviceKind::Exclusive,
                table: "exclusive",
                line: format!("sets = {:?}", facts.exclusive),
                what: format!(
                    "{} and {} are both on in the longest scan, and enable different instructions: state them as exclusive if an interlock or the plant prevents that both are on",
                    one.description(),
                    other.description()
                ),
                places,
            },
            facts,
            largest_gain: least,
        }
    };
    found.into_iter().map(candidate).collect()
}

/// A copy of `values` in which `bits`, which are on in `values`, are off.
fn without(values: &Assignment, bits: &[&ActiveBit]) -> Assignment {
    let mut values = values.clone();
    for on in bits {
        let value = &mut values.0[on.atom.variable().0 as usize];
        *value = turned(on.atom, *value);
    }
    values
}

/// The bits that are on when the longest scan starts, that instructions read as single bits, and that a facts file can
/// name. Flags of the first scan after power-up and bits without which the scan would not be shorter are left out. The
/// bits without which it would be shortest come first. At most [`MAX_BITS`].
fn bits_on(
    program: &Program,
    model: &ScanModel,
    longest: &Assignment,
    charges: &[usize],
) -> Vec<ActiveBit> {
    let values = model.circuit.evaluate(longest);
    let names = Names::new(program);
    let asked = asked_as_bits(program);
    let on = model.circuit.nodes().iter().enumerate().filter_map(|(index, node)| {
        let &Node::Atom(atom) = node else { return None };
        let variable = &model.variables[atom.variable().0 as usize];
        let Origin::Start(cell) = variable.origin else { return None };
        let is_hidden = program.area(cell.area).role == Role::Internal;
        // The flags of the first scan take part in no interlock.
        if is_hidden
            || program.power_up.first_scan.contains(&cell)
            || !values.get(Lit::positive(index))
        {
            return None;
        }
        let word = program.cell_name(cell);
        let (name, source) = match atom {
            Atom::Bit(_) => (word, BitSource::Cell(cell)),
            Atom::WordBit(_, bit) => (format!("{word}.{bit:X}"), BitSource::WordBit(cell, bit)),
            Atom::AtLeast(..) => return None,
        };
        let can_be_stated = stated::bit(program, &name) == Some(source);
        (can_be_stated && asked.contains(&source)).then(|| ActiveBit {
            atom,
            name,
            comment: names.comment(variable),
            worth: Picos::ZERO,
        })
    });
    let mut on: Vec<ActiveBit> = on.collect();
    let atoms: Vec<Atom> = on.iter().map(|one| one.atom).collect();
    let worth = weights_of_bits(model, longest, charges, &atoms);
    on.iter_mut().zip(worth).for_each(|(one, worth)| one.worth = worth);
    on.retain(|one| one.worth > Picos::ZERO);
    on.sort_by_key(|one| Reverse(one.worth));
    on.truncate(MAX_BITS);
    on
}

/// The bits that instructions read as single bits, as contacts do. Bits of words that are read as numbers are not among
/// them.
fn asked_as_bits(program: &Program) -> BTreeSet<BitSource> {
    let mut asked = BTreeSet::new();
    for instruction in &program.instructions {
        instruction.each_read(&mut |source| {
            if let Source::Bit(bit) = source {
                asked.insert(bit);
            }
        });
    }
    asked
}

/// The instruction with the execution whose time falls most from the first to the second of these scans, among those
/// whose time does not fall from the first to the third. `None` if there is none.
fn driven(
    program: &Program,
    model: &ScanModel,
    charges: &[usize],
    scans: [&Assignment; 3],
) -> Option<(Location, Arc<str>)> {
    let [now, off, other] = scans.map(|values| model.circuit.evaluate(values));
    let lost = |charge: &&usize| {
        let charge = &model.charges[**charge];
        let now = charge.cost(&now);
        match charge.cost(&other) >= now {
            true => now.checked_sub(charge.cost(&off)).unwrap_or_default(),
            false => Picos::ZERO,
        }
    };
    let most = charges.iter().max_by_key(lost).filter(|most| lost(most) > Picos::ZERO)?;
    let at = &program.instructions[model.charges[*most].instruction];
    Some((at.place, at.text.clone()))
}
