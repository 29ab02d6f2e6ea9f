//! Which one statement lowers the bound most. What may be worth stating is read off the dearest scan; what each statement is
//! worth is not guessed: the audit is made again with it.

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

/// What it is called while it runs.
const STAGE: &str = "asking what a statement is worth";
/// Pairs are made of so many bits, those that the dearest scan loses most without.
const MOST_BITS: usize = 24;
/// So many pairs are asked about, those first of which each bit is needed most for what the other is not needed for.
const MOST_PAIRS: usize = 12;

/// What is asked.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// What counts and indices are stated to be at most, each by itself.
    pub most: &'a [u32],
    /// How long all audits together may take.
    pub budget: Option<Duration>,
}

/// Statements and the bound with each, the lowest first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Advice {
    /// The program's files.
    pub files: Vec<String>,
    /// The bound with what is stated now; none where a scan may never end.
    pub upper: Option<Picos>,
    /// What lowers it.
    pub found: Vec<Measured>,
    /// How many others were asked about that lower it by less than a thousandth.
    pub useless: usize,
    /// How many were not asked about for want of time.
    pub untried: usize,
}

/// A statement, and the bound of an audit with it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// The statement.
    pub statement: Statement,
    /// The bound.
    pub bound: SolvedBound,
}

/// Something that may be stated.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Statement {
    /// Of what kind.
    pub kind: Kind,
    /// The table of the facts file.
    pub table: &'static str,
    /// Its line there.
    pub line: String,
    /// Why it may matter, a sentence without a full stop.
    pub what: String,
    /// Where it matters, and the instructions there.
    pub places: Vec<(Location, Arc<str>)>,
}

/// A kind of statements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// What a count is at most.
    Count,
    /// What an index is at most, or how many bits it has.
    Index,
    /// Two bits are never on together.
    Exclusive,
    /// Nobody but the program writes some devices.
    Internal,
    /// On which base unit the modules sit.
    Base,
}

impl Kind {
    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::Count => "count",
            Kind::Index => "index",
            Kind::Exclusive => "exclusive",
            Kind::Internal => "internal",
            Kind::Base => "base",
        }
    }
}

/// A statement that is to be asked about.
struct Candidate {
    statement: Statement,
    facts: Facts,
    /// How much it may be worth, by which those are asked about first that may be worth more.
    hope: Picos,
}

/// Asks what one statement more is worth, of all that may be worth stating.
///
/// # Errors
/// That in one of these audits the analysis and the interpreter disagree.
pub fn advise(
    concluded: &Concluded,
    request: &Request<'_>,
    settings: Settings<'_>,
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
    // What is left of the budget ends each audit.
    let within =
        || Request { time_limit: left().into_iter().chain(request.time_limit).min(), ..*request };
    let mut candidates = unknowns(concluded, request, settings.most);
    candidates.extend(bases(concluded, request));
    candidates.extend(pairs(concluded, request));
    candidates.sort_by_key(|one| Reverse(one.hope));
    if !is_over() {
        (request.progress)(Progress::Stage(STAGE));
        // What was found with an audit of its own is asked about first.
        if let Some(own) = internal(concluded, &within())? {
            candidates.insert(0, own);
        }
    }
    let mut open = candidates.into_iter().peekable();
    while open.peek().is_some() && !is_over() {
        let few: Vec<Candidate> = open.by_ref().take(rayon::current_num_threads()).collect();
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

/// What is not known of counts and indices, each stated as at most so many.
fn unknowns(concluded: &Concluded, request: &Request<'_>, most: &[u32]) -> Vec<Candidate> {
    let (audit, program) = (&concluded.audit, &concluded.followed.program);
    let of = |one: &Unknown, most: u32| {
        let mut facts = request.facts.clone();
        one.state(&mut facts, most);
        let (kind, hope) = match &one.kind {
            UnknownKind::Count(counts) => (Kind::Count, counts.cost),
            // What hangs on where something is written shows only when it is asked.
            _ => (Kind::Index, audit.bound.upper),
        };
        Candidate {
            statement: Statement {
                kind,
                table: one.table(),
                line: one.stated(most),
                what: offer::what(program, one),
                places: one.places.clone(),
            },
            facts,
            hope,
        }
    };
    // Where indirect addresses lead cannot be guessed.
    let can_be_stated = |one: &&Unknown| !matches!(one.kind, UnknownKind::Indirect);
    let all = audit.unknowns.iter().filter(can_be_stated).flat_map(|one| {
        // How many bits an index has is no matter of how large it is.
        let values = if one.is_number() { most } else { &most[..most.len().min(1)] };
        values.iter().map(move |&most| of(one, most))
    });
    all.collect()
}

/// The base unit of all modules, where it is not stated.
fn bases(concluded: &Concluded, request: &Request<'_>) -> Option<Candidate> {
    let bases = &concluded.audit.bases;
    let least = bases.first()?.least.clone();
    Some(Candidate {
        statement: Statement {
            kind: Kind::Base,
            table: "io",
            line: format!("base = {least:?}"),
            what: "the kind of base unit that all modules sit on: the dearest is taken".to_owned(),
            places: Vec::new(),
        },
        facts: Facts { base: Some(least), ..request.facts.clone() },
        hope: bases.iter().map(|side| side.saves).sum(),
    })
}

/// All that lowers the bound if nobody but the program writes what the program writes.
fn internal(concluded: &Concluded, request: &Request<'_>) -> Result<Option<Candidate>, Failure> {
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
    Ok(Some(Candidate {
        statement: Statement {
            kind: Kind::Internal,
            table: "internal",
            line: offer::listed(facts.internal.iter()),
            what: "nobody but the program writes these, no screen and no other PLC: then they hold what the program wrote, and relays that it keeps apart are never on together".to_owned(),
            places: Vec::new(),
        },
        facts,
        hope: audit.bound.upper,
    }))
}

/// A bit that is on when the dearest scan starts.
struct On {
    atom: Atom,
    name: String,
    comment: String,
    /// What the scan loses if it alone were off.
    worth: Picos,
}

impl On {
    fn told(&self) -> String {
        if self.comment.is_empty() {
            self.name.clone()
        } else {
            format!("{} {}", self.name, self.comment)
        }
    }
}

/// Pairs of bits that are both on in the dearest scan, and that it needs for different things.
fn pairs(concluded: &Concluded, request: &Request<'_>) -> Vec<Candidate> {
    let followed = &concluded.followed;
    if followed.is_structural_only() {
        return Vec::new();
    }
    let (model, program) = (&followed.model, &followed.program);
    let mut dearest = Assignment(vec![0; model.variables.len()]);
    concluded.maxima.iter().for_each(|found| found.best.copy_to(&mut dearest));
    let charges: Vec<usize> =
        followed.groups.iter().flat_map(|group| group.charges.iter().copied()).collect();
    let whole = model.cost(&charges, &dearest);
    let bits = bits_on(program, model, &dearest, &charges);
    let mut found = Vec::new();
    for (at, one) in bits.iter().enumerate() {
        for other in &bits[at + 1..] {
            let lost = whole.checked_sub(model.cost(&charges, &without(&dearest, &[one, other])));
            let lost = lost.unwrap_or_default();
            // What only one of them is needed for. Where there is nothing of that, both gate the same: no interlock.
            let own = [other, one].map(|on| lost.checked_sub(on.worth).unwrap_or_default());
            let least = own[0].min(own[1]);
            if least > Picos::ZERO {
                found.push((least, one, other));
            }
        }
    }
    found.sort_by_key(|(least, ..)| Reverse(*least));
    found.truncate(MOST_PAIRS);
    let driven = |on: &On, other: &On| {
        driven(
            program,
            model,
            &charges,
            [&dearest, &without(&dearest, &[on]), &without(&dearest, &[other])],
        )
    };
    let candidate = |(least, one, other): (Picos, &On, &On)| {
        let mut facts = request.facts.clone();
        facts.exclusive.push(vec![one.name.clone(), other.name.clone()]);
        let places = [driven(one, other), driven(other, one)].into_iter().flatten().collect();
        Candidate {
            statement: Statement {
                kind: Kind::Exclusive,
                table: "exclusive",
                line: format!("sets = {:?}", facts.exclusive),
                what: format!(
                    "{} and {} are both on in the dearest scan, and each runs what the other does not: state this if an interlock or the plant keeps them from being on together",
                    one.told(),
                    other.told()
                ),
                places,
            },
            facts,
            hope: least,
        }
    };
    found.into_iter().map(candidate).collect()
}

/// A scan's values with these bits off.
fn without(values: &Assignment, bits: &[&On]) -> Assignment {
    let mut values = values.clone();
    for on in bits {
        let value = &mut values.0[on.atom.variable().0 as usize];
        *value = turned(on.atom, *value);
    }
    values
}

/// The bits that are on when the dearest scan starts and that have a name, those first that it loses most without.
fn bits_on(
    program: &Program,
    model: &ScanModel,
    dearest: &Assignment,
    charges: &[usize],
) -> Vec<On> {
    let values = model.circuit.evaluate(dearest);
    let names = Names::new(program);
    let asked = asked_as_bits(program);
    let on = model.circuit.nodes().iter().enumerate().filter_map(|(index, node)| {
        let &Node::Atom(atom) = node else { return None };
        let variable = &model.variables[atom.variable().0 as usize];
        let Origin::Start(cell) = variable.origin else { return None };
        let is_hidden = program.area(cell.area).role == Role::Internal;
        // That a scan is the first is nothing that an interlock has to do with.
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
        (can_be_stated && asked.contains(&source)).then(|| On {
            atom,
            name,
            comment: names.comment(variable),
            worth: Picos::ZERO,
        })
    });
    let mut on: Vec<On> = on.collect();
    let atoms: Vec<Atom> = on.iter().map(|one| one.atom).collect();
    let worth = weights_of_bits(model, dearest, charges, &atoms);
    on.iter_mut().zip(worth).for_each(|(one, worth)| one.worth = worth);
    on.retain(|one| one.worth > Picos::ZERO);
    on.sort_by_key(|one| Reverse(one.worth));
    on.truncate(MOST_BITS);
    on
}

/// The bits that contacts ask for: the bits of a number are none.
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

/// The instruction that costs most less in the second scan than in the first, and no less in the third.
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
