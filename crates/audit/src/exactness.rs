//! How much of what a project says is followed exactly, and what the rest takes as any value.
//!
//! A statement is followed exactly if nothing that it reads or writes was taken as any value in the model of the scan, but
//! for what the outside gives: inputs, how far timers have run. `docs/sfc.md` says what counts as a statement.

use scanbound_base::location::Location;
use scanbound_ir::meaning::{ChoiceKind, Operation};
use scanbound_ir::{
    Approximated, BitSource, ChoiceId, Frame, Instruction, Program, Resolution, Source, Step,
    WordSource, Write,
};
use scanbound_model::{Origin, ScanModel};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What of a project is followed exactly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exactness {
    /// By language, the one with the most statements first.
    pub languages: Vec<LanguageUse>,
    /// What keeps the other statements from it, that of the most statements first.
    pub constructs: Vec<Construct>,
    /// The bodies that could not be read, which nothing calls; with the reason.
    pub unread: Vec<(String, String)>,
}

/// The bodies and statements of a language.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LanguageUse {
    /// Its short name.
    pub language: &'static str,
    /// The bodies that a scan can come to.
    pub called: u64,
    /// Those that nothing calls: their statements are not counted.
    pub uncalled: u64,
    /// The statements of those that are called.
    pub statements: u64,
    /// Those that are followed exactly.
    pub exact: u64,
}

/// Something that is taken as any value, and the statements in which it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Construct {
    /// What, in words.
    pub what: String,
    /// How many statements it keeps from being followed exactly.
    pub statements: u64,
    /// Each of them.
    pub places: Vec<InexactUse>,
}

/// A statement that is not followed exactly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InexactUse {
    /// Where it stands.
    pub at: Location,
    /// In which body.
    pub body: String,
    /// Its first line.
    pub text: Arc<str>,
}

impl Exactness {
    /// How many statements there are, and how many of them are followed exactly.
    #[must_use]
    pub fn total(&self) -> (u64, u64) {
        let sum = |of: fn(&LanguageUse) -> u64| self.languages.iter().map(of).sum();
        (sum(|one| one.statements), sum(|one| one.exact))
    }

    /// Of a program whose front tells its statements, by the model that was made of it.
    pub(super) fn of(program: &Program, model: &ScanModel) -> Option<Exactness> {
        let source = &program.statements;
        if source.bodies.is_empty() {
            return None;
        }
        let reasons = reasons(program, model);
        let by_instruction = source.by_instruction(program.instructions.len());
        // The first reason of a statement is the one that is told.
        let mut inexact: BTreeMap<usize, String> = BTreeMap::new();
        for (instruction, reason) in reasons {
            if let Some(statement) = by_instruction.get(instruction).copied().flatten() {
                inexact.entry(statement).or_insert(reason);
            }
        }
        let mut languages: BTreeMap<&'static str, LanguageUse> = BTreeMap::new();
        let blank =
            |language| LanguageUse { language, called: 0, uncalled: 0, statements: 0, exact: 0 };
        for body in &source.bodies {
            let own = languages.entry(body.language).or_insert_with(|| blank(body.language));
            *if body.is_called { &mut own.called } else { &mut own.uncalled } += 1;
        }
        let mut constructs: BTreeMap<&str, Construct> = BTreeMap::new();
        for (at, one) in source.all.iter().enumerate() {
            let body = &source.bodies[one.body];
            let own = languages.entry(body.language).or_insert_with(|| blank(body.language));
            let count = u64::from(one.count);
            own.statements += count;
            let Some(what) = inexact.get(&at) else {
                own.exact += count;
                continue;
            };
            let construct = constructs.entry(what).or_insert_with(|| Construct {
                what: what.clone(),
                statements: 0,
                places: Vec::new(),
            });
            construct.statements += count;
            let (name, text) = (body.name.clone(), one.text.clone());
            construct.places.push(InexactUse { at: one.place, body: name, text });
        }
        let mut languages: Vec<LanguageUse> = languages.into_values().collect();
        languages.sort_by_key(|one| std::cmp::Reverse(one.statements));
        let mut constructs: Vec<Construct> = constructs.into_values().collect();
        constructs.iter_mut().for_each(|one| one.places.sort_by_key(|place| place.at));
        constructs.sort_by_key(|one| std::cmp::Reverse(one.statements));
        let unread = source.bodies.iter().filter(|body| !body.is_called);
        let unread = unread.filter_map(|body| Some((body.name.clone(), body.unreadable.clone()?)));
        Some(Exactness { languages, constructs, unread: unread.collect() })
    }
}

/// The instructions that take something as any value, in their order, and what.
fn reasons(program: &Program, model: &ScanModel) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let taken = taken(program, model);
    for one in &program.approximations {
        if !holds_here(program, &taken, one.instruction) {
            continue;
        }
        let told = one.what.to_string();
        match (&one.what, &program.instructions[one.instruction].step) {
            (Approximated::WholeSummary(_), _) => {
                found.extend((0..program.instructions.len()).map(|at| (at, told.clone())));
            }
            (_, Step::Summary(summary)) => {
                found.extend(summary.charges.iter().map(|(at, _)| (*at, told.clone())));
            }
            _ => {}
        }
        found.push((one.instruction, told));
    }
    for (at, instruction) in program.instructions.iter().enumerate() {
        let own = choices(instruction).into_iter().filter(|choice| taken.contains(choice));
        found.extend(own.filter_map(|choice| Some((at, construct(program, choice)?))));
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

/// The choices that an instruction reads or writes.
fn choices(instruction: &Instruction) -> Vec<ChoiceId> {
    let mut found = Vec::new();
    instruction.each_read(&mut |source| match source {
        Source::Bit(BitSource::Free(choice)) | Source::Word(WordSource::Free(choice)) => {
            found.push(choice);
        }
        Source::Bit(_) | Source::Word(_) => {}
    });
    found.extend(instruction.effects.iter().filter_map(|effect| match effect.write {
        Write::Havoc(_, choice) => Some(choice),
        Write::Bit(..) | Write::Words(..) => None,
    }));
    found
}

/// Whether what is said of an instruction comes about in the model: one of its choices has any value there, if it has any.
fn holds_here(program: &Program, taken: &BTreeSet<ChoiceId>, at: usize) -> bool {
    let own = choices(&program.instructions[at]);
    own.is_empty() || own.iter().any(|choice| taken.contains(choice))
}

/// The choices that may have any value somewhere in the model, though their operation is settled or the language does not
/// leave them open.
fn taken(program: &Program, model: &ScanModel) -> BTreeSet<ChoiceId> {
    let read = model.variables.iter().filter_map(|variable| match &variable.origin {
        Origin::Choice(key) => Some((&key.frames, key.choice)),
        Origin::Start(_) | Origin::Havocked { .. } => None,
    });
    let written = model.havocs.all().iter().map(|havoc| (&havoc.frames, havoc.choice));
    let is_followed = |(frames, choice): &(&Vec<Frame>, ChoiceId)| {
        model.resolutions.choice(frames, *choice) == Some(&Resolution::Exact)
            || program.statements.undefined_by_language.contains(choice)
    };
    read.chain(written).filter(|one| !is_followed(one)).map(|(_, choice)| choice).collect()
}

/// What gives a choice its value on a PLC, if not the outside.
fn construct(program: &Program, choice: ChoiceId) -> Option<String> {
    let meaning = match program.kinds.get(&choice) {
        Some(ChoiceKind::Exact(meaning)) => meaning,
        Some(_) => return None,
        None => return Some("something that is not followed: it may have any value".to_owned()),
    };
    let what = match &meaning.operation {
        Operation::Copy => "an element of an array whose index is not known",
        Operation::Multiply { .. } => "a product of two values",
        Operation::Divide { .. } | Operation::DivideJoined { .. } => "a quotient or remainder",
        Operation::Shift { .. } | Operation::Rotate { .. } => "shifted or rotated bits",
        Operation::Real(_) => "arithmetic of REAL",
        Operation::ToReal | Operation::FromReal(_) => "a conversion from or to REAL",
        _ => "an operation",
    };
    Some(format!("{what}: taken as any value"))
}
